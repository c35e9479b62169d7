//! Properties that hold for every packing: searches agree, actions equal reactions, nothing depends on the frame.
//!
//! Source: Newton's third law, frame indifference, the Coulomb cone.

use granary_core::contact::hooke::Hooke;
use granary_core::contact::mindlin::{Mindlin, TangentialStiffness};
use granary_core::contact::mindlin_rescale::MindlinRescale;
use granary_core::contact::mindlin_sliced::MindlinSliced;
use granary_core::contact::{Components, Contact, TangentialLaw};
use granary_core::grains::{Grains, Motion, Pose};
use granary_core::lanes::{F64x1, F64x8};
use granary_core::material::Elastic;
use granary_core::math::Vec3;
use granary_core::math::plain::{add, compose, dot, norm, rotate, scale, sub};
use granary_core::neighbor::{CellGrid, Rows, Spheres, all_pairs};
use granary_core::scene::{Replicas, Scene};
use granary_core::shape::{Shape, Sphere, Tetrahedron};
use granary_core::wall::Walls;
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

#[path = "fixture/free_grains.rs"]
#[allow(dead_code, reason = "every proof takes what it needs")]
mod free_grains;

use free_grains::{
    Free, HOOKE, MINDLIN, SLICED, body, crowd, laws, random_orientation, random3, scene,
};

/// The centers of `count` grains scattered in a box of the given sides.
fn scattered<S: Shape>(seed: u64, count: u64, sides: [f64; 3]) -> Vec<[f64; 3]> {
    let arms = body::<S>().arms;
    (0..count)
        .flat_map(|n| {
            let at = random3(seed, n);
            let middle = [0, 1, 2].map(|axis| 0.5 * at[axis] * sides[axis]);
            let turn = random_orientation::<S>(seed, n);
            let center = |&arm: &[f64; 3]| add(middle, rotate(turn, arm));
            arms.iter().map(center).collect::<Vec<_>>()
        })
        .collect()
}

/// Both searches over the same spheres; a grid that has been used before.
fn searched<S: Shape>(
    seed: u64,
    count: u64,
    sides: [f64; 3],
    (slack, skin): (f64, f64),
) -> [Rows; 2] {
    let centers = scattered::<S>(seed, count, sides);
    let radii: Vec<f64> = (0..count)
        .map(|n| 1.0 + slack * (random3(seed + 1, n)[0] + 1.0))
        .collect();
    let spheres = Spheres {
        centers: &centers,
        per_grain: S::SPHERES,
        reach: if S::SPHERES > 1 {
            body::<S>().reach()
        } else {
            0.0
        },
        radii: &radii,
        skin,
    };
    let (mut certain, mut found) = (Rows::default(), Rows::default());
    all_pairs(&spheres, &mut certain);
    let mut grid = CellGrid::default();
    let elsewhere = Spheres {
        centers: &scattered::<S>(seed + 2, 7, [9.0; 3]),
        radii: &[1.1; 7],
        ..spheres
    };
    grid.search(&elsewhere, &mut found);
    grid.search(&spheres, &mut found);
    [certain, found]
}

/// Where grains are and how they move.
type State = Vec<(Pose, Motion)>;

/// A crowd that runs together, spinning.
fn converging<S: Shape>(seed: u64) -> State {
    crowd::<S>(seed, 6)
        .into_iter()
        .zip(0..)
        .map(|(pose, n)| {
            let random = scale(random3(seed, 1000 + n), 0.01);
            let velocity = add(random, scale(pose.position, -0.02));
            let spin = scale(random3(seed, 2000 + n), 0.02);
            (pose, Motion { velocity, spin })
        })
        .collect()
}

/// The state after 60 t_c.
fn evolved<S: Shape>(start: &State) -> State {
    let poses = start.iter().map(|(pose, _)| *pose).collect();
    let mut scene: Scene<F64x1, Free<S, Hooke>> = scene(laws::<S, Hooke>(HOOKE, 0.5), poses);
    for (i, (_, motion)) in start.iter().enumerate() {
        scene.grains.set_motion(i, 0, *motion);
    }
    for _ in 0..120 {
        scene.step();
    }
    let grain = |i| (scene.grains.pose(i, 0), scene.grains.motion(i, 0));
    (0..start.len()).map(grain).collect()
}

