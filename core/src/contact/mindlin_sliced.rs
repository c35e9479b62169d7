//! Law M2, App. D.2: Mindlin's linearized law with its whole history, by slices of the contact's radius.
//!
//! With q = √p, the force is the integral of a density f(q) over 0 < q < √p.
//! A slip Δσ adds k_M Δσ to the density wherever the spheres touch; what they no longer share as p falls is lost.
//! The density is kept in Q − 1 slices of width dq = √p_max/(Q − 1), as the content c_j of each: its density times its live
//! width, which is dq below the outermost slice and √p − j_p dq in that. A falling overlap weakens the outermost slice by its
//! live width and drops those beyond, so that the stiffness is k_M √p exactly, and what is sheared at one overlap and released
//! at that overlap is not affected by what was beyond. (As printed, the force of equal densities is dq(x_p − ½)f instead of
//! √p f; [`super::path::Printed`] is that.)
//!
//! Every slice below the outermost takes the same increments of density, so its content is known from G, their sum so far:
//! with S_j the content of all slices below j, P_j = S_j − j dq G does not change while slice j − 1 is filled.
//! A step needs G, S, the outermost slice and its number; P_j is stored when a slice is filled, and read when it becomes the
//! outermost again, once in a hundred steps. Vectors are two numbers in a frame that is carried with the pair, so that nothing
//! stored need be turned.

use super::{Contact, Slices, TangentialLaw};
use crate::lanes::{Lane, Mask, Row, Scalar, grown};
use crate::math::{Vec3, plain};

/// Law M2.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MindlinSliced {
    /// k_M \[E R^½\].
    pub stiffness: f64,
    /// γ_M \[E R^½ t_c\].
    pub damping: f64,
    /// μ.
    pub friction_coefficient: f64,
    /// Q: the number of values of q at which the density is known, two at least.
    pub slices: u32,
    /// p_max, the overlap at the last of them \[R\]; beyond, the outermost slice grows on.
    pub largest_overlap: f64,
}

impl MindlinSliced {
    /// dq = √p_max/(Q − 1).
    fn slice(&self) -> f64 {
        self.largest_overlap.sqrt() / f64::from(self.slices - 1)
    }
}

/// Law M2's constants in registers.
#[derive(Clone, Copy, Debug)]
pub struct MindlinSlicedConstants<L> {
    stiffness: L,
    damping: L,
    friction_coefficient: L,
    /// dq and 1/dq.
    slice: L,
    per_slice: L,
    /// Q − 2.
    last: L,
}

/// Components of a history: the frame's first vector, G, S, the content of the outermost slice, its number, its live width/dq.
const FRAME: usize = 0;
const SUM: usize = 3;
const BELOW: usize = 5;
const OUTERMOST: usize = 7;
const NUMBER: usize = 9;
const LIVE: usize = 10;
const COMPONENTS: usize = 11;

impl TangentialLaw for MindlinSliced {
    type History<T: Copy + Send + Sync> = [T; COMPONENTS];
    /// P_j of the slices 1 … j_p.
    type Slices<R: Row> = super::slices::Stack<R>;
    type Constants<L: Lane> = MindlinSlicedConstants<L>;
    const TANGENTIAL: bool = true;

    #[inline(always)]
    fn constants<L: Lane>(&self) -> MindlinSlicedConstants<L> {
        MindlinSlicedConstants {
            stiffness: L::constant(self.stiffness),
            damping: L::constant(self.damping),
            friction_coefficient: L::constant(self.friction_coefficient),
            slice: L::constant(self.slice()),
            per_slice: L::constant(1.0 / self.slice()),
            last: L::constant(f64::from(self.slices - 2)),
        }
    }

