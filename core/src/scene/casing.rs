//! A casing: a membrane around the grains, what presses on it from outside, and its contacts with the grains.
//!
//! A grain touches a triangle as it would a flat grain: R_eff is its radius, and the opposite force is shared out to the
//! triangle's corners by the barycentric coordinates of the contact point, where both velocities are taken too, so that
//! momentum and angular momentum are kept.
//!
//! A step works on eight things at a time: springs, triangles, grains before triangles, contacts.
//! What it adds to vertices and grains is added one by one, in order, so that sums do not depend on the vector width.

mod foot;
mod heirs;
mod near;
mod patch;
mod push;
mod reach;
mod sheet;
mod touch;

use super::surroundings::{OnGrains, Surroundings};
use crate::contact::TangentialLaw;
use crate::contact::mindlin::Mindlin;
use crate::grains::Grains;
use crate::lanes::{F64x1, F64x8, Kernel, Lane, Row, VectorWidth, dispatch};
use crate::material::Material;
use crate::math::plain;
use crate::membrane::Membrane;
use crate::wall::press::{Plane, Rod, VertexBall};
use heirs::Heirs;
use near::Near;
use patch::Sphere;
use push::Pending;
use reach::Reach;
use sheet::Sheet;
use touch::{Ball, Finder};

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

/// Where a grain touches the membrane.
#[derive(Clone, Debug, PartialEq)]
pub struct Contact {
    /// The grain.
    pub grain: u32,
    /// From the membrane into the grain.
    pub normal: [f64; 3],
    /// p \[m\].
    pub overlap: f64,
    /// The vertices that share the force, and their shares; they sum to one.
    pub shares: [(u32, f64); 3],
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
    /// α: drag over mass of every vertex \[1/s\].
    pub drag: f64,
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
    balls: Vec<sheet::Ball>,
    reaches: Vec<Reach>,
    finder: Finder,
    heirs: Heirs,
    pending: Vec<Pending>,
    /// Force and torque of every contact on its grain.
    pushes: Vec<F64x8>,
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

    /// Where `grains` and the membrane push each other as both are now: once for every foot.
    #[must_use]
    pub fn touches(&self, grains: &Grains<F64x1>, width: VectorWidth) -> Vec<Contact> {
        let mut casing = self.clone();
        let look = Look {
            casing: &mut casing,
            grains,
        };
        dispatch::<F64x8, _>(width, look)
    }

    /// Lets everything but grains act on the membrane.
    #[inline(always)]
    fn press_membrane<W: Lane<Row = F64x8, Scalar = f64>>(&mut self) {
        self.membrane.begin_step();
        self.membrane.add_internal_forces::<W>();
        self.membrane.add_pressure::<W>(self.press.pressure);
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
        if self.press.drag > 0.0 {
            self.membrane.add_drag(self.press.drag);
        }
    }

    /// Finds where every grain touches the membrane.
    #[inline(always)]
    fn find<W: Lane<Row = F64x8, Scalar = f64>>(&mut self, grains: &Grains<F64x1>) {
        self.reach::<W>(grains);
        self.finder.clear();
        for reaches in self.reaches.chunk_by(|a, b| a.pair[0] == b.pair[0]) {
            let ball = ball(&self.balls, &self.held, reaches[0].pair[0]);
            let sheet = Sheet {
                faces: self.membrane.faces(),
                balls: &self.balls,
            };
            self.finder.add(self.membrane.mesh(), sheet, &ball, reaches);
        }
    }

    /// Finds which triangles every grain reaches.
    #[inline(always)]
    fn reach<W: Lane<Row = F64x8, Scalar = f64>>(&mut self, grains: &Grains<F64x1>) {
        sheet::note(grains, &mut self.balls);
        let sheet = Sheet {
            faces: self.membrane.faces(),
            balls: &self.balls,
        };
        reach::find::<W>(sheet, self.near.pairs(), &mut self.reaches);
    }

    /// Takes the springs of the last step over to the contacts of this one, and notes how these move.
    #[inline(always)]
    fn carry_over(&mut self, grains: &Grains<F64x1>) {
        self.pending.clear();
        let mut held = self.held.as_slice();
        let mut shares = self.finder.shares.as_slice();
        let mut shares_from = 0;
        for touches in self.finder.touches.chunk_by(|a, b| a.grain == b.grain) {
            let of_grain = held_of(&mut held, touches[0].grain);
            self.heirs.find(self.membrane.mesh(), of_grain, touches);
            for (touch, &spring) in touches.iter().zip(&self.heirs.springs) {
                let own = shares
                    .split_off(..touch.shares_end - shares_from)
                    .unwrap_or_default();
                shares_from = touch.shares_end;
                let area = self.membrane.rest_areas()[touch.triangle as usize];
                let mass = self.grip.areal_density * area;
                let pending = Pending::new(touch, own, (grains, &self.membrane), spring, mass);
                self.pending.push(pending);
            }
        }
    }