/// The largest difference of any position, orientation, velocity or spin.
fn difference(a: &State, b: &State) -> f64 {
    let grain = |((a, u), (b, v)): (&(Pose, Motion), &(Pose, Motion))| {
        let turn = a.orientation.iter().zip(b.orientation);
        // q and −q are the same rotation.
        let same: f64 = turn.map(|(a, b)| a * b).sum();
        let place = norm(sub(a.position, b.position));
        let speed = norm(sub(u.velocity, v.velocity));
        place
            .max(speed)
            .max(norm(sub(u.spin, v.spin)))
            .max((1.0 - same.abs()).abs())
    };
    a.iter().zip(b).map(grain).fold(0.0, f64::max)
}

/// Rounding of 1e-15 (positions of a few R) in each of 120 steps, grown by e^(ωt) at most.
///
/// ω² = κ ≤ 0.25, the stiffest contact's: 1.5 k_n √0.3 2/m for spheres, and what a tetrahedron adds by turning; but a
/// contact lasts half a period, π/ω, and lets go: a grain that touches m others in turn multiplies errors by e^π each time.
/// Three in 60 t_c give e^(3π) = 12,000, and 120 × 1e-15 × 12,000 = 1.5e-9.
const FRAME_ERROR: f64 = 1.5e-9;

fn frame_is_indifferent<S: Shape>(seed: u64, turn: [f64; 4], drift: [f64; 3]) -> f64 {
    let start = converging::<S>(seed);
    let moved = |state: &State, time: f64| -> State {
        let grain = |(pose, motion): &(Pose, Motion)| {
            let position = add(rotate(turn, pose.position), scale(drift, time));
            let orientation = if S::SPHERES > 1 {
                compose(turn, pose.orientation)
            } else {
                pose.orientation
            };
            let velocity = add(rotate(turn, motion.velocity), drift);
            let spin = rotate(turn, motion.spin);
            let pose = Pose {
                position,
                orientation,
            };
            (pose, Motion { velocity, spin })
        };
        state.iter().map(grain).collect()
    };
    difference(
        &moved(&evolved::<S>(&start), 60.0),
        &evolved::<S>(&moved(&start, 0.0)),
    )
}

/// The momentum that one step gives the two grains of an overlapping pair, and the sizes of what each gets.
fn recoil<R: Replicas, S: Shape>(seed: u64, distance: f64) -> ([f64; 3], f64) {
    let along = random3(seed, 0);
    let place = scale(along, distance / norm(along));
    let pose = |position, n| Pose {
        position,
        orientation: random_orientation::<S>(seed, n),
    };
    let laws = laws::<S, Hooke>(HOOKE, 1.0);
    let grains = Grains::at_rest(vec![pose([0.0; 3], 0), pose(place, 1)], &laws.body, true);
    let walls = Walls::at_rest([-99.0, 99.0, -99.0, 99.0, -99.0, 99.0]);
    let mut scene: Scene<R, Free<S, Hooke>> = Scene::new(laws, grains, walls);
    let k = R::K - 1;
    for i in 0..2 {
        let spin = scale(random3(seed, 10 + i as u64), 0.1);
        // At rest, so that the kick is the velocity and no digit is lost.
        let velocity = [0.0; 3];
        scene.grains.set_motion(i, k, Motion { velocity, spin });
    }
    scene.step();
    let [a, b] = [0, 1].map(|i| scene.grains.motion(i, k).velocity);
    (add(a, b), norm(a) + norm(b))
}

fn vector<R: Replicas>(value: [f64; 3]) -> Vec3<R> {
    let mut row = Vec3::<R>::default();
    for k in 0..R::K {
        row.set_lane(k, value);
    }
    row
}

