//! Events: followed live, resumed after a break, bounded.

use std::time::Duration;

use axum::body::Body;
use axum::http::Method;
use futures_util::StreamExt;
use granary_api::id::SweepId;
use tower::ServiceExt;

use crate::harness::{Fresh, fresh, fresh_with, request, single, spec, sweep_of};

/// Reads events until one satisfies `last`: their ids and kinds, progress and comments apart.
async fn follow(
    fresh: &Fresh,
    sweep: SweepId,
    after: Option<u64>,
    last: impl Fn(&str, &str) -> bool,
) -> Vec<(Option<u64>, String)> {
    let mut builder = request(Method::GET, &format!("/api/v1/sweeps/{sweep}/events"));
    if let Some(id) = after {
        builder = builder.header("last-event-id", id.to_string());
    }
    let request = builder.body(Body::empty()).expect("a request");
    let response = fresh
        .router
        .clone()
        .oneshot(request)
        .await
        .expect("routes never fail");
    assert_eq!(response.headers()["content-type"], "text/event-stream");
    let mut stream = response.into_body().into_data_stream();
    let (mut text, mut events) = (String::new(), vec![]);
    let read = async {
        loop {
            let piece = stream.next().await.expect("more events").expect("a piece");
            text.push_str(std::str::from_utf8(&piece).expect("text"));
            while let Some((event, rest)) = text.split_once("\n\n") {
                let field = |name: &str| {
                    event
                        .lines()
                        .find_map(|line| line.strip_prefix(name))
                        .map(|value| value.trim().to_owned())
                };
                let kind = field("event:").unwrap_or_default();
                let data = field("data:").unwrap_or_default();
                if !matches!(kind.as_str(), "progress" | "") {
                    events.push((field("id:").and_then(|id| id.parse().ok()), kind.clone()));
                }
                let end = last(&kind, &data);
                let rest = rest.len();
                text.drain(..text.len() - rest);
                if end {
                    return;
                }
            }
        }
    };
    tokio::time::timeout(Duration::from_secs(30), read)
        .await
        .expect("events in time");
    events
}

#[tokio::test]
async fn follower_sees_every_point_and_the_end_and_resumes_where_it_stopped() {
    let fresh = fresh().await;
    let sweep = sweep_of(&fresh.submit(&spec()).await);
    fresh.work().await;
    let finished = |kind: &str, data: &str| kind == "state" && data.contains("finished");
    let all = follow(&fresh, sweep, None, finished).await;
    assert_eq!(all.iter().filter(|(_, kind)| kind == "point").count(), 12);
    let ids: Vec<u64> = all.iter().filter_map(|(id, _)| *id).collect();
    assert_eq!(ids, (1..=13).collect::<Vec<_>>());
    let rest = follow(&fresh, sweep, Some(ids[4]), finished).await;
    assert_eq!(rest, all[5..]);
}

#[tokio::test]
async fn waiting_follower_is_told_as_it_happens() {
    let fresh = fresh().await;
    let sweep = sweep_of(&fresh.submit(&single("six/1")).await);
    let finished = |kind: &str, data: &str| kind == "state" && data.contains("finished");
    let (events, _) = tokio::join!(follow(&fresh, sweep, None, finished), fresh.work());
    assert_eq!(events.len(), 2);
}

#[tokio::test]
async fn summary_comes_as_progress() {
    let fresh = fresh().await;
    let sweep = sweep_of(&fresh.submit(&spec()).await);
    follow(&fresh, sweep, None, |kind, data| {
        kind == "progress" && data.contains("\"total\":12")
    })
    .await;
}

#[tokio::test]
async fn forgotten_events_are_admitted_with_a_reset() {
    let fresh = fresh_with(|config| config.events = 3).await;
    let sweep = sweep_of(&fresh.submit(&spec()).await);
    fresh.work().await;
    let finished = |kind: &str, data: &str| kind == "state" && data.contains("finished");
    let events = follow(&fresh, sweep, Some(2), finished).await;
    assert_eq!(events[0].1, "reset");
    assert_eq!(events.len(), 1 + 3);
    assert_eq!(events[3].0, Some(13));
}