    #[inline(always)]
    fn force<L: Lane>(
        law: &MindlinSlicedConstants<L>,
        contact: &Contact<L>,
        history: &mut [L; COMPONENTS],
        slices: &mut impl Slices<L::Scalar>,
    ) -> Vec3<L> {
        let (zero, one) = (L::constant(0.0), L::constant(1.0));
        let root = contact.root_overlap;
        let reached = root * law.per_slice;
        // A lane that does not touch has no root, and none of these is true of it.
        let number = history[NUMBER];
        let outgrown = (number + one).le(reached).and(number.lt(law.last));
        let moved = [
            reached.lt(number),
            outgrown,
            history[LIVE].le(zero).and(zero.lt(reached)),
        ];
        if moved.iter().any(|mask| mask.any()) {
            let normal = contact.normal;
            let mut rows = history.map(in_memory);
            let move_to = MoveTo::<L::Row> {
                lanes: moved.iter().fold(0, |bits, mask| bits | mask.bits()),
                normal: [normal.x, normal.y, normal.z].map(in_memory),
                reached: in_memory(reached),
                slice: in_memory(law.slice),
                last: in_memory(law.last),
            };
            move_to.outermost(&mut rows, slices);
            for (lanes, row) in history.iter_mut().zip(&rows) {
                *lanes = L::load(row);
            }
        }

        let first = Vec3 {
            x: history[FRAME],
            y: history[FRAME + 1],
            z: history[FRAME + 2],
        };
        let first = carried(first, contact.normal, contact.dither);
        let second = contact.normal.cross(first);
        let sliding = contact.sliding_velocity;
        let sliding = [sliding.dot(first), sliding.dot(second)];

        // The outermost slice loses what is no longer touched of it.
        let (was_live, live) = (history[LIVE], reached - history[NUMBER]);
        let lost = (was_live - live).max(zero) / was_live.max(L::constant(1e-30));
        // What a density adds to the slices below, and to the outermost.
        let below = history[NUMBER] * law.slice;
        let outermost = root - below;
        let scale = law.stiffness * contact.time_step;
        let kept = |n: usize| lost.neg_mul_add(history[OUTERMOST + n], history[OUTERMOST + n]);
        let slid = sliding.map(|v| v * scale);
        let damping = law.damping * root;
        let elastic: [L; 2] =
            std::array::from_fn(|n| slid[n].mul_add(root, history[BELOW + n] + kept(n)));
        let damped: [L; 2] = std::array::from_fn(|n| sliding[n].mul_add(damping, elastic[n]));

        let limit = law.friction_coefficient * contact.normal_force;
        let square = damped[0].mul_add(damped[0], damped[1] * damped[1]);
        let slipping = (limit * limit).lt(square);
        let (mut along, mut density) = (damped, slid);
        if slipping.any() {
            let share = limit / square.sqrt();
            let per_root = (share - one) / root.max(L::constant(1e-30));
            for n in 0..2 {
                along[n] = (damped[n] * share).select(slipping, damped[n]);
                density[n] = damped[n]
                    .mul_add(per_root, slid[n])
                    .select(slipping, slid[n]);
            }
        }
        for n in 0..2 {
            let add = |sum: &mut L, part: L| {
                *sum = if L::Scalar::COARSE {
                    grown(*sum, part, contact.dither)
                } else {
                    *sum + part
                };
            };
            let shed = lost * history[OUTERMOST + n];
            add(&mut history[SUM + n], density[n]);
            add(&mut history[BELOW + n], density[n] * below);
            add(
                &mut history[OUTERMOST + n],
                density[n].mul_add(outermost, -shed),
            );
        }
        history[FRAME] = first.x;
        history[FRAME + 1] = first.y;
        history[FRAME + 2] = first.z;
        history[LIVE] = live;
        // The force on `i` opposes the path of `i`.
        second.scale_add(-along[1], first.scale(-along[0]))
    }

    fn slices(history: &[f64]) -> usize {
        history.get(NUMBER).map_or(0, |&number| number as usize)
    }
}

/// The frame's first vector in today's contact plane: projected, and given unit length by 1/√(1 − x) ≈ 1 + x/2 + 3x²/8.
#[inline(always)]
fn carried<L: Lane>(first: Vec3<L>, normal: Vec3<L>, dither: L) -> Vec3<L> {
    let out_of_plane = first.dot(normal);
    let projected = normal.scale_sub(out_of_plane, first);
    let x = L::constant(1.0) - projected.dot(projected);
    let longer = x * x.mul_add(L::constant(0.375), L::constant(0.5));
    if L::Scalar::COARSE {
        let change = normal.scale_sub(out_of_plane, projected.scale(longer));
        first.grown(change, dither)
    } else {
        projected.scale_add(longer, projected)
    }
}

