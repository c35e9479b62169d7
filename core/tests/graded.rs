//! Spheres of different sizes under Mindlin's spring: same bits in every lane and width, momenta kept, no energy from impacts.

use granary_core::contact::mindlin::{Mindlin, TangentialStiffness};
use granary_core::grains::{Grains, Motion, Pose, Size, UPRIGHT};
use granary_core::lanes::{F64x1, F64x8, VectorWidth};
use granary_core::material::{Elastic, Material};
use granary_core::math::plain::{add, cross, dot, norm, scale, sub};
use granary_core::scene::{Laws, Replicas, Scene, With};
use granary_core::shape::{Body, GradedSphere};
use granary_core::wall::Walls;

#[path = "fixture/free_grains.rs"]
#[allow(dead_code, reason = "every proof takes what it needs")]
mod free_grains;

use free_grains::random3;

type Spheres = With<GradedSphere, Mindlin, ()>;

/// The beam's grains (E = 100 MPa, ν = 0.245, A = 7 µs, γ = 0.3).
const SOLID: Elastic = Elastic {
    youngs_modulus: 1e8,
    poisson_ratio: 0.245,
};
const DENSITY: f64 = 2000.0;

fn laws(time_step: f64, width: VectorWidth) -> Laws<Spheres> {
    let pair = SOLID.against(SOLID);
    Laws {
        body: Body::sphere(),
        material: Material::viscoelastic(pair, 7e-6),
        tangential: Mindlin::new(pair, TangentialStiffness::Paper, 0.3, 0.3),
        body_force: (),
        time_step,
        dither: 0.0,
        skin: 2e-4,
        width,
    }
}

/// Radii from 1 to 3 mm, none overlapping by more than a tenth of a millimeter, most touching some.
fn crowd(count: usize) -> (Vec<Pose>, Vec<Size>) {
    let (mut poses, mut sizes): (Vec<Pose>, Vec<Size>) = (vec![], vec![]);
    let side = 2.3e-3 * (count as f64).cbrt();
    for counter in 0..2_000_000 {
        let [share, ..] = random3(2, counter);
        let radius = 2e-3 + 1e-3 * share;
        let position = scale(random3(1, counter), side);
        let overlap = |(pose, size): (&Pose, &Size)| {
            size.radius + radius - norm(sub(pose.position, position))
        };
        if poses.iter().zip(&sizes).all(|near| overlap(near) < 1e-4) {
            poses.push(Pose {
                position,
                orientation: UPRIGHT,
            });
            sizes.push(Size::sphere(radius, DENSITY));
        }
        if poses.len() == count {
            return (poses, sizes);
        }
    }
    panic!("the crowd does not fit");
}

/// Replica k of `scene` moves as seed k says.
fn scene<R: Replicas>(seeds: &[u64], width: VectorWidth) -> Scene<R, Spheres> {
    let (poses, sizes) = crowd(60);
    let laws = laws(5e-6, width);
    let mut grains = Grains::<R>::at_rest(poses, &laws.body, true).graded(sizes);
    for (k, &seed) in seeds.iter().enumerate() {
        for i in 0..grains.len() {
            let motion = Motion {
                velocity: scale(random3(seed, 2 * i as u64), 0.5),
                spin: scale(random3(seed, 2 * i as u64 + 1), 100.0),
            };
            grains.set_motion(i, k, motion);
        }
    }
    Scene::new(
        laws,
        grains,
        Walls::at_rest([-1.0, 1.0, -1.0, 1.0, -1.0, 1.0]),
    )
}

/// Everything that replica `k` is, after 400 steps.
fn end<R: Replicas>(seeds: &[u64], k: usize, width: VectorWidth) -> Vec<(Pose, Motion)> {
    let mut scene = scene::<R>(seeds, width);
    for _ in 0..400 {
        scene.step();
    }
    assert!(scene.renewals() > 3, "{}", scene.renewals());
    let grains = &scene.grains;
    (0..grains.len())
        .map(|i| (grains.pose(i, k), grains.motion(i, k)))
        .collect()
}

