//! The gate: whose request passes, and what is noted of it.
//!
//! A request must name one of our hosts, a write must be JSON, a page of another origin gets nothing,
//! and where tokens exist every request carries one.

use axum::extract::{MatchedPath, Request, State};
use axum::http::request::Parts;
use axum::http::uri::Authority;
use axum::http::{HeaderMap, Method, StatusCode, Uri, header};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};
use granary_api::token::Scope;
use std::time::Instant;

use super::App;
use crate::error::ApiError;

/// Lets a request through, or says why not.
pub(super) async fn pass(State(app): State<App>, request: Request, next: Next) -> Response {
    let (parts, body) = request.into_parts();
    match check(&app, &parts).await {
        Ok(()) => next.run(Request::from_parts(parts, body)).await,
        Err(error) => error.into_response(),
    }
}

/// Notes a request in the log, below `info`: a sweep makes many.
pub(super) async fn record(request: Request, next: Next) -> Response {
    let start = Instant::now();
    let method = request.method().clone();
    let matched = request
        .extensions()
        .get::<MatchedPath>()
        .map(|path| path.as_str().to_owned());
    let route = matched.unwrap_or_default();
    let response = next.run(request).await;
    let (status, ms) = (
        response.status().as_u16(),
        start.elapsed().as_millis() as u64,
    );
    tracing::debug!(http.method = %method, http.route = route, http.status = status, http.ms = ms, "http.request");
    response
}

async fn check(app: &App, request: &Parts) -> Result<(), ApiError> {
    let (method, path, headers) = (&request.method, request.uri.path(), &request.headers);
    let host = host(&request.uri, headers)?;
    if !is_ours(app, &host) {
        let detail = format!("{host} is not a name of this server");
        let status = StatusCode::MISDIRECTED_REQUEST;
        return Err(ApiError::new(
            status,
            "foreign-host",
            "The host is not ours",
            detail,
        ));
    }
    let origin = headers.get(header::ORIGIN);
    if let Some(origin) = origin
        && !same_origin(origin.to_str().unwrap_or_default(), &host)
    {
        let detail = "a page of another origin may not speak to this server";
        return Err(ApiError::new(
            StatusCode::FORBIDDEN,
            "foreign-origin",
            "The origin is foreign",
            detail,
        ));
    }
    let writes = !matches!(*method, Method::GET | Method::HEAD | Method::OPTIONS);
    if writes && !path.starts_with("/api/v1/artifacts/") && !is_json(headers) {
        let detail = "a write must have the Content-Type application/json";
        let status = StatusCode::UNSUPPORTED_MEDIA_TYPE;
        return Err(ApiError::new(
            status,
            "not-json",
            "The body is not JSON",
            detail,
        ));
    }
    match needed(method, path) {
        Some(scope) if app.store.token_any().await? => authorize(app, headers, scope).await,
        _ => Ok(()),
    }
}

/// The host that the request names.
fn host(uri: &Uri, headers: &HeaderMap) -> Result<Authority, ApiError> {
    let named = headers
        .get(header::HOST)
        .and_then(|host| host.to_str().ok());
    let named = named.or_else(|| uri.authority().map(Authority::as_str));
    let parsed = named.and_then(|host| host.parse().ok());
    parsed.ok_or_else(|| ApiError::bad_request("the request names no host"))
}

fn is_ours(app: &App, host: &Authority) -> bool {
    let name = host.host().trim_start_matches('[').trim_end_matches(']');
    let config = app.store.config();
    let loopback = name
        .parse()
        .is_ok_and(|address: std::net::IpAddr| address.is_loopback());
    loopback
        || name.eq_ignore_ascii_case("localhost")
        || name == config.listen.ip().to_string()
        || config
            .hosts
            .iter()
            .any(|ours| ours.eq_ignore_ascii_case(name))
}

/// Whether `origin` is a page that this very server gave.
fn same_origin(origin: &str, host: &Authority) -> bool {
    let authority = origin
        .strip_prefix("http://")
        .or_else(|| origin.strip_prefix("https://"));
    authority.is_some_and(|authority| authority.eq_ignore_ascii_case(host.as_str()))
}

fn is_json(headers: &HeaderMap) -> bool {
    let kind = headers
        .get(header::CONTENT_TYPE)
        .and_then(|kind| kind.to_str().ok());
    let kind = kind
        .and_then(|kind| kind.split(';').next())
        .unwrap_or_default();
    kind.trim().eq_ignore_ascii_case("application/json")
}

/// What a request needs where tokens exist; nothing for the page, the document of the API and the pulse.
fn needed(method: &Method, path: &str) -> Option<Scope> {
    let path = path.strip_prefix("/api/v1")?;
    let reads = matches!(*method, Method::GET | Method::HEAD);
    match path {
        "/healthz" | "/openapi.json" => None,
        _ if reads => Some(Scope::Read),
        _ if path.starts_with("/leases") || path.starts_with("/artifacts") => Some(Scope::Worker),
        _ if path.starts_with("/sweeps") => Some(Scope::Submit),
        _ => Some(Scope::Admin),
    }
}

async fn authorize(app: &App, headers: &HeaderMap, needed: Scope) -> Result<(), ApiError> {
    let header = headers
        .get(header::AUTHORIZATION)
        .and_then(|header| header.to_str().ok());
    let token = header
        .and_then(|header| header.strip_prefix("Bearer "))
        .map(str::trim);
    let scopes = match token {
        Some(token) => app.store.token_scopes(token).await?,
        None => None,
    };
    let Some(scopes) = scopes else {
        let detail = "send a token of this server as `Authorization: Bearer …`";
        return Err(ApiError::new(
            StatusCode::UNAUTHORIZED,
            "unauthorized",
            "A token is needed",
            detail,
        ));
    };
    if scopes.iter().any(|scope| scope.allows(needed)) {
        return Ok(());
    }
    let name = serde_json::to_value(needed).unwrap_or_default();
    let detail = format!("the token does not have the scope {name}");
    Err(ApiError::new(
        StatusCode::FORBIDDEN,
        "forbidden",
        "The token does not allow this",
        detail,
    ))
}
