//! The public API as commands call it: over HTTP, or through the same routes without a socket.

use std::path::PathBuf;
use std::time::Duration;

use anyhow::Context;
use axum::Router;
use axum::body::{Body, Bytes, to_bytes};
use axum::http::{Method, Request, header};
use clap::Args;
use granary_api::id::{ArtifactHash, JobId, SweepId};
use granary_api::job::JobDetail;
use granary_api::problem::Problem;
use granary_api::sweep::{Steered, Submitted, Sweep};
use granary_api::table::Page;
use granary_worker::lease_client::http::http_client;
use serde::de::DeserializeOwned;
use serde_json::{Value, json};
use tower::ServiceExt;

use crate::failure::Failure;
use crate::spec_file::SpecFile;

/// The longest that a call may take.
const CALL: Duration = Duration::from_mins(1);
/// Rows of a table asked for at once.
const PAGE: usize = 1000;

/// Which server, and as whom.
#[derive(Args, Clone, Debug)]
pub(crate) struct ServerArgs {
    /// Address of the server.
    #[arg(
        long,
        env = "GRANARY_SERVER",
        default_value = "http://127.0.0.1:8000",
        value_name = "URL"
    )]
    pub(crate) server: String,
    /// File that holds the bearer token; not needed on loopback.
    #[arg(long, env = "GRANARY_TOKEN_FILE", value_name = "FILE")]
    pub(crate) token_file: Option<PathBuf>,
}

impl ServerArgs {
    /// The token, if a file is named.
    ///
    /// # Errors
    /// If the file cannot be read.
    pub(crate) fn token(&self) -> anyhow::Result<Option<String>> {
        let read = |path: &PathBuf| {
            std::fs::read_to_string(path)
                .with_context(|| format!("cannot read the token file {}", path.display()))
        };
        self.token_file.as_ref().map(read).transpose()
    }

    /// A client of that server.
    ///
    /// # Errors
    /// If the token cannot be read or the address is none.
    pub(crate) fn client(&self) -> anyhow::Result<ApiClient> {
        let token = self.token()?;
        Ok(ApiClient::Remote {
            http: http_client(&self.server, token.as_deref())?,
            server: self.server.trim_end_matches('/').to_owned(),
        })
    }
}

/// The public API.
#[derive(Clone, Debug)]
pub(crate) enum ApiClient {
    /// A server's, over HTTP.
    Remote {
        /// Carries the token.
        http: reqwest::Client,
        /// The server's address, without a slash at the end.
        server: String,
    },
    /// The same routes in this process, without a socket.
    Local {
        /// The routes.
        router: Router,
        /// A token, if the store asks for one.
        token: Option<String>,
    },
}

impl ApiClient {
    /// Sends one request; every status but success is a failure.
    async fn call(
        &self,
        method: Method,
        path: &str,
        body: Option<&Value>,
    ) -> Result<Bytes, Failure> {
        let (status, bytes) = match self {
            Self::Remote { http, server } => remote_call(http, server, method, path, body).await?,
            Self::Local { router, token } => {
                let request = local_request(method, path, body, token.as_deref());
                local_call(router.clone(), request).await
            }
        };
        if (200..300).contains(&status) {
            Ok(bytes)
        } else {
            Err(Failure::Refused(problem(status, &bytes)))
        }
    }

    /// `GET` of `path`, as it comes.
    pub(crate) async fn get(&self, path: &str) -> Result<Bytes, Failure> {
        self.call(Method::GET, path, None).await
    }

    /// `GET` of `path`, as JSON.
    pub(crate) async fn get_json<T: DeserializeOwned>(&self, path: &str) -> anyhow::Result<T> {
        let bytes = self.get(path).await?;
        serde_json::from_slice(&bytes).with_context(|| {
            format!("the server's answer to {path} is not what this release expects")
        })
    }

    /// Submits a sweep; its mistakes come back with their lines.
    pub(crate) async fn submit(&self, spec: &SpecFile, dry_run: bool) -> anyhow::Result<Submitted> {
        let path = if dry_run {
            "/sweeps?dry_run=true"
        } else {
            "/sweeps"
        };
        match self.call(Method::POST, path, Some(&spec.value)).await {
            Ok(bytes) => Ok(serde_json::from_slice(&bytes)?),
            Err(Failure::Refused(problem)) if matches!(problem.status, 400 | 413 | 422) => {
                Err(spec.bad(mistakes(problem)).into())
            }
            Err(failure) => Err(failure.into()),
        }
    }

    /// Where a sweep stands.
    pub(crate) async fn sweep(&self, sweep: SweepId) -> anyhow::Result<Sweep> {
        self.get_json(&format!("/sweeps/{sweep}")).await
    }

