//! M8, M9 and M10 of the membrane's checks, and what a casing keeps.

use super::patch::Sphere;
use super::touch::{Ball, Finder};
use super::*;
use crate::contact::frictionless::Frictionless;
use crate::contact::mindlin::TangentialStiffness;
use crate::grains::{Motion, Pose, Size, UPRIGHT};
use crate::lanes::VectorWidth;
use crate::material::Elastic;
use crate::math::Vec3;
use crate::membrane::{Mesh, Sheet as Skin};
use crate::scene::{Encased, Laws, Scene};
use crate::shape::Body;
use crate::wall::Walls;
use proptest::prelude::*;
use std::collections::BTreeMap;

/// Edge length of the patches \[m\].
const EDGE: f64 = 4.7e-3;
const RADIUS: f64 = 2.35e-3;
const GRAIN: Elastic = Elastic {
    youngs_modulus: 1e8,
    poisson_ratio: 0.245,
};
const SKIN: Skin = Skin {
    youngs_modulus: 1e7,
    thickness: 3e-4,
    density: 2000.0,
    damping_ratio: 0.15,
    bending: None,
};

/// A patch of equilateral triangles about the origin, its outside below, folded up by `fold` along the line x = 0.
///
/// Rows run along y, so that the fold is a line of edges.
fn patch(fold: f64) -> Mesh {
    let (rows, columns) = (8i32, 8i32);
    let height = 0.75f64.sqrt() * EDGE;
    let mut places = vec![];
    for i in -rows..=rows {
        for j in -columns..=columns {
            let y = (f64::from(j) + 0.5 * f64::from(i.rem_euclid(2))) * EDGE;
            let x = f64::from(i) * height;
            let (sin, cos) = (libm::sin(0.5 * fold), libm::cos(0.5 * fold));
            places.push([x * cos, y, x.abs() * sin]);
        }
    }
    let at = |i: i32, j: i32| ((i + rows) * (2 * columns + 1) + j + columns) as u32;
    let mut triangles = vec![];
    for i in -rows..rows {
        for j in -columns..columns {
            let (a, b, c, d) = (at(i, j), at(i, j + 1), at(i + 1, j), at(i + 1, j + 1));
            // Counterclockwise seen from below.
            if i.rem_euclid(2) == 0 {
                triangles.extend([[a, b, c], [b, d, c]]);
            } else {
                triangles.extend([[a, b, d], [a, d, c]]);
            }
        }
    }
    Mesh::new(places, triangles).expect("a patch")
}

/// Where a grain that did or did not touch before touches `mesh`, whichever triangles it is near.
fn find_after(mesh: &Mesh, center: [f64; 3], radius: f64, touched: bool) -> Finder {
    let [x, y, z] = center;
    let mut membrane = Membrane::new(mesh.clone(), &SKIN).expect("a sheet");
    membrane.note::<F64x8>();
    let sheet = Sheet {
        faces: membrane.faces(),
        balls: &[[x, y, z, radius]],
    };
    let all: Vec<[u32; 2]> = (0..mesh.triangles().len() as u32).map(|t| [0, t]).collect();
    let (mut reaches, mut finder) = (vec![], Finder::default());
    reach::find::<F64x8>(sheet, &all, &mut reaches);
    let before = |triangle| Held {
        grain: 0,
        triangle,
        spring: [0.0; 3],
        normal_force: 0.0,
        tangential_force: 0.0,
        overlap: 0.0,
    };
    let held: Vec<Held> = (0..mesh.triangles().len() as u32).map(before).collect();
    let ball = Ball {
        grain: 0,
        sphere: Sphere { center, radius },
        held: if touched { &held } else { &[] },
    };
    finder.add(mesh, sheet, &ball, &reaches);
    finder
}

fn find(mesh: &Mesh, center: [f64; 3], radius: f64) -> Finder {
    find_after(mesh, center, radius, true)
}

