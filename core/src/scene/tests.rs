//! The threads of a job change no bit.

use super::*;
use crate::contact::hooke::Hooke;
use crate::crew::{Crew, helped};
use crate::grains::{Motion, Pose, UPRIGHT};
use crate::material::Material;
use crate::random::{Purpose, uniform3};
use crate::shape::{Body, Shape, Sphere, Tetrahedron};

/// Grains on a cubic lattice, `spacing` apart, that move at random; numbered layer by layer.
fn crowd<R: Replicas, S: Shape>(body: Body, spacing: f64) -> Scene<R, With<S, Hooke, ()>> {
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
        dither: 0.0,
        skin: 0.2,
        width: VectorWidth::widest(),
    };
    let mut grains = Grains::at_rest(poses, &laws.body, true);
    for (i, k) in (0..grains.len()).flat_map(|i| (0..R::K).map(move |k| (i, k))) {
        let [velocity, spin] = [0, 1].map(|n| {
            let shares = uniform3(1 + k as u64, Purpose::GasVelocity, 2 * i as u64 + n);
            shares.map(|share| 0.02 * (share - 0.5))
        });
        grains.set_motion(i, k, Motion { velocity, spin });
    }
    let (wall, far) = (-0.99, 1e3);
    Scene::new(
        laws,
        grains,
        Walls::at_rest([wall, far, wall, far, wall, far]),
    )
}

/// How all grains of all replicas move after 60 steps by `threads`, and what pushes the walls.
fn moved<R: Replicas, S: Shape>(
    body: &Body,
    spacing: f64,
    threads: usize,
) -> (Vec<Motion>, Vec<f64>) {
    let crew = Crew::new(threads, Default::default);
    crew.work(|| {
        helped(usize::MAX, || {
            let mut scene = crowd::<R, S>(body.clone(), spacing);
            for step in 0..60 {
                assert_eq!(scene.contacts.blocks.len(), threads, "step {step}");
                scene.step();
            }
            assert!(scene.renewals() > 1, "the list was never renewed");
            assert!(scene.touching() > scene.grains.len());
            let all = (0..scene.grains.len()).flat_map(|i| (0..R::K).map(move |k| (i, k)));
            let motions = all.map(|(i, k)| scene.grains.motion(i, k)).collect();
            (motions, scene.walls.force.as_flattened().to_vec())
        })
    })
    .0
}

fn threads_change_no_bit<R: Replicas, S: Shape>(body: &Body, spacing: f64) {
    let (alone, pushes_alone) = moved::<R, S>(body, spacing, 1);
    assert!(
        pushes_alone.iter().any(|&push| push > 0.0),
        "no wall is pushed"
    );
    for threads in [2, 3, 4] {
        let (together, pushes) = moved::<R, S>(body, spacing, threads);
        let other = alone.iter().zip(&together).position(|(a, b)| a != b);
        assert_eq!(other, None, "{threads} threads");
        assert_eq!(pushes_alone, pushes, "{threads} threads");
    }
}

fn lone_or_not<S: Shape>(body: &Body, spacing: f64) {
    threads_change_no_bit::<F64x1, S>(body, spacing);
    threads_change_no_bit::<F64x8, S>(body, spacing);
    threads_change_no_bit::<F32x16, S>(body, spacing);
}

#[test]
fn spheres_move_alike_whatever_the_threads() {
    lone_or_not::<Sphere>(&Body::sphere(), 1.97);
}

#[test]
fn tetrahedra_move_alike_whatever_the_threads() {
    lone_or_not::<Tetrahedron>(&Body::tetrahedron(0.6), 2.4);
}
