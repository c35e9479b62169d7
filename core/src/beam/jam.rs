//! The stage `jam`: the grown grains compacted by the pressure on the membrane, until they rest.

use super::spec::JamSpec;
use crate::lanes::VectorWidth;
use crate::outcome::{Outcome, Progress, StageFailure};

/// Runs the stage whose id is `stage` on the state `input`, from the start or from a checkpoint.
pub(crate) fn run(
    _spec: &JamSpec,
    _stage: &str,
    (_input, _checkpoint): (&[u8], Option<&[u8]>),
    _width: VectorWidth,
    _progress: &mut Progress<'_>,
) -> Result<Outcome, StageFailure> {
    Err(StageFailure::Input {
        detail: "not built yet".to_owned(),
    })
}
