//! A mold that keeps its proportions: its walls hold the membrane's faces and move inward by one strain rate.
//!
//! They move as long as Δp on them is not balanced by what is inside, so that compaction is isotropic.

use crate::beam::spec::JamSpec;
use crate::membrane::{Membrane, Mesh};

/// A vertex this near to a wall, over the side of the mold, is on it.
const ON_WALL: f64 = 1e-9;

/// The six faces of a membrane in its mold.
pub(super) struct Faces {
    /// The vertices at both ends of each axis, low and high.
    faces: [[Vec<u32>; 2]; 3],
    /// The strain rate at which the fastest wall moves at 1 m/s \[1/m\].
    per_speed: f64,
}

impl Faces {
    /// The faces of a membrane as built, which fills a mold of these sides about the origin.
    pub(super) fn of(built: &Mesh, sides: [f64; 3]) -> Self {
        let face = |axis: usize, sign: f64| {
            let on = |place: &[f64; 3]| sign * place[axis] > (0.5 - ON_WALL) * sides[axis];
            let vertices = (0u32..).zip(built.positions());
            let face = vertices.filter_map(|(v, place)| on(place).then_some(v));
            face.collect()
        };
        Self {
            faces: [0, 1, 2].map(|axis| [face(axis, -1.0), face(axis, 1.0)]),
            per_speed: 2.0 / sides.into_iter().fold(0.0, f64::max),
        }
    }

    /// The strain rate of the next step \[1/s\]: `mold_speed`'s, less and less below `mold_load` Δp that is not balanced.
    ///
    /// `None` once Δp has its full value and all but that much is.
    pub(super) fn rate(&self, spec: &JamSpec, membrane: &Membrane, time: f64) -> Option<f64> {
        let most = spec.mold_load * spec.confining_pressure;
        let open = self.net_pressure(membrane);
        if time >= spec.pressure_ramp && open <= most.max(0.0) {
            return None;
        }
        let share = if most > 0.0 { open / most } else { 0.0 };
        Some(self.per_speed * spec.mold_speed * share.clamp(0.0, 1.0))
    }

    /// Holds every face along its normal.
    pub(super) fn hold(&self, membrane: &mut Membrane) {
        for (axis, face) in self.each() {
            let mut axes = [false; 3];
            axes[axis] = true;
            membrane.hold(face, axes);
        }
    }

    /// Lets go of all faces.
    pub(super) fn release(&self, membrane: &mut Membrane) {
        for (_, face) in self.each() {
            membrane.release(face);
        }
    }

    /// Moves all faces inward by one strain `rate` \[1/s\].
    pub(super) fn drive(&self, membrane: &mut Membrane, rate: f64) {
        for (axis, face) in self.each() {
            for &vertex in face {
                let place = membrane.mesh().positions()[vertex as usize][axis];
                membrane.velocities_mut()[vertex as usize][axis] = -rate * place;
            }
        }
    }

    /// What pressed the walls inward in the last step \[Pa\]: Δp less what is inside, the mean of the three axes.
    fn net_pressure(&self, membrane: &Membrane) -> f64 {
        let sides = membrane.mesh().extent();
        let pressure = |axis: usize| {
            let [low, high] = self.faces[axis]
                .each_ref()
                .map(|face| membrane.reaction(face)[axis]);
            let area = sides[(axis + 1) % 3] * sides[(axis + 2) % 3];
            0.5 * (high - low) / area
        };
        (pressure(0) + pressure(1) + pressure(2)) / 3.0
    }

    fn each(&self) -> impl Iterator<Item = (usize, &Vec<u32>)> {
        let axes = self.faces.iter().enumerate();
        axes.flat_map(|(axis, faces)| faces.iter().map(move |face| (axis, face)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lanes::F64x8;
    use crate::membrane::{Cuboid, Sheet};

    const SIDES: [f64; 3] = [0.06, 0.03, 0.02];

    fn membrane() -> Membrane {
        let [length, depth, height] = SIDES;
        let mesh = Cuboid {
            length,
            height,
            depth,
            edge_length: 4e-3,
        }
        .mesh()
        .expect("a cuboid");
        let sheet = Sheet {
            youngs_modulus: 1e7,
            thickness: 3e-4,
            density: 2000.0,
            damping_ratio: 0.15,
            bending: None,
        };
        Membrane::new(mesh, &sheet).expect("a sheet")
    }

    /// Δp A on every wall: Σ p A n̂/3 over the corners of a face's triangles is all of it but what the sides take at the edges,
    /// and these lose to the face what they take from the others.
    #[test]
    fn walls_carry_the_pressure_and_shrink_the_mold_evenly() {
        let mut membrane = membrane();
        let walls = Faces::of(membrane.mesh(), SIDES);
        walls.hold(&mut membrane);
        membrane.begin_step();
        membrane.add_internal_forces::<F64x8>();
        membrane.add_pressure::<F64x8>(9e4);
        let net = walls.net_pressure(&membrane);
        assert!((net / 9e4 - 1.0).abs() < 1e-9, "{net}");
        walls.drive(&mut membrane, 2.0);
        membrane.advance(0.01);
        for (axis, side) in SIDES.iter().enumerate() {
            let shrunk = membrane.mesh().extent()[axis] / side;
            assert!((shrunk - 0.98).abs() < 1e-9, "{axis}: {shrunk}");
        }
        walls.release(&mut membrane);
        let everything: Vec<u32> = (0..membrane.masses().len() as u32).collect();
        let held = membrane.reaction(&everything);
        assert!(held.iter().all(|force| *force == 0.0), "{held:?}");
    }
}
