//! The lease protocol without a wire: workers in the server's own process call its store.

use axum::body::Bytes;
use granary_api::id::{ArtifactHash, LeaseId};
use granary_api::lease::{
    Completion, FailureReport, Heartbeat, HeartbeatReply, LeaseGrant, LeaseRequest, Release,
};
use granary_server::{Store, StoreError};
use granary_worker::lease_client::{ArtifactClient, ClientError, LeaseClient};

/// How often workers in this process say how far they are \[s\]: a beat costs one small transaction.
const HEARTBEAT_S: f64 = 2.0;

/// The store of this process.
#[derive(Clone)]
pub(crate) struct DirectLeaseClient {
    store: Store,
}

impl DirectLeaseClient {
    /// A client of `store`.
    pub(crate) fn new(store: Store) -> Self {
        Self { store }
    }
}

/// The answer that the routes would give to `error`.
fn client_error(call: &'static str, error: &StoreError) -> ClientError {
    let refused = |status| ClientError::Refused {
        call,
        status,
        detail: error.to_string(),
    };
    match error {
        StoreError::LeaseLost(_) => ClientError::LeaseLost,
        StoreError::NotFound(_) => refused(404),
        StoreError::Invalid(_)
        | StoreError::HashMismatch { .. }
        | StoreError::ResultMismatch(_) => refused(422),
        StoreError::TooLarge(_) => refused(413),
        StoreError::Database(source) => ClientError::Unavailable {
            call,
            detail: format!("{error}: {source}"),
        },
        StoreError::File { source, .. } => ClientError::Unavailable {
            call,
            detail: format!("{error}: {source}"),
        },
        other => ClientError::Unavailable {
            call,
            detail: other.to_string(),
        },
    }
}

impl ArtifactClient for DirectLeaseClient {
    async fn artifact_get(&self, hash: ArtifactHash) -> Result<Bytes, ClientError> {
        let bytes = match self.store.artifact_get(&hash).await {
            Err(StoreError::NotFound(_)) => return Err(ClientError::ArtifactMissing(hash)),
            answer => answer.map_err(|e| client_error("artifact download", &e))?,
        };
        if ArtifactHash::of_bytes(&bytes) == hash {
            Ok(Bytes::from(bytes))
        } else {
            Err(ClientError::ArtifactDamaged(hash))
        }
    }

    async fn artifact_put(&self, hash: ArtifactHash, bytes: Bytes) -> Result<(), ClientError> {
        let once = futures_util::stream::iter([Ok::<_, std::io::Error>(bytes)]);
        let received = self.store.artifact_receive(&hash, once).await;
        received
            .map(drop)
            .map_err(|e| client_error("artifact upload", &e))
    }
}

impl LeaseClient for DirectLeaseClient {
    async fn take(&self, request: &LeaseRequest) -> Result<Option<LeaseGrant>, ClientError> {
        let grant = self.store.lease_wait(request).await;
        let grant = grant.map_err(|e| client_error("request for work", &e))?;
        Ok(grant.map(|grant| LeaseGrant {
            heartbeat_s: grant.heartbeat_s.min(HEARTBEAT_S),
            ..grant
        }))
    }

    async fn heartbeat(
        &self,
        lease: LeaseId,
        heartbeat: &Heartbeat,
    ) -> Result<HeartbeatReply, ClientError> {
        let reply = self.store.lease_heartbeat(lease, heartbeat).await;
        reply.map_err(|e| client_error("heartbeat", &e))
    }

    async fn complete(&self, lease: LeaseId, completion: &Completion) -> Result<(), ClientError> {
        let done = self.store.lease_complete(lease, completion).await;
        done.map_err(|e| client_error("complete", &e))
    }

    async fn fail(&self, lease: LeaseId, failures: &FailureReport) -> Result<(), ClientError> {
        let done = self.store.lease_fail(lease, failures).await;
        done.map_err(|e| client_error("fail", &e))
    }

    async fn release(&self, lease: LeaseId, release: &Release) -> Result<(), ClientError> {
        let done = self.store.lease_release(lease, release).await;
        done.map_err(|e| client_error("release", &e))
    }
}