#[test]
fn every_lane_and_every_width_gives_the_bits_of_a_lone_portable_run() {
    let seeds = [11, 12, 13, 14, 15, 16, 17, 18];
    for (k, seed) in seeds.iter().enumerate() {
        let alone = end::<F64x1>(&[*seed], 0, VectorWidth::widest());
        assert!(
            alone == end::<F64x8>(&seeds, k, VectorWidth::widest()),
            "lane {k}"
        );
    }
    let portable = end::<F64x1>(&seeds[..1], 0, VectorWidth::PORTABLE);
    for width in VectorWidth::available() {
        assert!(
            portable == end::<F64x1>(&seeds[..1], 0, width),
            "{}",
            width.name()
        );
        assert!(
            portable == end::<F64x8>(&seeds, 0, width),
            "{}",
            width.name()
        );
    }
}

#[test]
fn momentum_and_angular_momentum_are_kept() {
    let mut scene = scene::<F64x1>(&[3], VectorWidth::widest());
    let momenta = |scene: &Scene<F64x1, Spheres>| {
        let (mut linear, mut angular, mut most) = ([0.0; 3], [0.0; 3], [0.0f64; 2]);
        for (i, size) in scene.grains.sizes().iter().enumerate() {
            let motion = scene.grains.motion(i, 0);
            let momentum = scale(motion.velocity, 1.0 / size.inverse_mass);
            let own = scale(motion.spin, 1.0 / size.inverse_inertia);
            let turning = add(own, cross(scene.grains.pose(i, 0).position, momentum));
            linear = add(linear, momentum);
            angular = add(angular, turning);
            most = [most[0] + norm(momentum), most[1] + norm(turning)];
        }
        (linear, angular, most)
    };
    let (linear, angular, most) = momenta(&scene);
    for _ in 0..1000 {
        scene.step();
    }
    let (linear_after, angular_after, _) = momenta(&scene);
    // Rounding of a thousand sums of some ten forces of 60 grains, at worst in step: 1e6 × 1e-16.
    assert!(norm(sub(linear_after, linear)) < 1e-10 * most[0]);
    // Positions are those of half a step after the velocities: both sides of a contact see the same ones.
    assert!(norm(sub(angular_after, angular)) < 1e-10 * most[1]);
}

/// Kinetic energy of two spheres before they meet, and after they part.
///
/// They meet anywhere on the disc in which they can touch, but for its rim.
fn impact(seed: u64) -> (f64, f64) {
    let [a, b, speed] = random3(seed, 0);
    let sizes = [a, b].map(|share| Size::sphere(2e-3 * (1.0 + 0.8 * share), DENSITY));
    let reach = sizes[0].radius + sizes[1].radius;
    let [x, y, _] = random3(seed, 1);
    let [x, y] = [0.7 * reach * x, 0.7 * reach * y];
    let z = 1.001 * (reach * reach - x * x - y * y).sqrt();
    let poses = [[0.0; 3], [x, y, z]].map(|position| Pose {
        position,
        orientation: UPRIGHT,
    });
    let laws = laws(5e-7, VectorWidth::widest());
    let mut grains =
        Grains::<F64x1>::at_rest(poses.to_vec(), &laws.body, true).graded(sizes.to_vec());
    let speed = 0.05 + 0.5 * (speed + 1.0);
    for (i, velocity) in [[0.0; 3], [0.0, 0.0, -speed]].into_iter().enumerate() {
        let spin = scale(random3(seed, 2 + i as u64), 500.0);
        grains.set_motion(i, 0, Motion { velocity, spin });
    }
    let far = 1.0;
    let mut scene = Scene::new(
        laws,
        grains,
        Walls::at_rest([-far, far, -far, far, -far, far]),
    );
    let energy = |scene: &Scene<F64x1, Spheres>| -> f64 {
        let one = |i: usize| {
            let (motion, size) = (scene.grains.motion(i, 0), sizes[i]);
            0.5 * (dot(motion.velocity, motion.velocity) / size.inverse_mass
                + dot(motion.spin, motion.spin) / size.inverse_inertia)
        };
        one(0) + one(1)
    };
    let before = energy(&scene);
    let mut touched = false;
    for _ in 0..5000 {
        scene.step();
        let [one, other] = [0, 1].map(|i| scene.grains.pose(i, 0).position);
        let apart = norm(sub(other, one)) > reach;
        touched |= !apart;
        if touched && apart {
            return (before, energy(&scene));
        }
    }
    panic!("impact {seed} does not end");
}

#[test]
fn no_impact_gains_energy() {
    let impacts: Vec<(f64, f64)> = (0..10_000).map(impact).collect();
    let worst = impacts
        .iter()
        .map(|(before, after)| after / before - 1.0)
        .fold(f64::NEG_INFINITY, f64::max);
    assert!(worst < 1e-9, "{worst:e}");
}
