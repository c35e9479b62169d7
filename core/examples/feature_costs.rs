//! What each feature costs a scene that has it: bytes and time, by pairs of scenes that differ in it alone.
//!
//! `cargo run --release -p granary-core --features validation --example feature_costs`: prints the table of docs/speed.md.

#![expect(
    clippy::disallowed_methods,
    clippy::print_stdout,
    reason = "a program that times the engine and prints"
)]

use std::time::Instant;

use granary_core::contact::TangentialLaw;
use granary_core::contact::frictionless::Frictionless;
use granary_core::contact::hooke::Hooke;
use granary_core::contact::mindlin::{Mindlin, TangentialStiffness};
use granary_core::contact::mindlin_rescale::MindlinRescale;
use granary_core::contact::mindlin_sliced::MindlinSliced;
use granary_core::force::{AffineDrag, BodyForce};
use granary_core::grains::{Grains, Motion, Pose, Size, UPRIGHT};
use granary_core::lanes::{F32x16, F64x1, F64x8, VectorWidth};
use granary_core::material::{Elastic, Material};
use granary_core::membrane::{Cuboid, Membrane, Sheet};
use granary_core::observable::critical_time_step::{Across, critical_time_step};
use granary_core::observable::observe;
use granary_core::scene::casing::{Casing, Grip, Press};
use granary_core::scene::{Encased, Laws, Physics, Replicas, Scene, With};
use granary_core::shape::{Body, GradedSphere, Shape, Sphere, Tetrahedron};
use granary_core::wall::Walls;

/// Grains along each edge of a lattice.
const ACROSS: usize = 14;
/// Steps of one timing, and timings of each scene, in turn with the others.
const STEPS: u32 = 100;
const ROUNDS: usize = 9;

const HOOKE: Hooke = Hooke {
    stiffness: 0.134,
    damping: 0.3 * 0.23 * 0.134,
    friction_coefficient: 1.0,
};

/// Law M1.
const RESCALED: MindlinRescale = MindlinRescale {
    stiffness: 0.6,
    damping: 0.3 * 0.23 * 0.6,
    friction_coefficient: 1.0,
};

/// Law M2, Q = 100 and p_max = 0.25 R.
const SLICED: MindlinSliced = MindlinSliced {
    stiffness: RESCALED.stiffness,
    damping: RESCALED.damping,
    friction_coefficient: RESCALED.friction_coefficient,
    slices: 100,
    largest_overlap: 0.25,
};

/// A lattice of grains that just touch; where there are walls, they do too.
fn lattice<R: Replicas, S: Shape, T: TangentialLaw, B: BodyForce>(
    grains: (Body, f64),
    tangential: T,
    body_force: B,
    walls: bool,
) -> Scene<R, With<S, T, B>> {
    within(grains, (tangential, body_force), walls, ())
}

fn within<R: Replicas, P: Physics>(
    (body, spacing): (Body, f64),
    (tangential, body_force): (P::Tangential, P::Body),
    walls: bool,
    surroundings: P::Surroundings,
) -> Scene<R, P> {
    let laws = Laws {
        body,
        material: Material::new(0.49, 0.23, 2f64.powf(1.5)),
        tangential,
        body_force,
        time_step: 0.01,
        dither: 0.0,
        skin: 0.05,
        width: VectorWidth::widest(),
    };
    let mut poses = vec![];
    for n in 0..ACROSS * ACROSS * ACROSS {
        let place = [n % ACROSS, n / ACROSS % ACROSS, n / (ACROSS * ACROSS)];
        poses.push(Pose {
            position: place.map(|n| spacing * n as f64),
            orientation: UPRIGHT,
        });
    }
    let (low, high) = if walls {
        (-0.99, spacing * (ACROSS - 1) as f64 + 0.99)
    } else {
        (-1e3, 1e3)
    };
    let mut grains = Grains::at_rest(poses, &laws.body, P::SPINS);
    // They move a little, so that springs are not next to zero, where numbers are slow.
    for i in 0..grains.len() {
        let velocity = [37, 53, 71].map(|stride| ((i * stride % 101) as f64 / 50.0 - 1.0) * 1e-4);
        for k in 0..R::K {
            let spin = [0.0; 3];
            grains.set_motion(i, k, Motion { velocity, spin });
        }
    }
    if P::GRADED {
        let sizes = vec![Size::sphere(1.0, 1.0); grains.len()];
        grains = grains.graded(sizes);
    }
    let walls = Walls::at_rest([low, high, low, high, low, high]);
    Scene::within(laws, grains, walls, surroundings)
}

