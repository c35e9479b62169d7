//! Which new contact of a grain goes on with the friction spring of which old one.
//!
//! The one at the same triangle does. What is left over goes to those that have none: the deepest chooses first, a triangle over
//! a side before one over a corner, and of those alike the contact that pushed harder, so that nothing depends on how
//! triangles are numbered.

use super::Held;
use super::touch::Touch;
use crate::membrane::Mesh;

/// Finds the springs of one grain after the other; keeps its memory.
#[derive(Clone, Debug, Default)]
pub(super) struct Heirs {
    /// Of every new contact of the grain at hand.
    pub(super) springs: Vec<[f64; 3]>,
    /// Its new contacts that have none yet, the deepest first.
    without: Vec<usize>,
    /// Which of its old ones have gone on.
    taken: Vec<bool>,
}

impl Heirs {
    /// Finds the spring of each of `touches`, zero if none goes on in it.
    #[inline(always)]
    pub(super) fn find(&mut self, mesh: &Mesh, held: &[Held], touches: &[Touch]) {
        if let ([old], [new]) = (held, touches) {
            let goes_on =
                old.triangle == new.triangle || mesh.are_neighbors(old.triangle, new.triangle);
            self.springs.clear();
            self.springs
                .push(if goes_on { old.spring } else { [0.0; 3] });
        } else {
            self.find_among(mesh, held, touches);
        }
    }

    fn find_among(&mut self, mesh: &Mesh, held: &[Held], touches: &[Touch]) {
        self.springs.clear();
        self.without.clear();
        self.taken.clear();
        self.taken.resize(held.len(), false);
        for (k, touch) in touches.iter().enumerate() {
            let same = held.iter().position(|old| old.triangle == touch.triangle);
            if let Some(n) = same {
                self.taken[n] = true;
            } else {
                self.without.push(k);
            }
            self.springs.push(same.map_or([0.0; 3], |n| held[n].spring));
        }
        let overlap = |k: &usize| touches[*k].overlap;
        self.without
            .sort_by(|a, b| overlap(b).total_cmp(&overlap(a)));
        for &k in &self.without {
            let nearness = |old: &Held| {
                let common = mesh.common_corners(old.triangle, touches[k].triangle);
                (common, old.normal_force)
            };
            let mut best = None;
            for (n, old) in held.iter().enumerate().filter(|(n, _)| !self.taken[*n]) {
                let near = nearness(old);
                if near.0 > 0 && best.is_none_or(|(_, nearest)| near > nearest) {
                    best = Some((n, near));
                }
            }
            if let Some((n, _)) = best {
                self.taken[n] = true;
                self.springs[k] = held[n].spring;
            }
        }
    }
}
