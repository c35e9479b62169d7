//! Migrations: embedded, applied in order, each in its own transaction.

use sqlx::{Connection, SqlitePool};

use super::StoreError;

/// Never edited after release, only added to.
const MIGRATIONS: [&str; 5] = [
    include_str!("../../../migrations/sqlite/0001_queue_and_results.sql"),
    include_str!("../../../migrations/sqlite/0002_archived_outcomes.sql"),
    include_str!("../../../migrations/sqlite/0003_pilots.sql"),
    include_str!("../../../migrations/sqlite/0004_encodings.sql"),
    include_str!("../../../migrations/sqlite/0005_classifiers.sql"),
];

/// Brings the database to the newest schema; refuses one that is newer still.
pub(super) async fn migrate(writer: &SqlitePool) -> Result<(), StoreError> {
    let (found, known) = versions(writer).await?;
    if found > known {
        return Err(StoreError::Schema { found, known });
    }
    // A table that takes another's place leaves references without their row for a moment.
    let mut connection = writer.acquire().await?;
    sqlx::raw_sql("pragma foreign_keys = off")
        .execute(&mut *connection)
        .await?;
    for (version, migration) in (1_i64..).zip(MIGRATIONS).skip(found as usize) {
        let mut transaction = connection.begin_with("begin immediate").await?;
        sqlx::raw_sql(migration).execute(&mut *transaction).await?;
        let dangling = sqlx::query("pragma foreign_key_check");
        if !dangling.fetch_all(&mut *transaction).await?.is_empty() {
            let detail = format!("migration {version} leaves references to rows that are gone");
            return Err(StoreError::NotFound(detail));
        }
        let mark = sqlx::AssertSqlSafe(format!("pragma user_version = {version}"));
        sqlx::raw_sql(mark).execute(&mut *transaction).await?;
        transaction.commit().await?;
    }
    sqlx::raw_sql("pragma foreign_keys = on")
        .execute(&mut *connection)
        .await?;
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

#[cfg(test)]
mod tests {
    use super::*;
    use sqlx::sqlite::{SqliteConnectOptions, SqlitePoolOptions};

    #[tokio::test]
    async fn jobs_of_an_older_database_keep_their_ensembles_when_the_table_is_replaced() {
        const FILLED: &str = "
            insert into ensemble (id, key, kind, class, physics, lanes, steps, grain_steps, bytes)
                values (7, randomblob(32), 'pack', 'pack/sphere/f64', 8, 1, 10, 100, 1000);
            insert into job (id, hash, ensemble, spec, state) values (3, randomblob(32), 7, '{}', 'ready');
            pragma user_version = 3";
        let options = SqliteConnectOptions::new()
            .in_memory(true)
            .foreign_keys(true);
        let pool = SqlitePoolOptions::new().max_connections(1);
        let pool = pool.connect_with(options).await.expect("a database");
        for sql in MIGRATIONS[..3].iter().chain([&FILLED]) {
            sqlx::raw_sql(*sql).execute(&pool).await.expect("older");
        }
        migrate(&pool).await.expect("migrated");
        check(&pool).await.expect("the newest schema");
        let of_job = "select e.kind from job j join ensemble e on e.id = j.ensemble where j.id = 3";
        let kind: String = sqlx::query_scalar(of_job)
            .fetch_one(&pool)
            .await
            .expect("the job");
        assert_eq!(kind, "pack");
        let encode = "
            insert into ensemble (key, kind, class, physics, lanes, steps, grain_steps, bytes)
                values (randomblob(32), 'encode', 'recall/sphere/f64', 9, 8, 10, 100, 1000)";
        sqlx::raw_sql(encode)
            .execute(&pool)
            .await
            .expect("allowed now");
        // References are looked at again, and name the new table.
        let dangling = "insert into job (hash, ensemble, spec, state) values (randomblob(32), 99, '{}', 'ready')";
        assert!(sqlx::raw_sql(dangling).execute(&pool).await.is_err());
        let gone = sqlx::raw_sql("delete from ensemble where id = 7");
        assert!(gone.execute(&pool).await.is_err());
    }
}