proptest! {
    // The same cases at every run: what fails here fails everywhere.
    #![proptest_config(ProptestConfig {
        cases: 24,
        failure_persistence: None,
        rng_seed: RngSeed::Fixed(1),
        ..ProptestConfig::default()
    })]

    #[test]
    fn every_neighbor_method_finds_the_same_contacts(
        seed in 0u64..1_000_000,
        count in 1u64..120,
        (x, y, z) in (1.0..40.0f64, 1.0..40.0f64, 1.0..40.0f64),
        (slack, skin) in (0.0..1.0f64, 0.0..1.0f64),
    ) {
        let [certain, found] = searched::<Sphere>(seed, count, [x, y, z], (slack, skin));
        prop_assert_eq!(certain, found);
        let [certain, found] = searched::<Tetrahedron>(seed, count, [x, y, z], (slack, skin));
        prop_assert!(found.starts.len() as u64 == count + 1);
        prop_assert!((0..count as usize).all(|i| found.row(i).is_sorted()));
        prop_assert_eq!(certain, found);
    }

    #[test]
    fn action_equals_reaction(seed in 0u64..1_000_000, distance in 1.6..2.2f64) {
        // Both get the same force, times 1/m and Δt: each rounds twice.
        let roundings = 4.0 * 1.1e-16;
        let (sum, size) = recoil::<F64x1, Sphere>(seed, distance);
        prop_assert!(norm(sum) <= roundings * size);
        let (sum, size) = recoil::<F64x8, Sphere>(seed, distance);
        prop_assert!(norm(sum) <= roundings * size);
        // Up to 16 contacts of a pair of tetrahedra add up in another order on either side.
        let (sum, size) = recoil::<F64x1, Tetrahedron>(seed, distance);
        prop_assert!(norm(sum) <= 16.0 * roundings * size.max(0.1));
    }

    #[test]
    fn rotation_and_galilean_invariance(
        seed in 0u64..1_000_000,
        turn in 0u64..1_000_000,
        drift in prop::array::uniform3(-0.1..0.1f64),
    ) {
        let turn = random_orientation::<Tetrahedron>(turn, 0);
        let error = frame_is_indifferent::<Sphere>(seed, turn, drift);
        prop_assert!(error < FRAME_ERROR, "spheres: {:e}", error);
        let error = frame_is_indifferent::<Tetrahedron>(seed, turn, drift);
        prop_assert!(error < FRAME_ERROR, "tetrahedra: {:e}", error);
    }

    #[test]
    fn friction_stays_inside_its_cone_and_in_the_plane(
        normal in prop::array::uniform3(-1.0..1.0f64),
        slides in prop::collection::vec(prop::array::uniform3(-0.1..0.1f64), 1..40),
        friction_coefficient in 0.01..2.0f64,
        normal_force in 0.0..0.05f64,
    ) {
        prop_assume!(norm(normal) > 0.1);
        let normal = scale(normal, 1.0 / norm(normal));
        let slides: Vec<[f64; 3]> = slides
            .into_iter()
            .map(|slide| sub(slide, scale(normal, dot(slide, normal))))
            .collect();
        let solid = Elastic { youngs_modulus: 1.0, poisson_ratio: 0.49 };
        let pair = solid.against(solid);
        let hooke = Hooke { friction_coefficient, ..HOOKE };
        let mindlin = Mindlin::new(pair, TangentialStiffness::Paper, 0.3, friction_coefficient);
        let hooke = pulls(hooke, normal, &slides, normal_force);
        let mindlin = pulls(mindlin, normal, &slides, normal_force);
        let rescaled = MindlinRescale { friction_coefficient, ..MINDLIN };
        let rescaled = pulls(rescaled, normal, &slides, normal_force);
        let sliced = MindlinSliced { friction_coefficient, ..SLICED };
        let sliced = pulls(sliced, normal, &slides, normal_force);
        for force in [hooke, mindlin, rescaled, sliced].concat() {
            let limit = friction_coefficient * normal_force;
            // Scaled to the limit by one division, one root and three products: 4 × 2⁻⁵³, and a lane at the limit itself.
            prop_assert!(norm(force) <= limit * (1.0 + 1e-15));
            // n̂ is a unit vector to 2e-16, the slide lies in its plane to 1e-16 of 0.2 R/t_c.
            prop_assert!(dot(force, normal).abs() < 1e-16);
        }
    }
}

/// The forces of a contact that slides as told, step by step.
fn pulls<T: TangentialLaw>(
    law: T,
    normal: [f64; 3],
    slides: &[[f64; 3]],
    normal_force: f64,
) -> Vec<[f64; 3]> {
    let mut history = Components::from_fn(|_| F64x1::default());
    let mut slices = T::Slices::<F64x1>::default();
    let pull = |&slide: &[f64; 3]| {
        let contact = Contact {
            normal: vector(normal),
            sliding_velocity: vector(slide),
            root_overlap: F64x1([0.2]),
            reduced_mass: F64x1([2.0]),
            normal_force: F64x1([normal_force]),
            time_step: F64x1([1.0]),
            dither: F64x1([0.0]),
        };
        T::force(&law.constants(), &contact, &mut history, &mut slices).lane(0)
    };
    slides.iter().map(pull).collect()
}
