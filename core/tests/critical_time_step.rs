//! The critical time step: measured as its closed form says, true of the integrator, and guarded in every run.
//!
//! Leapfrog with damping by half-step velocities, v' = v − Δt (κ x + c v), x' = x + Δt v', is stable while
//! Δt² κ + 2 Δt c < 4 (Jury's criterion: the characteristic polynomial λ² − (2 − κΔt² − cΔt) λ + 1 − cΔt at λ = −1).

use std::f64::consts::SQRT_2;

use granary_core::contact::frictionless::Frictionless;
use granary_core::contact::hooke::Hooke;
use granary_core::grains::{Grains, Motion, Pose, UPRIGHT};
use granary_core::guard::{Guard, Stop};
use granary_core::lanes::{F64x1, VectorWidth};
use granary_core::memory::cycle::{Cycle, Drive, Program, Segment};
use granary_core::memory::spec::Precision;
use granary_core::memory::state::PackState;
use granary_core::memory::waveform::Waveform;
use granary_core::observable::critical_time_step::{Across, CriticalTimeStep, critical_time_step};
use granary_core::protocol::Box2;
use granary_core::scene::Scene;
use granary_core::shape::{Shape, Sphere, Tetrahedron};
use granary_core::stage::{STATE, StageFailure, StageSpec};
use granary_core::wall::Walls;
use serde_json::json;

#[path = "fixture/free_grains.rs"]
#[allow(dead_code, reason = "every proof takes what it needs")]
mod free_grains;
#[path = "fixture/stiffness_matrix.rs"]
mod stiffness_matrix;
#[path = "fixture/tiny_pack.rs"]
#[allow(dead_code, reason = "every proof takes what it needs")]
mod tiny_pack;

use free_grains::{Free, HOOKE, MINDLIN, laws, scene};
use stiffness_matrix::{largest_eigenvalue, weighted};
use tiny_pack::{Results, finish, outcome, tiny};

type Smooth = Free<Sphere, Frictionless>;

/// The overlap of the two spheres; the walls, 2√2 times stiffer, carry the same force at half of it.
const OVERLAP: f64 = 0.05;

/// Half the extent of the box in y and z, which no sphere reaches.
const FAR: f64 = 50.0;

/// Where the walls that squeeze the pair are.
fn wall() -> f64 {
    2.0 - 0.5 * OVERLAP - 0.5 * OVERLAP
}

/// Two spheres squeezed between two walls, at rest in balance.
fn squeezed(time_step: f64) -> Scene<F64x1, Smooth> {
    let laws = laws::<Sphere, Frictionless>(Frictionless, time_step);
    let poses = [-1.0, 1.0].map(|side| Pose {
        position: [side * (1.0 - 0.5 * OVERLAP), 0.0, 0.0],
        orientation: UPRIGHT,
    });
    let grains = Grains::at_rest(poses.to_vec(), &laws.body, false);
    let x = wall();
    let walls = Walls::at_rest([-x, x, -FAR, FAR, -FAR, FAR]);
    Scene::new(laws, grains, walls)
}

/// Δt_c of stiffness κ and damping c per mass.
fn closed_form(stiffness: f64, damping: f64) -> f64 {
    (-damping + (damping * damping + 4.0 * stiffness).sqrt()) / stiffness
}

/// Δt_c of the squeezed pair: its stiffest mode is the two spheres against each other.
fn closed_form_of_the_pair() -> f64 {
    let scene = squeezed(1.0);
    let (material, mass) = (&scene.laws.material, scene.laws.body.mass);
    let (root, root_at_wall) = (OVERLAP.sqrt(), (0.5 * OVERLAP).sqrt());
    let sum = |pair: f64, wall: f64| (2.0 * pair * root + wall * root_at_wall) / mass;
    closed_form(
        1.5 * sum(material.normal_stiffness, material.wall_stiffness),
        sum(material.normal_damping, material.wall_damping),
    )
}

/// Asserts that both bounds are `expected`: so few modes are all found, up to rounding.
fn assert_exact(measured: CriticalTimeStep, expected: f64) {
    for bound in [measured.at_least, measured.at_most] {
        assert!(
            (bound / expected - 1.0).abs() < 1e-12,
            "{measured:?} {expected}"
        );
    }
}

