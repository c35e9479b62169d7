//! Which candidates touch.

use crate::lanes::{F64x1, F64x8};
use crate::math::Vec3;
use crate::scene::Physics;
use crate::scene::contacts::Candidate;
use crate::scene::interact::{Branch, branch};
use crate::shape::Shape;

use super::WIDE;
use super::records::{Records, vector};

/// Candidates that are looked at together.
pub(super) const MANY: usize = 128;

/// Those of some candidates that touch; what lies beyond the last repeats a candidate and means nothing.
pub(super) struct Touching {
    pub(super) len: usize,
    /// By their place in the list.
    pub(super) candidates: [u32; MANY],
    pub(super) branches: [Branch<F64x8>; MANY / WIDE],
    /// Of every candidate, whether it touches.
    pub(super) all: [bool; MANY],
}

impl Touching {
    #[inline(always)]
    pub(super) fn none() -> Self {
        let nowhere = Branch {
            vector: Vec3 {
                x: F64x8([2.0; WIDE]),
                y: F64x8([0.0; WIDE]),
                z: F64x8([0.0; WIDE]),
            },
            excess: F64x8([0.0; WIDE]),
        };
        Self {
            len: 0,
            candidates: [0; MANY],
            branches: [nowhere; MANY / WIDE],
            all: [false; MANY],
        }
    }

    /// Tests the candidates from `first` on.
    #[inline(always)]
    pub(super) fn find<P: Physics>(
        &mut self,
        first: usize,
        work: &Records,
        candidates: &[Candidate<f64>],
    ) {
        self.len = 0;
        let spheres = P::Shape::SPHERES;
        for (n, candidate) in candidates.iter().enumerate() {
            let shifted = |grain: u32, sphere: u8| {
                let sphere = spheres * grain as usize + usize::from(sphere);
                vector(work.spheres[sphere].0[0].map(|x| F64x1([x])))
            };
            let change = shifted(candidate.i, candidate.a) - shifted(candidate.j, candidate.b);
            let branch = branch(candidate.reference.map(|x| F64x1([x])), change);
            let touches = branch.excess.0[0] < 0.0;
            let (rows, e) = (&mut self.branches[self.len / WIDE], self.len % WIDE);
            rows.vector.x.0[e] = branch.vector.x.0[0];
            rows.vector.y.0[e] = branch.vector.y.0[0];
            rows.vector.z.0[e] = branch.vector.z.0[0];
            rows.excess.0[e] = branch.excess.0[0];
            self.candidates[self.len] = (first + n) as u32;
            self.all[n] = touches;
            self.len += usize::from(touches);
        }
    }
}
