//! What has gone wrong with the membrane: what a reader should know, and what stops a run.

use serde::{Deserialize, Serialize};

use super::Run;
use crate::beam::rig::Friction;
use crate::membrane::Finding;
use crate::outcome::StageFailure;

/// The worst of the membrane so far.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Sheet {
    /// ℓ/ℓ₀ of the shortest edge, if it is worth a warning.
    shortest_edge: Option<f64>,
    /// Cosine of the sharpest fold, if it is worth a warning.
    sharpest_fold: Option<f64>,
}

impl Sheet {
    /// Nothing is wrong with it.
    pub(super) const SOUND: Self = Self {
        shortest_edge: None,
        sharpest_fold: None,
    };

    pub(super) fn warnings(&self, when: &str) -> impl Iterator<Item = String> {
        let short = self.shortest_edge.map(|ratio| {
            format!(
                "short_edges: an edge of the membrane is {ratio:.2} of its length at rest {when}"
            )
        });
        let sharp = self.sharpest_fold.map(|cosine| {
            let degrees = libm::acos(cosine.clamp(-1.0, 1.0)).to_degrees();
            format!(
                "sharp_folds: the membrane is folded by {degrees:.0}° {when}; \
                 nothing keeps it from passing through itself"
            )
        });
        short.into_iter().chain(sharp)
    }
}

/// Keeps the least.
fn keep(worst: &mut Option<f64>, now: f64) {
    *worst = Some(worst.map_or(now, |before| before.min(now)));
}

impl<T: Friction> Run<T> {
    /// Looks at the membrane, and stops if a triangle has collapsed or has flipped since the last report.
    ///
    /// A run that goes on from a checkpoint misses nothing: checkpoints are taken at reports, after this.
    pub(super) fn check_sheet(&mut self) -> Result<(), StageFailure> {
        let membrane = &self.beam.surroundings.membrane;
        let volume = membrane.mesh().volume();
        if volume <= 0.0 {
            return Err(self.collapsed(format!("the membrane encloses {volume:.1e} m³")));
        }
        let now: Vec<[f64; 3]> = membrane.mesh().normals().collect();
        let before = if self.normals.is_empty() {
            &now
        } else {
            &self.normals
        };
        let found = membrane.findings([&now, before]);
        self.normals = now;
        for finding in found {
            let collapse = match finding {
                Finding::ShortEdge { ratio, .. } => {
                    keep(&mut self.sheet.shortest_edge, ratio);
                    continue;
                }
                Finding::SharpFold { cosine, .. } => {
                    keep(&mut self.sheet.sharpest_fold, cosine);
                    continue;
                }
                Finding::Collapsed { triangle, ratio } => {
                    format!("triangle {triangle} has shrunk to {ratio:.1e} of its area at rest")
                }
                Finding::Flipped { triangle, cosine } => {
                    let degrees = libm::acos(cosine.clamp(-1.0, 1.0)).to_degrees();
                    format!("triangle {triangle} has turned by {degrees:.0}° since the last report")
                }
            };
            return Err(self.collapsed(collapse));
        }
        Ok(())
    }

    pub(super) fn collapsed(&self, detail: String) -> StageFailure {
        let remedy = "use less pressure, a coarser membrane_edge, or a membrane_bending_stiffness";
        self.failed("membrane_collapse", detail, remedy)
    }
}
