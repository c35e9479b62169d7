//! Impacts lose energy: two frictional grains never part with more than they met with.
//!
//! Kinetic and rotational energy are compared before the grains touch and when they have parted for good, when no contact
//! holds any: what a spring held when its contact opened is lost, as in the law.
//! A pair meets at 0.2 to 1 times the fastest gas speed, 0.02 √3 R/t_c (docs/choices.md §3), at impact parameters uniform over the
//! disc in which the grains can touch, with independent spins of uniform size and direction.
//!
//! Where it holds, and where not: at Δt = 0.1 t_c for spins up to 1/t_c, and at Δt = 1.5 t_c for spins up to 0.03/t_c, three
//! orders above those of a packing that is slowly strained.
//! At Δt = 1.5 t_c and larger spins, some of 10⁵ impacts end with up to 0.3 % more energy (docs/validation.md).
//! The cause: law H takes the sliding velocity with normal and arms of the end of the step, but velocities of its middle.
//! That is half a step late, an error of first order in spin × Δt; where two surfaces meet nearly rolling, so that friction
//! takes next to nothing, it can exceed what the contact takes.
//! With normal and arms shifted back by half a step next to nothing grew, but the law as printed and the oracle's
//! trajectories (`oracle_press_shear.rs`, to 1e-9 N) take both at the end, the shift costs some 40 operations a contact, and
//! below 1e-3/t_c, where the spins of a strained packing are, it changes the slip by less than 1e-3 of it.

use granary_core::contact::hooke::Hooke;
use granary_core::grains::{Motion, Pose};
use granary_core::lanes::F64x8;
use granary_core::math::plain::{add, cross, dot, norm, scale, sub};
use granary_core::scene::Scene;
use granary_core::shape::{Shape, Sphere, Tetrahedron};

#[path = "fixture/free_grains.rs"]
#[allow(dead_code, reason = "every proof takes what it needs")]
mod free_grains;

use free_grains::{Free, HOOKE, body, energy, laws, random_orientation, random3, scene};

/// The fastest grain of the gas \[R/t_c\].
const GAS_SPEED: f64 = 0.034_641;

/// Energies are sums of 14 squares: rounding beyond 1e-13 of them is impossible.
const ROUNDING: f64 = 1e-13;

const LANES: usize = 8;

type Pairs<S> = Scene<F64x8, Free<S, Hooke>>;

/// What became of many impacts.
#[derive(Debug, Default)]
struct Tally {
    impacts: u64,
    touched: u64,
    grown: u64,
    /// The largest growth over the energy before.
    worst: f64,
}

/// The distance of two centers of mass beyond which their grains cannot touch.
fn apart<S: Shape>() -> f64 {
    let reach = if S::SPHERES > 1 {
        body::<S>().reach()
    } else {
        0.0
    };
    2.0 * (1.0 + reach)
}

/// A random direction.
fn direction(seed: u64, counter: u64) -> [f64; 3] {
    let random = random3(seed, counter);
    scale(random, 1.0 / norm(random))
}

/// Eight pairs about to meet.
fn meeting<S: Shape>(time_step: f64, most_spin: f64, seed: u64) -> Pairs<S> {
    let apart = apart::<S>();
    let pose = |x: f64, n: u64| Pose {
        position: [x, 0.0, 0.0],
        orientation: random_orientation::<S>(seed, n),
    };
    let mut laws = laws::<S, Hooke>(HOOKE, time_step);
    // Every sphere of one grain may meet every one of the other in some replica.
    laws.skin = 3.0;
    let mut scene: Pairs<S> = scene(laws, vec![pose(0.0, 0), pose(apart, 1)]);
    for k in 0..LANES {
        let counter = |n: u64| 10 + 10 * k as u64 + n;
        let share = |n: u64| random3(seed, counter(n)).map(|x| 0.5 * (x + 1.0));
        let along = direction(seed, counter(0));
        let aside = cross(along, direction(seed, counter(1)));
        let aside = scale(aside, 1.0 / norm(aside));
        let [area, fast, _] = share(2);
        let parameter = apart * area.sqrt();
        let ahead = (apart * apart - parameter * parameter).sqrt();
        let place = add(scale(along, ahead), scale(aside, parameter));
        let speed = GAS_SPEED * (0.2 + 0.8 * fast);
        let offsets = [[0.0; 3], sub(place, [apart, 0.0, 0.0])];
        let spins = share(3);
        for (i, sign) in [(0, 0.5), (1, -0.5)] {
            let turn = random_orientation::<S>(seed, counter(4 + i as u64));
            scene.grains.set_offset(i, k, offsets[i], turn);
            let motion = Motion {
                velocity: scale(along, sign * speed),
                spin: scale(direction(seed, counter(6 + i as u64)), most_spin * spins[i]),
            };
            scene.grains.set_motion(i, k, motion);
        }
    }
    scene.renew_contacts();
    scene
}

