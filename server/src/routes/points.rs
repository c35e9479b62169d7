//! `/sweeps/{id}/points`: the table, a page as JSON or all of it as CSV.

use axum::body::Body;
use axum::extract::State;
use axum::http::header;
use axum::response::{IntoResponse, Response};
use futures_util::stream;
use granary_api::id::SweepId;
use granary_api::problem::Problem;
use granary_api::table::{Page, PointRow};
use serde_json::{Value, json};

use super::body::Id;
use super::tables::{Asked, Format, TableParams, csv_line, json as json_page, not_modified};
use crate::error::ApiError;
use crate::store::{Store, StoreError};
use crate::table::TableQuery;

/// Rows of one piece of a CSV stream.
const PIECE: u32 = 1000;

/// The points of a sweep.
#[utoipa::path(get, path = "/api/v1/sweeps/{sweep}/points",
    params(("sweep" = SweepId, Path), TableParams),
    responses((status = 200, body = Page<PointRow>), (status = 304), (status = 404, body = Problem)))]
pub(super) async fn list_points(
    State(store): State<Store>,
    Id(sweep): Id<SweepId>,
    asked: Asked,
) -> Result<Response, ApiError> {
    let (etag, known) = asked.etag(&store, sweep).await?;
    if known {
        return Ok(not_modified(etag));
    }
    if asked.format == Format::Json {
        return Ok(json_page(
            etag,
            store.point_list(sweep, &asked.query).await?,
        ));
    }
    let body = csv(store, sweep, asked.query, asked.limited).await?;
    let kind = "text/csv; charset=utf-8";
    let headers = [
        (header::CONTENT_TYPE, kind.parse().ok()),
        (header::ETAG, Some(etag)),
    ];
    let mut response = body.into_response();
    for (name, value) in headers {
        response
            .headers_mut()
            .extend(value.map(|value| (name, value)));
    }
    Ok(response)
}

/// The columns of a CSV, and where each comes from.
struct Columns {
    axes: Vec<String>,
    results: Vec<String>,
}

/// All rows, or one page if the reader named its size, a piece at a time.
async fn csv(
    store: Store,
    sweep: SweepId,
    mut query: TableQuery,
    limited: bool,
) -> Result<Body, ApiError> {
    let mut axes = store.sweep_read(sweep).await?.axes;
    let mut results = store.point_result_names(sweep).await?;
    axes.retain(|name| query.shows(name));
    results.retain(|name| query.shows(name));
    let columns = Columns { axes, results };
    if !limited {
        query.limit = PIECE;
    }
    // The first page is read before anything is sent, so that a wrong question still gets its 4xx.
    let first = store.point_list(sweep, &query).await?;
    let start = columns.header() + &columns.lines(&first.items);
    query.cursor = first.next.filter(|_| !limited);
    let rest = stream::try_unfold(
        (store, query, columns),
        move |(store, mut query, columns)| async move {
            if query.cursor.is_none() {
                return Ok::<_, StoreError>(None);
            }
            let page = store.point_list(sweep, &query).await?;
            query.cursor = page.next;
            Ok(Some((columns.lines(&page.items), (store, query, columns))))
        },
    );
    let start = stream::once(async move { Ok(start) });
    Ok(Body::from_stream(futures_util::StreamExt::chain(
        start, rest,
    )))
}

impl Columns {
    fn header(&self) -> String {
        let names = ["point", "state"].into_iter();
        let names = names.chain(self.axes.iter().chain(&self.results).map(String::as_str));
        let names: Vec<Value> = names
            .chain(["job", "result_hash", "failure"])
            .map(Value::from)
            .collect();
        csv_line(names.iter())
    }

    fn lines(&self, rows: &[PointRow]) -> String {
        rows.iter().map(|row| self.line(row)).collect()
    }

    fn line(&self, row: &PointRow) -> String {
        let mut cells = vec![json!(row.point), json!(row.state)];
        cells.extend(
            self.axes
                .iter()
                .map(|name| row.parameters.get(name).cloned().unwrap_or_default()),
        );
        cells.extend(self.results.iter().map(|name| json!(row.results.get(name))));
        let failure = row.failure.as_ref().map(|failure| &failure.message);
        cells.extend([json!(row.job), json!(row.result_hash), json!(failure)]);
        csv_line(cells.iter())
    }
}
