//! `/artifacts`: immutable files under their hash, in ranges and as streams.

use std::io::SeekFrom;

use axum::body::Body;
use axum::extract::State;
use axum::http::{HeaderMap, StatusCode, header};
use axum::response::{IntoResponse, Response};
use granary_api::id::ArtifactHash;
use granary_api::problem::Problem;
use tokio::io::{AsyncReadExt, AsyncSeekExt};
use tokio_util::io::ReaderStream;

use super::body::Id;
use crate::error::ApiError;
use crate::store::{Store, StoreError};

/// One file, or the range of it that `Range` names.
#[utoipa::path(get, path = "/api/v1/artifacts/{hash}", params(("hash" = String, Path)),
    responses((status = 200, content_type = "application/octet-stream"), (status = 206), (status = 304),
        (status = 404, body = Problem), (status = 416, body = Problem)))]
pub(super) async fn read_artifact(
    State(store): State<Store>,
    Id(hash): Id<ArtifactHash>,
    headers: HeaderMap,
) -> Result<Response, ApiError> {
    let mut artifact = store.artifact_open(&hash).await?;
    let etag = format!("\"{}\"", hash.to_hex());
    let constant = [
        (header::ETAG, etag.clone()),
        (
            header::CACHE_CONTROL,
            "public, max-age=31536000, immutable".to_owned(),
        ),
        (header::ACCEPT_RANGES, "bytes".to_owned()),
        (header::CONTENT_TYPE, "application/octet-stream".to_owned()),
    ];
    let text = |name| {
        headers
            .get(name)
            .and_then(|value: &header::HeaderValue| value.to_str().ok())
    };
    if text(header::IF_NONE_MATCH).is_some_and(|known| known.contains(&etag)) {
        return Ok((StatusCode::NOT_MODIFIED, constant).into_response());
    }
    let Some(range) = text(header::RANGE) else {
        let length = [(header::CONTENT_LENGTH, artifact.bytes)];
        let body = Body::from_stream(ReaderStream::new(artifact.file));
        return Ok((
            constant,
            length.map(|(name, n)| (name, n.to_string())),
            body,
        )
            .into_response());
    };
    let Some((first, last)) = parse_range(range, artifact.bytes) else {
        let detail = format!("{range} is not a range of {} bytes", artifact.bytes);
        let status = StatusCode::RANGE_NOT_SATISFIABLE;
        let error =
            ApiError::new(status, "range", "There is no such range", detail).into_response();
        let whole = [(header::CONTENT_RANGE, format!("bytes */{}", artifact.bytes))];
        return Ok((whole, error).into_response());
    };
    let found = artifact.file.seek(SeekFrom::Start(first)).await;
    found.map_err(|source| StoreError::File {
        path: hash.to_string(),
        source,
    })?;
    let length = last - first + 1;
    let partial = [
        (
            header::CONTENT_RANGE,
            format!("bytes {first}-{last}/{}", artifact.bytes),
        ),
        (header::CONTENT_LENGTH, length.to_string()),
    ];
    let body = Body::from_stream(ReaderStream::new(artifact.file.take(length)));
    Ok((StatusCode::PARTIAL_CONTENT, constant, partial, body).into_response())
}

/// First and last byte of a single range `bytes=a-b`, `bytes=a-` or `bytes=-n`.
fn parse_range(range: &str, bytes: u64) -> Option<(u64, u64)> {
    let (first, last) = range.strip_prefix("bytes=")?.split_once('-')?;
    let (first, last) = match (first, last) {
        ("", n) => (
            bytes.checked_sub(n.parse::<u64>().ok()?.clamp(1, bytes.max(1)))?,
            bytes.checked_sub(1)?,
        ),
        (a, "") => (a.parse().ok()?, bytes.checked_sub(1)?),
        (a, b) => (
            a.parse().ok()?,
            b.parse::<u64>().ok()?.min(bytes.checked_sub(1)?),
        ),
    };
    (first <= last && last < bytes).then_some((first, last))
}

/// Stores a file, streamed to disk and checked against the hash that it is sent under.
#[utoipa::path(put, path = "/api/v1/artifacts/{hash}", params(("hash" = String, Path)),
    request_body(content = Vec<u8>, content_type = "application/octet-stream"),
    responses((status = 201), (status = 200, description = "known"), (status = 413, body = Problem), (status = 422, body = Problem)))]
pub(super) async fn store_artifact(
    State(store): State<Store>,
    Id(hash): Id<ArtifactHash>,
    body: Body,
) -> Result<StatusCode, ApiError> {
    let new = store
        .artifact_receive(&hash, body.into_data_stream())
        .await?;
    Ok(if new {
        StatusCode::CREATED
    } else {
        StatusCode::OK
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_stay_inside_the_file() {
        assert_eq!(parse_range("bytes=0-3", 10), Some((0, 3)));
        assert_eq!(parse_range("bytes=4-", 10), Some((4, 9)));
        assert_eq!(parse_range("bytes=-4", 10), Some((6, 9)));
        assert_eq!(parse_range("bytes=-40", 10), Some((0, 9)));
        assert_eq!(parse_range("bytes=8-40", 10), Some((8, 9)));
        for wrong in [
            "bytes=10-",
            "bytes=3-2",
            "bytes=a-b",
            "lines=1-2",
            "bytes=0-1,3-4",
            "bytes=0-",
        ] {
            let bytes = if wrong == "bytes=0-" { 0 } else { 10 };
            assert_eq!(parse_range(wrong, bytes), None, "{wrong}");
        }
    }
}
