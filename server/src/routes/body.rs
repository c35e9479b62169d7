//! Request bodies and ids in paths, whose errors are problem documents too.

use std::str::FromStr;

use axum::body::Bytes;
use axum::extract::rejection::BytesRejection;
use axum::extract::{FromRequest, FromRequestParts, Path, Request};
use axum::http::StatusCode;
use axum::http::request::Parts;
use granary_api::problem::Mistake;
use serde::de::DeserializeOwned;

use crate::error::ApiError;

/// A JSON body within the limits of size and depth.
pub(super) struct Json<T>(pub(super) T);

impl<S: Send + Sync, T: DeserializeOwned> FromRequest<S> for Json<T> {
    type Rejection = ApiError;

    async fn from_request(request: Request, state: &S) -> Result<Self, ApiError> {
        let bytes = Bytes::from_request(request, state)
            .await
            .map_err(|rejection| too_large(&rejection))?;
        // serde_json stops at a depth of 128, at numbers beyond a double and at anything that is no JSON.
        serde_json::from_slice(&bytes)
            .map(Json)
            .map_err(|error| unreadable(&error))
    }
}

fn too_large(rejection: &BytesRejection) -> ApiError {
    match rejection.status() {
        StatusCode::PAYLOAD_TOO_LARGE => ApiError::new(
            StatusCode::PAYLOAD_TOO_LARGE,
            "too-large",
            "The body is too large",
            "the body is larger than this server takes",
        ),
        _ => ApiError::bad_request("the body ended early"),
    }
}

fn unreadable(error: &serde_json::Error) -> ApiError {
    let detail = error.to_string();
    if error.is_data() {
        let mistake = Mistake {
            pointer: String::new(),
            detail,
        };
        let status = StatusCode::UNPROCESSABLE_ENTITY;
        return ApiError::new(
            status,
            "invalid-body",
            "The body is not what is expected",
            "see errors",
        )
        .with(vec![mistake]);
    }
    ApiError::bad_request(format!("the body is not JSON: {detail}"))
}

/// An id in the path.
pub(super) struct Id<T>(pub(super) T);

impl<S: Send + Sync, T: FromStr + Send> FromRequestParts<S> for Id<T> {
    type Rejection = ApiError;

    async fn from_request_parts(parts: &mut Parts, state: &S) -> Result<Self, ApiError> {
        let path = Path::<String>::from_request_parts(parts, state).await;
        let Path(text) = path.map_err(|_| ApiError::bad_request("the path holds no id"))?;
        let start: String = text.chars().take(80).collect();
        // An id that cannot be is the id of nothing.
        text.parse()
            .map(Id)
            .map_err(|_| ApiError::not_found(format!("there is no {start}")))
    }
}