#[test]
fn a_squeezed_pair_has_the_closed_form() {
    let measured = critical_time_step(&squeezed(1.0), 0, Across::default());
    assert_exact(measured, closed_form_of_the_pair());
}

#[test]
fn a_sheared_pair_has_the_closed_form() {
    // Two free spheres stuck across the contact: sliding moves each by 1/m and turns it by (1 − p/2)²/I with I = 2m/5.
    let mut laws = laws::<Sphere, Frictionless>(Frictionless, 1.0);
    laws.material.wall_stiffness = 0.0;
    let mass = laws.body.mass;
    let poses = [0.0, 2.0 - OVERLAP].map(|x| Pose {
        position: [x, 0.0, 0.0],
        orientation: UPRIGHT,
    });
    let scene: Scene<F64x1, Smooth> = scene(laws, poses.to_vec());
    let across = Across {
        stiffness: 0.6,
        damping: 0.04,
        ..Across::default()
    };
    // Mindlin's stiffness goes with the root of the overlap.
    let root = OVERLAP.sqrt();
    let growing = Across {
        stiffness_per_root: across.stiffness / root,
        damping_per_root: across.damping / root,
        ..Across::default()
    };
    let arm = 1.0 - 0.5 * OVERLAP;
    let share = 2.0 / mass * (1.0 + 2.5 * arm * arm);
    let expected = closed_form(across.stiffness * share, across.damping * share);
    for across in [across, growing] {
        assert_exact(critical_time_step(&scene, 0, across), expected);
    }
}

/// Asserts that the bounds of a prepared pack's critical time step enclose the one of its stiffness matrix.
fn assert_enclosed<S: Shape>(shape: &str, grains: u32, across: Across) {
    let point = tiny(&json!({"shape": shape, "grains": grains}));
    let packed = outcome(&StageSpec::Pack(point.pack()), &[]);
    let state = PackState::from_bytes(&packed.artifacts[STATE]).expect("a state");
    let laws = laws::<S, Hooke>(HOOKE, 1.0);
    let grains = Grains::at_rest(state.poses, &laws.body, true);
    let walls = Walls::at_rest(state.past.walls);
    let scene: Scene<F64x1, Free<S, Hooke>> = Scene::new(laws, grains, walls);
    let measured = critical_time_step(&scene, 0, across);
    // 2²⁰ iterations: an eigenvalue a share g below the largest still shifts the mean by g e^(−g·2²⁰), less than 1e-6.
    let top = |time_step: f64| largest_eigenvalue(&weighted(&scene, across, time_step), 20);
    let (stable, unstable) = (top(measured.at_least), top(measured.at_most));
    assert!(stable < 4.0 * (1.0 + 1e-12), "{shape}: {stable}");
    assert!(unstable > 4.0 * (1.0 - 1e-6), "{shape}: {unstable}");
    assert!(unstable < 4.0 * (1.0 + 1e-6), "{shape}: {unstable}");
    // Measured on packs of 325 grains: 5e-5 at most; these are smaller, and known better.
    let width = measured.at_most / measured.at_least - 1.0;
    assert!((0.0..1e-3).contains(&width), "{shape}: {width:e}");
}

#[test]
fn the_bounds_enclose_the_critical_time_step_of_a_pack() {
    let stuck = Across {
        stiffness: HOOKE.stiffness,
        damping: HOOKE.damping,
        ..Across::default()
    };
    let growing = Across {
        stiffness_per_root: MINDLIN.stiffness,
        damping_per_root: MINDLIN.damping,
        ..Across::default()
    };
    for across in [Across::default(), stuck, growing] {
        assert_enclosed::<Sphere>("sphere", 40, across);
        assert_enclosed::<Tetrahedron>("tetrahedron", 40, across);
    }
}

#[test]
fn motion_grows_just_above_it_and_dies_just_below() {
    for (share, grows) in [(0.99, false), (1.01, true)] {
        let mut scene = squeezed(share * closed_form_of_the_pair());
        let start = 1e-9;
        for (i, speed) in [(0, start), (1, -start)] {
            let velocity = [speed, 0.0, 0.0];
            let spin = [0.0; 3];
            scene.grains.set_motion(i, 0, Motion { velocity, spin });
        }
        // With ε = 1 % above, λ = −1 − (8 ε)^½ or so: e^(0.28 n); below, |λ|² = 1 − c Δt with c Δt ≈ 0.1.
        for _ in 0..200 {
            scene.step();
        }
        let speed = scene.grains.motion(0, 0).velocity[0].abs();
        assert_eq!(speed > 1e4 * start, grows, "{share}: {speed:e}");
        assert_eq!(speed < 1e-2 * start, !grows, "{share}: {speed:e}");
    }
}

