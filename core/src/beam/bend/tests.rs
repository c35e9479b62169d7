//! B3 and B4 of the beam's checks: what nothing pushes stays as it is, and left is right.

#[cfg(feature = "validation")]
mod lattice;

use std::collections::BTreeMap;
use std::ops::ControlFlow;

use super::*;
use crate::beam::point::BeamPoint;
use crate::beam::spec::GrowSpec;
use crate::beam::{grow, jam};
use crate::identity::StageId;
use crate::lanes::VectorWidth;
use crate::outcome::{HISTORY, STATE};
use serde_json::json;

/// A small soft beam, made and bent in haste but for `changes`.
fn point(changes: serde_json::Value) -> BeamPoint {
    let mut map = BeamPoint::defaults("smoke").expect("a preset");
    let small = json!({
        "length": 0.06, "height": 0.012, "depth": 0.012, "membrane_edge": 3e-3,
        "radius_min": 1.6e-3, "radius_max": 1.8e-3, "youngs_modulus": 2e7, "vertex_radius": 4e-4,
        "growth_time": 0.01, "growth_rest": 0.005, "pressure_ramp": 0.04, "mold_speed": 0.1, "release_time": 0.01,
        "rest_window": 0.005, "rest_volume_rate": 0.1, "rest_force_ratio": 0.05, "rest_energy_ratio": 1e-2,
        "background_damping": 100.0, "rod_speed": 0.05, "strain_end": 0.0025,
    });
    for changes in [small, changes] {
        map.extend(changes.as_object().expect("parameters by name").clone());
    }
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

/// The state of the compacted beam of a point.
fn compacted(point: &BeamPoint) -> Vec<u8> {
    let (grow, jam) = (point.grow(), point.jam(StageId::of_bytes(b"grown")));
    let grown = finished(|width, progress| grow::run(&grow, "grow", None, width, progress));
    let input = grown.artifacts[STATE].as_slice();
    let jammed = finished(|width, progress| jam::run(&jam, "jam", (input, None), width, progress));
    jammed.artifacts[STATE].clone()
}

/// How the beams of `point` are made again from their states.
fn rig<'a>(grow: &'a GrowSpec, jam: &'a JamSpec) -> Rig<'a> {
    Rig {
        grow,
        jam: Some(jam),
        friction_coefficient: 0.3,
        damping: 100.0,
        width: VectorWidth::widest(),
    }
}

/// The beam of `state` at rest between supports and rods that just touch it.
fn mounted(
    bench: &mut Bench<'_>,
    (rig, state): (&Rig<'_>, &Snapshot<Past>),
    progress: &mut Progress<'_>,
) -> Run<Mindlin> {
    let (mut run, _) = bench.begun::<Mindlin>(rig, state).expect("begun");
    let Ok(Phase::Relax(rest)) = bench.release(&mut run, progress) else {
        panic!("released");
    };
    let Ok(Phase::Bend(bending)) = bench.relax(&mut run, rest, progress) else {
        panic!("at rest");
    };
    for rod in &mut run.beam.surroundings.press.rods {
        rod.position[1] -= bending.drive.gap();
    }
    run
}

/// The rods touch the beam from the start, so they would feel it rise by a hair.
#[test]
fn beam_between_rods_at_rest_is_not_pushed_and_does_not_drift() {
    let point = point(json!({
        "rest_window": 0.05, "rest_volume_rate": 1e-3, "rest_force_ratio": 1e-3, "rest_energy_ratio": 1e-6,
    }));
    let bytes = compacted(&point);
    let (grow, jam) = (point.grow(), point.jam(StageId::of_bytes(b"grown")));
    let spec = point.bend(StageId::of_bytes(b"jammed"));
    let bent = finished(|width, progress| run(&spec, "bend", (&bytes, None), width, progress));
    let record: serde_json::Value =
        serde_json::from_slice(&bent.artifacts[HISTORY]).expect("a record");
    let column = |name: &str| {
        let values = record[name].as_array().expect("a column").iter();
        values
            .map(|value| value.as_f64().expect("a number"))
            .collect::<Vec<f64>>()
    };
    let at = column("strain").iter().position(|strain| *strain >= 0.002);
    let pushed = column("force")[at.expect("bent so far")].abs();
    let rig = rig(&grow, &jam);
    let state = Snapshot::<Past>::from_bytes(&bytes).expect("a beam");
    let places = places(
        rig.membrane().expect("a membrane").mesh(),
        grow.membrane_edge,
    );
    let mut bench = Bench {
        spec: &spec,
        past: &state.header,
        jam: &jam,
        stage: "bend",
        places,
    };
    let mut go_on = |_: &crate::outcome::Report<'_>| ControlFlow::Continue(());
    let mut progress = Progress {
        watch: &mut go_on,
        steps: 0,
    };
    let mut run = mounted(&mut bench, (&rig, &state), &mut progress);
    let supports = bench.places.supports.concat();
    let volume = |run: &Run<Mindlin>| run.beam.surroundings.membrane.mesh().volume();
    let before = volume(&run);
    let (mut felt, mut held, mut steps) = (0.0f64, 0.0, 0.0);
    while run.time < 1.0 {
        run.advance(&mut progress, &|_| vec![])
            .expect("a stable step");
        let casing = &run.beam.surroundings;
        felt = felt.max(casing.press.rods.iter().map(|rod| rod.force.abs()).sum());
        held += casing.membrane.reaction(&supports)[2];
        steps += 1.0;
    }
    let held = (held / steps).abs();
    let drift = volume(&run) / before - 1.0;
    println!(
        "B3: {felt:.2e} N on rods, {held:.2e} N on supports, {pushed:.2e} N at 0.002; volume {drift:.2e}"
    );
    assert!(felt <= 1e-3 * pushed, "{felt} {pushed}");
    assert!(held <= 1e-3 * pushed, "{held} {pushed}");
    assert!(drift.abs() < 1e-5, "{drift}");
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
    let point = point(json!({}));
    let (grow, jam) = (point.grow(), point.jam(StageId::of_bytes(b"grown")));
    let bend = point.bend(StageId::of_bytes(b"jammed"));
    let bytes = compacted(&point);
    let state = Snapshot::<Past>::from_bytes(&bytes).expect("a beam");
    let rig = rig(&grow, &jam);
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