/// A membrane around the lattice that touches all outer grains and is held in place, of triangles a grain wide.
fn membrane(spacing: f64) -> Casing {
    let middle = 0.5 * spacing * (ACROSS - 1) as f64;
    let side = 2.0 * (middle + 0.99);
    let cuboid = Cuboid {
        length: side,
        height: side,
        depth: side,
        edge_length: side / ACROSS as f64,
    };
    let sheet = Sheet {
        youngs_modulus: 1.0,
        thickness: 0.1,
        density: 1.0,
        damping_ratio: 0.1,
        bending: None,
    };
    let mesh = cuboid.mesh().expect("a cube");
    let vertices: Vec<u32> = (0..mesh.positions().len() as u32).collect();
    let mut membrane = Membrane::new(mesh, &sheet).expect("a sheet");
    for position in membrane.positions_mut() {
        *position = position.map(|x| x + middle);
    }
    membrane.hold(&vertices, [true; 3]);
    let grip = Grip {
        material: Material::new(0.49, 0.23, 2f64.powf(1.5)),
        tangential: mindlin(),
        areal_density: 0.1,
    };
    Casing::new(membrane, grip, Press::default())
}

fn spheres() -> (Body, f64) {
    (Body::sphere(), 1.99)
}

/// Tetrahedra, spaced so that each touches its six neighbors with four pairs of spheres, whose centers are askew by `wide`.
fn tetrahedra() -> (Body, f64) {
    let body = Body::tetrahedron(0.6);
    let farthest = body.arms.iter().map(|arm| arm[0]).fold(0.0, f64::max);
    let nearest = body.arms.iter().map(|arm| arm[0]).fold(0.0, f64::min);
    let wide = farthest - nearest;
    let spacing = wide + (1.99f64.powi(2) - wide * wide).sqrt();
    (body, spacing)
}

fn mindlin() -> Mindlin {
    let solid = Elastic {
        youngs_modulus: 1.0,
        poisson_ratio: 0.49,
    };
    Mindlin::new(solid.against(solid), TangentialStiffness::Paper, 1.0, 0.3)
}

/// A scene that can be timed.
struct Timed {
    name: &'static str,
    grains: usize,
    contacts: usize,
    bytes_per_grain: usize,
    bytes_per_contact: usize,
    /// Times a step \[ns\].
    time: Box<dyn FnMut() -> f64>,
    times: Vec<f64>,
}

fn timed<R: Replicas + 'static, P: Physics>(name: &'static str, mut scene: Scene<R, P>) -> Timed {
    scene.step();
    let contacts = scene.touching();
    Timed {
        name,
        grains: scene.grains.len(),
        contacts,
        bytes_per_grain: scene.bytes_per_grain(),
        bytes_per_contact: Scene::<R, P>::bytes_per_candidate() + scene.slice_bytes() / contacts,
        time: Box::new(move || {
            let start = Instant::now();
            for _ in 0..STEPS {
                scene.step();
            }
            start.elapsed().as_secs_f64() * 1e9 / f64::from(STEPS)
        }),
        times: vec![],
    }
}

fn scenes<R: Replicas + 'static>() -> Vec<Timed> {
    let drag = AffineDrag { rate: 0.01 };
    vec![
        timed(
            "smooth spheres",
            lattice::<R, Sphere, _, _>(spheres(), Frictionless, (), false),
        ),
        timed(
            "+ friction (law H)",
            lattice::<R, Sphere, _, _>(spheres(), HOOKE, (), false),
        ),
        timed(
            "+ friction (Mindlin's spring)",
            lattice::<R, Sphere, _, _>(spheres(), mindlin(), (), false),
        ),
        timed(
            "+ friction (Mindlin's spring), sizes",
            lattice::<R, GradedSphere, _, _>(spheres(), mindlin(), (), false),
        ),
        timed(
            "+ drag",
            lattice::<R, Sphere, _, _>(spheres(), Frictionless, drag, false),
        ),
        timed(
            "+ walls that touch",
            lattice::<R, Sphere, _, _>(spheres(), Frictionless, (), true),
        ),
        timed(
            "smooth tetrahedra (orientation)",
            lattice::<R, Tetrahedron, _, _>(tetrahedra(), Frictionless, (), false),
        ),
        timed(
            "+ friction (law H)",
            lattice::<R, Tetrahedron, _, _>(tetrahedra(), HOOKE, (), false),
        ),
        timed(
            "+ friction (law M1)",
            lattice::<R, Tetrahedron, _, _>(tetrahedra(), RESCALED, (), false),
        ),
        timed(
            "+ friction (law M2, Q = 100)",
            lattice::<R, Tetrahedron, _, _>(tetrahedra(), SLICED, (), false),
        ),
    ]
}

