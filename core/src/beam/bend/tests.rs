//! B4 of the beam's checks: left is right.

use std::collections::BTreeMap;
use std::ops::ControlFlow;

use super::*;
use crate::beam::point::BeamPoint;
use crate::beam::{grow, jam};
use crate::identity::StageId;
use crate::lanes::VectorWidth;
use crate::outcome::STATE;
use serde_json::json;

/// A small soft beam, made and bent in haste.
fn point() -> BeamPoint {
    let mut map = BeamPoint::defaults("smoke").expect("a preset");
    let small = json!({
        "length": 0.06, "height": 0.012, "depth": 0.012, "membrane_edge": 3e-3,
        "radius_min": 1.6e-3, "radius_max": 1.8e-3, "youngs_modulus": 2e7, "vertex_radius": 4e-4,
        "growth_time": 0.01, "growth_rest": 0.005, "pressure_ramp": 0.04, "mold_speed": 0.1, "release_time": 0.01,
        "rest_window": 0.005, "rest_volume_rate": 0.1, "rest_force_ratio": 0.05, "rest_energy_ratio": 1e-2,
        "background_damping": 100.0, "rod_speed": 0.05, "strain_end": 0.0025,
    });
    map.extend(small.as_object().expect("parameters by name").clone());
    BeamPoint::from_parameters(map).expect("valid parameters")
}

/// The outcome of a stage that takes its spec, its name, its input and how it goes on.
fn finished(
    stage: impl FnOnce(VectorWidth, &mut Progress<'_>) -> Result<Outcome, StageFailure>,
) -> Outcome {
    let mut go_on = |_: &crate::outcome::Report<'_>| ControlFlow::Continue(());
    let mut progress = Progress {
        watch: &mut go_on,
        steps: 0,
    };
    stage(VectorWidth::widest(), &mut progress).unwrap_or_else(|failure| panic!("{failure}"))
}

fn flipped([x, y, z]: [f64; 3]) -> [f64; 3] {
    [-x, y, z]
}

/// The beam as a mirror at x = 0 shows it; `built` is the membrane as it was made, which is its own image.
fn mirrored(mut state: Snapshot<Past>, built: &Mesh) -> Snapshot<Past> {
    let bits = |place: [f64; 3]| place.map(|x| (x + 0.0).to_bits());
    let places = (0u32..).zip(built.positions());
    let by_place: BTreeMap<_, u32> = places.map(|(v, place)| (bits(*place), v)).collect();
    let image: Vec<u32> = built
        .positions()
        .iter()
        .map(|place| by_place[&bits(flipped(*place))])
        .collect();
    let sorted = |mut corners: [u32; 3]| {
        corners.sort_unstable();
        corners
    };
    let triangles = (0u32..).zip(built.triangles());
    let by_corners: BTreeMap<_, u32> = triangles.map(|(t, c)| (sorted(*c), t)).collect();
    let permuted = |values: &[[f64; 3]]| {
        let mut out = values.to_vec();
        for (v, value) in values.iter().enumerate() {
            out[image[v] as usize] = flipped(*value);
        }
        out
    };
    state.vertices = permuted(&state.vertices);
    state.velocities = permuted(&state.velocities);
    for place in state.reference.iter_mut().chain(&mut state.displacements) {
        *place = flipped(*place);
    }
    for motion in &mut state.motions {
        motion.velocity = flipped(motion.velocity);
        // A spin is an axial vector.
        motion.spin = flipped(motion.spin).map(|x| -x);
    }
    for contact in &mut state.contacts {
        if let Some(x) = contact.history.first_mut() {
            *x = -*x;
        }
    }
    for held in &mut state.held {
        let corners = built.triangles()[held.triangle as usize];
        held.triangle = by_corners[&sorted(corners.map(|v| image[v as usize]))];
        held.spring = flipped(held.spring);
    }
    state
}

/// What differs is the order of sums, whose rounding grows from contact to contact while the beam is bent.
#[test]
fn mirrored_beam_is_as_stiff() {
    let point = point();
    let (grow, jam) = (point.grow(), point.jam(StageId::of_bytes(b"grown")));
    let bend = point.bend(StageId::of_bytes(b"jammed"));
    let grown = finished(|width, progress| grow::run(&grow, "grow", None, width, progress));
    let input = grown.artifacts[STATE].as_slice();
    let jammed = finished(|width, progress| jam::run(&jam, "jam", (input, None), width, progress));
    let bytes = &jammed.artifacts[STATE];
    let state = Snapshot::<Past>::from_bytes(bytes).expect("a beam");
    let rig = Rig {
        grow: &grow,
        jam: state.header.jam.as_ref(),
        friction_coefficient: 0.0,
        damping: 0.0,
        width: VectorWidth::widest(),
    };
    let built = rig.membrane().expect("a membrane");
    let image = mirrored(state.clone(), built.mesh());
    assert_ne!(image, state);
    assert_eq!(mirrored(image.clone(), built.mesh()), state);
    let stiffness = [bytes.clone(), image.to_bytes()]
        .map(|bytes| {
            finished(|width, progress| run(&bend, "bend", (&bytes, None), width, progress))
        })
        .map(|bent| bent.results["beam_stiffness"].expect("stiff"));
    println!("B4: {stiffness:?}");
    assert!(
        (stiffness[0] / stiffness[1] - 1.0).abs() < 1e-6,
        "{stiffness:?}"
    );
}
