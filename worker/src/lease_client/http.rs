//! The lease protocol over HTTP.

use std::time::Duration;

use bytes::Bytes;
use granary_api::id::{ArtifactHash, LeaseId};
use granary_api::lease::{
    Completion, FailureReport, Heartbeat, HeartbeatReply, LeaseGrant, LeaseRequest, Release,
};
use granary_api::problem::Problem;
use reqwest::header::{AUTHORIZATION, HeaderMap, HeaderValue};
use reqwest::{RequestBuilder, Response, StatusCode};
use serde::Serialize;

use super::{ArtifactClient, ClientError, LeaseClient};

/// The longest that a short call may take.
const CALL: Duration = Duration::from_secs(10);
/// The longest that connecting may take.
const CONNECT: Duration = Duration::from_secs(5);
/// The slowest line that artifacts are expected to pass \[bytes/s\].
const SLOWEST_LINE: u64 = 1 << 20;
/// The longest that an artifact of unknown size may take.
const DOWNLOAD: Duration = Duration::from_mins(10);

/// Why a client cannot be made.
#[derive(Debug, thiserror::Error)]
pub enum SetupError {
    /// The address is not an HTTP one.
    #[error("`{0}` is not an http or https address")]
    Address(String),
    /// The token holds characters that no header may.
    #[error("the token holds characters that a header cannot carry")]
    Token,
    /// The HTTP library does not start.
    #[error("the HTTP client cannot start")]
    Client(#[from] reqwest::Error),
}

/// An HTTP client for the server at `address`, with our TLS, our time limits, and `token` in every request.
///
/// # Errors
/// If the address is not an HTTP one, the token cannot stand in a header, or TLS cannot be set up.
pub fn http_client(address: &str, token: Option<&str>) -> Result<reqwest::Client, SetupError> {
    let secure = address.starts_with("https://");
    if !secure && !address.starts_with("http://") {
        return Err(SetupError::Address(address.to_owned()));
    }
    // An error means that a provider is installed already, which is what we want.
    let _ = rustls::crypto::ring::default_provider().install_default();
    let mut headers = HeaderMap::new();
    if let Some(token) = token {
        let mut value = HeaderValue::from_str(&format!("Bearer {}", token.trim()))
            .map_err(|_| SetupError::Token)?;
        value.set_sensitive(true);
        headers.insert(AUTHORIZATION, value);
    }
    let mut client = reqwest::Client::builder()
        .default_headers(headers)
        .connect_timeout(CONNECT)
        .user_agent(concat!("granary/", env!("CARGO_PKG_VERSION")));
    if !secure {
        // A small container has no authorities' certificates, and a plain address needs none.
        client = client.tls_certs_only([]);
    }
    Ok(client.build()?)
}

/// A server's lease routes.
#[derive(Clone, Debug)]
pub struct HttpLeaseClient {
    http: reqwest::Client,
    api: String,
}

impl HttpLeaseClient {
    /// A client of the server at `server`, such as `http://127.0.0.1:8080`.
    ///
    /// # Errors
    /// If the address or the token cannot be one.
    pub fn new(server: &str, token: Option<&str>) -> Result<Self, SetupError> {
        Ok(Self {
            http: http_client(server, token)?,
            api: format!("{}/api/v1", server.trim_end_matches('/')),
        })
    }

    /// Sends `body` to `{lease}/{call}`.
    async fn post<T: Serialize + Sync>(
        &self,
        call: &'static str,
        lease: LeaseId,
        body: &T,
    ) -> Result<Response, ClientError> {
        let request = self
            .http
            .post(format!("{}/leases/{lease}/{call}", self.api))
            .json(body)
            .timeout(CALL);
        send(call, request).await
    }

