//! A mold that keeps its proportions: its walls hold the membrane's faces and move inward by one strain rate.
//!
//! They carry loose grains to where these bear a part of the pressure, so that compaction is isotropic.
//! The membrane shrinks with the mold and is let go there, gently: its springs take their lengths back as the pressure rises.
//! Let go strained, or under the full pressure, it would snap into folds.

use crate::beam::spec::{GrowSpec, JamSpec};
use crate::membrane::{Membrane, Mesh};

/// A vertex this near to a wall, over the side of the mold, is on it.
const ON_WALL: f64 = 1e-9;

/// Frictionless grains of one size bear a load from this volume fraction on, others from a lower one: the walls go no farther.
const RANDOM_CLOSE_PACKING: f64 = 0.64;

/// Nor do they come nearer than by this factor, however few the grains.
const SMALLEST: f64 = 0.8;

/// The pressure under which walls move, over Δp: the more, the more even is the beam, and the harder the membrane is let go.
pub(super) const PRESSURE: f64 = 0.3;

/// How long the rate takes to follow the load \[s\], a few times the time of a sound wave across the beam.
const FOLLOWING: f64 = 1e-3;

/// The rate over the largest one at which the grains bear enough.
const BORNE: f64 = 0.5;

/// The six faces of a membrane in its mold.
pub(super) struct Faces {
    /// The vertices at both ends of each axis, low and high.
    ends: [[Vec<u32>; 2]; 3],
    /// The strain rate of walls that nothing stops \[1/s\].
    pub(super) fastest: f64,
    /// The pressure under which they move \[Pa\].
    pub(super) pressure: f64,
    /// Their least extent, over the first.
    least: f64,
    /// The first extent along x \[m\].
    length: f64,
    /// The springs' lengths as built \[m\].
    lengths: Vec<f64>,
}

impl Faces {
    /// The faces of a membrane as built, which fills the mold of `grow` about the origin.
    pub(super) fn of(built: &Mesh, spec: &JamSpec, grow: &GrowSpec) -> Self {
        let sides = [grow.length, grow.depth, grow.height];
        let face = |axis: usize, sign: f64| {
            let on = |place: &[f64; 3]| sign * place[axis] > (0.5 - ON_WALL) * sides[axis];
            let vertices = (0u32..).zip(built.positions());
            let face = vertices.filter_map(|(v, place)| on(place).then_some(v));
            face.collect()
        };
        let longest = sides.into_iter().fold(0.0, f64::max);
        let filled = libm::cbrt(grow.initial_volume_fraction / RANDOM_CLOSE_PACKING);
        Self {
            ends: [0, 1, 2].map(|axis| [face(axis, -1.0), face(axis, 1.0)]),
            fastest: 2.0 * spec.mold_speed / longest,
            pressure: PRESSURE * spec.confining_pressure,
            least: filled.max(SMALLEST),
            length: sides[0],
            lengths: built.edge_lengths().collect(),
        }
    }

    /// Whether walls have anything to do: loose grains, and a pressure on them.
    pub(super) fn are_loose(&self) -> bool {
        self.pressure > 0.0 && self.least < 1.0
    }

