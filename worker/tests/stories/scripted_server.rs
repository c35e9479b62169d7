//! A server that grants what a test puts in, writes down what it hears, and answers as it is told.

use std::collections::{BTreeMap, VecDeque};
use std::net::SocketAddr;
use std::time::Duration;

use axum::body::Bytes;
use axum::extract::{Path, Request, State};
use axum::http::{StatusCode, header};
use axum::middleware::{Next, from_fn_with_state};
use axum::response::{IntoResponse, Response};
use axum::routing::{get, post};
use axum::{Json, Router};
use granary_api::id::{ArtifactHash, JobId, LeaseId};
use granary_api::lease::{
    Completion, FailureReport, Heartbeat, HeartbeatReply, JobFailure, JobOutcome, JobProgress,
    LeaseGrant, LeaseRequest, Release,
};
use tokio::net::TcpListener;
use tokio::sync::watch;
use tokio::task::JoinHandle;

/// What the server does and what it has heard.
#[derive(Clone, Default)]
pub(crate) struct Script {
    /// Leases to give, first in first out.
    pub(crate) grants: VecDeque<LeaseGrant>,
    /// Jobs that heartbeats are told to drop.
    pub(crate) stop: Vec<JobId>,
    /// Leases that are no longer valid.
    pub(crate) lost: Vec<LeaseId>,
    /// Whether a completion that names a dropped job is refused.
    pub(crate) refuse_stopped: bool,
    /// Whether every request is answered with 503.
    pub(crate) unwell: bool,
    /// Stored files.
    pub(crate) artifacts: BTreeMap<ArtifactHash, Bytes>,
    /// Requests for work so far.
    pub(crate) asked: u64,
    /// Requests answered with 503 so far.
    pub(crate) turned_away: u64,
    /// Heartbeats, newest last.
    pub(crate) beats: Vec<Vec<JobProgress>>,
    /// Outcomes reported.
    pub(crate) outcomes: Vec<JobOutcome>,
    /// Failures reported.
    pub(crate) failures: Vec<JobFailure>,
    /// Jobs handed back.
    pub(crate) released: Vec<JobProgress>,
}

type Shared = watch::Sender<Script>;

/// The server; it can be stopped and started again on the same port.
pub(crate) struct ScriptedServer {
    script: Shared,
    address: SocketAddr,
    task: Option<JoinHandle<()>>,
}

impl ScriptedServer {
    pub(crate) async fn start() -> Self {
        let mut server = Self {
            script: watch::Sender::default(),
            address: SocketAddr::from(([127, 0, 0, 1], 0)),
            task: None,
        };
        server.begin().await;
        server
    }

    /// Serves, on the same port as before if there was one.
    pub(crate) async fn begin(&mut self) {
        let listener = TcpListener::bind(self.address).await.expect("free port");
        self.address = listener.local_addr().expect("bound");
        let app = router(self.script.clone());
        self.task = Some(tokio::spawn(async move {
            axum::serve(listener, app).await.expect("server runs");
        }));
    }

    /// Stops serving new connections and answers those that are open with 503.
    pub(crate) async fn kill(&mut self) {
        let task = self.task.take().expect("serving");
        task.abort();
        let _ = task.await;
        self.change(|script| script.unwell = true);
    }

    pub(crate) fn address(&self) -> String {
        format!("http://{}", self.address)
    }

    pub(crate) fn change(&self, change: impl FnOnce(&mut Script)) {
        self.script.send_modify(change);
    }

    pub(crate) fn store(&self, bytes: &'static [u8]) -> ArtifactHash {
        let hash = ArtifactHash::of_bytes(bytes);
        self.change(|script| {
            script.artifacts.insert(hash, Bytes::from_static(bytes));
        });
        hash
    }

    /// Waits until `condition` holds, 20 seconds at most.
    pub(crate) async fn until(&self, condition: impl FnMut(&Script) -> bool) -> Script {
        let mut changes = self.script.subscribe();
        let reached = changes.wait_for(condition);
        tokio::time::timeout(Duration::from_secs(20), reached)
            .await
            .expect("the condition is reached within 20 s")
            .expect("the script lives")
            .clone()
    }
}

