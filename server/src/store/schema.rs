//! Migrations: embedded, applied in order, each in its own transaction.

use sqlx::SqlitePool;

use super::StoreError;

/// Never edited after release, only added to.
const MIGRATIONS: [&str; 3] = [
    include_str!("../../../migrations/sqlite/0001_queue_and_results.sql"),
    include_str!("../../../migrations/sqlite/0002_archived_outcomes.sql"),
    include_str!("../../../migrations/sqlite/0003_pilots.sql"),
];

/// Brings the database to the newest schema; refuses one that is newer still.
pub(super) async fn migrate(writer: &SqlitePool) -> Result<(), StoreError> {
    let (found, known) = versions(writer).await?;
    if found > known {
        return Err(StoreError::Schema { found, known });
    }
    for (version, migration) in (1_i64..).zip(MIGRATIONS).skip(found as usize) {
        let mut transaction = writer.begin_with("begin immediate").await?;
        sqlx::raw_sql(migration).execute(&mut *transaction).await?;
        let mark = sqlx::AssertSqlSafe(format!("pragma user_version = {version}"));
        sqlx::raw_sql(mark).execute(&mut *transaction).await?;
        transaction.commit().await?;
    }
    Ok(())
}

/// Refuses a database whose schema is not ours, and changes nothing: another process has it open.
pub(super) async fn check(database: &SqlitePool) -> Result<(), StoreError> {
    match versions(database).await? {
        (found, known) if found == known => Ok(()),
        (found, known) => Err(StoreError::Schema { found, known }),
    }
}

/// The schema of the file, and ours.
async fn versions(database: &SqlitePool) -> Result<(i64, i64), StoreError> {
    const FOUND: &str = "pragma user_version";
    let found = sqlx::query_scalar(FOUND).fetch_one(database).await?;
    Ok((found, super::signed(MIGRATIONS.len() as u64)))
}