/// Σ of the contacts' forces over k √R: p^(3/2) n̂ and what they have beside it.
fn pull(finder: &Finder) -> [f64; 3] {
    let along = finder.touches.iter().map(|touch| {
        let size = touch.overlap * touch.overlap.sqrt();
        plain::scale(touch.normal, size)
    });
    let beside = finder.surpluses.iter();
    let beside = beside.map(|surplus| plain::scale(surplus.force, 1.0 / RADIUS.sqrt()));
    along.chain(beside).fold([0.0; 3], plain::add)
}

#[test]
fn patch_faces_down() {
    for normal in patch(0.0).normals() {
        assert!((normal[2] + 1.0).abs() < 1e-12, "{normal:?}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    /// M8: a linear velocity field is exact at the contact point, so are the sum and the torque of the shared force.
    #[test]
    fn shares_of_a_contact_sum_to_one_at_the_contact_point(
        place in prop::array::uniform2(-3.0..3.0f64),
        depth in 0.01..0.6f64,
        fold in -1.2..1.2f64,
    ) {
        let mesh = patch(fold);
        let center = [place[0] * EDGE, place[1] * EDGE, (1.0 - depth) * RADIUS + place[0].abs() * EDGE * libm::tan(0.5 * fold)];
        let finder = find(&mesh, center, RADIUS);
        let mut from = 0;
        for touch in &finder.touches {
            let shares = &finder.shares[from..touch.shares_end];
            from = touch.shares_end;
            prop_assert!((shares.iter().map(|s| s.weight).sum::<f64>() - 1.0).abs() < 1e-12);
            let mean = shares.iter().fold([0.0; 3], |sum, share| {
                plain::add(sum, plain::scale(mesh.positions()[share.vertex as usize], share.weight))
            });
            let point = plain::add(center, touch.lever);
            prop_assert!(plain::norm(plain::sub(mean, point)) < 1e-12 * EDGE);
            // The lever lies along the normal: a normal force cannot turn a sphere.
            let turn = plain::norm(plain::cross(touch.lever, touch.normal));
            prop_assert!(turn < 1e-12 * RADIUS);
        }
    }
}

/// M9 on a flat patch: whatever triangles, edges and vertices the way crosses.
#[test]
fn flat_patch_is_one_contact_of_one_depth_wherever_a_grain_is() {
    let mesh = patch(0.0);
    let height = 0.9 * RADIUS;
    // Along a line of edges and vertices, across it, along the rows of vertices, and askew.
    let ways = [[0.0, 1.0], [1.0, 0.0], [0.75f64.sqrt(), 0.5], [0.8, 0.37]];
    for way in ways {
        for k in -1000..=1000 {
            let s = 3.0 * EDGE * f64::from(k) / 1000.0;
            let finder = find(&mesh, [s * way[0], s * way[1], height], RADIUS);
            assert_eq!(finder.touches.len(), 1, "{way:?} {s}");
            let touch = finder.touches[0];
            assert!((touch.overlap - 0.1 * RADIUS).abs() < 1e-12 * RADIUS);
            assert!((touch.normal[2] - 1.0).abs() < 1e-12);
        }
    }
}

/// M9 across a ridge (fold down) and a valley (fold up): the grain slides over the sheet at a steady depth below its ideal
/// height above the fold's middle.
#[test]
fn force_does_not_jump_across_a_fold() {
    for degrees in [1.0f64, 5.0, 20.0, 60.0] {
        for sign in [-1.0, 1.0] {
            let fold = sign * degrees.to_radians();
            let mesh = patch(fold);
            // Level: over a ridge the top is reached deepest, over a valley both faces are.
            let height = if sign < 0.0 {
                0.9 * RADIUS
            } else {
                0.9 * RADIUS / libm::cos(0.5 * fold)
            };
            let step = 1e-3 * EDGE;
            let single = (0.1 * RADIUS) * (0.1 * RADIUS).sqrt();
            let mut before: Option<[f64; 3]> = None;
            for k in -400..=400 {
                // A line that meets edges and vertices of the fold askew.
                let s = f64::from(k) * step;
                let finder = find(&mesh, [s, 0.3 * s + 1e-4, height], RADIUS);
                let pull = pull(&finder);
                let jump = before.map_or(0.0, |b| plain::norm(plain::sub(pull, b)));
                let deepest = finder.touches.iter().map(|t| t.overlap).fold(0.0, f64::max);
                let most = deepest * deepest.sqrt();
                assert!(
                    jump < 0.1 * single.max(most),
                    "{fold} {s}: {jump:e} of {single:e}"
                );
                assert!(plain::norm(pull) < 2.0 * most + 1e-30, "{fold} {s}");
                before = Some(pull);
            }
        }
    }
}

type Grained<T> = Scene<F64x1, Encased<T, ()>>;

/// One grain of `mass` times its own at `center` over `mesh`, everything at rest.
fn scene(mesh: Mesh, center: [f64; 3], (mass, friction): (f64, f64)) -> Grained<Mindlin> {
    let sheet = Elastic {
        youngs_modulus: SKIN.youngs_modulus,
        poisson_ratio: 1.0 / 3.0,
    };
    let law = |a: Elastic, b: Elastic| {
        Mindlin::new(a.against(b), TangentialStiffness::Paper, 0.3, friction)
    };
    let laws = Laws {
        body: Body::sphere(),
        material: Material::viscoelastic(GRAIN.against(GRAIN), 7e-6),
        tangential: law(GRAIN, GRAIN),
        body_force: (),
        time_step: 5e-6,
        dither: 0.0,
        skin: 2e-4,
        width: VectorWidth::widest(),
    };
    let size = Size::sphere(RADIUS, 2000.0);
    let size = Size {
        inverse_mass: size.inverse_mass / mass,
        inverse_inertia: size.inverse_inertia / mass,
        ..size
    };
    let pose = Pose {
        position: center,
        orientation: UPRIGHT,
    };
    let grains = Grains::at_rest(vec![pose], &laws.body, true).graded(vec![size]);
    let grip = Grip {
        material: Material::viscoelastic(GRAIN.against(sheet), 7e-6),
        tangential: law(GRAIN, sheet),
        areal_density: SKIN.density * SKIN.thickness,
    };
    let membrane = Membrane::new(mesh, &SKIN).expect("a sheet");
    let casing = Casing::new(membrane, grip, Press::default());
    let far = 1.0;
    let walls = Walls::at_rest([-far, far, -far, far, -far, far]);
    Scene::within(laws, grains, walls, casing)
}

fn all_vertices(scene: &Grained<Mindlin>) -> Vec<u32> {
    (0..scene.surroundings.membrane.masses().len() as u32).collect()
}

/// M9: the friction spring of a grain that is dragged over a held patch.
#[test]
fn spring_is_carried_across_edges_and_vertices() {
    let mut scene = scene(patch(0.0), [-2.0 * EDGE, 0.0, 0.97 * RADIUS], (1e16, 1e3));
    let all = all_vertices(&scene);
    scene.surroundings.membrane.hold(&all, [true; 3]);
    let velocity = [1.0, 0.0, 0.0];
    let spin = [0.0; 3];
    scene.grains.set_motion(0, 0, Motion { velocity, spin });
    let steps = 3000;
    for k in 1..=steps {
        scene.step();
        let held: Vec<Held> = scene.surroundings.held().copied().collect();
        assert_eq!(held.len(), 1, "step {k}");
        let expected = 5e-6 * f64::from(k);
        let spring = held[0].spring[0];
        assert!(
            (spring - expected).abs() < 1e-9 * expected,
            "step {k}: {spring} of {expected}, {:?}",
            held[0]
        );
        assert!(
            (held[0].overlap - 0.03 * RADIUS).abs() < 1e-9 * RADIUS,
            "step {k}"
        );
    }
    // Three edge lengths: about seven triangles.
    assert!(5e-6 * f64::from(steps) > 3.0 * EDGE);
}

#[test]
fn grain_and_membrane_keep_momentum_and_angular_momentum() {
    let mut scene = scene(patch(0.3), [1e-3, 2e-3, 1.02 * RADIUS], (1.0, 0.5));
    let motion = Motion {
        velocity: [0.3, -0.2, -0.4],
        spin: [100.0, 50.0, -80.0],
    };
    scene.grains.set_motion(0, 0, motion);
    let momenta = |scene: &Grained<Mindlin>| {
        let (size, motion) = (scene.grains.sizes()[0], scene.grains.motion(0, 0));
        let own = plain::scale(motion.velocity, 1.0 / size.inverse_mass);
        let place = scene.grains.pose(0, 0).position;
        let turning = plain::scale(motion.spin, 1.0 / size.inverse_inertia);
        let mut sums = [own, plain::add(turning, plain::cross(place, own))];
        let membrane = &scene.surroundings.membrane;
        let vertices = membrane
            .mesh()
            .positions()
            .iter()
            .zip(membrane.velocities());
        for ((&x, &v), &m) in vertices.zip(membrane.masses()) {
            let momentum = plain::scale(v, m);
            sums = [
                plain::add(sums[0], momentum),
                plain::add(sums[1], plain::cross(x, momentum)),
            ];
        }
        sums
    };
    let before = momenta(&scene);
    let mut touched = 0;
    for _ in 0..2000 {
        scene.step();
        touched += usize::from(scene.surroundings.held().next().is_some());
    }
    let after = momenta(&scene);
    assert!(touched > 50, "{touched}");
    for (n, what) in [(0, "momentum"), (1, "angular momentum")] {
        let lost = plain::norm(plain::sub(after[n], before[n]));
        assert!(lost < 1e-11 * plain::norm(before[n]), "{what}: {lost:e}");
    }
}

/// M10: pressure on a patch with a held border presses it against a grain that does not give.
#[test]
fn pressed_patch_comes_to_rest_on_a_grain() {
    // The sheet's outside is below: pressure from there pushes it up.
    let mut scene = scene(patch(0.0), [0.0, 0.0, 0.99 * RADIUS], (1e12, 0.5));
    let membrane = &mut scene.surroundings.membrane;
    let border: Vec<u32> = (0u32..)
        .zip(membrane.mesh().positions())
        .filter(|(_, x)| libm::hypot(x[0], x[1]) > 2.2 * EDGE)
        .map(|(vertex, _)| vertex)
        .collect();
    membrane.hold(&border, [true; 3]);
    scene.surroundings.press.pressure = 9e4;
    let mut energies = vec![];
    for _ in 0..10 {
        for _ in 0..4000 {
            scene.step();
        }
        energies.push(scene.surroundings.membrane.kinetic_energy());
    }
    assert!(energies[9] < 1e-6 * energies[0], "{energies:?}");
    let held: Vec<Held> = scene.surroundings.held().copied().collect();
    let force: f64 = held.iter().map(|h| h.normal_force).sum();
    assert!(force > 0.5, "{force}");
}

#[test]
fn grain_that_has_crossed_is_pushed_back_and_one_behind_the_sheet_is_not_touched() {
    // Center 0.1 R below the sheet: only a grain that touched before is held back.
    for (touched, overlap) in [(true, Some(1.1 * RADIUS)), (false, None)] {
        let center = [1e-4, 3e-4, -0.1 * RADIUS];
        let finder = find_after(&patch(0.0), center, RADIUS, touched);
        let found = finder.touches.first().map(|touch| touch.overlap);
        assert_eq!(found.is_some(), overlap.is_some());
        if let (Some(found), Some(overlap)) = (found, overlap) {
            assert!((found - overlap).abs() < 1e-12 * RADIUS);
            assert!((finder.touches[0].normal[2] - 1.0).abs() < 1e-12);
        }
    }
}

/// Behind a ridge, whose foot is on the side that both faces share, and behind one of its vertices.
#[test]
fn grain_that_has_crossed_at_a_side_or_corner_is_pushed_back() {
    let mesh = patch(-0.4);
    // Below the fold; the sheet's inside is above.
    for along in [0.5 * EDGE, 0.0] {
        for depth in [0.02, 0.1, 0.3] {
            let center = [0.0, along, -depth * RADIUS];
            let finder = find(&mesh, center, RADIUS);
            assert_eq!(finder.touches.len(), 1, "{along} {depth}");
            let touch = finder.touches[0];
            assert!(touch.overlap > RADIUS, "{along} {depth}: {touch:?}");
            assert!(pull(&finder)[2] > 0.0, "{along} {depth}");
        }
    }
}

#[test]
fn smooth_grains_in_a_casing_can_spin_but_keep_no_history() {
    use crate::scene::Physics;
    const { assert!(<Encased<Frictionless, ()> as Physics>::SPINS) }
    assert_eq!(crate::scene::history_components::<Frictionless>(), 0);
}

#[test]
fn fold_beside_a_grain_does_not_push_it_from_outside() {
    // The sheet is folded up by 150° along x = 0: to a grain on one flank, close to the fold, the other shows its outside.
    let mesh = patch(150f64.to_radians());
    let tilt = 75f64.to_radians();
    let along = [libm::cos(tilt), 0.0, libm::sin(tilt)];
    let inward = [-libm::sin(tilt), 0.0, libm::cos(tilt)];
    for distance in [0.5, 1.0, 2.0] {
        let foot = plain::scale(along, distance * RADIUS);
        // On the right flank's inner side the center is beyond the left flank.
        let center = plain::add(foot, plain::scale(inward, 0.9 * RADIUS));
        let finder = find(&mesh, center, RADIUS);
        for touch in &finder.touches {
            assert!(touch.overlap <= RADIUS, "{distance}: {touch:?}");
        }
    }
}

/// Distance of `point` from the convex hull of one, two or three points, by its definition: from all of them at once.
fn distance(mesh: &Mesh, corners: &[u32], point: [f64; 3]) -> f64 {
    let place = |n: usize| {
        Vec3::<F64x1>::splat(mesh.positions()[corners[n.min(corners.len() - 1)] as usize])
    };
    if let [a, b] = corners {
        let [a, b] = [a, b].map(|end| mesh.positions()[*end as usize]);
        let (along, to) = (plain::sub(b, a), plain::sub(point, a));
        let share = (plain::dot(along, to) / plain::dot(along, along)).clamp(0.0, 1.0);
        return plain::norm(plain::sub(to, plain::scale(along, share)));
    }
    if let [a] = corners {
        return plain::norm(plain::sub(point, mesh.positions()[*a as usize]));
    }
    let corners = [place(0), place(1), place(2)];
    let center = Vec3::<F64x1>::splat(point);
    let from = center - foot::foot(center, corners).on(corners);
    from.dot(from).0[0].sqrt()
}

/// U over k √R of a grain before all of a mesh, by inclusion and exclusion, without asking what it reaches.
fn energy(mesh: &Mesh, center: [f64; 3]) -> f64 {
    let of = |corners: &[u32]| {
        let overlap = (RADIUS - distance(mesh, corners, center)).max(0.0);
        0.4 * overlap * overlap * overlap.sqrt()
    };
    let triangles: f64 = mesh.triangles().iter().map(|corners| of(corners)).sum();
    let edges = mesh.edges().iter().zip(mesh.edge_triangles());
    let inner = edges.filter(|(_, both)| !both.contains(&None));
    let edges: f64 = inner.map(|(ends, _)| of(ends)).sum();
    // Far from the border, where every vertex counts.
    let vertices: f64 = (0..mesh.positions().len() as u32).map(|v| of(&[v])).sum();
    triangles - edges + vertices
}

/// The forces of a grain's contacts on the vertices over k √R.
fn pulls(finder: &Finder) -> BTreeMap<u32, [f64; 3]> {
    let mut forces = BTreeMap::<u32, [f64; 3]>::new();
    let mut add = |vertex: u32, force: [f64; 3]| {
        let sum = forces.entry(vertex).or_default();
        *sum = plain::sub(*sum, force);
    };
    let mut from = 0;
    for touch in &finder.touches {
        let push = plain::scale(touch.normal, touch.overlap * touch.overlap.sqrt());
        for share in &finder.shares[from..touch.shares_end] {
            add(share.vertex, plain::scale(push, share.weight));
        }
        from = touch.shares_end;
    }
    for pull in &finder.pulls {
        add(pull.vertex, plain::scale(pull.force, 1.0 / RADIUS.sqrt()));
    }
    forces
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(100))]

    /// Forces on grain and vertices are minus the gradient of one energy, however rumpled the sheet is.
    ///
    /// Central differences over h = 1e-5 R: the curvature of u is at most (3/2) √p over k √R and jumps where a term comes or
    /// goes, so they are wrong by at most h (3/2) √R for each of some ten terms: 1.5e-4 R^(3/2).
    #[test]
    fn forces_are_the_gradient_of_one_energy(
        offsets in prop::collection::vec(-1.0..1.0f64, 17 * 17 * 3),
        rumple in 0.0..0.15f64,
        place in prop::array::uniform2(-1.0..1.0f64),
        depth in 0.05..0.5f64,
    ) {
        let mut mesh = patch(0.0);
        let moved = mesh.positions_mut().as_flattened_mut().iter_mut().zip(&offsets);
        moved.for_each(|(x, offset)| *x += rumple * EDGE * offset);
        let center = [place[0] * EDGE, place[1] * EDGE, 0.0];
        // At that depth above the highest point.
        let height = |z: f64| distance_to_all(&mesh, [center[0], center[1], z]);
        let mut z = 2.0 * RADIUS;
        while height(z) > (1.0 - depth) * RADIUS {
            z -= 0.01 * RADIUS;
        }
        let center = [center[0], center[1], z];
        let finder = find(&mesh, center, RADIUS);
        let step = 1e-5 * RADIUS;
        let allowed = 1.5e-4 * RADIUS * RADIUS.sqrt();
        let force = pull(&finder);
        for axis in 0..3 {
            let [mut low, mut high] = [center; 2];
            (low[axis], high[axis]) = (low[axis] - step, high[axis] + step);
            let slope = (energy(&mesh, high) - energy(&mesh, low)) / (2.0 * step);
            prop_assert!((force[axis] + slope).abs() < allowed, "{axis}: {} {slope}", force[axis]);
        }
        for (vertex, force) in pulls(&finder) {
            for (axis, force) in force.into_iter().enumerate() {
                let mut at = |offset: f64| {
                    mesh.positions_mut()[vertex as usize][axis] += offset;
                    let energy = energy(&mesh, center);
                    mesh.positions_mut()[vertex as usize][axis] -= offset;
                    energy
                };
                let slope = (at(step) - at(-step)) / (2.0 * step);
                prop_assert!(
                    (force + slope).abs() < allowed,
                    "{vertex} {axis}: {} {slope}", force
                );
            }
        }
    }
}

