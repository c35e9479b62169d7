//! The state of one step as records, so that a contact finds what it needs in few places.

use crate::grains::Grains;
use crate::lanes::{F64x1, F64x8, Lane};
use crate::math::Vec3;
use crate::scene::interact::Partner;
use crate::scene::motion::Load;
use crate::scene::{Physics, Work};
use crate::shape::Shape;

use super::WIDE;
use super::eight::Eight;

/// A vector and a spare number.
pub(super) type Four = [f64; 4];

/// Two vectors that are wanted together, on one line of the cache.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C, align(64))]
pub(super) struct Pair(pub(super) [Four; 2]);

impl Pair {
    /// Adds a force and a torque.
    #[inline(always)]
    pub(super) fn add<P: Physics>(&mut self, force: &Four, torque: &Four) {
        for (sum, part) in self.0[0].iter_mut().zip(force) {
            *sum += part;
        }
        if P::SPINS {
            for (sum, part) in self.0[1].iter_mut().zip(torque) {
                *sum += part;
            }
        }
    }
}

/// The state of the running step, as records that a contact finds in one place each; remade in every step.
#[derive(Clone, Debug)]
pub struct Records {
    /// Of every sphere: its center's displacement from the reference, and its center from the center of mass.
    pub(super) spheres: Vec<Pair>,
    /// Of every grain: velocity and spin.
    motions: Vec<Pair>,
    /// Of every grain: the sums of force and torque.
    pub(super) loads: Vec<Pair>,
}

impl Work<F64x1> for Records {
    fn new<P: Physics>(grains: &Grains<F64x1>) -> Self {
        let n = grains.len();
        Self {
            spheres: vec![Pair::default(); P::Shape::SPHERES * n],
            motions: vec![Pair::default(); n],
            loads: vec![Pair::default(); n],
        }
    }

    fn bytes(&self) -> usize {
        size_of::<Pair>() * (self.spheres.len() + self.motions.len() + self.loads.len())
    }
}

impl Records {
    /// Writes what contacts need of all grains, and sets the sums to zero.
    #[inline(always)]
    pub(super) fn write<W: Lane<Row = F64x8, Scalar = f64>, P: Physics>(
        &mut self,
        grains: &Grains<F64x1>,
    ) {
        let spheres = P::Shape::SPHERES;
        for first in (0..grains.len()).step_by(WIDE) {
            let eight = Eight::from(first, grains.len());
            let moving = eight.load::<W, P>(grains);
            for a in 0..spheres {
                let arm = if P::ORIENTED {
                    eight.gather(|i| grains.lane_arms[spheres * i + a])
                } else {
                    Vec3::zero()
                };
                let (shifted, arm) = moving.sphere::<P>(arm);
                let (shifted, arms) = (fours(shifted), fours_if::<W>(P::ORIENTED, arm));
                for e in 0..eight.count {
                    self.spheres[spheres * (first + e) + a] = Pair([shifted[e], arms[e]]);
                }
            }
            let velocities = fours(moving.velocity);
            let spins = fours_if(P::SPINS, moving.spin);
            for e in 0..eight.count {
                self.motions[first + e] = Pair([velocities[e], spins[e]]);
                self.loads[first + e] = Pair::default();
            }
        }
    }

    /// One of the two grains, and its sphere, of eight pairs.
    #[inline(always)]
    pub(super) fn partner<W: Lane<Row = F64x8, Scalar = f64>, P: Physics>(
        &self,
        eight: [(u32, u8); WIDE],
    ) -> Partner<W> {
        let spheres = P::Shape::SPHERES;
        let motion = |e: usize| &self.motions[eight[e].0 as usize].0;
        let arm = |e: usize| {
            let (grain, sphere) = eight[e];
            &self.spheres[spheres * grain as usize + usize::from(sphere)].0[1]
        };
        Partner {
            arm: if P::ORIENTED {
                vector(W::gather(arm))
            } else {
                Vec3::zero()
            },
            velocity: vector(W::gather(|e| &motion(e)[0])),
            spin: if P::SPINS {
                vector(W::gather(|e| &motion(e)[1]))
            } else {
                Vec3::zero()
            },
        }
    }

    /// What acts on eight grains.
    #[inline(always)]
    pub(super) fn load<W: Lane<Row = F64x8, Scalar = f64>, P: Physics>(
        &self,
        eight: Eight,
    ) -> Load<W> {
        Load {
            force: vector(W::gather(|e| &self.loads[eight.grain(e)].0[0])),
            torque: if P::SPINS {
                vector(W::gather(|e| &self.loads[eight.grain(e)].0[1]))
            } else {
                Vec3::zero()
            },
        }
    }
}

#[inline(always)]
pub(super) fn vector<L>([x, y, z, _]: [L; 4]) -> Vec3<L> {
    Vec3 { x, y, z }
}

/// Eight vectors as records.
#[inline(always)]
pub(super) fn fours<W: Lane<Row = F64x8, Scalar = f64>>(vector: Vec3<W>) -> [Four; WIDE] {
    let mut fours = [Four::default(); WIDE];
    W::scatter([vector.x, vector.y, vector.z, W::constant(0.0)], &mut fours);
    fours
}

/// Eight vectors as records; zeros unless `wanted`.
#[inline(always)]
pub(super) fn fours_if<W: Lane<Row = F64x8, Scalar = f64>>(
    wanted: bool,
    vector: Vec3<W>,
) -> [Four; WIDE] {
    if wanted {
        fours(vector)
    } else {
        [Four::default(); WIDE]
    }
}