    /// The strain rate of the next step \[1/s\], after one at `rate`; `None` once the grains bear enough.
    ///
    /// It follows the share of the pressure that they do not bear.
    pub(super) fn next(&self, rate: f64, membrane: &Membrane, time_step: f64) -> Option<f64> {
        let open = (self.net_pressure(membrane) / self.pressure).clamp(0.0, 1.0);
        let rate = rate + (open * self.fastest - rate) * (time_step / FOLLOWING).min(1.0);
        let goes_on = rate > BORNE * self.fastest && self.scale(membrane.mesh()) > self.least;
        goes_on.then_some(rate)
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

    /// The present extent over the first.
    pub(super) fn scale(&self, mesh: &Mesh) -> f64 {
        self.side(0, mesh) / self.length
    }

    /// Makes the springs `scale` times as long at rest as they were built.
    pub(super) fn relax(&self, membrane: &mut Membrane, scale: f64) {
        membrane.set_rest_lengths(self.lengths.iter().map(|length| scale * length));
    }

    /// Moves all faces inward by one strain `rate` \[1/s\], and lets the springs shrink with them.
    pub(super) fn drive(&self, membrane: &mut Membrane, rate: f64) {
        self.relax(membrane, self.scale(membrane.mesh()));
        for (axis, face) in self.each() {
            for &vertex in face {
                let place = membrane.mesh().positions()[vertex as usize][axis];
                membrane.velocities_mut()[vertex as usize][axis] = -rate * place;
            }
        }
    }

    /// What pressed the walls inward in the last step \[Pa\]: Δp less what is inside, the mean of the three axes.
    fn net_pressure(&self, membrane: &Membrane) -> f64 {
        let sides = [0, 1, 2].map(|axis| self.side(axis, membrane.mesh()));
        let pressure = |axis: usize| {
            let [low, high] = self.ends[axis]
                .each_ref()
                .map(|face| membrane.reaction(face)[axis]);
            let area = sides[(axis + 1) % 3] * sides[(axis + 2) % 3];
            0.5 * (high - low) / area
        };
        (pressure(0) + pressure(1) + pressure(2)) / 3.0
    }

    /// From one wall to the other along an axis.
    fn side(&self, axis: usize, mesh: &Mesh) -> f64 {
        let [low, high] = self.ends[axis]
            .each_ref()
            .map(|face| mesh.positions()[face[0] as usize][axis]);
        high - low
    }

    fn each(&self) -> impl Iterator<Item = (usize, &Vec<u32>)> {
        let axes = self.ends.iter().enumerate();
        axes.flat_map(|(axis, faces)| faces.iter().map(move |face| (axis, face)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::beam::point::BeamPoint;
    use crate::identity::StageId;
    use crate::lanes::F64x8;
    use crate::membrane::{Cuboid, Sheet};

    fn specs() -> (GrowSpec, JamSpec) {
        let map = BeamPoint::defaults("smoke").expect("a preset");
        let point = BeamPoint::from_parameters(map).expect("a point");
        (point.grow(), point.jam(StageId::of_bytes(b"grown")))
    }

    fn membrane(grow: &GrowSpec) -> Membrane {
        let mesh = Cuboid {
            length: grow.length,
            height: grow.height,
            depth: grow.depth,
            edge_length: 4e-3,
        };
        let sheet = Sheet {
            youngs_modulus: 1e7,
            thickness: 3e-4,
            density: 2000.0,
            damping_ratio: 0.15,
            bending: None,
        };
        Membrane::new(mesh.mesh().expect("a cuboid"), &sheet).expect("a sheet")
    }

    /// Δp A on every wall: what a face's triangles give to the vertices at its edges, it gets back from its neighbors' there
    /// along their normals, not its own.
    #[test]
    fn walls_carry_the_pressure_and_shrink_the_mold_evenly() {
        let (grow, jam) = specs();
        let mut membrane = membrane(&grow);
        let faces = Faces::of(membrane.mesh(), &jam, &grow);
        faces.hold(&mut membrane);
        membrane.begin_step();
        membrane.add_internal_forces::<F64x8>();
        membrane.add_pressure::<F64x8>(faces.pressure);
        let net = faces.net_pressure(&membrane);
        assert!((net / faces.pressure - 1.0).abs() < 1e-9, "{net}");
        faces.drive(&mut membrane, 2.0);
        membrane.advance(0.01);
        let sides = [grow.length, grow.depth, grow.height];
        for (axis, side) in sides.iter().enumerate() {
            let shrunk = faces.side(axis, membrane.mesh()) / side;
            assert!((shrunk - 0.98).abs() < 1e-9, "{axis}: {shrunk}");
        }
        faces.release(&mut membrane);
        let everything: Vec<u32> = (0..membrane.masses().len() as u32).collect();
        let held = membrane.reaction(&everything);
        assert!(held.iter().all(|force| *force == 0.0), "{held:?}");
    }

    #[test]
    fn walls_stop_where_half_the_pressure_is_borne_or_the_grains_must_be_packed() {
        let (grow, jam) = specs();
        let mut membrane = membrane(&grow);
        let faces = Faces::of(membrane.mesh(), &jam, &grow);
        assert!(faces.are_loose());
        faces.hold(&mut membrane);
        // Much longer than walls take to follow.
        let long = 1.0;
        for (share, goes_on) in [
            (1.0, true),
            (0.6, true),
            (0.4, false),
            (0.0, false),
            (-1.0, false),
        ] {
            membrane.begin_step();
            membrane.add_pressure::<F64x8>(share * faces.pressure);
            let rate = faces.next(faces.fastest, &membrane, long);
            assert_eq!(rate.is_some(), goes_on, "{share}");
            let expected = share * faces.fastest;
            assert!(
                rate.is_none_or(|rate| (rate / expected - 1.0).abs() < 1e-9),
                "{rate:?}"
            );
        }
        membrane.begin_step();
        membrane.add_pressure::<F64x8>(faces.pressure);
        // 1 − (0.5/0.64)^(1/3) = 0.079.
        for (shrunk, goes_on) in [(0.078, true), (0.080, false)] {
            let strain = 1.0 - (1.0 - shrunk) / faces.scale(membrane.mesh());
            faces.drive(&mut membrane, strain);
            membrane.advance(1.0);
            membrane.begin_step();
            membrane.add_pressure::<F64x8>(faces.pressure);
            let rate = faces.next(faces.fastest, &membrane, 0.0);
            assert_eq!(rate.is_some(), goes_on, "{shrunk}");
        }
    }

    #[test]
    fn walls_stay_where_grains_are_packed_or_nothing_presses() {
        let (grow, jam) = specs();
        let mesh = membrane(&grow).mesh().clone();
        let packed = GrowSpec {
            initial_volume_fraction: 0.65,
            ..grow.clone()
        };
        assert!(!Faces::of(&mesh, &jam, &packed).are_loose());
        let loose = JamSpec {
            confining_pressure: 0.0,
            ..jam
        };
        assert!(!Faces::of(&mesh, &loose, &grow).are_loose());
    }
}
