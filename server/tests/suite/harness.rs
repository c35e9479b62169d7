//! A fresh server per test, and a worker that yields made-up but deterministic outcomes.

use std::collections::BTreeMap;

use axum::Router;
use axum::body::Body;
use axum::http::{HeaderMap, Method, Request, StatusCode, header};
use granary_api::id::{LeaseId, SweepId, WorkerId};
use granary_api::lease::{Completion, JobOutcome, LeaseGrant, LeaseRequest, LeasedJob, Provenance};
use granary_api::sweep::Submitted;
use granary_core::PHYSICS_VERSION;
use granary_core::beam::spec::BendSpec;
use granary_core::memory::score::Signal;
use granary_core::memory::waveform::{SAMPLES, sample_u};
use granary_core::stage::{Ensemble, HISTORY, Outcome, SIGNAL, STATE, StageSpec, run};
use granary_server::{Config, Store, Submission, app, submit};
use http_body_util::BodyExt;
use serde_json::{Value, json};
use tokio_util::sync::CancellationToken;
use tower::ServiceExt;

/// A store and its routes on a directory that is removed afterwards.
pub(crate) struct Fresh {
    pub(crate) store: Store,
    pub(crate) router: Router,
    pub(crate) directory: tempfile::TempDir,
}

/// An answer, read to its end.
pub(crate) struct Answer {
    pub(crate) status: StatusCode,
    pub(crate) headers: HeaderMap,
    pub(crate) bytes: Vec<u8>,
}

impl Answer {
    pub(crate) fn json(&self) -> Value {
        serde_json::from_slice(&self.bytes).expect("a JSON body")
    }

    pub(crate) fn text(&self) -> String {
        String::from_utf8(self.bytes.clone()).expect("a text body")
    }
}

pub(crate) async fn fresh() -> Fresh {
    fresh_with(|_| {}).await
}

pub(crate) async fn fresh_with(configure: impl FnOnce(&mut Config)) -> Fresh {
    let directory = tempfile::tempdir().expect("a temporary directory");
    let mut config = Config::new(directory.path());
    configure(&mut config);
    let store = Store::open(config, "a test").await.expect("a fresh store");
    let router = app(store.clone(), CancellationToken::new(), None);
    Fresh {
        store,
        router,
        directory,
    }
}

impl Fresh {
    /// A request with a body and headers of its own.
    pub(crate) async fn send(&self, request: Request<Body>) -> Answer {
        let response = self
            .router
            .clone()
            .oneshot(request)
            .await
            .expect("routes never fail");
        let (parts, body) = response.into_parts();
        let bytes = body
            .collect()
            .await
            .expect("a whole body")
            .to_bytes()
            .to_vec();
        Answer {
            status: parts.status,
            headers: parts.headers,
            bytes,
        }
    }

    pub(crate) async fn get(&self, path: &str) -> Answer {
        self.send(
            request(Method::GET, path)
                .body(Body::empty())
                .expect("a request"),
        )
        .await
    }

    pub(crate) async fn post(&self, path: &str, body: &Value) -> Answer {
        let request = request(Method::POST, path).header(header::CONTENT_TYPE, "application/json");
        self.send(
            request
                .body(Body::from(body.to_string()))
                .expect("a request"),
        )
        .await
    }

    pub(crate) async fn submit(&self, spec: &Value) -> Submitted {
        submit(&self.store, spec, &Submission::default())
            .await
            .expect("a valid sweep")
    }

    pub(crate) async fn take(&self) -> Option<LeaseGrant> {
        self.take_as("worker 1").await
    }

    pub(crate) async fn take_as(&self, worker: &str) -> Option<LeaseGrant> {
        self.store
            .lease_take(&asking(worker))
            .await
            .expect("the store answers")
    }

    /// Takes and completes everything that is ready; the jobs in the order in which they were given.
    pub(crate) async fn work(&self) -> Vec<LeasedJob> {
        let mut done = vec![];
        while let Some(grant) = self.take().await {
            self.complete(grant.lease, &grant.jobs).await;
            done.extend(grant.jobs);
        }
        done
    }

    pub(crate) async fn complete(&self, lease: LeaseId, jobs: &[LeasedJob]) {
        let completion = self.outcomes(jobs).await;
        self.store
            .lease_complete(lease, &completion)
            .await
            .expect("the lease is ours");
    }

    /// What a worker would report of `jobs`, its files stored.
    pub(crate) async fn outcomes(&self, jobs: &[LeasedJob]) -> Completion {
        let mut outcomes = vec![];
        for job in jobs {
            let mut outcome = self.report(job, &outcome(&job.spec)).await;
            // Each of them takes a second.
            outcome.provenance.lanes = jobs.len() as u32;
            outcome.provenance.cpu_s = jobs.len() as f64;
            outcomes.push(outcome);
        }
        Completion { outcomes }
    }

