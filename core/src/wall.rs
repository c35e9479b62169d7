//! Walls: six flat, rigid, frictionless planes that move along their normals.
//!
//! Positions and forces are kept in double precision whatever the lanes are.

pub mod press;

use crate::lanes::{Row, Scalar};

/// The largest number of replicas.
pub const MAX_LANES: usize = 16;

/// The walls' numbers: −x, +x, −y, +y, −z, +z.
pub const WALLS: usize = 6;

/// The axis that a wall is normal to.
#[inline(always)]
#[must_use]
pub fn axis(wall: usize) -> usize {
    wall / 2
}

/// +1 for a wall that pushes grains up its axis, −1 for one that pushes them down.
#[inline(always)]
#[must_use]
pub fn inward(wall: usize) -> f64 {
    if wall.is_multiple_of(2) { 1.0 } else { -1.0 }
}

/// Six walls in K replicas.
#[derive(Clone, Debug)]
pub struct Walls<R: Row> {
    /// Where each wall is in the shared reference \[R\].
    reference: [f64; WALLS],
    /// Where each wall is, per replica.
    position: [[f64; MAX_LANES]; WALLS],
    /// Displacement from the reference, in the lanes' type.
    pub(crate) displacement: [R; WALLS],
    /// Velocity along the axis since the last step.
    pub(crate) velocity: [R; WALLS],
    /// Force of the grains on each wall in the last step, pushing outward \[E R²\].
    pub(crate) force: [[f64; MAX_LANES]; WALLS],
}

impl<R: Row> Walls<R> {
    /// Walls at rest in their reference.
    #[must_use]
    pub fn at_rest(reference: [f64; WALLS]) -> Self {
        Self {
            reference,
            position: reference.map(|w| [w; MAX_LANES]),
            displacement: [R::default(); WALLS],
            velocity: [R::default(); WALLS],
            force: [[0.0; MAX_LANES]; WALLS],
        }
    }

    /// Where each wall is in the shared reference.
    #[must_use]
    pub fn reference(&self) -> [f64; WALLS] {
        self.reference
    }

    /// Where wall `w` of replica `k` is.
    #[must_use]
    pub fn position(&self, w: usize, k: usize) -> f64 {
        self.position[w][k]
    }

    /// The extent of the box of replica `k` along `axis`.
    #[must_use]
    pub fn extent(&self, axis: usize, k: usize) -> f64 {
        self.position[2 * axis + 1][k] - self.position[2 * axis][k]
    }

    /// Moves wall `w` of replica `k` to `position` within one step of `time_step`.
    pub fn advance(&mut self, w: usize, k: usize, position: f64, time_step: f64) {
        let velocity = (position - self.position[w][k]) / time_step;
        self.place(w, k, position);
        self.velocity[w].lanes_mut()[k] = R::Scalar::from_f64(velocity);
    }

    /// Puts wall `w` of replica `k` at `position`, at rest.
    pub fn place(&mut self, w: usize, k: usize, position: f64) {
        self.position[w][k] = position;
        self.displacement[w].lanes_mut()[k] = R::Scalar::from_f64(position - self.reference[w]);
        self.velocity[w].lanes_mut()[k] = R::Scalar::from_f64(0.0);
    }

    /// Makes the forces of the grains the sums of `pushes`, each with its wall's number, in their order.
    pub(crate) fn bear<'a>(&mut self, pushes: impl Iterator<Item = &'a (u8, R)>) {
        self.force = [[0.0; MAX_LANES]; WALLS];
        for (wall, push) in pushes {
            for (sum, &lane) in self.force[usize::from(*wall)].iter_mut().zip(push.lanes()) {
                *sum += lane.to_f64();
            }
        }
    }

    /// Mean pressure of replica `k` on the two walls normal to `axis` in the last step \[E\].
    #[must_use]
    pub fn pressure(&self, axis: usize, k: usize) -> f64 {
        let area = self.extent((axis + 1) % 3, k) * self.extent((axis + 2) % 3, k);
        0.5 * (self.force[2 * axis][k] + self.force[2 * axis + 1][k]) / area
    }

    /// The volume of the box of replica `k`.
    #[must_use]
    pub fn volume(&self, k: usize) -> f64 {
        self.extent(0, k) * self.extent(1, k) * self.extent(2, k)
    }

    /// Makes replica `to` a copy of replica `from`.
    pub fn copy_lane(&mut self, from: usize, to: usize) {
        for w in 0..WALLS {
            self.position[w][to] = self.position[w][from];
            self.force[w][to] = self.force[w][from];
            for rows in [&mut self.displacement[w], &mut self.velocity[w]] {
                rows.lanes_mut()[to] = rows.lanes()[from];
            }
        }
    }
}
