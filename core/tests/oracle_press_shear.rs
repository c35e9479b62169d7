//! The force law on prescribed paths: pressing, shearing, reversing, circling, as in another code; and turning, unlike it.
//!
//! Source: `data/oracle_press_shear.json`, made with LAMMPS 22 Jul 2025 (Update 4, double precision): `pair granular hertz`
//! with `tangential linear_history` (law H) or `mindlin_rescale/force` (law M1) and `limit_damping`; sphere A is held, B is
//! moved along the rows, spins are zero.
//! Both codes evaluate row k with the velocity (row k − row k−1)/Δt, so on these paths they do the same arithmetic.
//!
//! Comparable are the cases of law H without tangential damping (`xt` = 0), and `damped_shear`, whose damping γ √p is a
//! constant while it shears, since it shears at constant overlap; and all of law M1, whose damping grows with √p in both.
//! Spins are zero in all of them, so the arm in the sliding velocity (R there, R − p/2 here) does not show; the arm of the
//! torque is R − p/2 in both. Under a common rotation it would show: there the oracle is wrong and is not compared.

use granary_core::contact::TangentialLaw;
use granary_core::contact::hooke::Hooke;
use granary_core::contact::mindlin_rescale::MindlinRescale;
use granary_core::grains::{Motion, Pose, UPRIGHT};
use granary_core::lanes::F64x1;
use granary_core::material::{Material, Units};
use granary_core::math::plain::{add, cross, norm, scale, sub};
use granary_core::scene::Scene;
use granary_core::shape::Sphere;
use serde::Deserialize;

#[path = "fixture/free_grains.rs"]
#[allow(dead_code, reason = "every proof takes what it needs")]
mod free_grains;

use free_grains::{Free, laws, scene};

#[derive(Deserialize)]
struct Case {
    name: String,
    law: String,
    mu: f64,
    xt: f64,
    normal_damping: f64,
    /// B's place, force on A, torque on A, torque on B.
    rows: Vec<[f64; 12]>,
    max_abs_force_diff_dt4: f64,
}

#[derive(Deserialize)]
struct Parameters {
    dt: f64,
    gamma_n: f64,
    #[serde(rename = "k_M")]
    mindlin: f64,
}

#[derive(Deserialize)]
struct Oracle {
    parameters: Parameters,
    cases: Vec<Case>,
}

type Pair<T> = Scene<F64x1, Free<Sphere, T>>;

/// B's place in the scene's reference.
const REFERENCE: [f64; 3] = [2.0, 0.0, 0.0];

fn pair<T: TangentialLaw>(law: T, normal_damping: f64, time_step: f64) -> Pair<T> {
    let mut laws = laws::<Sphere, T>(law, time_step);
    laws.material = Material::new(0.49, 0.23 * normal_damping, 2f64.powf(1.5));
    let poses = [[0.0; 3], REFERENCE].map(|position| Pose {
        position,
        orientation: UPRIGHT,
    });
    scene(laws, poses.to_vec())
}

/// Moves B from one place to another within a step, both spheres spinning; returns force and torque on A there.
fn felt<T: TangentialLaw>(
    scene: &mut Pair<T>,
    from: [f64; 3],
    to: [f64; 3],
    spin: [f64; 3],
) -> ([f64; 3], [f64; 3]) {
    let time_step = scene.laws.time_step;
    let velocity = scale(sub(to, from), 1.0 / time_step);
    scene.grains.set_offset(0, 0, [0.0; 3], UPRIGHT);
    scene.grains.set_offset(1, 0, sub(to, REFERENCE), UPRIGHT);
    let held = Motion {
        velocity: [0.0; 3],
        spin,
    };
    scene.grains.set_motion(0, 0, held);
    scene.grains.set_motion(1, 0, Motion { velocity, spin });
    scene.step();
    let kicked = scene.grains.motion(0, 0);
    let body = &scene.laws.body;
    (
        scale(kicked.velocity, body.mass / time_step),
        scale(sub(kicked.spin, spin), body.inertia / time_step),
    )
}

/// How far forces, and torques over R, are from the oracle's at most \[N\].
fn off<T: TangentialLaw>(law: T, case: &Case, units: Units, time_step: f64) -> f64 {
    let force_unit = units.pressure * units.length * units.length;
    let mut scene = pair(law, case.normal_damping, time_step);
    let place = |row: &[f64; 12]| [0, 1, 2].map(|n| row[n] / units.length);
    let mut most = 0.0f64;
    for (from, to) in case.rows.iter().zip(&case.rows[1..]) {
        let (force, torque) = felt(&mut scene, place(from), place(to), [0.0; 3]);
        for n in 0..3 {
            most = most.max((force[n] * force_unit - to[3 + n]).abs());
            let arm = units.length;
            most = most.max((torque[n] * force_unit * arm - to[6 + n]).abs() / arm);
        }
    }
    most
}