    fn artifact_url(&self, hash: ArtifactHash) -> String {
        format!("{}/artifacts/{hash}", self.api)
    }
}

/// Sends `request`; any status but success is an error.
async fn send(call: &'static str, request: RequestBuilder) -> Result<Response, ClientError> {
    let response = request.send().await.map_err(|e| unavailable(call, &e))?;
    if response.status().is_success() {
        return Ok(response);
    }
    let status = response.status();
    let problem: Option<Problem> = response.json().await.ok();
    let detail = problem.map_or_else(
        || status.to_string(),
        |problem| problem.detail.unwrap_or(problem.title),
    );
    Err(match status {
        StatusCode::CONFLICT => ClientError::LeaseLost,
        StatusCode::TOO_MANY_REQUESTS | StatusCode::REQUEST_TIMEOUT => {
            ClientError::Unavailable { call, detail }
        }
        status if status.is_server_error() => ClientError::Unavailable { call, detail },
        status => ClientError::Refused {
            call,
            status: status.as_u16(),
            detail,
        },
    })
}

/// An error on the way, with the causes that the library keeps apart.
fn unavailable(call: &'static str, error: &reqwest::Error) -> ClientError {
    let mut detail = error.to_string();
    let mut cause = std::error::Error::source(error);
    while let Some(error) = cause {
        detail = format!("{detail}: {error}");
        cause = error.source();
    }
    ClientError::Unavailable { call, detail }
}

impl ArtifactClient for HttpLeaseClient {
    async fn artifact_get(&self, hash: ArtifactHash) -> Result<Bytes, ClientError> {
        const CALL: &str = "artifact download";
        let request = self.http.get(self.artifact_url(hash)).timeout(DOWNLOAD);
        let response = match send(CALL, request).await {
            Err(ClientError::Refused { status: 404, .. }) => {
                return Err(ClientError::ArtifactMissing(hash));
            }
            answer => answer?,
        };
        let bytes = response.bytes().await.map_err(|e| unavailable(CALL, &e))?;
        if ArtifactHash::of_bytes(&bytes) == hash {
            Ok(bytes)
        } else {
            Err(ClientError::ArtifactDamaged(hash))
        }
    }

    async fn artifact_put(&self, hash: ArtifactHash, bytes: Bytes) -> Result<(), ClientError> {
        let deadline = CALL + Duration::from_secs(bytes.len() as u64 / SLOWEST_LINE);
        let request = self
            .http
            .put(self.artifact_url(hash))
            .header("content-type", "application/octet-stream")
            .body(bytes)
            .timeout(deadline);
        send("artifact upload", request).await.map(drop)
    }
}

impl LeaseClient for HttpLeaseClient {
    async fn take(&self, request: &LeaseRequest) -> Result<Option<LeaseGrant>, ClientError> {
        const CALL: &str = "request for work";
        let deadline = self::CALL + Duration::from_secs_f64(request.wait_s.clamp(0.0, 60.0));
        let post = self
            .http
            .post(format!("{}/leases", self.api))
            .json(request)
            .timeout(deadline);
        let response = send(CALL, post).await?;
        if response.status() == StatusCode::NO_CONTENT {
            return Ok(None);
        }
        response.json().await.map_err(|e| unavailable(CALL, &e))
    }

    async fn heartbeat(
        &self,
        lease: LeaseId,
        heartbeat: &Heartbeat,
    ) -> Result<HeartbeatReply, ClientError> {
        let response = self.post("heartbeat", lease, heartbeat).await?;
        response
            .json()
            .await
            .map_err(|e| unavailable("heartbeat", &e))
    }

    async fn complete(&self, lease: LeaseId, completion: &Completion) -> Result<(), ClientError> {
        self.post("complete", lease, completion).await.map(drop)
    }

    async fn fail(&self, lease: LeaseId, failures: &FailureReport) -> Result<(), ClientError> {
        self.post("fail", lease, failures).await.map(drop)
    }

    async fn release(&self, lease: LeaseId, release: &Release) -> Result<(), ClientError> {
        self.post("release", lease, release).await.map(drop)
    }
}
