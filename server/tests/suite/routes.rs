//! The rest: the OpenAPI document, models, metrics, the lock, a restart, a real socket.

use std::time::Duration;

use granary_api::job::JobState;
use granary_server::queue::MOVES;
use granary_server::{Config, Server, Store, StoreError};
use serde_json::json;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio_util::sync::CancellationToken;

use crate::harness::{fresh, single, spec, sweep_of};

#[test]
fn openapi_document_is_what_it_was() {
    insta::assert_json_snapshot!("openapi", granary_server::openapi());
}

#[tokio::test]
async fn every_documented_route_is_answered() {
    let fresh = fresh().await;
    let document = fresh.get("/api/v1/openapi.json").await.json();
    let paths = document["paths"].as_object().expect("paths");
    assert!(paths.len() >= 20);
    for (path, methods) in paths {
        if methods.get("get").is_none() || path.contains('{') {
            continue;
        }
        assert_eq!(fresh.get(path).await.status, 200, "{path}");
    }
}

#[tokio::test]
async fn models_describe_every_parameter_and_preset() {
    let fresh = fresh().await;
    let model = fresh.get("/api/v1/models/memory").await.json();
    let delta0 = &model["parameters"]["properties"]["delta0"];
    assert_eq!(
        (&delta0["x-symbol"], &delta0["exclusiveMinimum"]),
        (&json!("δ0"), &json!(0.0))
    );
    let gain = &model["results"]["properties"]["gain_e_delta0"];
    assert_eq!(
        (&gain["x-symbol"], &gain["x-unit"]),
        (&json!("𝒢·E·δ0"), &json!("Pa"))
    );
    assert_eq!(model["presets"].as_array().expect("presets").len(), 3);
    let beam = fresh.get("/api/v1/models/beam").await.json();
    let stiffness = &beam["parameters"]["properties"]["youngs_modulus"];
    assert_eq!(stiffness["x-symbol"], "E_p");
    let strength = &beam["results"]["properties"]["ultimate_strength"];
    assert_eq!(
        (&strength["x-symbol"], &strength["x-unit"]),
        (&json!("Y_b"), &json!("Pa"))
    );
    assert_eq!(beam["presets"].as_array().expect("presets").len(), 5);
    assert_eq!(fresh.get("/api/v1/models").await.json()["total"], 2);
    assert_eq!(fresh.get("/api/v1/models/drum").await.status, 404);
}

#[tokio::test]
async fn metrics_count_jobs_by_state() {
    let fresh = fresh().await;
    fresh.submit(&spec()).await;
    let text = fresh.get("/api/v1/metrics").await.text();
    assert!(text.contains("granary_jobs{state=\"ready\"} 2\n"), "{text}");
    assert!(
        text.contains("granary_jobs{state=\"blocked\"} 20\n"),
        "{text}"
    );
}

#[tokio::test]
async fn second_server_on_the_same_data_is_refused_with_the_address_of_the_first() {
    let directory = tempfile::tempdir().expect("a directory");
    let first = Store::open(Config::new(directory.path()), "starting")
        .await
        .expect("a store");
    first
        .lock_announce("a server at http://127.0.0.1:8123")
        .expect("announced");
    let second = Store::open(Config::new(directory.path()), "second").await;
    assert!(
        matches!(second, Err(StoreError::Locked { holder, .. }) if holder == "a server at http://127.0.0.1:8123")
    );
    first.close().await;
    drop(first);
    assert!(
        Store::open(Config::new(directory.path()), "third")
            .await
            .is_ok()
    );
}

#[tokio::test]
async fn restart_loses_nothing_and_repeats_nothing() {
    let before = fresh().await;
    let sweep = sweep_of(&before.submit(&spec()).await);
    for _ in 0..4 {
        let grant = before.take().await.expect("work");
        before.complete(grant.lease, &grant.jobs).await;
    }
    let held = before.take().await.expect("work under way");
    let directory = before.directory;
    before.store.close().await;
    drop((before.store, before.router));
    let store = Store::open(Config::new(directory.path()), "restarted")
        .await
        .expect("a store");
    let router = granary_server::app(store.clone(), CancellationToken::new(), None);
    let after = crate::harness::Fresh {
        store,
        router,
        directory,
    };
    // The worker that held a lease goes on as if nothing had happened.
    after.complete(held.lease, &held.jobs).await;
    let rest = after.work().await.len();
    assert_eq!(4 + held.jobs.len() + rest, 22);
    let detail = after.store.sweep_read(sweep).await.expect("the sweep");
    assert_eq!(detail.points.done, 12);
}

#[tokio::test]
async fn schema_allows_exactly_the_moves_of_the_queue() {
    let migration = include_str!("../../../migrations/sqlite/0002_archived_outcomes.sql");
    for from in JobState::ALL {
        for to in JobState::ALL {
            let named = migration.contains(&format!("'{from}>{to}'"));
            assert_eq!(named, MOVES.contains(&(from, to)), "{from} > {to}");
        }
    }
}

#[tokio::test]
async fn server_answers_on_a_socket_and_stops_when_told_even_with_a_follower() {
    let directory = tempfile::tempdir().expect("a directory");
    let mut config = Config::new(directory.path());
    config.listen = "127.0.0.1:0".parse().expect("an address");
    let store = Store::open(config, "a test").await.expect("a store");
    let submitted = granary_server::submit(
        &store,
        &single("six/1"),
        &granary_server::Submission::default(),
    )
    .await;
    let sweep = sweep_of(&submitted.expect("valid"));
    let server = Server::bind(store).await.expect("bound");
    let address = server.address();
    let shutdown = CancellationToken::new();
    let running = tokio::spawn(server.run(None, shutdown.clone()));
    let mut socket = tokio::net::TcpStream::connect(address)
        .await
        .expect("connected");
    let request = format!("GET /api/v1/sweeps/{sweep}/events HTTP/1.1\r\nHost: {address}\r\n\r\n");
    socket.write_all(request.as_bytes()).await.expect("written");
    let mut start = [0; 15];
    socket.read_exact(&mut start).await.expect("an answer");
    assert_eq!(&start, b"HTTP/1.1 200 OK");
    shutdown.cancel();
    let stopped = tokio::time::timeout(Duration::from_secs(20), running).await;
    stopped
        .expect("in time")
        .expect("no panic")
        .expect("stopped well");
}
