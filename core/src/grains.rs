//! The state of all grains; this module alone knows how it lies in memory.
//!
//! Every replica is a displacement from one shared reference in double precision, so that single precision lanes resolve
//! the small differences that carry a memory (docs/choices.md §4).
//! Velocities and spins are those of the last half step.

use crate::lanes::{Row, Scalar};
use crate::math::{Quaternion, Vec3, plain};
use crate::shape::Body;

/// Where one grain is, in the reference or in one replica.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// Center of mass \[R\].
    pub position: [f64; 3],
    /// Rotation of the body frame `[w, x, y, z]`; the identity for spheres.
    pub orientation: [f64; 4],
}

/// How one grain moves in one replica.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Motion {
    /// \[R/t_c\].
    pub velocity: [f64; 3],
    /// \[1/t_c\].
    pub spin: [f64; 3],
}

/// The rotation that turns nothing.
pub const UPRIGHT: [f64; 4] = [1.0, 0.0, 0.0, 0.0];

/// The order in which grains should be numbered, so that near numbers mean near places: by layers of z, then y, then x.
#[must_use]
pub fn spatial_order(poses: &[Pose]) -> Vec<usize> {
    // Cells about as wide as a grain keep a row's neighbors within two layers of memory.
    const CELL: f64 = 3.0;
    let key = |&i: &usize| {
        let [x, y, z] = poses[i].position;
        ((z / CELL).floor() as i64, (y / CELL).floor() as i64, x)
    };
    let mut order: Vec<usize> = (0..poses.len()).collect();
    order.sort_by(|a, b| {
        let ((za, ya, xa), (zb, yb, xb)) = (key(a), key(b));
        (za, ya)
            .cmp(&(zb, yb))
            .then(xa.total_cmp(&xb))
            .then(a.cmp(b))
    });
    order
}

/// All grains in K replicas.
#[derive(Clone, Debug)]
pub struct Grains<R: Row> {
    /// The shared reference.
    pub(crate) reference: Vec<Pose>,
    /// Sphere centers from the center of mass in the reference, `spheres` to a grain.
    arms: Vec<[f64; 3]>,
    /// The same, rounded to the lanes' type.
    pub(crate) lane_arms: Vec<[R::Scalar; 3]>,
    /// Spheres per grain.
    spheres: usize,
    pub(crate) displacement: Vec<Vec3<R>>,
    pub(crate) velocity: Vec<Vec3<R>>,
    /// Rotation from the reference; empty for spheres.
    pub(crate) turn: Vec<Quaternion<R>>,
    /// Empty where nothing can spin a grain.
    pub(crate) spin: Vec<Vec3<R>>,
    /// Empty where all grains are alike, with radius 1.
    pub(crate) sizes: Vec<Size>,
}

/// How large and heavy one grain is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Size {
    /// R.
    pub radius: f64,
    /// 1/m.
    pub inverse_mass: f64,
    /// 1/I.
    pub inverse_inertia: f64,
}

impl Size {
    /// A solid sphere: m = (4π/3) ρ R³, I = (2/5) m R².
    #[must_use]
    pub fn sphere(radius: f64, density: f64) -> Self {
        let mass = 4.0 / 3.0 * std::f64::consts::PI * density * radius * radius * radius;
        Self {
            radius,
            inverse_mass: 1.0 / mass,
            inverse_inertia: 1.0 / (0.4 * mass * radius * radius),
        }
    }
}

impl<R: Row> Grains<R> {
    /// Grains at rest in their reference; `spins` says whether anything can turn them.
    #[must_use]
    pub fn at_rest(reference: Vec<Pose>, body: &Body, spins: bool) -> Self {
        let n = reference.len();
        let spheres = body.arms.len();
        let turning = if spheres > 1 { n } else { 0 };
        let spinning = if spins { n } else { 0 };
        let arms: Vec<[f64; 3]> = if spheres > 1 {
            let rotated = |pose: &Pose| {
                body.arms
                    .iter()
                    .map(|&arm| plain::rotate(pose.orientation, arm))
                    .collect::<Vec<_>>()
            };
            reference.iter().flat_map(rotated).collect()
        } else {
            vec![]
        };
        Self {
            lane_arms: arms
                .iter()
                .map(|arm| arm.map(R::Scalar::from_f64))
                .collect(),
            arms,
            spheres,
            displacement: vec![Vec3::default(); n],
            velocity: vec![Vec3::default(); n],
            turn: vec![Quaternion::identity(); turning],
            spin: vec![Vec3::default(); spinning],
            sizes: vec![],
            reference,
        }
    }

