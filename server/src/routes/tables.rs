//! What points and sets have in common: the query, the format, and the ETag.

use axum::extract::{FromRequestParts, Query};
use axum::http::request::Parts;
use axum::http::{HeaderMap, HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};
use granary_api::id::SweepId;
use serde::Serialize;
use serde_json::Value;
use utoipa::IntoParams;

use crate::error::ApiError;
use crate::store::Store;
use crate::table::TableQuery;

/// How a table is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Format {
    Json,
    Csv,
}

/// What a question may say, for the OpenAPI document; [`Asked`] reads it.
#[derive(IntoParams)]
#[into_params(parameter_in = Query)]
#[expect(dead_code, reason = "describes a query and never holds one")]
pub(super) struct TableParams {
    /// `COLUMN`, one of `= != < <= > >=`, and a value; rows must meet all of them, 20 at most.
    r#where: Option<Vec<String>>,
    /// The column to order by, descending after a `-`.
    sort: Option<String>,
    /// The columns to show, separated by commas.
    columns: Option<String>,
    /// The `next` of the page before.
    cursor: Option<String>,
    /// Rows of a page, 1 to 10,000.
    limit: Option<u32>,
    /// `json` or `csv`; the Accept header counts if this is absent.
    format: Option<String>,
}

/// A reader's question.
pub(super) struct Asked {
    pub(super) query: TableQuery,
    pub(super) format: Format,
    /// Whether the reader named a page's size.
    pub(super) limited: bool,
    text: String,
    known: Option<String>,
}

impl<S: Send + Sync> FromRequestParts<S> for Asked {
    type Rejection = ApiError;

    async fn from_request_parts(parts: &mut Parts, state: &S) -> Result<Self, ApiError> {
        let pairs = Query::<Vec<(String, String)>>::from_request_parts(parts, state).await;
        let Query(pairs) = pairs.map_err(|error| ApiError::bad_request(error.body_text()))?;
        let query = TableQuery::parse(&pairs, &["format"]).map_err(ApiError::bad_request)?;
        let asked = pairs.iter().find(|(key, _)| key == "format");
        let known = parts.headers.get(header::IF_NONE_MATCH);
        Ok(Self {
            query,
            format: format(asked.map(|(_, name)| name.as_str()), &parts.headers)?,
            limited: pairs.iter().any(|(key, _)| key == "limit"),
            text: parts.uri.to_string(),
            known: known.and_then(|tag| tag.to_str().ok()).map(str::to_owned),
        })
    }
}

fn format(asked: Option<&str>, headers: &HeaderMap) -> Result<Format, ApiError> {
    let accept = headers
        .get(header::ACCEPT)
        .and_then(|accept| accept.to_str().ok());
    match (asked, accept) {
        (Some("json"), _) => Ok(Format::Json),
        (Some("csv"), _) => Ok(Format::Csv),
        (Some(other), _) => Err(ApiError::bad_request(format!(
            "format={other} is not json or csv"
        ))),
        (None, Some(accept)) if accept.starts_with("text/csv") => Ok(Format::Csv),
        (None, _) => Ok(Format::Json),
    }
}

impl Asked {
    /// The tag of this answer as the sweep stands now, and whether the reader has it already.
    pub(super) async fn etag(
        &self,
        store: &Store,
        sweep: SweepId,
    ) -> Result<(HeaderValue, bool), ApiError> {
        let version = store.sweep_version(sweep).await?;
        let format = self.format == Format::Csv;
        let hash = blake3::hash(format!("{version} {format} {}", self.text).as_bytes());
        let tag = format!("\"{}\"", &hash.to_hex()[..32]);
        let known = self
            .known
            .as_deref()
            .is_some_and(|known| known.contains(&tag));
        let value = HeaderValue::from_str(&tag).map_err(|_| ApiError::bad_request("no tag"))?;
        Ok((value, known))
    }
}

/// 304, with the tag that still holds.
pub(super) fn not_modified(etag: HeaderValue) -> Response {
    (StatusCode::NOT_MODIFIED, [(header::ETAG, etag)]).into_response()
}

/// A page as JSON.
pub(super) fn json<T: Serialize>(etag: HeaderValue, page: T) -> Response {
    ([(header::ETAG, etag)], axum::Json(page)).into_response()
}

/// A line of CSV (RFC 4180).
pub(super) fn csv_line<'a>(cells: impl Iterator<Item = &'a Value>) -> String {
    let cells: Vec<String> = cells.map(csv_cell).collect();
    cells.join(",") + "\r\n"
}

fn csv_cell(value: &Value) -> String {
    let text = match value {
        Value::Null => return String::new(),
        Value::String(text) => text.clone(),
        other => other.to_string(),
    };
    if text.contains([',', '"', '\n', '\r']) {
        format!("\"{}\"", text.replace('"', "\"\""))
    } else {
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn csv_quotes_what_it_must() {
        let row = [
            json!("a,b"),
            json!("say \"x\""),
            json!(null),
            json!(0.5),
            json!({"a": 1}),
        ];
        assert_eq!(
            csv_line(row.iter()),
            "\"a,b\",\"say \"\"x\"\"\",,0.5,\"{\"\"a\"\":1}\"\r\n"
        );
    }
}
