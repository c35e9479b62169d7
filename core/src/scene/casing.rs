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
mod part;
mod patch;
mod push;
mod reach;
mod sheet;
mod touch;

use super::surroundings::{OnGrains, Surroundings};
use crate::contact::mindlin::Mindlin;
use crate::crew;
use crate::grains::Grains;
use crate::lanes::{F64x1, F64x8, Kernel, Lane, Row, VectorWidth, dispatch};
use crate::material::Material;
use crate::math::plain;
use crate::membrane::Membrane;
use crate::wall::press::{Plane, Rod, VertexBall};
use near::Near;
use part::{Around, Part};
use sheet::Sheet;

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
    near: Near,
    /// Where the vertices were at the last renewal.
    built: Vec<[f64; 3]>,
    balls: Vec<sheet::Ball>,
    /// The contacts, some neighboring grains to a part.
    parts: Vec<Part>,
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
    pub fn held(&self) -> impl Iterator<Item = &Held> {
        self.parts.iter().flat_map(|part| &part.held)
    }

    /// Gives back the contacts of a step before.
    pub fn hold(&mut self, held: &[Held]) {
        part::share_out(self.near.pairs(), held, &mut self.parts);
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

    /// Finds the forces of grains and membrane on each other, and adds those on the vertices in order.
    fn grip(&mut self, grains: &Grains<F64x1>, time_step: f64, width: VectorWidth) {
        sheet::note(grains, &mut self.balls);
        let around = Around {
            grip: &self.grip,
            membrane: &self.membrane,
            balls: &self.balls,
            pairs: self.near.pairs(),
        };
        crew::each(&mut self.parts, &|part| {
            let acting = Acting {
                part,
                around,
                grains,
                time_step,
            };
            dispatch::<F64x8, _>(width, acting);
        });
        let forces = self.membrane.forces_mut();
        for part in &self.parts {
            part.share(forces);
        }
        let stiffness = self.grip.material.normal_stiffness;
        for part in &mut self.parts {
            part.add_surpluses(stiffness, forces);
        }
    }
}

/// A step of a membrane up to what grains do to it.
struct Pressing<'a> {
    casing: &'a mut Casing,
}

impl Kernel<F64x8> for Pressing<'_> {
    type Output = ();

    #[inline(always)]
    fn run<W: Lane<Row = F64x8, Scalar = f64>>(self) {
        self.casing.press_membrane::<W>();
    }
}

/// A step of a part, up to what it does to vertices and grains.
struct Acting<'a> {
    part: &'a mut Part,
    around: Around<'a>,
    grains: &'a Grains<F64x1>,
    time_step: f64,
}

impl Kernel<F64x8> for Acting<'_> {
    type Output = ();

    #[inline(always)]
    fn run<W: Lane<Row = F64x8, Scalar = f64>>(self) {
        self.part
            .act::<W>(&self.around, self.grains, self.time_step);
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
        sheet::note(self.grains, &mut casing.balls);
        let around = Around {
            grip: &casing.grip,
            membrane: &casing.membrane,
            balls: &casing.balls,
            pairs: casing.near.pairs(),
        };
        let mut found = vec![];
        for part in &mut casing.parts {
            part.look::<W>(&around, &mut found);
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
        part::renew(self.near.pairs(), &mut self.parts);
        self.built.clear();
        self.built.extend_from_slice(mesh.positions());
    }

    fn moved(&self) -> f64 {
        let moved = |(now, then): (&[f64; 3], &[f64; 3])| plain::norm(plain::sub(*now, *then));
        let vertices = self.membrane.mesh().positions().iter().zip(&self.built);
        vertices.map(moved).fold(0.0, f64::max)
    }

    fn act(&mut self, grains: &Grains<F64x1>, time_step: f64, width: VectorWidth) {
        dispatch::<F64x8, _>(width, Pressing { casing: self });
        self.grip(grains, time_step, width);
    }

    #[inline(always)]
    fn push_grains(&self, on: &mut OnGrains<'_>) {
        for (grain, push) in self.parts.iter().flat_map(Part::pushes) {
            on.add(grain as usize, push);
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