fn median(times: &mut [f64]) -> f64 {
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}

/// Grains in a membrane, which run alone, and the same without.
fn encased() -> Vec<Timed> {
    let casing = membrane(spheres().1);
    let mesh = casing.membrane.mesh();
    let (vertices, triangles) = (mesh.positions().len(), mesh.triangles().len());
    let scene = within::<F64x1, Encased<_, ()>>(spheres(), (mindlin(), ()), false, casing);
    let mut touched = scene.clone();
    touched.step();
    println!(
        "\nA membrane of {vertices} vertices and {triangles} triangles, {} grains touch it",
        touched.surroundings.held().count()
    );
    vec![
        timed(
            "spheres of different sizes, friction (Mindlin's spring)",
            lattice::<F64x1, GradedSphere, _, _>(spheres(), mindlin(), (), false),
        ),
        timed("+ a membrane that they touch", scene),
    ]
}

fn compare(lanes: &str, mut scenes: Vec<Timed>) {
    for _ in 0..ROUNDS {
        for scene in &mut scenes {
            let time = (scene.time)();
            scene.times.push(time);
        }
    }
    println!("\n{lanes}, {} grains\n", ACROSS * ACROSS * ACROSS);
    println!(
        "| scene | bytes per grain | bytes per contact | contacts | µs a step | ns per contact |"
    );
    println!("|---|---|---|---|---|---|");
    for scene in &mut scenes {
        let time = median(&mut scene.times);
        println!(
            "| {} | {} | {} | {} | {:.1} | {:.1} |",
            scene.name,
            scene.bytes_per_grain,
            scene.bytes_per_contact,
            scene.contacts,
            time / 1e3,
            time / scene.contacts as f64
        );
        assert_eq!(scene.grains, ACROSS * ACROSS * ACROSS);
    }
}

/// What the guard looks at: everything every hundred steps, and the critical time step at both ends of a ramp.
fn guard<R: Replicas>(lanes: &str) {
    let mut scene = lattice::<R, Tetrahedron, _, _>(tetrahedra(), HOOKE, (), true);
    let mut times = [vec![], vec![], vec![]];
    let micro = |start: Instant| start.elapsed().as_secs_f64() * 1e6;
    for _ in 0..ROUNDS {
        let start = Instant::now();
        for _ in 0..STEPS {
            scene.step();
        }
        times[0].push(micro(start) / f64::from(STEPS));
        let start = Instant::now();
        std::hint::black_box(observe(&scene));
        times[1].push(micro(start));
        let across = Across {
            stiffness: HOOKE.stiffness,
            damping: HOOKE.damping,
            ..Across::default()
        };
        let start = Instant::now();
        std::hint::black_box(critical_time_step(&scene, 0, across));
        times[2].push(micro(start));
    }
    let [step, look, critical] = times.map(|mut times| median(&mut times));
    println!(
        "guard, {lanes}: a step {step:.0} µs; a look {look:.0} µs, {:.2} % of 100 steps; a critical time step {critical:.0} µs, \
         {:.2} % of a ramp of 12,000 steps for each replica",
        look / step,
        100.0 * critical / (12_000.0 * step)
    );
}

fn main() {
    compare("a lone run", scenes::<F64x1>());
    compare("eight replicas in f64", scenes::<F64x8>());
    compare("sixteen replicas in f32", scenes::<F32x16>());
    compare("in a membrane", encased());
    println!();
    guard::<F64x1>("a lone run");
    guard::<F64x8>("eight replicas in f64");
    guard::<F32x16>("sixteen replicas in f32");
}