    /// Gives every grain a size of its own; only for shapes that are graded.
    ///
    /// # Panics
    ///
    /// If there are not as many sizes as grains.
    #[must_use]
    pub fn graded(mut self, sizes: Vec<Size>) -> Self {
        assert_eq!(sizes.len(), self.len(), "one size for each grain");
        self.sizes = sizes;
        self
    }

    /// The radius of every sphere of grain `i`.
    #[must_use]
    pub fn radius(&self, i: usize) -> f64 {
        self.sizes.get(i).map_or(1.0, |size| size.radius)
    }

    /// The sizes of all grains; none where all are alike.
    #[must_use]
    pub fn sizes(&self) -> &[Size] {
        &self.sizes
    }

    /// N.
    #[must_use]
    pub fn len(&self) -> usize {
        self.reference.len()
    }

    /// Whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.reference.is_empty()
    }

    /// Spheres per grain.
    #[must_use]
    pub fn spheres(&self) -> usize {
        self.spheres
    }

    /// The shared reference.
    #[must_use]
    pub fn reference(&self) -> &[Pose] {
        &self.reference
    }

    /// The center of sphere `a` of grain `i` in the reference, from the grain's center of mass.
    #[must_use]
    pub fn arm(&self, i: usize, a: usize) -> [f64; 3] {
        if self.spheres > 1 {
            self.arms[self.spheres * i + a]
        } else {
            [0.0; 3]
        }
    }

    /// Where grain `i` is in replica `k`.
    #[must_use]
    pub fn pose(&self, i: usize, k: usize) -> Pose {
        let reference = &self.reference[i];
        let orientation = match self.turn.get(i) {
            Some(turn) => plain::compose(turn.lane(k), reference.orientation),
            None => UPRIGHT,
        };
        Pose {
            position: self.place(i, k),
            orientation,
        }
    }

    /// The center of mass of grain `i` in replica `k`.
    #[inline(always)]
    #[must_use]
    pub fn place(&self, i: usize, k: usize) -> [f64; 3] {
        plain::add(self.reference[i].position, self.displacement[i].lane(k))
    }

    /// The center of sphere `a` of grain `i` in replica `k`.
    #[must_use]
    pub fn center(&self, i: usize, a: usize, k: usize) -> [f64; 3] {
        let position = self.place(i, k);
        match self.turn.get(i) {
            Some(turn) => plain::add(position, plain::rotate(turn.lane(k), self.arm(i, a))),
            None => position,
        }
    }

    /// How grain `i` moves in replica `k`.
    #[must_use]
    pub fn motion(&self, i: usize, k: usize) -> Motion {
        Motion {
            velocity: self.velocity[i].lane(k),
            spin: self.spin.get(i).map_or([0.0; 3], |spin| spin.lane(k)),
        }
    }

    /// Sets how grain `i` moves in replica `k`.
    pub fn set_motion(&mut self, i: usize, k: usize, motion: Motion) {
        self.velocity[i].set_lane(k, motion.velocity);
        if let Some(spin) = self.spin.get_mut(i) {
            spin.set_lane(k, motion.spin);
        }
    }

    /// How far grain `i` of replica `k` is from the reference: displacement and turn `[w, x, y, z]`.
    #[must_use]
    pub fn offset(&self, i: usize, k: usize) -> ([f64; 3], [f64; 4]) {
        (
            self.displacement[i].lane(k),
            self.turn.get(i).map_or(UPRIGHT, |turn| turn.lane(k)),
        )
    }

    /// Sets how far grain `i` of replica `k` is from the reference.
    pub fn set_offset(&mut self, i: usize, k: usize, displacement: [f64; 3], turn: [f64; 4]) {
        self.displacement[i].set_lane(k, displacement);
        if let Some(row) = self.turn.get_mut(i) {
            row.set_lane(k, turn);
        }
    }

    /// Makes replica `to` a copy of replica `from`.
    pub fn copy_lane(&mut self, from: usize, to: usize) {
        for i in 0..self.len() {
            let (displacement, turn) = self.offset(i, from);
            let motion = self.motion(i, from);
            self.set_offset(i, to, displacement, turn);
            self.set_motion(i, to, motion);
        }
    }

    /// Bytes per grain of state, without lists and springs.
    #[must_use]
    pub fn bytes_per_grain(&self) -> usize {
        use std::mem::size_of;
        let n = self.len().max(1);
        let vectors = self.displacement.len() + self.velocity.len() + self.spin.len();
        let total = self.reference.len() * size_of::<Pose>()
            + self.arms.len() * (size_of::<[f64; 3]>() + size_of::<[R::Scalar; 3]>())
            + vectors * size_of::<Vec3<R>>()
            + self.turn.len() * size_of::<Quaternion<R>>()
            + self.sizes.len() * size_of::<Size>();
        total / n
    }
}
