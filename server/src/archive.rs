//! What was computed before, on whatever server: outcomes that a sweep takes when it is submitted.

use std::fmt::Debug;

use granary_core::stage::{Outcome, StageSpec};

/// Outcomes by their stages.
pub trait Archive: Debug + Send + Sync {
    /// What a stage yielded; none if anything of it is missing or damaged.
    fn find(&self, spec: &StageSpec) -> Option<Archived>;
}

/// The outcome of a stage and what it cost.
#[derive(Clone, Debug)]
pub struct Archived {
    /// What it yielded, artifacts included.
    pub outcome: Outcome,
    /// The release that computed it.
    pub engine_version: String,
    /// Wall time \[s\].
    pub wall_s: f64,
    /// CPU time \[s\].
    pub cpu_s: f64,
}