/// Holds the squeezed pair for 3,000 steps with a speck of noise, on its line: aside of it the pair would buckle.
fn held(share: f64) -> Option<Stop> {
    let mut scene = squeezed(share * closed_form_of_the_pair());
    let velocity = [1e-9, 0.0, 0.0];
    let spin = [0.0; 3];
    scene.grains.set_motion(0, 0, Motion { velocity, spin });
    let cycle = Cycle {
        segments: vec![Segment::hold(3000)],
        delta0: 0.0,
        extent: Box2 {
            x: 2.0 * wall(),
            y: 2.0 * FAR,
        },
    };
    let silent = Program {
        gamma0: 0.0,
        curve: Waveform::Zero.curve(),
    };
    let guard = Guard {
        parameter: "time_step",
        deepest_slice: None,
        critical_at_start: critical_time_step(&scene, 0, Across::default()),
    };
    let mut drive = Drive::new(scene, cycle, vec![silent], Across::default(), guard);
    while drive.step < drive.cycle.steps() && !drive.is_over() {
        drive.step_once();
    }
    drive.stops.remove(0).map(|(_, stop)| stop)
}

#[test]
fn a_run_just_above_it_is_stopped_as_unstable_and_one_below_is_not() {
    assert_eq!(held(0.9), None);
    assert_eq!(held(0.99), None);
    for share in [1.01, 1.1, 1.3] {
        let stop = held(share);
        assert_eq!(stop.map(|stop| stop.kind), Some("unstable"), "{share}");
    }
}

/// Asserts that every job was refused or stopped as unstable.
fn assert_unstable(results: &Results, what: &str) {
    for result in results {
        match result {
            Err(StageFailure::Stopped { kind, .. }) if kind == "unstable" => {}
            other => panic!("{what}: {other:?}"),
        }
    }
}

#[test]
fn a_time_step_of_two_and_a_half_is_never_an_outcome() {
    for shape in ["tetrahedron", "sphere"] {
        for seed in 1..=4 {
            let point =
                tiny(&json!({"shape": shape, "packing_seed": seed, "grains": 40 + 20 * seed}));
            let what = format!("{shape}, seed {seed}");
            let pack = StageSpec::Pack(point.pack());
            let packed = outcome(&pack, &[]);
            let input = &packed.artifacts[STATE];

            let mut fast = point.clone();
            fast.time_step = 2.5;
            // The time step is shortened to fit 255 samples: a ramp of 765 steps of 2.5 t_c takes it as it is.
            fast.ramp = 765.0 * 2.5;
            let train = StageSpec::Train(fast.train(pack.id()));
            let trained = finish(&[train], input, VectorWidth::widest());
            assert_unstable(&trained, &format!("{what}, train"));

            let train = StageSpec::Train(point.train(pack.id()));
            let trained = outcome(&train, input);
            for precision in [Precision::F64, Precision::F32] {
                let mut fast = fast.clone();
                (fast.precision, fast.waveform) = (precision, Waveform::Six(2));
                let recall = StageSpec::Recall(fast.recall(train.id()));
                let results = finish(&[recall], &trained.artifacts[STATE], VectorWidth::widest());
                assert_unstable(&results, &format!("{what}, recall {precision:?}"));
            }
        }
    }
}

#[test]
fn the_walls_of_the_pair_are_in_balance() {
    // The premise of the closed form: k_w (p/2)^(3/2) = k_n p^(3/2).
    let material = squeezed(1.0).laws.material;
    let ratio = material.wall_stiffness / material.normal_stiffness;
    assert!((ratio - 2.0 * SQRT_2).abs() < 1e-12);
    let mut scene = squeezed(1.0);
    scene.step();
    let speed = scene.grains.motion(0, 0).velocity[0];
    assert!(speed.abs() < 1e-15, "{speed:e}");
}
