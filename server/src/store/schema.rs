//! Migrations: embedded, applied in order, each in its own transaction.

use sqlx::SqlitePool;

use super::StoreError;

/// Never edited after release, only added to.
const MIGRATIONS: [&str; 1] = [include_str!(
    "../../../migrations/sqlite/0001_queue_and_results.sql"
)];

/// Brings the database to the newest schema; refuses one that is newer still.
pub(super) async fn migrate(writer: &SqlitePool) -> Result<(), StoreError> {
    let known = super::signed(MIGRATIONS.len() as u64);
    let found: i64 = sqlx::query_scalar("pragma user_version")
        .fetch_one(writer)
        .await?;
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
