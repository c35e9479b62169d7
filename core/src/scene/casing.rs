//! A casing: a membrane around the grains, what presses on it from outside, and its contacts with the grains.
//!
//! A grain touches a triangle as it would a flat grain: R_eff is its radius, and the opposite force is shared out to the
//! triangle's corners by the barycentric coordinates of the contact point, where both velocities are taken too, so that
//! momentum and angular momentum are kept.

mod foot;
mod near;
mod touch;

use super::surroundings::{OnGrains, Surroundings};
use crate::contact::mindlin::Mindlin;
use crate::contact::{Contact, TangentialLaw, hertz};
use crate::grains::Grains;
use crate::lanes::{F64x1, F64x8, Lane, Row};
use crate::material::Material;
use crate::math::{Vec3, plain};
use crate::membrane::Membrane;
use crate::wall::press::{Plane, Rod, VertexBall};
use near::Near;
use touch::{Ball, Face, Finder, Share, Sheet, faces};

/// Lanes.
const WIDE: usize = 8;

/// How grains and membrane touch.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Grip {
    /// Along the normal.
    pub material: Material,
    /// Across it.
    pub tangential: Mindlin,
    /// Mass of the membrane \[kg/m²\].
    pub areal_density: f64,
}

/// What presses on the membrane from outside.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Press {
    /// Δp \[Pa\].
    pub pressure: f64,
    /// The mold.
    pub planes: Vec<Plane>,
    /// The loading rods.
    pub rods: Vec<Rod>,
    /// The ball that stands for a vertex before planes and rods.
    pub ball: VertexBall,
}

/// A contact of a grain with the membrane, as it was in the last step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Held {
    /// The grain.
    pub grain: u32,
    /// The triangle that it reaches deepest.
    pub triangle: u32,
    /// The elongation of the friction spring \[m\].
    pub spring: [f64; 3],
    /// f_n \[N\].
    pub normal_force: f64,
    /// |f_t| \[N\].
    pub tangential_force: f64,
    /// p \[m\].
    pub overlap: f64,
}

/// One contact of the running step, until its force is known.
#[derive(Clone, Copy, Debug)]
struct Pending {
    held: Held,
    normal: [f64; 3],
    lever: [f64; 3],
    /// Velocity of the grain against the membrane at the contact point.
    relative: [f64; 3],
    radius: f64,
    /// 1/m_grain + 1/m_triangle.
    inverse_mass: f64,
    /// Where its shares end.
    shares_end: usize,
}

/// A membrane with grains inside.
#[derive(Clone, Debug, Default)]
pub struct Casing {
    /// The membrane.
    pub membrane: Membrane,
    /// How grains touch it.
    pub grip: Grip,
    /// What presses on it.
    pub press: Press,
    /// The contacts of the last step, by grains.
    held: Vec<Held>,
    near: Near,
    /// Where the vertices were at the last renewal.
    built: Vec<[f64; 3]>,
    faces: Vec<Face>,
    finder: Finder,
    pending: Vec<Pending>,
    shares: Vec<Share>,
}

impl Casing {
    /// A membrane that no grain touches yet.
    #[must_use]
    pub fn new(membrane: Membrane, grip: Grip, press: Press) -> Self {
        Self {
            membrane,
            grip,
            press,
            ..Self::default()
        }
    }

    /// The contacts of the last step, by grains.
    #[must_use]
    pub fn held(&self) -> &[Held] {
        &self.held
    }

    /// Gives back the contacts of a step before.
    pub fn hold(&mut self, held: Vec<Held>) {
        self.held = held;
    }

    /// Finds where every grain touches the membrane.
    fn find(&mut self, grains: &Grains<F64x1>) {
        self.pending.clear();
        self.shares.clear();
        self.faces.clear();
        self.faces.extend(faces(self.membrane.mesh()));
        let mut old = 0;
        for i in 0..self.near.grains() {
            let first = old;
            while self.held.get(old).is_some_and(|h| h.grain as usize == i) {
                old += 1;
            }
            let near = self.near.of(i);
            if near.is_empty() {
                continue;
            }
            let mesh = self.membrane.mesh();
            let held = &self.held[first..old];
            let near_held = |t: u32| {
                held.iter()
                    .any(|h| is_neighbor(&self.membrane, h.triangle, t))
            };
            let ball = Ball {
                center: grains.pose(i, 0).position,
                radius: grains.radius(i),
                touched: &near_held,
            };
            let sheet = Sheet {
                mesh,
                faces: &self.faces,
            };
            self.finder.find(&sheet, &ball, near);
            let mut taken = 0u64;
            for k in 0..self.finder.touches.len() {
                let held = &self.held[first..old];
                let spring = carried_over(&self.membrane, held, &self.finder, k, &mut taken);
                self.note(grains, i, k, spring);
            }
        }
    }

