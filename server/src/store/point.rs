//! Points: the rows of a sweep's table, filtered, sorted and paged by key in the database.

use std::collections::BTreeSet;

use granary_api::id::{SweepId, WorkerId};
use granary_api::job::Progress;
use granary_api::problem::Mistake;
use granary_api::table::{Page, PointRow};
use serde_json::{Map, Value, json};
use sqlx::{AssertSqlSafe, SqlitePool};

use super::sweep::SweepPlan;
use super::{Store, StoreError, job, rfc3339};
use crate::sweep::nearest_name;
use crate::table::TableQuery;

/// A statement put together from constant pieces, and the values bound to it.
struct Statement {
    sql: String,
    values: Vec<Value>,
}

/// A point's columns: number, parameters, job, state, step, steps, failure, results, warnings, result hash, worker,
/// last heartbeat, and the value sorted by.
type Row = (
    i64,
    String,
    Vec<u8>,
    String,
    i64,
    i64,
    Option<String>,
    Option<String>,
    Option<String>,
    Option<Vec<u8>>,
    Option<String>,
    Option<i64>,
    String,
);

const FROM: &str = "
      from point p join job j on j.id = p.job
      left join outcome o on o.job = j.id left join lease l on l.id = j.lease
     where p.sweep = ?";

const SELECT: &str = "
    select p.point, p.parameters, j.hash, j.state, j.step, j.steps, j.failure,
           o.results, o.warnings, o.result_hash, l.worker, l.heard_at, json_quote(";

impl Statement {
    fn push(&mut self, sql: &str, values: &[Value]) {
        self.sql.push_str(sql);
        self.values.extend_from_slice(values);
    }
}

/// The expression of a column, with the value bound to it; a fixed parameter is itself a value.
fn expression(plan: &SweepPlan, column: &str) -> (&'static str, Option<Value>) {
    match column {
        "point" => ("p.point", None),
        "state" => ("j.state", None),
        name if plan.axes.iter().any(|axis| axis == name) => (
            "json_extract(p.parameters, ?)",
            Some(json!(format!("$.{name}"))),
        ),
        name => match plan.fixed.get(name) {
            Some(value) => ("?", Some(value.clone())),
            None => (
                "json_extract(o.results, ?)",
                Some(json!(format!("$.{name}"))),
            ),
        },
    }
}

/// Adds the filters of `query`.
fn filtered(statement: &mut Statement, plan: &SweepPlan, query: &TableQuery) {
    statement.push(FROM, &[json!(plan.id)]);
    for filter in &query.filters {
        let (expression, bound) = expression(plan, &filter.column);
        statement.push(" and ", &[]);
        statement.push(expression, bound.as_slice());
        statement.push(" ", &[]);
        statement.push(filter.comparison.sql(), &[]);
        statement.push(" ?", std::slice::from_ref(&filter.value));
    }
}

/// The page's statement: rows after the cursor in the order asked for, `null` last.
fn page(plan: &SweepPlan, query: &TableQuery) -> Result<Statement, StoreError> {
    let sort = query.sort.as_ref();
    let (by, bound) = expression(plan, sort.map_or("point", |sort| &sort.column));
    let bound = bound.as_slice();
    let (after, order) = match sort {
        Some(sort) if sort.descending => ("<", " desc"),
        _ => (">", ""),
    };
    let mut statement = Statement {
        sql: SELECT.to_owned(),
        values: vec![],
    };
    statement.push(by, bound);
    statement.push(")", &[]);
    filtered(&mut statement, plan, query);
    if let Some(cursor) = &query.cursor {
        let (value, point) = read_cursor(cursor)?;
        if value.is_null() {
            statement.push(" and ", &[]);
            statement.push(by, bound);
            statement.push(" is null and p.point > ?", &[point]);
        } else {
            statement.push(" and (", &[]);
            statement.push(by, bound);
            statement.push(&format!(" {after} ? or "), std::slice::from_ref(&value));
            statement.push(by, bound);
            statement.push(" is null or (", &[]);
            statement.push(by, bound);
            statement.push(" = ? and p.point > ?))", &[value, point]);
        }
    }
    statement.push(" order by ", &[]);
    if sort.is_some() {
        statement.push(by, bound);
        statement.push(" is null, ", &[]);
        statement.push(by, bound);
        statement.push(order, &[]);
        statement.push(", ", &[]);
    }
    statement.push("p.point limit ?", &[json!(query.limit)]);
    Ok(statement)
}

impl Store {
    /// A page of a sweep's points.
    pub async fn point_list(
        &self,
        sweep: SweepId,
        query: &TableQuery,
    ) -> Result<Page<PointRow>, StoreError> {
        let plan = self.sweep_plan(sweep).await?;
        self.columns_exist(&plan, query).await?;
        let statement = page(&plan, query)?;
        let rows: Vec<Row> = bind(
            sqlx::query_as(AssertSqlSafe(statement.sql)),
            statement.values,
        )
        .fetch_all(self.readers())
        .await?;
        let full = rows.len() == query.limit as usize;
        let next = rows
            .last()
            .filter(|_| full)
            .map(|row| write_cursor(&row.12, row.0));
        let total = match query.filters.len() {
            0 => plan.points,
            _ => count(self.readers(), &plan, query).await?,
        };
        let items: Result<_, _> = rows.into_iter().map(|row| point(row, query)).collect();
        Ok(Page {
            items: items?,
            next,
            total,
        })
    }

    /// The names of the scalars that the points of a sweep have so far.
    pub async fn point_result_names(&self, sweep: SweepId) -> Result<Vec<String>, StoreError> {
        let plan = self.sweep_plan(sweep).await?;
        Ok(self.result_names(&plan).await?.into_iter().collect())
    }

    async fn result_names(&self, plan: &SweepPlan) -> Result<BTreeSet<String>, StoreError> {
        const NAMES: &str = "
            select o.results from want w join outcome o on o.job = w.job
             where w.sweep = $1 and w.state = 'done' and w.points > 0 limit 20";
        let rows: Vec<String> = sqlx::query_scalar(NAMES)
            .bind(plan.id)
            .fetch_all(self.readers())
            .await?;
        let mut names = BTreeSet::new();
        for row in rows {
            let results: Map<String, Value> =
                serde_json::from_str(&row).map_err(StoreError::corrupt("result"))?;
            names.extend(results.into_iter().map(|(name, _)| name));
        }
        // A later row may lack what the first ones have.
        for name in plan.model.reasoned() {
            if names.contains(*name) {
                names.insert(format!("{name}_reason"));
            }
        }
        Ok(names)
    }

    /// Refuses columns that no row can have; before the first result any name may be one.
    async fn columns_exist(&self, plan: &SweepPlan, query: &TableQuery) -> Result<(), StoreError> {
        let strange = |name: &&str| {
            !["point", "state"].contains(name) && plan.model.parameter(name).is_none()
        };
        let strange: Vec<&str> = query.named().filter(strange).collect();
        if strange.is_empty() {
            return Ok(());
        }
        let known = self.result_names(plan).await?;
        let wrong = strange
            .into_iter()
            .filter(|name| !known.is_empty() && !known.contains(*name));
        let axes = plan.axes.iter().map(String::as_str);
        let candidates = || axes.clone().chain(known.iter().map(String::as_str));
        let mistakes: Vec<Mistake> = wrong
            .map(|name| Mistake {
                pointer: String::new(),
                detail: match nearest_name(name, candidates()) {
                    Some(near) => {
                        format!("{name} is not a column of this table; did you mean {near}?")
                    }
                    None => format!("{name} is not a column of this table"),
                },
            })
            .collect();
        if mistakes.is_empty() {
            Ok(())
        } else {
            Err(StoreError::Invalid(mistakes))
        }
    }
}

async fn count(
    readers: &SqlitePool,
    plan: &SweepPlan,
    query: &TableQuery,
) -> Result<u64, StoreError> {
    let mut statement = Statement {
        sql: "select count(*)".to_owned(),
        values: vec![],
    };
    filtered(&mut statement, plan, query);
    let counted = bind(
        sqlx::query_as(AssertSqlSafe(statement.sql)),
        statement.values,
    );
    let (total,): (i64,) = counted.fetch_one(readers).await?;
    Ok(total as u64)
}

type Query<T> = sqlx::query::QueryAs<'static, sqlx::Sqlite, T, sqlx::sqlite::SqliteArguments>;

fn bind<T>(query: Query<T>, values: Vec<Value>) -> Query<T> {
    values.into_iter().fold(query, |query, value| match value {
        Value::Bool(flag) => query.bind(flag),
        Value::Number(number) if number.is_i64() => query.bind(number.as_i64()),
        Value::Number(number) => query.bind(number.as_f64()),
        Value::String(text) => query.bind(text),
        Value::Null => query.bind(None::<i64>),
        other => query.bind(other.to_string()),
    })
}

/// The cursor after a row: the value sorted by, and the point's number.
fn write_cursor(sorted_by: &str, point: i64) -> String {
    format!("{point}:{sorted_by}")
}

fn read_cursor(cursor: &str) -> Result<(Value, Value), StoreError> {
    let parts = cursor.split_once(':');
    let parsed = parts.and_then(|(point, value)| {
        Some((
            serde_json::from_str(value).ok()?,
            json!(point.parse::<i64>().ok()?),
        ))
    });
    parsed.ok_or_else(|| wrong_cursor(cursor))
}

/// The mistake of a cursor that no page gave.
pub(super) fn wrong_cursor(cursor: &str) -> StoreError {
    let start: String = cursor.chars().take(80).collect();
    StoreError::Invalid(vec![Mistake {
        pointer: String::new(),
        detail: format!("cursor={start} was not given by this table"),
    }])
}

fn point(row: Row, query: &TableQuery) -> Result<PointRow, StoreError> {
    let (
        point,
        parameters,
        id,
        state,
        step,
        steps,
        failure,
        results,
        warnings,
        hash,
        worker,
        heard,
        _,
    ) = row;
    let mut row = PointRow {
        point: point as u64,
        state: state
            .parse()
            .map_err(|_| StoreError::NotFound(format!("job state {state}")))?,
        parameters: serde_json::from_str(&parameters).map_err(StoreError::corrupt("point"))?,
        results: read_or_default(results.as_deref(), "result")?,
        warnings: read_or_default(warnings.as_deref(), "list of warnings")?,
        job: job::stage_id(&id),
        result_hash: hash.as_deref().map(job::hash),
        progress: worker.zip(heard).map(|(worker, heard)| Progress {
            step: step as u64,
            steps: steps as u64,
            worker: WorkerId(worker),
            last_heartbeat: rfc3339(heard),
        }),
        failure: failure
            .as_deref()
            .map(serde_json::from_str)
            .transpose()
            .map_err(StoreError::corrupt("failure"))?,
    };
    row.parameters.retain(|name, _| query.shows(name));
    row.results.retain(|name, _| query.shows(name));
    Ok(row)
}

pub(super) fn read_or_default<T: serde::de::DeserializeOwned + Default>(
    text: Option<&str>,
    what: &'static str,
) -> Result<T, StoreError> {
    let read = text.map(serde_json::from_str).transpose();
    Ok(read.map_err(StoreError::corrupt(what))?.unwrap_or_default())
}