    pub(crate) async fn report(&self, job: &LeasedJob, outcome: &Outcome) -> JobOutcome {
        let mut artifacts = BTreeMap::new();
        for (name, bytes) in &outcome.artifacts {
            let hash = self
                .store
                .artifact_put(bytes.clone())
                .await
                .expect("stored");
            artifacts.insert(name.clone(), hash);
        }
        JobOutcome {
            job: job.job,
            results: outcome.results.clone(),
            reasons: outcome.reasons.clone(),
            artifacts,
            warnings: outcome.warnings.clone(),
            result_hash: outcome.hash(),
            provenance: provenance(outcome.steps),
        }
    }
}

pub(crate) fn request(method: Method, path: &str) -> axum::http::request::Builder {
    Request::builder()
        .method(method)
        .uri(path)
        .header(header::HOST, "localhost:8000")
}

pub(crate) fn asking(worker: &str) -> LeaseRequest {
    LeaseRequest {
        worker: WorkerId(worker.to_owned()),
        physics_version: PHYSICS_VERSION,
        engine_version: "test".to_owned(),
        memory_bytes: 1 << 40,
        wait_s: 0.0,
    }
}

fn provenance(steps: u64) -> Provenance {
    Provenance {
        engine_version: "test".to_owned(),
        physics_version: PHYSICS_VERSION,
        target: "test".to_owned(),
        worker: WorkerId("worker 1".to_owned()),
        steps,
        lanes: 1,
        wall_s: 1.0,
        cpu_s: 1.0,
    }
}

/// 𝒢 E δ0 \[Pa\] of every made-up recall, exact.
pub(crate) const GAIN_E_DELTA0: f64 = 150_000.0;

/// A made-up outcome: a recall gives back its waveform with a known gain over a known background.
pub(crate) fn outcome(spec: &StageSpec) -> Outcome {
    if let StageSpec::Bend(bend) = spec {
        return bent(bend);
    }
    if let StageSpec::Classifier(_) = spec {
        // Real ones, as small as the specs of tests ask for.
        let ensemble = Ensemble {
            specs: std::slice::from_ref(spec),
            input: &[],
            checkpoints: None,
        };
        let trained = run(&ensemble, &mut |_| std::ops::ControlFlow::Continue(()));
        let trained = trained.into_iter().next().expect("one job");
        return trained.expect("a classifier");
    }
    let (name, bytes) = match spec {
        StageSpec::Recall(recall) => {
            let curve = recall.waveform.curve();
            let background = |u: f64| 3000.0 - 1000.0 * u;
            let p = |u: f64| background(u) - GAIN_E_DELTA0 * recall.gamma0 * curve.integral(u);
            let us = || (0..SAMPLES).map(sample_u);
            let second = if recall.second_cycle {
                us().map(background).collect()
            } else {
                vec![]
            };
            let signal = Signal {
                encode: us().map(p).collect(),
                decode: us().map(p).collect(),
                second_decode: second,
                resolution: Some(0.0),
            };
            (SIGNAL, serde_json::to_vec(&signal).expect("plain data"))
        }
        other => (STATE, other.id().to_string().into_bytes()),
    };
    let results = [("hold_kinetic_energy", 3e-15), ("encode_correlation", 0.9)];
    Outcome {
        results: results
            .into_iter()
            .map(|(name, value)| (name.to_owned(), Some(value)))
            .collect(),
        reasons: BTreeMap::new(),
        artifacts: BTreeMap::from([(name.to_owned(), bytes)]),
        warnings: vec![],
        steps: 1000,
    }
}

/// A made-up beam: E_b = 5 MPa, and Y_b = 100 kPa − 80 kPa e^{−5μ} but for μ = 0.2, where it does not yield.
fn bent(spec: &BendSpec) -> Outcome {
    let strength = 100e3 - 80e3 * (-5.0 * spec.friction_coefficient).exp();
    let yields = (spec.friction_coefficient - 0.2).abs() > 1e-9;
    let results = [
        ("beam_stiffness", Some(5e6)),
        ("ultimate_strength", yields.then_some(strength)),
        ("ultimate_strength_lower_bound", Some(175e3)),
        ("volume_fraction", Some(0.62)),
    ];
    let reason = ("ultimate_strength".to_owned(), "not_prominent".to_owned());
    Outcome {
        results: results
            .into_iter()
            .map(|(name, value)| (name.to_owned(), value))
            .collect(),
        reasons: (!yields).then_some(reason).into_iter().collect(),
        artifacts: BTreeMap::from([(HISTORY.to_owned(), b"[]".to_vec())]),
        warnings: vec![],
        steps: 1000,
    }
}

/// Two packings, two frictions, three waveforms: 12 points, 2 packs, 4 trains, 4 zero recalls, 22 jobs.
pub(crate) fn spec() -> Value {
    json!({
        "name": "friction and memory",
        "model": "memory",
        "fixed": {"grains": 100},
        "grid": [{
            "friction_coefficient": [0.4, 1.0],
            "packing_seed": [1, 2],
            "waveform": ["six/1", "six/2", "six/5"],
        }],
    })
}

/// One packing, one friction, one waveform.
pub(crate) fn single(waveform: &str) -> Value {
    json!({"name": "one", "model": "memory", "fixed": {"grains": 100, "waveform": waveform}})
}

pub(crate) fn sweep_of(submitted: &Submitted) -> SweepId {
    submitted.sweep.expect("not a dry run")
}
