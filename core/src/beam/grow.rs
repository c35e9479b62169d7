//! The stage `grow`: grains placed at random in the mold and grown to the initial volume fraction, without friction.

use super::spec::GrowSpec;
use crate::lanes::VectorWidth;
use crate::outcome::{Outcome, Progress, StageFailure};

/// Runs the stage whose id is `stage`, from the start or from a checkpoint.
pub(crate) fn run(
    _spec: &GrowSpec,
    _stage: &str,
    _checkpoint: Option<&[u8]>,
    _width: VectorWidth,
    _progress: &mut Progress<'_>,
) -> Result<Outcome, StageFailure> {
    Err(StageFailure::Input {
        detail: "not built yet".to_owned(),
    })
}
