//! Configuration: read once in `main` and passed down.

use std::net::{IpAddr, Ipv4Addr, SocketAddr};
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

use granary_api::token::Scope;

use crate::archive::Archive;
use crate::{queue, sweep};

/// Everything a server may be told.
#[derive(Clone, Debug)]
pub struct Config {
    /// The directory that holds database and artifacts; made if it is missing.
    pub data: PathBuf,
    /// Where to listen.
    pub listen: SocketAddr,
    /// Host names, besides those of this machine's loopback, under which requests are accepted.
    pub hosts: Vec<String>,
    /// Tokens that need not stand in the database: text and scopes.
    pub tokens: Vec<(String, Vec<Scope>)>,
    /// How large a sweep may be.
    pub sweep: sweep::Limits,
    /// How often a job may fail for reasons that are not its own.
    pub queue: queue::Limits,
    /// How long a worker may be silent before its lease is taken back.
    pub lease_term: Duration,
    /// How often a worker should say that it lives.
    pub heartbeat: Duration,
    /// The largest JSON body \[bytes\].
    pub body_bytes: usize,
    /// The largest artifact \[bytes\].
    pub artifact_bytes: u64,
    /// Events kept per sweep.
    pub events: u32,
    /// What a sweep need not wait for.
    pub archive: Option<Arc<dyn Archive>>,
}

impl Config {
    /// The defaults, for the data directory `data`.
    #[must_use]
    pub fn new(data: impl Into<PathBuf>) -> Self {
        Self {
            data: data.into(),
            listen: SocketAddr::new(IpAddr::V4(Ipv4Addr::LOCALHOST), 8000),
            hosts: vec![],
            tokens: vec![],
            sweep: sweep::Limits::default(),
            queue: queue::Limits::default(),
            lease_term: Duration::from_secs(30),
            heartbeat: Duration::from_secs(10),
            body_bytes: 4 << 20,
            artifact_bytes: 4 << 30,
            events: 10_000,
            archive: None,
        }
    }
}
