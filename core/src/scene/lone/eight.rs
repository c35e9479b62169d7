//! Grains eight at a time: one to a lane.

use crate::lanes::{F64x1, F64x8, Lane};
use crate::math::{Quaternion, Vec3};
use crate::scene::Physics;
use crate::scene::motion::Moving;
use crate::scene::motions::{Motions, MotionsMut};

use super::WIDE;

/// Up to eight grains in a row, one to a lane; lanes beyond the last grain repeat it.
#[derive(Clone, Copy)]
pub(super) struct Eight {
    pub(super) first: usize,
    pub(super) count: usize,
}

impl Eight {
    #[inline(always)]
    pub(super) fn from(first: usize, len: usize) -> Self {
        Self {
            first,
            count: WIDE.min(len - first),
        }
    }

    /// The grain in lane `e`.
    #[inline(always)]
    pub(super) fn nth(self, e: usize) -> usize {
        self.first + e.min(self.count - 1)
    }

    #[inline(always)]
    pub(super) fn gather<W: Lane<Row = F64x8, Scalar = f64>>(
        self,
        vector: impl Fn(usize) -> [f64; 3],
    ) -> Vec3<W> {
        gathered(|e| vector(self.nth(e)))
    }

    /// The grains' own vectors of all.
    #[inline(always)]
    fn vectors<W: Lane<Row = F64x8, Scalar = f64>>(self, all: &[Vec3<F64x1>]) -> Vec3<W> {
        let own = &all[self.first..self.first + self.count];
        let mut triples = [[0.0; 3]; WIDE];
        match own.as_array::<WIDE>() {
            Some(own) => {
                for (triple, vector) in triples.iter_mut().zip(own) {
                    *triple = numbers(vector);
                }
            }
            None => {
                for (e, triple) in triples.iter_mut().enumerate() {
                    *triple = numbers(&own[e.min(self.count - 1)]);
                }
            }
        }
        let [x, y, z] = W::of_triples(&triples);
        Vec3 { x, y, z }
    }

    #[inline(always)]
    pub(super) fn numbers<W: Lane<Row = F64x8, Scalar = f64>>(
        self,
        number: impl Fn(usize) -> f64,
    ) -> W {
        W::load(&F64x8(std::array::from_fn(|e| number(self.nth(e)))))
    }

    #[inline(always)]
    pub(super) fn load<W: Lane<Row = F64x8, Scalar = f64>, P: Physics>(
        self,
        motions: &Motions<'_, F64x1>,
    ) -> Moving<W> {
        let mut moving = Moving {
            displacement: self.vectors(motions.displacement),
            velocity: self.vectors(motions.velocity),
            turn: Quaternion {
                w: W::constant(1.0),
                v: Vec3::zero(),
            },
            spin: Vec3::zero(),
        };
        if P::SPINS {
            moving.spin = self.vectors(motions.spin);
        }
        if P::ORIENTED {
            moving.turn = Quaternion {
                w: W::load(&F64x8(std::array::from_fn(|e| {
                    motions.turn[self.nth(e)].w.0[0]
                }))),
                v: self.gather(|i| numbers(&motions.turn[i].v)),
            };
        }
        moving
    }

    #[inline(always)]
    pub(super) fn store<W: Lane<Row = F64x8, Scalar = f64>, P: Physics>(
        self,
        moving: Moving<W>,
        motions: &mut MotionsMut<'_, F64x1>,
    ) {
        let range = self.first..self.first + self.count;
        put(
            moving.displacement,
            &mut motions.displacement[range.clone()],
        );
        put(moving.velocity, &mut motions.velocity[range.clone()]);
        if P::SPINS {
            put(moving.spin, &mut motions.spin[range.clone()]);
        }
        if P::ORIENTED {
            let mut turn = Quaternion::default();
            moving.turn.store(&mut turn);
            for (e, to) in motions.turn[range].iter_mut().enumerate() {
                *to = Quaternion {
                    w: F64x1([turn.w.0[e]]),
                    v: nth(&turn.v, e),
                };
            }
        }
    }
}

#[inline(always)]
fn nth(rows: &Vec3<F64x8>, e: usize) -> Vec3<F64x1> {
    Vec3 {
        x: F64x1([rows.x.0[e]]),
        y: F64x1([rows.y.0[e]]),
        z: F64x1([rows.z.0[e]]),
    }
}

#[inline(always)]
fn numbers(vector: &Vec3<F64x1>) -> [f64; 3] {
    [vector.x.0[0], vector.y.0[0], vector.z.0[0]]
}

#[inline(always)]
fn put<W: Lane<Row = F64x8, Scalar = f64>>(vector: Vec3<W>, to: &mut [Vec3<F64x1>]) {
    let triples = W::triples([vector.x, vector.y, vector.z]);
    for (to, [x, y, z]) in to.iter_mut().zip(triples) {
        *to = Vec3 {
            x: F64x1([x]),
            y: F64x1([y]),
            z: F64x1([z]),
        };
    }
}

#[inline(always)]
fn gathered<W: Lane<Row = F64x8>>(vector: impl Fn(usize) -> [f64; 3]) -> Vec3<W> {
    let mut rows = Vec3::<F64x8>::default();
    for e in 0..WIDE {
        [rows.x.0[e], rows.y.0[e], rows.z.0[e]] = vector(e);
    }
    rows.load()
}
