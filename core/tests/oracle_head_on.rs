//! Two spheres meet head-on as in another code: restitution, largest overlap, positions and velocities.
//!
//! Source: `data/oracle_head_on.json`, made with LAMMPS 22 Jul 2025 (Update 4, double precision): `pair granular hertz`
//! with damping γ_n √p, `limit_damping`, `fix nve/sphere`, R = 0.5 mm, E = 10 MPa, ν = 0.49, ρ = 1200 kg/m³.
//!
//! Both codes kick, drift and evaluate damping with the velocities of the half step before, so at equal Δt they do the same
//! arithmetic up to rounding; against Δt/16 they may differ by the scheme's error, 4e-6 without and 3e-5 with damping.

use granary_core::contact::frictionless::Frictionless;
use granary_core::grains::{Motion, Pose, UPRIGHT};
use granary_core::lanes::F64x1;
use granary_core::material::{Material, Units};
use granary_core::scene::Scene;
use granary_core::shape::Sphere;
use serde::Deserialize;

#[path = "fixture/free_grains.rs"]
#[allow(dead_code, reason = "every proof takes what it needs")]
mod free_grains;

use free_grains::{Free, laws, scene};

/// What one column holds at Δt, Δt/4 and Δt/16.
#[derive(Deserialize)]
struct Refined {
    #[serde(rename = "dt/1")]
    coarse: f64,
    #[serde(rename = "dt/16")]
    fine: f64,
}

#[derive(Deserialize)]
struct Case {
    v_rel: f64,
    normal_damping: f64,
    x0: [[f64; 3]; 2],
    restitution: Refined,
    pmax_sampled: Refined,
    v1x_final: Refined,
    /// t, x1, v1, fx1.
    series_dt: Option<Vec<[f64; 4]>>,
}

#[derive(Deserialize)]
struct Parameters {
    dt: f64,
}

#[derive(Deserialize)]
struct Oracle {
    parameters: Parameters,
    cases: Vec<Case>,
}

fn oracle() -> Oracle {
    serde_json::from_str(include_str!("data/oracle_head_on.json")).expect("the oracle's file")
}

fn units() -> Units {
    Units::new(0.5e-3, 1200.0, 1e7)
}

/// The pair of a case before it meets, in the engine's units.
fn pair(case: &Case, time_step: f64) -> Scene<F64x1, Free<Sphere, Frictionless>> {
    let units = units();
    let mut laws = laws::<Sphere, Frictionless>(Frictionless, time_step);
    laws.material = Material::new(0.49, 0.23 * case.normal_damping, 2f64.powf(1.5));
    let poses = case.x0.map(|x| Pose {
        position: x.map(|x| x / units.length),
        orientation: UPRIGHT,
    });
    let mut scene = scene(laws, poses.to_vec());
    let speed = 0.5 * case.v_rel * units.time / units.length;
    for (i, speed) in [(0, speed), (1, -speed)] {
        let velocity = [speed, 0.0, 0.0];
        let spin = [0.0; 3];
        scene.grains.set_motion(i, 0, Motion { velocity, spin });
    }
    scene
}

fn overlap(scene: &Scene<F64x1, Free<Sphere, Frictionless>>) -> f64 {
    2.0 - (scene.grains.pose(1, 0).position[0] - scene.grains.pose(0, 0).position[0])
}

#[test]
fn restitution_and_overlap_are_the_oracles() {
    let oracle = oracle();
    let units = units();
    let time_step = oracle.parameters.dt / units.time;
    assert!((time_step - 0.1).abs() < 1e-12, "{time_step}");
    for case in &oracle.cases {
        let mut scene = pair(case, time_step);
        let start = scene.grains.motion(0, 0).velocity[0];
        let (mut deepest, mut touched) = (0.0f64, false);
        while !touched || overlap(&scene) > 0.0 {
            scene.step();
            deepest = deepest.max(overlap(&scene));
            touched |= deepest > 0.0;
        }
        // The first step apart still kicks with the last force felt.
        scene.step();
        let found = -scene.grains.motion(0, 0).velocity[0] / start;
        let name = format!("{} m/s, damping {}", case.v_rel, case.normal_damping);

        // k_n was typed in with 17 digits there and is computed here: 2e-16, and 1e3 steps of rounding.
        let same = (found - case.restitution.coarse).abs();
        assert!(same < 1e-10, "{name}: {same:e}");
        let speed = found * start * units.length / units.time;
        assert!((speed + case.v1x_final.coarse).abs() < 1e-10 * case.v_rel);

        // Stated with one digit, so up to 3.5 and 4.5; the file's own largest are 2.99e-5 and 4.003e-6.
        let sensitivity = if case.normal_damping > 0.0 {
            3.5e-5
        } else {
            4.5e-6
        };
        let converged = (found - case.restitution.fine).abs();
        assert!(converged < sensitivity, "{name}: {converged:e}");

        let expected = case.pmax_sampled.coarse / units.length;
        assert!((deepest - expected).abs() < 1e-10, "{name}: {deepest}");
    }
}

#[test]
fn trajectories_are_the_oracles_step_by_step() {
    let oracle = oracle();
    let units = units();
    let time_step = oracle.parameters.dt / units.time;
    let mut compared = 0;
    for case in &oracle.cases {
        let Some(series) = &case.series_dt else {
            continue;
        };
        let mut scene = pair(case, time_step);
        let speed = case.v_rel * units.time / units.length;
        let mut before = scene.grains.motion(0, 0).velocity[0];
        for row in series {
            let [_, x, v, force] = *row;
            let position = scene.grains.pose(0, 0).position[0];
            assert!((position - x / units.length).abs() < 1e-10, "{position}");
            scene.step();
            let after = scene.grains.motion(0, 0).velocity[0];
            // The oracle's velocity is that of the whole step: the mean of the half steps around it.
            let whole = 0.5 * (before + after);
            let expected = v * units.time / units.length;
            assert!(
                (whole - expected).abs() < 1e-10 * speed,
                "{whole} {expected}"
            );
            let kick = (after - before) * scene.laws.body.mass / time_step;
            let newton = force / (units.pressure * units.length * units.length);
            // Forces are second differences of positions near 1 R in both codes.
            assert!((kick - newton).abs() < 1e-10, "{kick} {newton}");
            before = after;
            compared += 1;
        }
    }
    assert!(compared > 700, "{compared} rows");
}