#[test]
fn forces_and_torques_on_prescribed_paths_are_the_oracles() {
    let oracle: Oracle =
        serde_json::from_str(include_str!("data/oracle_press_shear.json")).expect("the file");
    let units = Units::new(0.5e-3, 1200.0, 1e7);
    let time_step = oracle.parameters.dt / units.time;
    let mut names = vec![];
    for case in &oracle.cases {
        let friction_coefficient = case.mu;
        // The stated sensitivities, of forces up to 0.015 N, are 7e-8 N and 1.1e-6 N; doing the same arithmetic, the codes
        // agree to the rounding of B's path: 1e-16 of R against overlaps of 0.045 R and velocities of its difference, 1e-11 of
        // the force.
        let (most, sensitivity) = if case.law == "H" {
            // `damped_shear` shears at p = 0.045 R: γ = xt γ_n √p \[N s/m\].
            let damping = case.xt * oracle.parameters.gamma_n * (0.045 * units.length).sqrt();
            let law = Hooke {
                stiffness: units.stiffness_from_si(670.0),
                damping: units.stiffness_from_si(damping) / units.time,
                friction_coefficient,
            };
            (off(law, case, units, time_step), 7e-8)
        } else {
            let damping = case.xt * oracle.parameters.gamma_n;
            let law = MindlinRescale {
                stiffness: units.stiffness_per_root_from_si(oracle.parameters.mindlin),
                damping: units.stiffness_per_root_from_si(damping) / units.time,
                friction_coefficient,
            };
            (off(law, case, units, time_step), 1.1e-6)
        };
        assert!(
            most < 1.5e-12,
            "{} {} μ {}: {most:e} N",
            case.law,
            case.name,
            case.mu
        );
        assert!(case.max_abs_force_diff_dt4 < sensitivity);
        names.push((case.law.as_str(), case.name.as_str()));
    }
    let paths = [
        "press_shear_below",
        "press_shear_above",
        "press_shear_below",
        "press_shear_above",
        "fig10",
        "circle_yz",
        "damped_shear",
    ];
    let expected = ["H", "M1"].map(|law| paths.map(|path| (law, path)));
    assert_eq!(names, expected.concat());
}

/// Presses, shears across and along the axis of the coming turn, then turns pair and spins by 90° in `steps` steps.
///
/// The axis stands across the branch vector; returns |ξ| before and after.
fn turned(steps: u32) -> (f64, f64) {
    let law = Hooke {
        stiffness: 0.134,
        damping: 0.0,
        friction_coefficient: 1.0,
    };
    let mut scene = pair(law, 0.0, 0.1);
    let (length, shear) = (1.955, 0.013);
    let elongation = |scene: &Pair<Hooke>| {
        let contact = scene.remembered(0).next().expect("a contact").2;
        norm([contact[0], contact[1], contact[2]])
    };
    let mut place = [length, 0.0, 0.0];
    for n in 1..=50 {
        let share = f64::from(n) / 50.0 * shear / length;
        let to = [
            length * (1.0 - 2.0 * share * share).sqrt(),
            length * share,
            length * share,
        ];
        felt(&mut scene, place, to, [0.0; 3]);
        place = to;
    }
    let before = elongation(&scene);
    let branch = scale(place, 1.0 / length);
    let axis = sub([0.0, 0.0, 1.0], scale(branch, branch[2]));
    let axis = scale(axis, 1.0 / norm(axis));
    let aside = cross(axis, branch);
    let turn = std::f64::consts::FRAC_PI_2 / f64::from(steps);
    let spin = scale(axis, turn / scene.laws.time_step);
    for n in 1..=steps {
        let (sin, cos) = (turn * f64::from(n)).sin_cos();
        let to = scale(add(scale(branch, cos), scale(aside, sin)), length);
        felt(&mut scene, place, to, spin);
        place = to;
    }
    (before, elongation(&scene))
}

#[test]
fn a_pair_that_turns_rigidly_keeps_its_tangential_force() {
    // A step moves B along the chord and the spins along the arc: a slip of L (θ − sin θ) ≈ L θ³/6, which in 90° adds up to
    // L (π/2)³/(6 N²) with L < 2 R: 1.3 R/N². |ξ| = 0.018 R changes by less than that: 4.5e-4 in 400 steps, as coarse as
    // the oracle's, whose own force grows 3.3 times, and 7.2e-11 in 10⁶; 10⁶ roundings of 1e-16 add up to 1e-10 at most.
    let (before, after) = turned(400);
    assert!((before - 0.018).abs() < 1e-3, "{before}");
    assert!((after / before - 1.0).abs() < 4.5e-4, "{before} {after}");
    let (before, after) = turned(1_000_000);
    assert!((after / before - 1.0).abs() < 1e-9, "{before} {after}");
}
