//! What a frictionless scene does not model costs nothing, and leaving it out changes nothing.
//!
//! Source: ARCHITECTURE.md, the invariants of the engine.

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

use granary_core::contact::TangentialLaw;
use granary_core::contact::frictionless::Frictionless;
use granary_core::contact::hooke::Hooke;
use granary_core::grains::Pose;
use granary_core::lanes::{F32x16, F64x1, F64x8};
use granary_core::protocol::{Box2, move_box};
use granary_core::scene::{Replicas, Scene, history_components};
use granary_core::shape::{Shape, Sphere, Tetrahedron};
use granary_core::wall::Walls;

#[path = "fixture/free_grains.rs"]
#[allow(dead_code, reason = "every proof takes what it needs")]
mod free_grains;

use free_grains::{Free, HOOKE, crowd, laws, scene, set_random_motions};

/// The system's allocator, counting the requests of each thread.
struct Counting;

thread_local! {
    static REQUESTS: Cell<usize> = const { Cell::new(0) };
}

fn requests() -> usize {
    REQUESTS.with(Cell::get)
}

#[expect(unsafe_code, reason = "an allocator cannot be written without")]
// SAFETY: every call is handed to the system's allocator unchanged.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        REQUESTS.with(|requests| requests.set(requests.get() + 1));
        // SAFETY: the caller keeps the contract of `GlobalAlloc`.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: the caller keeps the contract of `GlobalAlloc`.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

const NO_FRICTION: Hooke = Hooke {
    friction_coefficient: 0.0,
    ..HOOKE
};

/// The bits of every grain's displacement and velocity, and of its turn and spin if it is oriented.
fn trajectory<R: Replicas, S: Shape, T: TangentialLaw>(law: T, seed: u64) -> Vec<u64> {
    let mut scene: Scene<R, Free<S, T>> = scene(laws::<S, T>(law, 0.7), crowd::<S>(seed, 16));
    set_random_motions(&mut scene, seed, (0.02, 0.0));
    let mut bits = vec![];
    for step in 0..600 {
        scene.step();
        if step % 50 == 49 {
            for (i, k) in (0..scene.grains.len()).flat_map(|i| (0..R::K).map(move |k| (i, k))) {
                let (displacement, turn) = scene.grains.offset(i, k);
                let motion = scene.grains.motion(i, k);
                bits.extend(displacement.map(f64::to_bits));
                bits.extend(motion.velocity.map(f64::to_bits));
                if S::SPHERES > 1 {
                    bits.extend(turn.map(f64::to_bits));
                    bits.extend(motion.spin.map(f64::to_bits));
                }
            }
        }
    }
    bits
}

/// Asserts that all of it is the same without friction as under μ = 0.
fn assert_same<R: Replicas, S: Shape>() {
    for seed in 0..10 {
        let without = trajectory::<R, S, _>(Frictionless, seed);
        let zero = trajectory::<R, S, _>(NO_FRICTION, seed);
        assert!(without == zero, "seed {seed}, {} spheres", S::SPHERES);
    }
}

#[test]
fn no_friction_coefficient_and_no_friction_give_the_same_bits() {
    assert_same::<F64x1, Tetrahedron>();
    assert_same::<F64x8, Tetrahedron>();
    assert_same::<F64x1, Sphere>();
    assert_same::<F32x16, Sphere>();
}

#[test]
fn a_frictionless_contact_remembers_nothing() {
    type Smooth = Scene<F64x8, Free<Tetrahedron, Frictionless>>;
    type Rough = Scene<F64x8, Free<Tetrahedron, Hooke>>;
    assert_eq!(history_components::<Frictionless>(), 0);
    assert_eq!(
        size_of::<<Frictionless as TangentialLaw>::History<F64x8>>(),
        0
    );
    // Law H remembers ξ: three components in each of eight lanes of eight bytes.
    assert_eq!(
        Rough::bytes_per_candidate() - Smooth::bytes_per_candidate(),
        3 * 8 * 8
    );
}

#[test]
fn a_sphere_has_no_orientation_and_a_smooth_one_no_spin() {
    fn bytes<S: Shape, T: TangentialLaw>(law: T) -> usize {
        let scene: Scene<F64x8, Free<S, T>> = scene(laws::<S, T>(law, 1.0), crowd::<S>(1, 5));
        scene.bytes_per_grain()
    }
    let (vector, pose) = (3 * 8 * 8, 7 * 8);
    // Displacement, velocity, force; spin and torque where something can spin a grain; turn and arms where it has one.
    assert_eq!(bytes::<Sphere, _>(Frictionless), pose + 3 * vector);
    assert_eq!(bytes::<Sphere, _>(HOOKE), pose + 5 * vector);
    let (turn, arms) = (4 * 8 * 8, 4 * 2 * 3 * 8);
    let tetrahedron = pose + 5 * vector + turn + arms;
    assert_eq!(bytes::<Tetrahedron, _>(Frictionless), tetrahedron);
    assert_eq!(bytes::<Tetrahedron, _>(HOOKE), tetrahedron);
}

/// Requests for memory while a box of grains breathes, once it has done so before.
fn requests_when_warm<R: Replicas, S: Shape, T: TangentialLaw>(law: T) -> (usize, u64) {
    let poses: Vec<Pose> = crowd::<S>(2, 40);
    let laws = laws::<S, T>(law, 0.5);
    let grains = granary_core::grains::Grains::at_rest(poses, &laws.body, true);
    let half = 6.0;
    let walls = Walls::at_rest([-half, half, -half, half, -half, half]);
    let mut scene: Scene<R, Free<S, T>> = Scene::new(laws, grains, walls);
    set_random_motions(&mut scene, 2, (0.02, 0.0));
    let breathe = |scene: &mut Scene<R, Free<S, T>>, breaths: u32| {
        for n in 0..breaths * 1000 {
            let phase = f64::from(n % 1000) / 1000.0 * std::f64::consts::TAU;
            let extent = 2.0 * half * (0.9 + 0.1 * phase.cos());
            for k in 0..R::K {
                let to = Box2 {
                    x: extent,
                    y: extent,
                };
                move_box(scene, k, to);
            }
            scene.step();
        }
    };
    // Lists grow to their largest size in the first breaths.
    breathe(&mut scene, 6);
    let (before, renewals) = (requests(), scene.renewals());
    breathe(&mut scene, 2);
    (requests() - before, scene.renewals() - renewals)
}

#[test]
fn the_step_loop_allocates_nothing_once_warm() {
    for (requests, renewals) in [
        requests_when_warm::<F64x1, Tetrahedron, _>(HOOKE),
        requests_when_warm::<F64x8, Tetrahedron, _>(HOOKE),
        requests_when_warm::<F32x16, Sphere, _>(HOOKE),
        requests_when_warm::<F64x1, Sphere, _>(Frictionless),
    ] {
        assert!(renewals > 5, "the list was renewed {renewals} times only");
        assert_eq!(requests, 0);
    }
}
