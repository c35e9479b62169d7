//! The lease protocol as a worker sees it; one runner serves every way to speak it.

pub mod http;

use bytes::Bytes;
use granary_api::id::{ArtifactHash, LeaseId};
use granary_api::lease::{
    Completion, FailureReport, Heartbeat, HeartbeatReply, LeaseGrant, LeaseRequest, Release,
};

/// Why a call of the lease protocol has no answer.
#[derive(Debug, thiserror::Error)]
pub enum ClientError {
    /// The jobs are held under another lease, or by nobody: final, whatever was computed is not wanted.
    #[error("the lease is no longer held by this worker")]
    LeaseLost,
    /// No answer came in time, or the server is in trouble: another try may go through.
    #[error("no answer to {call}: {detail}")]
    Unavailable {
        /// The call, such as `heartbeat`.
        call: &'static str,
        /// What went wrong on the way.
        detail: String,
    },
    /// The server understood and said no: final.
    #[error("{call} was refused with status {status}: {detail}")]
    Refused {
        /// The call, such as `heartbeat`.
        call: &'static str,
        /// The HTTP status, or the one that HTTP would have.
        status: u16,
        /// The server's reason.
        detail: String,
    },
    /// The artifact is not stored: final.
    #[error("artifact {0} is not stored")]
    ArtifactMissing(ArtifactHash),
    /// The bytes that came do not have the hash that names them.
    #[error("artifact {0} arrived damaged")]
    ArtifactDamaged(ArtifactHash),
}

impl ClientError {
    /// Whether the same call may succeed later.
    #[must_use]
    pub fn is_retryable(&self) -> bool {
        matches!(self, Self::Unavailable { .. })
    }
}

/// Immutable files by hash.
pub trait ArtifactClient: Clone + Send + Sync + 'static {
    /// The bytes of an artifact, their hash verified.
    fn artifact_get(
        &self,
        hash: ArtifactHash,
    ) -> impl Future<Output = Result<Bytes, ClientError>> + Send;

    /// Stores `bytes`, whose hash is `hash`; storing the same again changes nothing.
    fn artifact_put(
        &self,
        hash: ArtifactHash,
        bytes: Bytes,
    ) -> impl Future<Output = Result<(), ClientError>> + Send;
}

/// The worker's side of the queue; each call has a deadline, and none tries twice.
pub trait LeaseClient: ArtifactClient {
    /// Asks for the jobs of one ensemble; `None` if none became ready within `request.wait_s`.
    fn take(
        &self,
        request: &LeaseRequest,
    ) -> impl Future<Output = Result<Option<LeaseGrant>, ClientError>> + Send;

    /// Says that the worker lives and how far its jobs are.
    fn heartbeat(
        &self,
        lease: LeaseId,
        heartbeat: &Heartbeat,
    ) -> impl Future<Output = Result<HeartbeatReply, ClientError>> + Send;

    /// Reports outcomes, whose artifacts are already stored.
    fn complete(
        &self,
        lease: LeaseId,
        completion: &Completion,
    ) -> impl Future<Output = Result<(), ClientError>> + Send;

    /// Reports jobs that cannot be finished.
    fn fail(
        &self,
        lease: LeaseId,
        failures: &FailureReport,
    ) -> impl Future<Output = Result<(), ClientError>> + Send;

    /// Hands jobs back.
    fn release(
        &self,
        lease: LeaseId,
        release: &Release,
    ) -> impl Future<Output = Result<(), ClientError>> + Send;
}
