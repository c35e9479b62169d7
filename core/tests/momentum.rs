//! Contact forces sum to zero and act at one point: free grains keep their linear and angular momentum.
//!
//! Newton's third law, and the contact point in the middle of the overlap (docs/choices.md §2).

use granary_core::contact::TangentialLaw;
use granary_core::contact::frictionless::Frictionless;
use granary_core::grains::{Motion, Pose, UPRIGHT};
use granary_core::lanes::{F64x1, F64x8};
use granary_core::math::plain::{add, norm, scale, sub};
use granary_core::scene::{Replicas, Scene};
use granary_core::shape::{Shape, Sphere, Tetrahedron};

#[path = "fixture/free_grains.rs"]
#[allow(dead_code, reason = "every proof takes what it needs")]
mod free_grains;

use free_grains::{
    Free, HOOKE, MINDLIN, Momenta, SLICED, crowd, laws, momenta, scene, set_random_motions,
};

/// 2⁻⁵³: what one operation may round by.
const ROUNDING: f64 = 1.1e-16;

/// A crowd that runs together and apart again, sliding and spinning, for 400 t_c.
fn momentum_is_kept<R: Replicas, S: Shape, T: TangentialLaw>(law: T, seed: u64) {
    let (grains, steps) = (12, 800);
    let mut scene: Scene<R, Free<S, T>> = scene(laws::<S, T>(law, 0.5), crowd::<S>(seed, grains));
    set_random_motions(&mut scene, seed, (0.02, 0.1));
    for (i, k) in (0..grains).flat_map(|i| (0..R::K).map(move |k| (i, k))) {
        let inward = scale(scene.grains.pose(i, k).position, -0.02);
        let Motion { velocity, spin } = scene.grains.motion(i, k);
        let velocity = add(velocity, inward);
        scene.grains.set_motion(i, k, Motion { velocity, spin });
    }
    let before: Vec<Momenta> = (0..R::K).map(|k| momenta(&scene, k)).collect();
    let mut largest = (0.0f64, 0.0f64);
    let mut contacts = 0;
    for step in 0..steps {
        scene.step();
        contacts = contacts.max(scene.remembered(0).count());
        if step % 10 == 0 || step == steps - 1 {
            for k in 0..R::K {
                let now = momenta(&scene, k);
                largest.0 = largest.0.max(now.linear_size);
                largest.1 = largest.1.max(now.angular_size);
            }
        }
    }
    assert!(contacts > 6, "at most {contacts} contacts at once");
    // A step rounds each grain's momentum once per contact and twice in the kick: fewer than 20 times, each by at most
    // 2⁻⁵³ of the grain's share of the sizes. The bound lets all of them add up.
    let roundings = 20.0 * f64::from(steps) * ROUNDING;
    for (k, before) in before.iter().enumerate() {
        let after = momenta(&scene, k);
        let linear = norm(sub(after.linear, before.linear));
        let angular = norm(sub(after.angular, before.angular));
        assert!(linear < roundings * largest.0, "lane {k}: {linear:e}");
        assert!(angular < roundings * largest.1, "lane {k}: {angular:e}");
    }
}

#[test]
fn a_lone_run_keeps_its_momenta() {
    for seed in 0..5 {
        momentum_is_kept::<F64x1, Sphere, _>(HOOKE, seed);
        momentum_is_kept::<F64x1, Tetrahedron, _>(HOOKE, seed);
        momentum_is_kept::<F64x1, Tetrahedron, _>(Frictionless, seed);
        momentum_is_kept::<F64x1, Tetrahedron, _>(MINDLIN, seed);
        momentum_is_kept::<F64x1, Tetrahedron, _>(SLICED, seed);
    }
}

#[test]
fn every_lane_of_eight_keeps_its_momenta() {
    for seed in 0..5 {
        momentum_is_kept::<F64x8, Sphere, _>(HOOKE, seed);
        momentum_is_kept::<F64x8, Tetrahedron, _>(HOOKE, seed);
        momentum_is_kept::<F64x8, Tetrahedron, _>(Frictionless, seed);
        momentum_is_kept::<F64x8, Tetrahedron, _>(MINDLIN, seed);
        momentum_is_kept::<F64x8, Tetrahedron, _>(SLICED, seed);
    }
}

#[test]
fn a_frictionless_impact_off_center_spins_a_tetrahedron() {
    let pose = |x: f64, y: f64| Pose {
        position: [x, y, 0.0],
        orientation: UPRIGHT,
    };
    let laws = laws::<Tetrahedron, Frictionless>(Frictionless, 0.1);
    let mut scene: Scene<F64x1, Free<Tetrahedron, Frictionless>> =
        scene(laws, vec![pose(-1.6, 0.3), pose(1.6, 0.0)]);
    for (i, velocity) in [(0, 0.02), (1, -0.02)] {
        let velocity = [velocity, 0.0, 0.0];
        let spin = [0.0; 3];
        scene.grains.set_motion(i, 0, Motion { velocity, spin });
    }
    let before = momenta(&scene, 0);
    let steps = 3000;
    for _ in 0..steps {
        scene.step();
    }
    let after = momenta(&scene, 0);
    let spin = |i| norm(scene.grains.motion(i, 0).spin);
    assert!(spin(0) > 1e-3 && spin(1) > 1e-3, "{} {}", spin(0), spin(1));
    let bound = 20.0 * f64::from(steps) * ROUNDING;
    let linear = norm(sub(after.linear, before.linear));
    assert!(linear < bound * before.linear_size, "{linear:e}");
    // The grains stay within 3 R of the origin before and move apart to 6 R after.
    let angular = norm(sub(after.angular, before.angular));
    assert!(
        angular < bound * before.angular_size.max(after.angular_size),
        "{angular:e}"
    );
}
