//! `/sweeps/{id}/sets`: what the reductions say about whatever has finished.

use axum::extract::State;
use axum::http::header;
use axum::response::{IntoResponse, Response};
use granary_api::id::SweepId;
use granary_api::problem::Problem;
use granary_api::table::{Page, SetRow};
use serde_json::{Value, json};

use super::body::Id;
use super::tables::{Asked, Format, TableParams, csv_line, json as json_page, not_modified};
use crate::error::ApiError;
use crate::store::Store;
use crate::table::MOST_ROWS;

/// The sets of a sweep.
#[utoipa::path(get, path = "/api/v1/sweeps/{sweep}/sets",
    params(("sweep" = SweepId, Path), TableParams),
    responses((status = 200, body = Page<SetRow>), (status = 304), (status = 404, body = Problem)))]
pub(super) async fn list_sets(
    State(store): State<Store>,
    Id(sweep): Id<SweepId>,
    asked: Asked,
) -> Result<Response, ApiError> {
    let (etag, known) = asked.etag(&store, sweep).await?;
    if known {
        return Ok(not_modified(etag));
    }
    let mut query = asked.query;
    if asked.format == Format::Csv && !asked.limited {
        query.limit = MOST_ROWS;
    }
    let page = store.set_list(sweep, &query).await?;
    if asked.format == Format::Json {
        return Ok(json_page(etag, page));
    }
    let kind = "text/csv; charset=utf-8";
    let mut response = ([(header::CONTENT_TYPE, kind)], csv(&page.items)).into_response();
    response.headers_mut().insert(header::ETAG, etag);
    Ok(response)
}

/// Every column that some row has.
fn csv(rows: &[SetRow]) -> String {
    let mut parameters: Vec<&String> = vec![];
    let mut results: Vec<&String> = vec![];
    for row in rows {
        let new = row
            .parameters
            .keys()
            .filter(|name| !parameters.contains(name));
        parameters.extend(new.collect::<Vec<_>>());
        let new = row.results.keys().filter(|name| !results.contains(name));
        results.extend(new.collect::<Vec<_>>());
    }
    // Only fits have a shape, and only studies have settings.
    let shaped = rows.iter().any(|row| row.shape.is_some());
    let studied = rows.iter().any(|row| row.setting.is_some());
    let names = ["set", "reduce", "processing"].into_iter();
    let names = names.chain(shaped.then_some("shape"));
    let names = names.chain(
        studied
            .then_some(["setting", "verdict"])
            .into_iter()
            .flatten(),
    );
    let names = names.chain(parameters.iter().chain(&results).map(|name| name.as_str()));
    let names: Vec<Value> = names
        .chain(["n", "of", "provisional"])
        .map(Value::from)
        .collect();
    let line = |row: &SetRow| {
        let mut cells = vec![json!(row.set), json!(row.reduce), json!(row.processing)];
        cells.extend(shaped.then(|| json!(row.shape)));
        if studied {
            cells.extend([json!(row.setting), json!(row.verdict)]);
        }
        cells.extend(
            parameters
                .iter()
                .map(|name| row.parameters.get(*name).cloned().unwrap_or_default()),
        );
        cells.extend(
            results
                .iter()
                .map(|name| json!(row.results.get(*name).copied().flatten())),
        );
        cells.extend([json!(row.n), json!(row.of), json!(row.provisional)]);
        csv_line(cells.iter())
    };
    csv_line(names.iter()) + &rows.iter().map(line).collect::<String>()
}
