//! Artifacts: checked, immutable, in ranges.

use axum::body::Body;
use axum::http::Method;
use granary_api::id::ArtifactHash;

use crate::harness::{Answer, Fresh, fresh, fresh_with, request};

async fn put(fresh: &Fresh, hash: &ArtifactHash, bytes: &[u8]) -> Answer {
    let request = request(Method::PUT, &format!("/api/v1/artifacts/{hash}"));
    fresh
        .send(request.body(Body::from(bytes.to_vec())).expect("a request"))
        .await
}

async fn get_range(fresh: &Fresh, hash: &ArtifactHash, range: &str) -> Answer {
    let request = request(Method::GET, &format!("/api/v1/artifacts/{hash}")).header("range", range);
    fresh
        .send(request.body(Body::empty()).expect("a request"))
        .await
}

#[tokio::test]
async fn what_was_put_is_got_whole_or_in_ranges() {
    let fresh = fresh().await;
    let bytes: Vec<u8> = (0..100_000_u32).map(|n| (n % 251) as u8).collect();
    let hash = ArtifactHash::of_bytes(&bytes);
    assert_eq!(put(&fresh, &hash, &bytes).await.status, 201);
    assert_eq!(put(&fresh, &hash, &bytes).await.status, 200);
    let whole = fresh.get(&format!("/api/v1/artifacts/{hash}")).await;
    assert_eq!((whole.status.as_u16(), whole.bytes == bytes), (200, true));
    assert!(
        whole.headers["cache-control"]
            .to_str()
            .expect("text")
            .contains("immutable")
    );
    let part = get_range(&fresh, &hash, "bytes=10-19").await;
    assert_eq!(
        (part.status.as_u16(), part.bytes.as_slice()),
        (206, &bytes[10..20])
    );
    assert_eq!(part.headers["content-range"], "bytes 10-19/100000");
    let tail = get_range(&fresh, &hash, "bytes=-5").await;
    assert_eq!(tail.bytes, &bytes[99_995..]);
    let beyond = get_range(&fresh, &hash, "bytes=100000-").await;
    assert_eq!(
        (beyond.status.as_u16(), &beyond.headers["content-range"]),
        (416, &"bytes */100000".parse().expect("text"))
    );
    let etag = whole.headers["etag"].clone();
    let again =
        request(Method::GET, &format!("/api/v1/artifacts/{hash}")).header("if-none-match", etag);
    assert_eq!(
        fresh
            .send(again.body(Body::empty()).expect("a request"))
            .await
            .status,
        304
    );
}

#[tokio::test]
async fn bytes_of_another_hash_are_refused_and_leave_nothing() {
    let fresh = fresh().await;
    let hash = ArtifactHash::of_bytes(b"what was promised");
    let answer = put(&fresh, &hash, b"what was sent").await;
    assert_eq!(
        (answer.status.as_u16(), answer.json()["type"].clone()),
        (422, "/problems/hash-mismatch".into())
    );
    assert!(!fresh.store.artifact_exists(&hash).await);
    let left = fresh.directory.path().join("artifacts").join("tmp");
    assert_eq!(std::fs::read_dir(left).expect("a directory").count(), 0);
}

#[tokio::test]
async fn artifact_over_the_limit_is_413_and_one_over_the_json_limit_is_fine() {
    let fresh = fresh_with(|config| {
        config.artifact_bytes = 10_000;
        config.body_bytes = 100;
    })
    .await;
    let (small, large) = (vec![1; 9_000], vec![2; 11_000]);
    assert_eq!(
        put(&fresh, &ArtifactHash::of_bytes(&small), &small)
            .await
            .status,
        201
    );
    assert_eq!(
        put(&fresh, &ArtifactHash::of_bytes(&large), &large)
            .await
            .status,
        413
    );
}

#[tokio::test]
async fn missing_or_misnamed_artifact_is_404() {
    let fresh = fresh().await;
    let hash = ArtifactHash::of_bytes(b"nothing");
    assert_eq!(
        fresh.get(&format!("/api/v1/artifacts/{hash}")).await.status,
        404
    );
    assert_eq!(
        fresh
            .get("/api/v1/artifacts/..%2F..%2Fgranary.sqlite")
            .await
            .status,
        404
    );
}