/// Distance of `point` from the nearest triangle.
fn distance_to_all(mesh: &Mesh, point: [f64; 3]) -> f64 {
    let distances = mesh.triangles().iter().map(|t| distance(mesh, t, point));
    distances.fold(f64::INFINITY, f64::min)
}

/// A valley is one contact when it is shallow and two when it is deep, and everything between is between.
#[test]
fn valley_is_ever_more_two_contacts_the_deeper_it_is() {
    let mut before = 1.0;
    for degrees in 0..=90 {
        let fold = f64::from(degrees).to_radians();
        // Above the middle of the valley, 0.1 R deep in both faces.
        let center = [0.0, 1e-4, 0.9 * RADIUS / libm::cos(0.5 * fold)];
        let finder = find(&patch(fold), center, RADIUS);
        let single = 0.1 * RADIUS * (0.1 * RADIUS).sqrt();
        // Both faces push along the middle by cos(fold/2).
        let count = pull(&finder)[2] / (single * libm::cos(0.5 * fold));
        assert!(
            count > before - 1e-9 && count < 2.0 + 1e-9,
            "{degrees}: {count}"
        );
        assert_eq!(
            finder.touches.len(),
            if degrees < 52 { 1 } else { 2 },
            "{degrees}"
        );
        before = count;
    }
    assert!((before - 2.0).abs() < 1e-9);
}
