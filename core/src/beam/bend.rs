//! The stage `bend`: the compacted beam released from its mold, put on its supports and bent.

use super::spec::BendSpec;
use crate::lanes::VectorWidth;
use crate::outcome::{Outcome, Progress, StageFailure};

/// Runs the stage whose id is `stage` on the state `input`, from the start or from a checkpoint.
pub(crate) fn run(
    _spec: &BendSpec,
    _stage: &str,
    (_input, _checkpoint): (&[u8], Option<&[u8]>),
    _width: VectorWidth,
    _progress: &mut Progress<'_>,
) -> Result<Outcome, StageFailure> {
    Err(StageFailure::Input {
        detail: "not built yet".to_owned(),
    })
}
