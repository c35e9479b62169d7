//! Refusals: bad input, the answers it gets, and the table of both in `docs/refusals.md`.
//!
//! The table is written from the answers themselves; the test fails if the file says anything else.
//! `GRANARY_WRITE_DOCS=1 cargo test -p granary-server refusals` writes the file anew: read the difference before you commit it.

use std::fmt::Write;

use axum::body::Body;
use axum::http::Method;
use serde_json::{Map, Value, json};

use crate::harness::{Answer, Fresh, fresh, request};

const PLACE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/refusals.md");

const HEAD: &str = "# Bad input and the answers it gets

Every row is an answer of the server to `POST /api/v1/sweeps`, as `application/problem+json`; nothing is queued by any of them.
A sweep with several mistakes is told all of them, one row each; the command line shows the line of the file instead of the pointer.
The table is written by `server/tests/suite/refusals.rs`, which also keeps it true.

| input | status | pointer | message |
|---|---|---|---|
";

/// The longest input shown \[characters\].
const LONGEST: usize = 110;

/// Bodies that are no sweep for reasons of their own: what to show of each, the status and the body.
fn bodies() -> Vec<(String, u16, String)> {
    let nested = |open: &str, close: &str| open.repeat(100_000) + "1" + &close.repeat(100_000);
    let large = json!({"model": "memory", "name": "x".repeat(4 << 20)}).to_string();
    let named = [
        ("lists nested 100,000 deep", 400, nested("[", "]")),
        ("tables nested 100,000 deep", 400, nested("{\"a\":", "}")),
        ("a body of more than 4 MiB", 413, large),
        ("an empty body", 400, String::new()),
    ];
    let shown = [
        ("{", 400),
        ("model = \"memory\"", 400),
        (r#"{"model": "memory", "fixed": {"delta0": NaN}}"#, 400),
        (r#"{"model": "memory", "fixed": {"delta0": 1e999}}"#, 400),
        (
            r#"{"model": "memory", "fixed": {"delta0": -Infinity}}"#,
            400,
        ),
        (r#"{"model": "memory"} trailing"#, 400),
        ("\u{fffd}", 400),
        (r#"{"model": "memory", "model": "memory"}"#, 422),
    ];
    let named = named.map(|(what, status, body)| (what.to_owned(), status, body));
    let shown = shown.map(|(body, status)| (code(body), status, body.to_owned()));
    named.into_iter().chain(shown).collect()
}

/// Sweeps with mistakes in them, by what is wrong.
fn bad_specs() -> Map<String, Value> {
    serde_json::from_str(include_str!("bad_specs.json")).expect("a table of specs")
}

async fn submit(fresh: &Fresh, body: String) -> Answer {
    let request =
        request(Method::POST, "/api/v1/sweeps").header("content-type", "application/json");
    let answer = fresh.send(request.body(Body::from(body)).expect("a request"));
    let answer = answer.await;
    assert_eq!(answer.headers["content-type"], "application/problem+json");
    answer
}

/// As code in a cell of a table, shortened.
fn code(text: &str) -> String {
    let mut short: String = text.chars().take(LONGEST).collect();
    if short.len() < text.len() {
        short.push('…');
    }
    format!("`{}`", short.replace('|', "\\|"))
}

/// The rows of one answer: one for each mistake, or one for the whole.
fn rows(table: &mut String, input: &str, answer: &Answer) {
    let problem = answer.json();
    assert_eq!(problem["status"], answer.status.as_u16());
    let errors = problem["errors"].as_array().cloned().unwrap_or_default();
    let mut mistakes: Vec<(String, &Value)> = vec![];
    for error in &errors {
        let pointer = error["pointer"].as_str().expect("a pointer");
        mistakes.push((code(pointer).replace("``", ""), &error["detail"]));
    }
    if mistakes.is_empty() {
        mistakes.push((String::new(), &problem["detail"]));
    }
    let mut input = input;
    for (pointer, message) in mistakes {
        let message = message.as_str().expect("a message").replace('|', "\\|");
        let status = answer.status.as_u16();
        let _ = writeln!(table, "| {input} | {status} | {pointer} | {message} |");
        input = "〃";
    }
}

#[tokio::test]
async fn bad_input_is_refused_with_every_mistake_as_the_documented_table_says() {
    let fresh = fresh().await;
    let mut table = HEAD.to_owned();
    for (input, status, body) in bodies() {
        let answer = submit(&fresh, body).await;
        assert_eq!(answer.status, status, "{input}: {}", answer.text());
        rows(&mut table, &input, &answer);
    }
    let bad = bad_specs();
    assert!(bad.len() >= 30);
    for (why, spec) in bad {
        let answer = submit(&fresh, spec.to_string()).await;
        assert_eq!(answer.status, 422, "{why}: {}", answer.text());
        rows(
            &mut table,
            &format!("{why}: {}", code(&spec.to_string())),
            &answer,
        );
    }
    assert_eq!(fresh.get("/api/v1/sweeps").await.json()["total"], 0);
    if std::env::var_os("GRANARY_WRITE_DOCS").is_some() {
        std::fs::write(PLACE, &table).expect("written");
    }
    let documented = std::fs::read_to_string(PLACE).unwrap_or_default();
    assert!(
        documented == table,
        "docs/refusals.md is not what the server answers: see the head of this test\n{table}"
    );
}

#[tokio::test]
async fn body_over_the_configured_limit_is_413() {
    let fresh = crate::harness::fresh_with(|config| config.body_bytes = 1000).await;
    let answer = submit(&fresh, json!({"name": "x".repeat(2000)}).to_string()).await;
    assert_eq!(answer.status, 413);
    assert_eq!(answer.json()["type"], "/problems/too-large");
}