/// Whether the grains of replica `k` are out of reach of each other and receding.
fn parted<S: Shape>(scene: &Pairs<S>, k: usize) -> bool {
    let grains = &scene.grains;
    let branch = sub(grains.pose(1, k).position, grains.pose(0, k).position);
    let velocity = sub(grains.motion(1, k).velocity, grains.motion(0, k).velocity);
    norm(branch) > apart::<S>() && dot(branch, velocity) > 0.0
}

fn impacts<S: Shape>(time_step: f64, most_spin: f64, count: u64) -> Tally {
    let mut tally = Tally::default();
    for seed in 0..count / LANES as u64 {
        let mut scene = meeting::<S>(time_step, most_spin, seed);
        let energies = |scene: &Pairs<S>| [0, 1, 2, 3, 4, 5, 6, 7].map(|k| energy(scene, k));
        let before = energies(&scene);
        let start: Vec<Motion> = (0..LANES).map(|k| scene.grains.motion(0, k)).collect();
        let mut steps = 0.0;
        while !(0..LANES).all(|k| parted(&scene, k)) {
            for _ in 0..16 {
                scene.step();
            }
            steps += 16.0;
            assert!(steps * time_step < 1e5, "seed {seed}: a pair does not part");
        }
        for (k, after) in energies(&scene).into_iter().enumerate() {
            let growth = (after - before[k]) / before[k];
            tally.impacts += 1;
            tally.touched += u64::from(scene.grains.motion(0, k) != start[k]);
            tally.grown += u64::from(growth > ROUNDING);
            tally.worst = tally.worst.max(growth);
        }
    }
    tally
}

/// Asserts that no impact ended with more energy, and that most were impacts.
fn assert_never_grows(tally: &Tally) {
    assert_eq!(tally.grown, 0, "{tally:?}");
    assert!(tally.touched * 10 > tally.impacts * 8, "{tally:?}");
}

#[test]
fn energy_of_spheres_never_grows_at_a_fine_step_and_any_spin() {
    assert_never_grows(&impacts::<Sphere>(0.1, 1.0, 10_000));
}

#[test]
fn energy_of_tetrahedra_never_grows_at_a_fine_step_and_any_spin() {
    assert_never_grows(&impacts::<Tetrahedron>(0.1, 1.0, 10_000));
}

#[test]
fn energy_never_grows_at_the_standard_step() {
    assert_never_grows(&impacts::<Sphere>(1.5, 0.03, 20_000));
    assert_never_grows(&impacts::<Tetrahedron>(1.5, 0.03, 20_000));
}

#[test]
fn energy_seldom_and_hardly_grows_at_the_standard_step_and_extreme_spin() {
    // Measured in 10⁵ impacts: 7 and 8 of them, by 6e-4 and 3e-3 at most. A scheme that fed on spin would show many.
    for tally in [
        impacts::<Sphere>(1.5, 1.0, 20_000),
        impacts::<Tetrahedron>(1.5, 1.0, 20_000),
    ] {
        assert!(tally.grown * 1000 < tally.impacts, "{tally:?}");
        assert!(tally.worst < 0.01, "{tally:?}");
    }
}