    /// Cancels, pauses, resumes or retries a sweep.
    pub(crate) async fn steer(&self, sweep: SweepId, way: &str) -> anyhow::Result<Steered> {
        let path = format!("/sweeps/{sweep}/{way}");
        let bytes = self.call(Method::POST, &path, Some(&json!({}))).await?;
        Ok(serde_json::from_slice(&bytes)?)
    }

    /// A job, with its outcome if it has one.
    pub(crate) async fn job(&self, job: JobId) -> anyhow::Result<JobDetail> {
        self.get_json(&format!("/jobs/{job}")).await
    }

    /// The bytes of an artifact, their hash verified.
    pub(crate) async fn artifact(&self, hash: ArtifactHash) -> anyhow::Result<Bytes> {
        let bytes = self.get(&format!("/artifacts/{hash}")).await?;
        anyhow::ensure!(
            ArtifactHash::of_bytes(&bytes) == hash,
            "artifact {hash} arrived damaged"
        );
        Ok(bytes)
    }

    /// Every row of a table; `query` holds `where` and `sort`, already encoded.
    pub(crate) async fn rows<T: DeserializeOwned>(
        &self,
        sweep: SweepId,
        table: &str,
        query: &[(String, String)],
    ) -> anyhow::Result<Vec<T>> {
        let mut rows = vec![];
        let mut cursor: Option<String> = None;
        loop {
            let mut query = query.to_vec();
            query.push(("limit".to_owned(), PAGE.to_string()));
            query.extend(cursor.take().map(|cursor| ("cursor".to_owned(), cursor)));
            let path = format!("/sweeps/{sweep}/{table}?{}", encode(&query));
            let page: Page<T> = self.get_json(&path).await?;
            rows.extend(page.items);
            match page.next {
                Some(next) => cursor = Some(next),
                None => return Ok(rows),
            }
        }
    }
}

async fn remote_call(
    http: &reqwest::Client,
    server: &str,
    method: Method,
    path: &str,
    body: Option<&Value>,
) -> Result<(u16, Bytes), Failure> {
    let mut request = http
        .request(method, format!("{server}/api/v1{path}"))
        .timeout(CALL);
    if let Some(body) = body {
        request = request.json(body);
    }
    let unreachable = |error: reqwest::Error| Failure::Unreachable {
        server: server.to_owned(),
        detail: innermost(&error),
    };
    let response = request.send().await.map_err(unreachable)?;
    let status = response.status().as_u16();
    Ok((status, response.bytes().await.map_err(unreachable)?))
}

fn local_request(
    method: Method,
    path: &str,
    body: Option<&Value>,
    token: Option<&str>,
) -> Request<Body> {
    let mut request = Request::builder()
        .method(method)
        .uri(format!("/api/v1{path}"))
        .header(header::HOST, "localhost")
        .header(header::CONTENT_TYPE, "application/json");
    if let Some(token) = token {
        request = request.header(header::AUTHORIZATION, format!("Bearer {token}"));
    }
    let body = body.map_or_else(Body::empty, |body| Body::from(body.to_string()));
    request
        .body(body)
        .expect("paths are made of hashes, ids and escaped text")
}

async fn local_call(router: Router, request: Request<Body>) -> (u16, Bytes) {
    // The router cannot fail; a body that breaks off reads as an empty one, which no caller accepts.
    let Ok(response) = router.oneshot(request).await;
    let status = response.status().as_u16();
    let bytes = to_bytes(response.into_body(), usize::MAX).await;
    (status, bytes.unwrap_or_default())
}

/// `name=value&…` with everything but letters, digits and a few signs escaped.
pub(crate) fn encode(query: &[(String, String)]) -> String {
    let pairs = query
        .iter()
        .map(|(name, value)| format!("{}={}", escape(name), escape(value)));
    pairs.collect::<Vec<_>>().join("&")
}

fn escape(text: &str) -> String {
    let sign = |byte: u8| {
        if byte.is_ascii_alphanumeric() || b"-_.~".contains(&byte) {
            char::from(byte).to_string()
        } else {
            format!("%{byte:02X}")
        }
    };
    text.bytes().map(sign).collect()
}

/// The problem document in `bytes`, or one made of the status alone.
fn problem(status: u16, bytes: &[u8]) -> Problem {
    serde_json::from_slice(bytes).unwrap_or_else(|_| Problem {
        kind: "about:blank".to_owned(),
        title: "The server refused the request".to_owned(),
        status,
        detail: None,
        errors: vec![],
    })
}

/// The mistakes that a problem lists; its own words if it lists none.
fn mistakes(problem: Problem) -> Vec<granary_api::problem::Mistake> {
    if !problem.errors.is_empty() {
        return problem.errors;
    }
    vec![granary_api::problem::Mistake {
        pointer: String::new(),
        detail: problem.detail.unwrap_or(problem.title),
    }]
}

fn innermost(error: &dyn std::error::Error) -> String {
    let mut error = error;
    while let Some(source) = error.source() {
        error = source;
    }
    error.to_string()
}