    /// Finds the forces of all contacts, eight at a time, and adds them to the vertices in order.
    #[inline(always)]
    fn push<W: Lane<Row = F64x8, Scalar = f64>>(&mut self, time_step: f64) {
        let constants = self.grip.tangential.constants::<W>();
        self.held.clear();
        self.pushes.clear();
        let stiffness = self.grip.material.normal_stiffness;
        for eight in self.pending.chunks(W::K) {
            let acting = push::forces::<W>(&self.grip.material, &constants, time_step, eight);
            self.held.extend(acting.held(eight));
            self.pushes.extend(&acting.pushes[..eight.len()]);
        }
        let forces = self.membrane.forces_mut();
        let mut shares_from = 0;
        for (touch, push) in self.finder.touches.iter().zip(&self.pushes) {
            let [x, y, z, ..] = push.0;
            for share in &self.finder.shares[shares_from..touch.shares_end] {
                let force = &mut forces[share.vertex as usize];
                *force = plain::sub(*force, plain::scale([x, y, z], share.weight));
            }
            shares_from = touch.shares_end;
        }
        let mut pulls_from = 0;
        for surplus in &self.finder.surpluses {
            let [x, y, z] = plain::scale(surplus.force, stiffness);
            let [f_x, f_y, f_z, ..] = &mut self.pushes[surplus.touch].0;
            (*f_x, *f_y, *f_z) = (*f_x + x, *f_y + y, *f_z + z);
            for pull in &self.finder.pulls[pulls_from..surplus.pulls_end] {
                let force = &mut forces[pull.vertex as usize];
                *force = plain::sub(*force, plain::scale(pull.force, stiffness));
            }
            pulls_from = surplus.pulls_end;
        }
    }
}

/// A grain, and the contacts `held` from the last step.
#[inline(always)]
fn ball<'a>(balls: &[sheet::Ball], held: &'a [Held], grain: u32) -> Ball<'a> {
    let [x, y, z, radius] = balls[grain as usize];
    let sphere = Sphere {
        center: [x, y, z],
        radius,
    };
    Ball {
        grain,
        sphere,
        held,
    }
}

/// The contacts of `grain` in the last step; `held` goes on behind them.
#[inline(always)]
fn held_of<'a>(held: &mut &'a [Held], grain: u32) -> &'a [Held] {
    let before = held.iter().take_while(|h| h.grain < grain).count();
    let own = held[before..]
        .iter()
        .take_while(|h| h.grain == grain)
        .count();
    let (_, from) = held.split_at(before);
    let (own, after) = from.split_at(own);
    *held = after;
    own
}

/// A step of a casing up to what it does to grains.
struct Forces<'a> {
    casing: &'a mut Casing,
    grains: &'a Grains<F64x1>,
    time_step: f64,
}

impl Kernel<F64x8> for Forces<'_> {
    type Output = ();

    #[inline(always)]
    fn run<W: Lane<Row = F64x8, Scalar = f64>>(self) {
        self.casing.press_membrane::<W>();
        self.casing.find::<W>(self.grains);
        self.casing.carry_over(self.grains);
        self.casing.push::<W>(self.time_step);
    }
}

/// Finds contacts between two steps.
struct Look<'a> {
    casing: &'a mut Casing,
    grains: &'a Grains<F64x1>,
}

impl Kernel<F64x8> for Look<'_> {
    type Output = Vec<Contact>;

    #[inline(always)]
    fn run<W: Lane<Row = F64x8, Scalar = f64>>(self) -> Vec<Contact> {
        let casing = self.casing;
        casing.membrane.note::<W>();
        casing.reach::<W>(self.grains);
        let sheet = Sheet {
            faces: casing.membrane.faces(),
            balls: &casing.balls,
        };
        let mut found = vec![];
        for reaches in casing.reaches.chunk_by(|a, b| a.pair[0] == b.pair[0]) {
            let ball = ball(&casing.balls, &casing.held, reaches[0].pair[0]);
            casing.finder.clear();
            casing
                .finder
                .add(casing.membrane.mesh(), sheet, &ball, reaches);
            found.extend(casing.finder.pushes().map(|push| Contact {
                grain: ball.grain,
                normal: push.normal,
                overlap: push.overlap,
                shares: push.shares,
            }));
        }
        found
    }
}

/// Takes note of all faces between two steps.
struct Note<'a> {
    casing: &'a mut Casing,
}

impl Kernel<F64x8> for Note<'_> {
    type Output = ();

    #[inline(always)]
    fn run<W: Lane<Row = F64x8, Scalar = f64>>(self) {
        self.casing.membrane.note::<W>();
    }
}

impl Surroundings for Casing {
    const SPINS: bool = true;

    fn renew<R: Row>(&mut self, grains: &Grains<R>, skin: f64, width: VectorWidth) {
        dispatch::<F64x8, _>(width, Note { casing: self });
        sheet::note(grains, &mut self.balls);
        let mesh = self.membrane.mesh();
        let sheet = Sheet {
            faces: self.membrane.faces(),
            balls: &self.balls,
        };
        self.near.search(sheet, mesh, skin, width);
        self.built.clear();
        self.built.extend_from_slice(mesh.positions());
    }

    fn moved(&self) -> f64 {
        let moved = |(now, then): (&[f64; 3], &[f64; 3])| plain::norm(plain::sub(*now, *then));
        let vertices = self.membrane.mesh().positions().iter().zip(&self.built);
        vertices.map(moved).fold(0.0, f64::max)
    }

    fn act(&mut self, grains: &Grains<F64x1>, time_step: f64, width: VectorWidth) {
        let forces = Forces {
            casing: self,
            grains,
            time_step,
        };
        dispatch::<F64x8, _>(width, forces);
    }

    #[inline(always)]
    fn push_grains(&self, on: &mut OnGrains<'_>) {
        for (touch, push) in self.finder.touches.iter().zip(&self.pushes) {
            on.add(touch.grain as usize, push);
        }
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