fn router(script: Shared) -> Router {
    let api = Router::new()
        .route("/leases", post(take))
        .route("/leases/{lease}/heartbeat", post(heartbeat))
        .route("/leases/{lease}/complete", post(complete))
        .route("/leases/{lease}/fail", post(fail))
        .route("/leases/{lease}/release", post(release))
        .route("/artifacts/{hash}", get(artifact).put(put_artifact));
    Router::new()
        .nest("/api/v1", api)
        .layer(from_fn_with_state(script.clone(), at_the_door))
        .with_state(script)
}

/// Checks token and health before anything else.
async fn at_the_door(State(script): State<Shared>, request: Request, next: Next) -> Response {
    let unwell = script.borrow().unwell;
    if unwell {
        script.send_modify(|script| script.turned_away += 1);
        return StatusCode::SERVICE_UNAVAILABLE.into_response();
    }
    let expected = format!("Bearer {}", crate::TOKEN);
    match request.headers().get(header::AUTHORIZATION) {
        Some(token) if *token == *expected => next.run(request).await,
        _ => StatusCode::UNAUTHORIZED.into_response(),
    }
}

async fn take(State(script): State<Shared>, Json(request): Json<LeaseRequest>) -> Response {
    script.send_modify(|script| script.asked += 1);
    let mut changes = script.subscribe();
    let ready = changes.wait_for(|script| !script.grants.is_empty());
    // The guard must go before the script is changed.
    let ready = tokio::time::timeout(Duration::from_secs_f64(request.wait_s), ready).await;
    drop(ready);
    let mut grant = None;
    script.send_modify(|script| grant = script.grants.pop_front());
    grant.map_or_else(
        || StatusCode::NO_CONTENT.into_response(),
        |grant| Json(grant).into_response(),
    )
}

/// Changes the script if `lease` is still valid.
fn under(script: &Shared, lease: LeaseId, change: impl FnOnce(&mut Script)) -> StatusCode {
    if script.borrow().lost.contains(&lease) {
        return StatusCode::CONFLICT;
    }
    script.send_modify(change);
    StatusCode::NO_CONTENT
}

async fn heartbeat(
    State(script): State<Shared>,
    Path(lease): Path<LeaseId>,
    Json(body): Json<Heartbeat>,
) -> Response {
    let status = under(&script, lease, |script| script.beats.push(body.jobs));
    if status == StatusCode::CONFLICT {
        return status.into_response();
    }
    let stop = script.borrow().stop.clone();
    Json(HeartbeatReply { stop }).into_response()
}

async fn complete(
    State(script): State<Shared>,
    Path(lease): Path<LeaseId>,
    Json(body): Json<Completion>,
) -> StatusCode {
    let refused = {
        let script = script.borrow();
        let dropped = |outcome: &JobOutcome| script.stop.contains(&outcome.job);
        let stored = |hash: &ArtifactHash| script.artifacts.contains_key(hash);
        let mut named = body.outcomes.iter().flat_map(|o| o.artifacts.values());
        assert!(
            named.all(stored),
            "artifacts are stored before the completion names them"
        );
        script.refuse_stopped && body.outcomes.iter().any(dropped)
    };
    if refused {
        return StatusCode::CONFLICT;
    }
    under(&script, lease, |script| {
        script.outcomes.extend(body.outcomes);
    })
}

async fn fail(
    State(script): State<Shared>,
    Path(lease): Path<LeaseId>,
    Json(body): Json<FailureReport>,
) -> StatusCode {
    under(&script, lease, |script| {
        script.failures.extend(body.failures);
    })
}

async fn release(
    State(script): State<Shared>,
    Path(lease): Path<LeaseId>,
    Json(body): Json<Release>,
) -> StatusCode {
    under(&script, lease, |script| script.released.extend(body.jobs))
}

async fn artifact(State(script): State<Shared>, Path(hash): Path<String>) -> Response {
    let hash: ArtifactHash = hash.parse().expect("a hash");
    match script.borrow().artifacts.get(&hash) {
        Some(bytes) => bytes.clone().into_response(),
        None => StatusCode::NOT_FOUND.into_response(),
    }
}

async fn put_artifact(
    State(script): State<Shared>,
    Path(hash): Path<String>,
    body: Bytes,
) -> StatusCode {
    let hash: ArtifactHash = hash.parse().expect("a hash");
    assert_eq!(ArtifactHash::of_bytes(&body), hash);
    script.send_modify(|script| {
        script.artifacts.insert(hash, body);
    });
    StatusCode::CREATED
}
