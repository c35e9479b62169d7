//! The gate: hosts, origins, content types, tokens.

use axum::body::Body;
use axum::http::{Method, Request, header};
use granary_api::token::Scope;
use granary_server::{Config, ServeError, Server, Store};
use serde_json::json;

use crate::harness::{Fresh, fresh, fresh_with, request, spec};

async fn with_header(fresh: &Fresh, method: Method, name: &str, value: &str) -> u16 {
    let body = if method == Method::GET {
        String::new()
    } else {
        spec().to_string()
    };
    let path = "/api/v1/sweeps";
    let mut request = Request::builder().method(method).uri(path);
    if name != "host" {
        request = request.header(header::HOST, "localhost:8000");
    }
    if name != "content-type" {
        request = request.header(header::CONTENT_TYPE, "application/json");
    }
    let request = request
        .header(name, value)
        .body(Body::from(body))
        .expect("a request");
    fresh.send(request).await.status.as_u16()
}

#[tokio::test]
async fn only_our_hosts_are_answered() {
    let fresh = fresh_with(|config| config.hosts = vec!["granary.example".to_owned()]).await;
    for (host, status) in [
        ("localhost", 200),
        ("127.0.0.1:8000", 200),
        ("[::1]:8000", 200),
        ("granary.example", 200),
        ("GRANARY.example:443", 200),
        ("evil.example", 421),
        ("localhost.evil.example", 421),
        ("10.0.0.1", 421),
    ] {
        assert_eq!(
            with_header(&fresh, Method::GET, "host", host).await,
            status,
            "{host}"
        );
    }
}

#[tokio::test]
async fn pages_of_another_origin_are_refused() {
    let fresh = fresh().await;
    for (origin, status) in [
        ("http://localhost:8000", 201),
        ("http://localhost:9000", 403),
        ("https://evil.example", 403),
        ("null", 403),
    ] {
        assert_eq!(
            with_header(&fresh, Method::POST, "origin", origin).await,
            status,
            "{origin}"
        );
    }
}

#[tokio::test]
async fn writes_must_be_json_even_without_a_body() {
    let fresh = fresh().await;
    for (kind, status) in [
        ("application/json", 201),
        ("application/json; charset=utf-8", 200),
        ("text/plain", 415),
        ("application/x-www-form-urlencoded", 415),
    ] {
        assert_eq!(
            with_header(&fresh, Method::POST, "content-type", kind).await,
            status,
            "{kind}"
        );
    }
    let bare = request(Method::POST, "/api/v1/sweeps/x/cancel")
        .body(Body::empty())
        .expect("a request");
    assert_eq!(fresh.send(bare).await.status, 415);
}

async fn status_with(fresh: &Fresh, method: Method, path: &str, token: Option<&str>) -> u16 {
    let mut request = request(method, path).header(header::CONTENT_TYPE, "application/json");
    if let Some(token) = token {
        request = request.header(header::AUTHORIZATION, format!("Bearer {token}"));
    }
    fresh
        .send(request.body(Body::from("{}")).expect("a request"))
        .await
        .status
        .as_u16()
}

#[tokio::test]
async fn once_a_token_exists_every_request_needs_one_with_the_scope() {
    let fresh = fresh().await;
    assert_eq!(
        status_with(&fresh, Method::GET, "/api/v1/sweeps", None).await,
        200
    );
    let read = fresh
        .store
        .token_create("r", &[Scope::Read])
        .await
        .expect("a token");
    let submit = fresh
        .store
        .token_create("s", &[Scope::Submit])
        .await
        .expect("a token");
    let worker = fresh
        .store
        .token_create("w", &[Scope::Worker])
        .await
        .expect("a token");
    let admin = fresh
        .store
        .token_create("a", &[Scope::Admin])
        .await
        .expect("a token");
    let cases = [
        (Method::GET, "/api/v1/sweeps", [401, 200, 200, 200, 200]),
        (Method::POST, "/api/v1/sweeps", [401, 403, 422, 403, 422]),
        (Method::POST, "/api/v1/leases", [401, 403, 403, 422, 422]),
        (Method::GET, "/api/v1/metrics", [401, 200, 200, 200, 200]),
        (Method::GET, "/api/v1/healthz", [200; 5]),
        (Method::GET, "/api/v1/openapi.json", [200; 5]),
    ];
    for (method, path, expected) in cases {
        let tokens = [
            None,
            Some(&read),
            Some(&submit),
            Some(&worker),
            Some(&admin),
        ];
        for (token, expected) in tokens.into_iter().zip(expected) {
            let status = status_with(&fresh, method.clone(), path, token.map(String::as_str)).await;
            assert_eq!(status, expected, "{method} {path} {token:?}");
        }
    }
    assert_eq!(
        status_with(&fresh, Method::GET, "/api/v1/sweeps", Some("granary_0")).await,
        401
    );
    assert_eq!(fresh.store.token_revoke("r").await.expect("revoked"), 1);
    assert_eq!(
        status_with(&fresh, Method::GET, "/api/v1/sweeps", Some(&read)).await,
        401
    );
}

#[tokio::test]
async fn token_text_is_nowhere_on_disk() {
    let fresh = fresh().await;
    let token = fresh
        .store
        .token_create("x", &[Scope::Admin])
        .await
        .expect("a token");
    assert_eq!(token.len(), "granary_".len() + 64);
    for entry in std::fs::read_dir(fresh.directory.path()).expect("the data") {
        let path = entry.expect("an entry").path();
        if path.is_file() {
            let bytes = std::fs::read(&path).expect("readable");
            assert!(
                !bytes
                    .windows(token.len())
                    .any(|window| window == token.as_bytes()),
                "{path:?}"
            );
        }
    }
}

#[tokio::test]
async fn configured_token_works_like_a_stored_one() {
    let fresh =
        fresh_with(|config| config.tokens = vec![("secret".to_owned(), vec![Scope::Read])]).await;
    assert_eq!(
        status_with(&fresh, Method::GET, "/api/v1/sweeps", None).await,
        401
    );
    assert_eq!(
        status_with(&fresh, Method::GET, "/api/v1/sweeps", Some("secret")).await,
        200
    );
}

#[tokio::test]
async fn open_address_without_token_is_refused_and_with_one_is_not() {
    let directory = tempfile::tempdir().expect("a directory");
    let mut config = Config::new(directory.path());
    config.listen = "0.0.0.0:0".parse().expect("an address");
    let store = Store::open(config, "a test").await.expect("a store");
    assert!(matches!(
        Server::bind(store.clone()).await,
        Err(ServeError::Open(_))
    ));
    store
        .token_create("x", &[Scope::Admin])
        .await
        .expect("a token");
    assert!(Server::bind(store).await.is_ok());
}

#[tokio::test]
async fn unknown_routes_and_methods_are_problem_documents() {
    let fresh = fresh().await;
    for (method, path, status) in [
        (Method::GET, "/api/v1/nothing", 404),
        (Method::GET, "/nothing", 404),
        (Method::DELETE, "/api/v1/sweeps", 405),
        (Method::GET, "/api/v1/jobs/b3:12", 404),
    ] {
        let request = request(method, path).header(header::CONTENT_TYPE, "application/json");
        let answer = fresh
            .send(request.body(Body::empty()).expect("a request"))
            .await;
        assert_eq!(answer.status.as_u16(), status, "{path}");
        assert_eq!(
            answer.headers["content-type"], "application/problem+json",
            "{path}"
        );
        assert_eq!(answer.json()["status"], json!(status));
    }
}
