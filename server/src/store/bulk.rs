//! Bulk: many rows under one statement, every value bound.

use sqlx::Sqlite;
use sqlx::query_builder::{QueryBuilder, Separated};

use super::{StoreError, Writing};

/// Rows of one statement: so few sizes that each statement is prepared once and kept.
const SIZES: [usize; 4] = [256, 32, 4, 1];

/// One row that is being bound.
pub(super) type Row<'a> = Separated<'a, Sqlite, &'static str>;

/// Inserts `rows`: `into` names table and columns, `after` says what to do about those that are there.
pub(super) async fn insert_all<T>(
    transaction: &mut Writing,
    (into, after): (&'static str, &'static str),
    rows: &[T],
    bind: impl Fn(&mut Row<'_>, &T),
) -> Result<(), StoreError> {
    let mut rest = rows;
    while let Some(size) = SIZES.into_iter().find(|&size| size <= rest.len()) {
        let (part, later) = rest.split_at(size);
        let mut statement = QueryBuilder::new(into);
        statement.push_values(part, |mut row, value| bind(&mut row, value));
        statement.push(after);
        statement.build().execute(&mut **transaction).await?;
        rest = later;
    }
    Ok(())
}
