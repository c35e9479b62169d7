//! The interaction of two spheres: from their branch vector to forces and torques, for any lane type.
//!
//! Nothing here knows where the numbers come from, or whether lanes are replicas or contacts.

mod length;

use crate::contact::slices::Slices;
use crate::contact::{Contact, TangentialLaw, hertz};
use crate::lanes::Lane;
use crate::math::Vec3;
use crate::scene::{Laws, Physics};

use length::inverse_length_and_overlap;

/// Constants of all contacts in registers.
#[derive(Clone, Copy)]
pub(super) struct Constants<L: Lane, T: TangentialLaw> {
    normal_stiffness: L,
    normal_damping: L,
    /// Half a mass, where all are alike.
    reduced_mass: L,
    tangential: T::Constants<L>,
    time_step: L,
    dither: L,
}

impl<L: Lane, T: TangentialLaw> Constants<L, T> {
    #[inline(always)]
    pub(super) fn new<P: Physics<Tangential = T>>(laws: &Laws<P>) -> Self {
        Self {
            normal_stiffness: L::constant(laws.material.normal_stiffness),
            normal_damping: L::constant(laws.material.normal_damping),
            reduced_mass: L::constant(0.5 * laws.body.mass),
            tangential: laws.tangential.constants(),
            time_step: L::constant(laws.time_step),
            dither: L::constant(laws.dither),
        }
    }
}

/// How the branch vector L = L0 + e of two spheres departs from its reference.
#[derive(Clone, Copy)]
pub(super) struct Branch<L> {
    /// L.
    pub(super) vector: Vec3<L>,
    /// |L|² − (R_i + R_j)²: below zero where the spheres touch.
    pub(super) excess: L,
}

/// The branch vector from (2 L0, |L0|² − 4) and the change e: no digits are lost to |L|² ≈ 4.
///
/// Where grains differ in size, the last number is |L0|² and `reach` R_i + R_j.
#[inline(always)]
pub(super) fn branch<L: Lane, P: Physics>(
    [x, y, z, square]: [L; 4],
    change: Vec3<L>,
    reach: L,
) -> Branch<L> {
    let twice = Vec3 { x, y, z };
    let both = twice + change;
    let excess = if P::GRADED {
        reach.neg_mul_add(reach, square)
    } else {
        square
    };
    Branch {
        vector: twice.scale_add(L::constant(0.5), change),
        excess: both.x.mul_add(
            change.x,
            both.y.mul_add(change.y, both.z.mul_add(change.z, excess)),
        ),
    }
}

/// Where and how deep two spheres touch.
#[derive(Clone, Copy)]
pub(super) struct Geometry<L> {
    /// n̂, from `j` into `i`.
    pub(super) normal: Vec3<L>,
    /// p \[R\].
    pub(super) overlap: L,
    /// √p, or √(R_eff p) where grains differ in size.
    pub(super) root_overlap: L,
}

/// From the branch vector of two spheres that touch.
#[inline(always)]
pub(super) fn geometry<L: Lane, P: Physics>(branch: Branch<L>, radii: [L; 2]) -> Geometry<L> {
    if P::GRADED {
        return graded(branch, radii);
    }
    let (inverse, overlap) = inverse_length_and_overlap(branch.excess);
    Geometry {
        normal: branch.vector.scale(inverse),
        overlap,
        root_overlap: overlap.sqrt(),
    }
}

/// p = −(|L|² − s²)/(|L| + s) with s = R_i + R_j, with one division for p, n̂ and R_eff together.
#[inline(always)]
fn graded<L: Lane>(branch: Branch<L>, radii: [L; 2]) -> Geometry<L> {
    let excess = branch.excess;
    let reach = radii[0] + radii[1];
    let length = (excess + reach * reach).sqrt();
    let sum = length + reach;
    let both = length * sum;
    let inverse_of_all = L::constant(1.0) / (both * reach);
    let (inverse, inverse_reach) = (inverse_of_all * reach, inverse_of_all * both);
    let overlap = -excess * (inverse * length);
    Geometry {
        normal: branch.vector.scale(inverse * sum),
        overlap,
        root_overlap: (radii[0] * radii[1] * inverse_reach * overlap).sqrt(),
    }
}