    /// Notes contact `k` of grain `i`, as the finder left it.
    fn note(&mut self, grains: &Grains<F64x1>, i: usize, k: usize, spring: [f64; 3]) {
        let touch = self.finder.touches[k];
        let first = if k == 0 { 0 } else { self.finder.ends[k - 1] };
        let shares = &self.finder.shares[first..self.finder.ends[k]];
        let motion = grains.motion(i, 0);
        let velocities = self.membrane.velocities();
        let of_sheet = shares.iter().fold([0.0; 3], |sum, share| {
            plain::add(
                sum,
                plain::scale(velocities[share.vertex as usize], share.weight),
            )
        });
        let surface = plain::add(motion.velocity, plain::cross(motion.spin, touch.lever));
        let area = self.membrane.rest_areas()[touch.triangle as usize];
        let size = grains.sizes()[i];
        self.shares.extend_from_slice(shares);
        self.pending.push(Pending {
            held: Held {
                grain: i as u32,
                triangle: touch.triangle,
                spring,
                normal_force: 0.0,
                tangential_force: 0.0,
                overlap: touch.overlap,
            },
            normal: touch.normal,
            lever: touch.lever,
            relative: plain::sub(surface, of_sheet),
            radius: size.radius,
            inverse_mass: size.inverse_mass + 1.0 / (self.grip.areal_density * area),
            shares_end: self.shares.len(),
        });
    }

    /// Finds the forces of all contacts, eight at a time, and adds them in order.
    #[inline(always)]
    fn push<W: Lane<Row = F64x8, Scalar = f64>>(&mut self, time_step: f64, on: &mut OnGrains<'_>) {
        let constants = self.grip.tangential.constants::<W>();
        let mut shares_from = 0;
        for eight in self.pending.chunks_mut(WIDE) {
            let forces = forces::<W>(&self.grip.material, &constants, time_step, eight);
            for (pending, force) in eight.iter().zip(forces) {
                let grain = pending.held.grain as usize;
                on.add(grain, force, plain::cross(pending.lever, force));
                let onto = self.membrane.forces_mut();
                for share in &self.shares[shares_from..pending.shares_end] {
                    let vertex = share.vertex as usize;
                    onto[vertex] = plain::sub(onto[vertex], plain::scale(force, share.weight));
                }
                shares_from = pending.shares_end;
            }
        }
        self.held.clear();
        self.held.extend(self.pending.iter().map(|p| p.held));
    }
}

/// Whether two triangles are one or share a corner.
fn is_neighbor(membrane: &Membrane, a: u32, b: u32) -> bool {
    a == b || membrane.mesh().around(a).binary_search(&b).is_ok()
}

/// The spring of the old contact that became contact `k`: one at its triangle, or else at a neighbor of it.
fn carried_over(
    membrane: &Membrane,
    held: &[Held],
    finder: &Finder,
    k: usize,
    taken: &mut u64,
) -> [f64; 3] {
    let triangle = finder.touches[k].triangle;
    let free = |n: &usize| *taken >> (n % 64) & 1 == 0;
    let exact = (0..held.len()).find(|n| free(n) && held[*n].triangle == triangle);
    let belongs_elsewhere = |n: &usize| {
        let mut others = finder.touches.iter().enumerate();
        others.any(|(other, touch)| other != k && touch.triangle == held[*n].triangle)
    };
    let beside = || {
        (0..held.len()).find(|n| {
            free(n) && !belongs_elsewhere(n) && is_neighbor(membrane, held[*n].triangle, triangle)
        })
    };
    match exact.or_else(beside) {
        Some(n) => {
            *taken |= 1 << (n % 64);
            held[n].spring
        }
        None => [0.0; 3],
    }
}

