//! Errors on the wire: every one an `application/problem+json`.

use axum::Json;
use axum::http::{HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};
use granary_api::problem::{Mistake, Problem};

use crate::store::StoreError;

/// A status and what to say about it.
#[derive(Debug)]
pub(crate) struct ApiError(pub(crate) Box<Problem>);

impl ApiError {
    /// A problem of `kind` without a list of mistakes.
    #[must_use]
    pub(crate) fn new(
        status: StatusCode,
        kind: &str,
        title: &str,
        detail: impl Into<String>,
    ) -> Self {
        Self(Box::new(Problem {
            kind: format!("/problems/{kind}"),
            title: title.to_owned(),
            status: status.as_u16(),
            detail: Some(detail.into()),
            errors: vec![],
        }))
    }

    /// 400: the request cannot be read.
    #[must_use]
    pub(crate) fn bad_request(detail: impl Into<String>) -> Self {
        Self::new(
            StatusCode::BAD_REQUEST,
            "bad-request",
            "The request cannot be read",
            detail,
        )
    }

    /// 404.
    #[must_use]
    pub(crate) fn not_found(detail: impl Into<String>) -> Self {
        Self::new(
            StatusCode::NOT_FOUND,
            "not-found",
            "There is no such thing",
            detail,
        )
    }

    /// The same with one entry per mistake.
    #[must_use]
    pub(crate) fn with(mut self, errors: Vec<Mistake>) -> Self {
        self.0.errors = errors;
        self
    }

    /// 422 of a sweep.
    fn invalid(mistakes: Vec<Mistake>) -> Self {
        let count = mistakes.len();
        let s = if count == 1 { "" } else { "s" };
        let detail = format!("{count} mistake{s}, nothing was queued");
        let status = StatusCode::UNPROCESSABLE_ENTITY;
        Self::new(status, "invalid-sweep", "The sweep is not valid", detail).with(mistakes)
    }
}

impl From<StoreError> for ApiError {
    fn from(error: StoreError) -> Self {
        let said = error.to_string();
        match error {
            StoreError::NotFound(_) => Self::not_found(said),
            StoreError::Invalid(mistakes) => Self::invalid(mistakes),
            StoreError::LeaseLost(jobs) => {
                let lost = |job| Mistake {
                    pointer: String::new(),
                    detail: format!("{job} is not under this lease"),
                };
                let errors = jobs.iter().map(lost).collect();
                let detail = format!("{said}; nothing was recorded");
                Self::new(
                    StatusCode::CONFLICT,
                    "lease_lost",
                    "The lease is lost",
                    detail,
                )
                .with(errors)
            }
            StoreError::KeyReused => {
                let status = StatusCode::UNPROCESSABLE_ENTITY;
                Self::new(status, "idempotency-key-reused", "The key is taken", said)
            }
            StoreError::ResultMismatch(mistakes) => {
                let status = StatusCode::UNPROCESSABLE_ENTITY;
                let detail = format!("{said}; nothing was recorded");
                let title = "The outcome is not the one that was hashed";
                Self::new(status, "result-mismatch", title, detail).with(mistakes)
            }
            StoreError::HashMismatch { .. } => {
                let status = StatusCode::UNPROCESSABLE_ENTITY;
                Self::new(
                    status,
                    "hash-mismatch",
                    "The bytes are not the artifact",
                    said,
                )
            }
            StoreError::TooLarge(_) => Self::new(
                StatusCode::PAYLOAD_TOO_LARGE,
                "too-large",
                "The body is too large",
                said,
            ),
            StoreError::Database(_)
            | StoreError::File { .. }
            | StoreError::Corrupt { .. }
            | StoreError::Schema { .. }
            | StoreError::Locked { .. } => {
                tracing::error!(error = %said, cause = ?std::error::Error::source(&error), "request failed");
                let status = StatusCode::INTERNAL_SERVER_ERROR;
                Self::new(
                    status,
                    "internal",
                    "The server failed",
                    "see the server's log",
                )
            }
        }
    }
}

impl IntoResponse for ApiError {
    fn into_response(self) -> Response {
        let status =
            StatusCode::from_u16(self.0.status).unwrap_or(StatusCode::INTERNAL_SERVER_ERROR);
        let mut response = (status, Json(*self.0)).into_response();
        let kind = HeaderValue::from_static("application/problem+json");
        response.headers_mut().insert(header::CONTENT_TYPE, kind);
        if status == StatusCode::UNAUTHORIZED {
            let bearer = HeaderValue::from_static("Bearer");
            response
                .headers_mut()
                .insert(header::WWW_AUTHENTICATE, bearer);
        }
        response
    }
}