/// How one of the two grains is placed and moves.
#[derive(Clone, Copy)]
pub(super) struct Partner<L> {
    /// The sphere's center from the grain's center of mass.
    pub(super) arm: Vec3<L>,
    /// Of the center of mass.
    pub(super) velocity: Vec3<L>,
    /// Meaningless where nothing spins.
    pub(super) spin: Vec3<L>,
    /// 1 where all are alike.
    pub(super) radius: L,
    /// Meaningless where all are alike.
    pub(super) inverse_mass: L,
}

/// What a contact does to its grains.
#[derive(Clone, Copy)]
pub(super) struct Action<L> {
    /// On `i`; the opposite acts on `j`.
    pub(super) force: Vec3<L>,
    /// The part of it that may turn a grain: a sphere's lever lies along the normal force, which but for rounding cannot.
    turning: Vec3<L>,
    /// From `i`'s center of mass to the contact point.
    pub(super) lever_i: Vec3<L>,
    /// From `j`'s center of mass to the contact point.
    pub(super) lever_j: Vec3<L>,
}

impl<L: Lane> Action<L> {
    /// The same where two touch; where not, what may not be numbers becomes an exact zero, and turns nothing.
    #[inline(always)]
    pub(super) fn keep(self, touching: L::Mask) -> Self {
        Self {
            force: self.force.keep(touching),
            turning: self.turning.keep(touching),
            ..self
        }
    }

    /// On `i`, about its center of mass.
    #[inline(always)]
    pub(super) fn torque_i(&self) -> Vec3<L> {
        self.lever_i.cross(self.turning)
    }

    /// On `j`, about its center of mass, from the opposite force.
    #[inline(always)]
    pub(super) fn torque_j(&self) -> Vec3<L> {
        self.turning.cross(self.lever_j)
    }
}

/// The force of one contact; advances its history. Lanes that do not touch hold numbers without meaning.
///
/// Both grains' velocities are taken at one and the same point, in the middle of the overlap, and the force acts there:
/// a pair that turns rigidly does not slip, and no torque is lost.
#[inline(always)]
pub(super) fn interact<L: Lane, P: Physics>(
    constants: &Constants<L, P::Tangential>,
    geometry: &Geometry<L>,
    i: &Partner<L>,
    j: &Partner<L>,
    (history, slices): (
        &mut <P::Tangential as TangentialLaw>::History<L>,
        &mut impl Slices<L::Scalar>,
    ),
) -> Action<L> {
    let normal = geometry.normal;
    let half = L::constant(0.5);
    let lever_i = normal.scale_sub(geometry.overlap.neg_mul_add(half, i.radius), i.arm);
    let lever_j = normal.scale_add(geometry.overlap.neg_mul_add(half, j.radius), j.arm);
    let mut relative = i.velocity - j.velocity;
    if P::SPINS {
        relative = lever_j.cross_add(j.spin, i.spin.cross_add(lever_i, relative));
    }
    let overlap_rate = -relative.dot(normal);
    let normal_force = hertz::normal_force(
        constants.normal_stiffness,
        constants.normal_damping,
        geometry.overlap,
        geometry.root_overlap,
        overlap_rate,
    );
    let mut tangential = Vec3::zero();
    if P::Tangential::TANGENTIAL {
        let contact = Contact {
            normal,
            sliding_velocity: normal.scale_add(overlap_rate, relative),
            root_overlap: geometry.root_overlap,
            reduced_mass: if P::GRADED {
                L::constant(1.0) / (i.inverse_mass + j.inverse_mass)
            } else {
                constants.reduced_mass
            },
            normal_force,
            time_step: constants.time_step,
            dither: constants.dither,
        };
        tangential = P::Tangential::force(&constants.tangential, &contact, history, slices);
    }
    // Beams keep the bits of a sum that is rounded twice.
    let force = if !P::Tangential::TANGENTIAL {
        normal.scale(normal_force)
    } else if P::GRADED {
        normal.scale(normal_force) + tangential
    } else {
        normal.scale_add(normal_force, tangential)
    };
    Action {
        force,
        turning: if P::ORIENTED { force } else { tangential },
        lever_i,
        lever_j,
    }
}