/// The forces on up to eight grains; notes them, and advances the springs.
#[inline(always)]
fn forces<W: Lane<Row = F64x8, Scalar = f64>>(
    material: &Material,
    constants: &<Mindlin as TangentialLaw>::Constants<W>,
    time_step: f64,
    eight: &mut [Pending],
) -> [[f64; 3]; WIDE] {
    let last = eight.len() - 1;
    let number = |of: &dyn Fn(&Pending) -> f64| -> W {
        W::load(&F64x8(std::array::from_fn(|e| of(&eight[e.min(last)]))))
    };
    let vector = |of: fn(&Pending) -> [f64; 3]| -> Vec3<W> {
        Vec3 {
            x: number(&|p| of(p)[0]),
            y: number(&|p| of(p)[1]),
            z: number(&|p| of(p)[2]),
        }
    };
    let (normal, relative) = (vector(|p| p.normal), vector(|p| p.relative));
    let overlap = number(&|p| p.held.overlap);
    let root_overlap = (number(&|p| p.radius) * overlap).sqrt();
    let overlap_rate = -relative.dot(normal);
    let normal_force = hertz::normal_force(
        W::constant(material.normal_stiffness),
        W::constant(material.normal_damping),
        overlap,
        root_overlap,
        overlap_rate,
    );
    let contact = Contact {
        normal,
        sliding_velocity: normal.scale_add(overlap_rate, relative),
        root_overlap,
        reduced_mass: W::constant(1.0) / number(&|p| p.inverse_mass),
        normal_force,
        time_step: W::constant(time_step),
    };
    let spring = vector(|p| p.held.spring);
    let mut history = [spring.x, spring.y, spring.z];
    let tangential = Mindlin::force(constants, &contact, &mut history);
    let force = normal.scale_add(normal_force, tangential);
    let size = tangential.dot(tangential).sqrt();
    let [x, y, z] = history;
    let lanes = |v: Vec3<W>| [v.x, v.y, v.z].map(row);
    let (springs, pushes) = (lanes(Vec3 { x, y, z }), lanes(force));
    let (normal_forces, sizes) = (row(normal_force), row(size));
    let mut found = [[0.0; 3]; WIDE];
    for (e, pending) in eight.iter_mut().enumerate() {
        pending.held.spring = [0, 1, 2].map(|axis: usize| springs[axis].0[e]);
        pending.held.normal_force = normal_forces.0[e];
        pending.held.tangential_force = sizes.0[e];
        found[e] = [0, 1, 2].map(|axis: usize| pushes[axis].0[e]);
    }
    found
}

#[inline(always)]
fn row<W: Lane<Row = F64x8>>(lanes: W) -> F64x8 {
    let mut row = F64x8::default();
    lanes.store(&mut row);
    row
}

impl Surroundings for Casing {
    const SPINS: bool = true;

    fn renew<R: Row>(&mut self, grains: &Grains<R>, skin: f64) {
        self.near.search(grains, self.membrane.mesh(), skin);
        self.built.clear();
        self.built
            .extend_from_slice(self.membrane.mesh().positions());
    }

    fn moved(&self) -> f64 {
        let moved = |(now, then): (&[f64; 3], &[f64; 3])| plain::norm(plain::sub(*now, *then));
        let vertices = self.membrane.mesh().positions().iter().zip(&self.built);
        vertices.map(moved).fold(0.0, f64::max)
    }

    #[inline(always)]
    fn act<W: Lane<Row = F64x8, Scalar = f64>>(
        &mut self,
        grains: &Grains<F64x1>,
        time_step: f64,
        on: &mut OnGrains<'_>,
    ) {
        self.membrane.clear_forces();
        self.membrane.add_internal_forces();
        self.membrane.add_pressure(self.press.pressure);
        let (state, forces) = self.membrane.acting();
        let Press {
            planes, rods, ball, ..
        } = &mut self.press;
        for plane in planes {
            plane.press(ball, state, forces);
        }
        for rod in rods {
            rod.press(ball, state, forces);
        }
        self.find(grains);
        self.push::<W>(time_step, on);
    }

    fn advance(&mut self, time_step: f64) -> f64 {
        for plane in &mut self.press.planes {
            plane.position += plane.velocity * time_step;
        }
        for rod in &mut self.press.rods {
            rod.position[1] += rod.velocity * time_step;
        }
        self.membrane.advance(time_step) * time_step
    }
}

#[cfg(test)]
mod tests;
