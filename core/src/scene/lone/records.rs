//! The state of one step as records, so that a contact finds what it needs in few places.

use crate::grains::Grains;
use crate::lanes::{F64x1, F64x8, Lane};
use crate::math::Vec3;
use crate::scene::contacts::Candidate;
use crate::scene::interact::Partner;
use crate::scene::motion::Load;
use crate::scene::{Physics, Work};
use crate::shape::Shape;

use super::WIDE;
use super::eight::Eight;

/// The state of the running step, remade in every step.
///
/// A record is one line of the cache: two vectors that are wanted together, each with a number beside it.
#[derive(Clone, Debug)]
pub struct Records {
    /// Of every sphere: its center's displacement from the reference and its radius, and its center from the center of mass.
    spheres: Vec<F64x8>,
    /// Of every grain: velocity and inverse mass, and spin.
    motions: Vec<F64x8>,
    /// Of every grain: the sums of force and torque.
    pub(super) loads: Vec<F64x8>,
}

/// A sphere of a grain, by the places of their records.
#[derive(Clone, Copy)]
pub(super) struct Ball {
    pub(super) grain: usize,
    sphere: usize,
}

impl Ball {
    /// The one in the candidate's row.
    #[inline(always)]
    pub(super) fn i<P: Physics>(candidate: &Candidate<f64>) -> Self {
        Self::new::<P>(candidate.i, candidate.a)
    }

    /// The other one.
    #[inline(always)]
    pub(super) fn j<P: Physics>(candidate: &Candidate<f64>) -> Self {
        Self::new::<P>(candidate.j, candidate.b)
    }

    #[inline(always)]
    fn new<P: Physics>(grain: u32, sphere: u8) -> Self {
        let grain = grain as usize;
        Self {
            grain,
            sphere: P::Shape::SPHERES * grain + usize::from(sphere),
        }
    }
}

impl Work<F64x1> for Records {
    fn new<P: Physics>(grains: &Grains<F64x1>) -> Self {
        let n = grains.len();
        Self {
            spheres: vec![F64x8::default(); P::Shape::SPHERES * n],
            motions: vec![F64x8::default(); n],
            loads: vec![F64x8::default(); n],
        }
    }

    fn bytes(&self) -> usize {
        size_of::<F64x8>() * (self.spheres.len() + self.motions.len() + self.loads.len())
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
            let zero = W::constant(0.0);
            let (mut radius, mut inverse_mass) = (zero, zero);
            if P::GRADED {
                radius = eight.numbers(|i| grains.sizes[i].radius);
                inverse_mass = eight.numbers(|i| grains.sizes[i].inverse_mass);
            }
            for a in 0..spheres {
                let arm = if P::ORIENTED {
                    eight.gather(|i| grains.lane_arms[spheres * i + a])
                } else {
                    Vec3::zero()
                };
                let (shifted, arm) = moving.sphere::<P>(arm);
                let records = records(shifted, arm, [radius, zero]);
                for (e, record) in records.into_iter().enumerate().take(eight.count) {
                    record.store(&mut self.spheres[spheres * (first + e) + a]);
                }
            }
            let records = records(moving.velocity, moving.spin, [inverse_mass, zero]);
            for (e, record) in records.into_iter().enumerate().take(eight.count) {
                record.store(&mut self.motions[first + e]);
                self.loads[first + e] = F64x8::default();
            }
        }
    }

    /// Displacements from the reference of the centers of eight spheres, and their radii.
    #[inline(always)]
    pub(super) fn shifted<W: Lane<Row = F64x8, Scalar = f64>, P: Physics>(
        &self,
        eight: &[Ball; WIDE],
    ) -> (Vec3<W>, W) {
        let numbers = W::gather(|e| self.spheres[eight[e].sphere].halves()[0]);
        let radius = if P::GRADED {
            numbers[3]
        } else {
            W::constant(1.0)
        };
        (vector(numbers), radius)
    }

    /// One of the two grains, and its sphere, of eight pairs.
    #[inline(always)]
    pub(super) fn partner<W: Lane<Row = F64x8, Scalar = f64>, P: Physics>(
        &self,
        eight: &[Ball; WIDE],
        radius: W,
    ) -> Partner<W> {
        let motion = |e: usize| self.motions[eight[e].grain].halves();
        let moving = W::gather(|e| motion(e)[0]);
        Partner {
            arm: if P::ORIENTED {
                vector(W::gather(|e| self.spheres[eight[e].sphere].halves()[1]))
            } else {
                Vec3::zero()
            },
            velocity: vector(moving),
            spin: if P::SPINS {
                vector(W::gather(|e| motion(e)[1]))
            } else {
                Vec3::zero()
            },
            radius,
            inverse_mass: moving[3],
        }
    }

    /// Adds a force and a torque to the sums of a grain.
    #[inline(always)]
    pub(super) fn add<W: Lane<Row = F64x8>>(&mut self, grain: usize, load: W) {
        let sum = &mut self.loads[grain];
        (W::load(sum) + load).store(sum);
    }

    /// What acts on eight grains.
    #[inline(always)]
    pub(super) fn load<W: Lane<Row = F64x8, Scalar = f64>, P: Physics>(
        &self,
        eight: Eight,
    ) -> Load<W> {
        let load = |e: usize| self.loads[eight.nth(e)].halves();
        Load {
            force: vector(W::gather(|e| load(e)[0])),
            torque: if P::SPINS {
                vector(W::gather(|e| load(e)[1]))
            } else {
                Vec3::zero()
            },
        }
    }
}

/// Two vectors of eight, and the numbers beside them, as eight records.
#[inline(always)]
pub(super) fn records<W: Lane<Row = F64x8>>(
    first: Vec3<W>,
    second: Vec3<W>,
    [beside_first, beside_second]: [W; 2],
) -> [W; WIDE] {
    W::transposed([
        first.x,
        first.y,
        first.z,
        beside_first,
        second.x,
        second.y,
        second.z,
        beside_second,
    ])
}

#[inline(always)]
fn vector<L>([x, y, z, _]: [L; 4]) -> Vec3<L> {
    Vec3 { x, y, z }
}
