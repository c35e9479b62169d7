//! The threads of a team change no bit.

use super::*;
use crate::contact::hooke::Hooke;
use crate::grains::{Motion, UPRIGHT};
use crate::lanes::VectorWidth;
use crate::material::Material;
use crate::random::{Purpose, uniform3};
use crate::scene::With;
use crate::shape::{Body, Shape, Sphere, Tetrahedron};

/// Grains on a cubic lattice, `spacing` apart, that move at random; numbered layer by layer.
fn crowd<S: Shape>(body: Body, spacing: f64) -> Scene<F64x1, With<S, Hooke, ()>> {
    let (across, layers) = (6, 36);
    let mut poses = vec![];
    for z in 0..layers {
        for (y, x) in (0..across).flat_map(|y| (0..across).map(move |x| (y, x))) {
            poses.push(Pose {
                position: [x, y, z].map(|n| spacing * f64::from(n)),
                orientation: UPRIGHT,
            });
        }
    }
    let laws = Laws {
        body,
        material: Material::new(0.49, 0.23, 2f64.powf(1.5)),
        tangential: Hooke {
            stiffness: 0.134,
            damping: 0.01,
            friction_coefficient: 0.5,
        },
        body_force: (),
        time_step: 0.3,
        skin: 0.2,
        width: VectorWidth::widest(),
    };
    let mut grains = Grains::at_rest(poses, &laws.body, true);
    for i in 0..grains.len() {
        let [velocity, spin] = [0, 1].map(|n| {
            let shares = uniform3(1, Purpose::GasVelocity, 2 * i as u64 + n);
            shares.map(|share| 0.02 * (share - 0.5))
        });
        grains.set_motion(i, 0, Motion { velocity, spin });
    }
    let (wall, far) = (-0.99, 1e3);
    Scene::new(
        laws,
        grains,
        Walls::at_rest([wall, far, wall, far, wall, far]),
    )
}

/// How all grains move after 60 steps by `threads`.
fn moved<S: Shape>(body: &Body, spacing: f64, threads: usize) -> Vec<Motion> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    pool.expect("threads").install(|| {
        team::helped(usize::MAX, || {
            let mut scene = crowd::<S>(body.clone(), spacing);
            for step in 0..60 {
                assert_eq!(scene.contacts.blocks.len(), threads, "step {step}");
                scene.step();
            }
            assert!(scene.renewals() > 1, "the list was never renewed");
            assert!(scene.touching() > scene.grains.len());
            (0..scene.grains.len())
                .map(|i| scene.grains.motion(i, 0))
                .collect()
        })
    })
}

fn threads_change_no_bit<S: Shape>(body: &Body, spacing: f64) {
    let alone = moved::<S>(body, spacing, 1);
    for threads in [2, 3, 4] {
        let together = moved::<S>(body, spacing, threads);
        let other = alone.iter().zip(&together).position(|(a, b)| a != b);
        assert_eq!(other, None, "{threads} threads");
    }
}

#[test]
fn spheres_move_alike_whatever_the_threads() {
    threads_change_no_bit::<Sphere>(&Body::sphere(), 1.97);
}

#[test]
fn tetrahedra_move_alike_whatever_the_threads() {
    threads_change_no_bit::<Tetrahedron>(&Body::tetrahedron(0.6), 2.4);
}

#[test]
fn every_bit_becomes_its_flag() {
    for bits in 0..=0xFFu32 {
        let one_by_one = std::array::from_fn(|e| bits >> e & 1 == 1);
        assert_eq!(super::flags(bits), one_by_one, "{bits:08b}");
    }
}