/// Where the outermost slices of some lanes go.
struct MoveTo<R> {
    /// One bit for each lane that is meant.
    lanes: u32,
    normal: [R; 3],
    /// √p/dq.
    reached: R,
    /// dq.
    slice: R,
    /// Q − 2.
    last: R,
}

impl<R: Row> MoveTo<R> {
    /// Makes the slice that √p lies in the outermost of each lane; a lane that is new gets a frame.
    #[cold]
    #[inline(never)]
    fn outermost(&self, rows: &mut [R; COMPONENTS], slices: &mut impl Slices<R::Scalar>) {
        for k in (0..R::K).filter(|k| self.lanes >> k & 1 == 1) {
            let of = |row: &R| row.lanes()[k].to_f64();
            let mut moving = Moving {
                history: std::array::from_fn(|n| of(&rows[n])),
                slice: of(&self.slice),
                last: of(&self.last),
            };
            if moving.history[FRAME..SUM] == [0.0; 3] {
                let [x, y, z] = &self.normal;
                moving.history[FRAME..SUM].copy_from_slice(&across([x, y, z].map(of)));
            }
            moving.to(of(&self.reached), k, slices);
            for (row, number) in rows.iter_mut().zip(moving.history) {
                row.lanes_mut()[k] = R::Scalar::from_f64(number);
            }
        }
    }
}

#[inline(always)]
fn in_memory<L: Lane>(lanes: L) -> L::Row {
    let mut row = L::Row::default();
    lanes.store(&mut row);
    row
}

/// A unit vector across `normal`.
fn across(normal: [f64; 3]) -> [f64; 3] {
    let [x, y, z] = normal.map(f64::abs);
    let axis = if x <= y && x <= z {
        [1.0, 0.0, 0.0]
    } else if y <= z {
        [0.0, 1.0, 0.0]
    } else {
        [0.0, 0.0, 1.0]
    };
    let across = plain::cross(normal, axis);
    plain::scale(across, 1.0 / plain::norm(across))
}

/// One lane whose outermost slice becomes another.
struct Moving {
    history: [f64; COMPONENTS],
    slice: f64,
    last: f64,
}

impl Moving {
    /// P_j = S_j − j dq G and S_j, one from the other: `sign` is −1 or +1.
    fn offset(&self, [x, y]: [f64; 2], slice: usize, sign: f64) -> [f64; 2] {
        let times = sign * slice as f64 * self.slice;
        [
            x + times * self.history[SUM],
            y + times * self.history[SUM + 1],
        ]
    }

    /// The content of all slices below slice `j`, from what was stored when it became the outermost.
    fn below<S: Scalar>(&self, j: usize, lane: usize, slices: &impl Slices<S>) -> [f64; 2] {
        match j.checked_sub(1) {
            None => [0.0; 2],
            Some(stored) => self.offset(slices.get(lane, stored).map(S::to_f64), j, 1.0),
        }
    }

    /// Makes the slice of `reached` = √p/dq the outermost.
    fn to<S: Scalar>(&mut self, reached: f64, lane: usize, slices: &mut impl Slices<S>) {
        let target = reached.min(self.last).max(0.0) as usize;
        let mut number = self.history[NUMBER] as usize;
        if target < number {
            let (below, with) = (
                self.below(target, lane, slices),
                self.below(target + 1, lane, slices),
            );
            let live = reached - target as f64;
            for n in 0..2 {
                self.history[BELOW + n] = below[n];
                self.history[OUTERMOST + n] = (with[n] - below[n]) * live;
            }
            self.history[LIVE] = live;
            number = target;
        }
        while number < target {
            number += 1;
            for n in 0..2 {
                self.history[BELOW + n] += self.history[OUTERMOST + n];
                self.history[OUTERMOST + n] = 0.0;
            }
            let below = [self.history[BELOW], self.history[BELOW + 1]];
            let stored = self.offset(below, number, -1.0);
            slices.set(lane, number - 1, stored.map(S::from_f64));
            self.history[LIVE] = reached - number as f64;
        }
        self.history[NUMBER] = number as f64;
    }
}
