//! Sheets in equilibrium: uniaxial stretch, spheres and tubes under pressure, a strip that hangs; supports and resets.

use super::shapes::{SHEET, icosphere, relax, strip, tube};
use super::*;

/// Δp of inflated bodies \[Pa\].
const PRESSURE: f64 = 300.0;
/// a \[m\].
const EDGE: f64 = 4.7e-3;
/// E t \[N/m\].
const MODULUS: f64 = 3000.0;
/// Edges in a row of a strip, and strips between rows.
const EDGES: u32 = 10;
const ROWS: u32 = 8;

/// Vertex `i` of each row.
fn column(i: u32) -> Vec<u32> {
    (0..=ROWS).map(|row| row * (EDGES + 1) + i).collect()
}

/// All vertices of one row.
fn row(row: u32) -> Vec<u32> {
    (0..=EDGES).map(|i| row * (EDGES + 1) + i).collect()
}

/// How far two sets of vertices are apart along `axis`, on average \[m\].
fn gap(membrane: &Membrane, sets: [&[u32]; 2], axis: usize) -> f64 {
    let mean = |set: &[u32]| {
        let sum: f64 = set
            .iter()
            .map(|&vertex| membrane.mesh().positions()[vertex as usize][axis])
            .sum();
        sum / set.len() as f64
    };
    mean(sets[1]) - mean(sets[0])
}

/// Secant modulus over E, and the ratio of lateral to axial strain, of a strip stretched along a bond row (axis 0) or
/// perpendicular to it (axis 1).
///
/// The ends are held along the load only, so the sheet is uniform.
fn uniaxial(axis: usize, stretch: f64) -> (f64, f64) {
    let pairs = [[column(0), column(EDGES)], [row(0), row(ROWS)]];
    let [ends, sides] = [axis, 1 - axis].map(|k| pairs[k].each_ref().map(Vec::as_slice));
    let mut membrane = Membrane::new(strip(EDGES, ROWS, EDGE), &SHEET).unwrap();
    let width = gap(&membrane, sides, 1 - axis);
    for place in membrane.positions_mut() {
        place[axis] *= stretch;
    }
    let held = [axis == 0, axis == 1, false];
    membrane.hold(ends[0], held);
    membrane.hold(ends[1], held);
    let expected = MODULUS * (stretch - 1.0) * EDGE;
    relax(&mut membrane, 5e3, 1e-9 * expected, |_| {});
    let stress = membrane.reaction(ends[1])[axis] / width;
    let lateral = gap(&membrane, sides, 1 - axis) / width - 1.0;
    let strain = stretch - 1.0;
    (stress / strain / MODULUS, -lateral / strain)
}

/// M1, small strain.
#[test]
fn stretched_strip_has_the_modulus_of_the_material_in_both_orientations() {
    for axis in 0..2 {
        let (modulus, poisson) = uniaxial(axis, 1.0 + 1e-3);
        println!("M1 axis {axis}: E {modulus:.6}, ν {poisson:.5}");
        assert!((modulus - 1.0).abs() < 1e-3, "{modulus}");
        assert!((poisson - 0.333).abs() < 0.002, "{poisson}");
    }
}

/// M1, finite strain: secant modulus over E and ν of a lattice of linear springs.
///
/// Along a bond row the slanted springs carry nothing and keep their length: ν = (1 − √((4 − λ²)/3))/(λ − 1).
#[test]
fn stretched_strip_follows_the_finite_strain_of_linear_springs() {
    const TABLE: [(usize, f64, f64, f64); 8] = [
        (0, 1.01, 1.0, 0.3356),
        (0, 1.05, 1.0, 0.3446),
        (0, 1.1, 1.0, 0.3563),
        (0, 1.2, 1.0, 0.3812),
        (1, 1.01, 1.0066, 0.3311),
        (1, 1.05, 1.0319, 0.3223),
        (1, 1.1, 1.061, 0.3115),
        (1, 1.2, 1.1118, 0.2909),
    ];
    for (axis, stretch, modulus, poisson) in TABLE {
        let (found_modulus, found_poisson) = uniaxial(axis, stretch);
        println!("M1 axis {axis}, λ {stretch}: E {found_modulus:.5}, ν {found_poisson:.5}");
        assert!((found_modulus / modulus - 1.0).abs() < 2e-3);
        assert!((found_poisson / poisson - 1.0).abs() < 2e-3);
    }
}

/// M2: ε = Δp R (1 − ν)/(2 E t), tension Δp R/2.
#[test]
fn inflated_sphere_has_the_strain_and_tension_of_a_thin_shell() {
    const RADIUS: f64 = 0.02;
    let pressure = 1e3;
    let mut membrane = Membrane::new(icosphere(3, RADIUS), &SHEET).unwrap();
    let tolerance = 1e-9 * pressure * membrane.mesh().area() / 642.0;
    relax(&mut membrane, 1e3, tolerance, |membrane| {
        membrane.add_pressure::<F64x8>(-pressure);
    });
    let places = membrane.mesh().positions();
    let radius = places.iter().map(|&x| plain::norm(x)).sum::<f64>() / 642.0;
    let strain = radius / RADIUS - 1.0;
    let expected = pressure * RADIUS * (1.0 - POISSON_RATIO) / (2.0 * MODULUS);
    // A sheet under isotropic tension T stores Σ F ℓ = 2 T A.
    let pull = membrane.springs().tensions(membrane.mesh());
    let pull = pull
        .zip(membrane.mesh().edge_lengths())
        .map(|(force, length)| force * length);
    let tension = pull.sum::<f64>() / (2.0 * membrane.mesh().area());
    println!(
        "M2: ε {strain:.4e} ({:.4} of the shell's), T {tension:.4} N/m ({:.4})",
        strain / expected,
        tension / (0.5 * pressure * radius)
    );
    assert!((strain / expected - 1.0).abs() < 0.03, "{strain}");
    assert!((tension / (0.5 * pressure * radius) - 1.0).abs() < 0.03);
}

/// M3: hoop strain Δp R/(E t), axial strain −ν of it.
#[test]
fn inflated_tube_with_free_ends_has_the_hoop_strain_of_a_thin_shell() {
    const RADIUS: f64 = 0.02;
    let (edges, rings) = (48, 24);
    let mut membrane = Membrane::new(tube(edges, rings, RADIUS), &SHEET).unwrap();
    let ring = |n: u32| (n * edges..(n + 1) * edges).collect::<Vec<u32>>();
    let (low, high) = (ring(rings / 4), ring(3 * rings / 4));
    let length = gap(&membrane, [&low, &high], 2);
    let area = membrane.mesh().area() / membrane.masses().len() as f64;
    relax(&mut membrane, 1e3, 1e-9 * PRESSURE * area, |membrane| {
        membrane.add_pressure::<F64x8>(-PRESSURE);
    });
    let radius: f64 = ring(rings / 2)
        .iter()
        .map(|&vertex| membrane.mesh().positions()[vertex as usize])
        .map(|[x, y, _]| (x * x + y * y).sqrt())
        .sum::<f64>()
        / f64::from(edges);
    let hoop = radius / RADIUS - 1.0;
    let axial = gap(&membrane, [&low, &high], 2) / length - 1.0;
    let expected = PRESSURE * RADIUS / MODULUS;
    println!(
        "M3: hoop strain {hoop:.4e} ({:.4} of the shell's), axial/hoop {:.4}",
        hoop / expected,
        axial / hoop
    );
    assert!((hoop / expected - 1.0).abs() < 0.02, "{hoop}");
    assert!((axial / hoop + POISSON_RATIO).abs() < 0.02, "{axial}");
}

/// M4: the tip of a strip of length L sinks by ρ g L²/2E = 39.2 µm, and its upper end carries its weight.
#[test]
fn hanging_strip_stretches_under_its_weight() {
    const GRAVITY: f64 = 9.81;
    const LENGTH: f64 = 0.2;
    let (edges, rows) = (4, 40);
    let edge_length = LENGTH / (0.75f64.sqrt() * f64::from(rows));
    let mut membrane = Membrane::new(strip(edges, rows, edge_length), &SHEET).unwrap();
    let [top, tip] = [0, rows].map(|row| {
        (0..=edges)
            .map(|i| row * (edges + 1) + i)
            .collect::<Vec<u32>>()
    });
    membrane.hold(&top, [false, true, false]);
    let before = gap(&membrane, [&top, &tip], 1);
    let weight = 0.6 * membrane.mesh().area() * GRAVITY;
    relax(&mut membrane, 1e3, 1e-9 * weight, |membrane| {
        let masses = membrane.masses().to_vec();
        for (force, mass) in membrane.forces_mut().iter_mut().zip(masses) {
            force[1] += mass * GRAVITY;
        }
    });
    let sunk = gap(&membrane, [&top, &tip], 1) - before;
    let expected = 2000.0 * GRAVITY * LENGTH * LENGTH / 2e7;
    println!("M4: {:.3} µm, {:.5}", 1e6 * sunk, sunk / expected);
    assert!((sunk / expected - 1.0).abs() < 0.01, "{sunk}");
    let reaction = membrane.reaction(&top)[1];
    assert!((reaction / weight + 1.0).abs() < 1e-6, "{reaction}");
}

#[test]
#[expect(clippy::float_cmp, reason = "nothing is rounded")]
fn rollers_let_vertices_go_along_the_axis_that_is_free() {
    let mut membrane = Membrane::new(strip(EDGES, ROWS, EDGE), &SHEET).unwrap();
    membrane.hold(&[0], [false, true, true]);
    membrane.hold(&[1], [true; 3]);
    let start = membrane.mesh().positions().to_vec();
    let push = |membrane: &mut Membrane| {
        membrane.begin_step();
        membrane.forces_mut()[..3].fill([1.0, 2.0, 3.0]);
        membrane.advance(1e-5)
    };
    let speed = push(&mut membrane);
    let mass = membrane.masses()[2];
    assert!((speed - 1e-5 * 14f64.sqrt() / mass).abs() < 1e-12 * speed);
    let [roller, pin] = [0, 1].map(|i| plain::sub(membrane.mesh().positions()[i], start[i]));
    assert!(roller[0] > 0.0 && roller[1] == 0.0 && roller[2] == 0.0);
    assert_eq!(pin, [0.0; 3]);
    assert_eq!(membrane.reaction(&[0]), [0.0, -2.0, -3.0]);
    assert_eq!(membrane.reaction(&[0, 1, 2]), [-1.0, -4.0, -6.0]);
    membrane.release(&[1]);
    push(&mut membrane);
    assert!(membrane.velocities()[1][2] > 0.0);
}

#[test]
fn speed_that_is_not_a_number_is_told() {
    let mut membrane = Membrane::new(strip(2, 2, EDGE), &SHEET).unwrap();
    membrane.forces_mut()[3][1] = f64::NAN;
    assert!(membrane.advance(1e-5).is_nan());
}

#[test]
#[expect(clippy::float_cmp, reason = "the same lengths twice")]
fn sheet_that_is_reset_is_free_of_stress() {
    let bending = Some(Bending {
        stiffness: 1e-3,
        damping: 0.0,
    });
    let sheet = Sheet { bending, ..SHEET };
    let mut membrane = Membrane::new(icosphere(1, 0.02), &sheet).unwrap();
    for place in membrane.positions_mut() {
        *place = [0.5 * place[0], 0.2 * place[1], place[2]];
    }
    assert!(membrane.elastic_energy() > 0.0);
    let normals: Vec<_> = membrane.mesh().normals().collect();
    assert!(!membrane.findings([&normals, &normals]).is_empty());
    membrane.reset_rest();
    assert_eq!(membrane.elastic_energy(), 0.0);
    membrane.begin_step();
    membrane.add_internal_forces::<F64x8>();
    assert!(membrane.forces().iter().all(|force| force == &[0.0; 3]));
    assert_eq!(membrane.findings([&normals, &normals]), []);
}

#[test]
fn sheets_without_meaning_are_refused_by_name() {
    let refused = |sheet: Sheet| Membrane::new(strip(2, 2, EDGE), &sheet).unwrap_err();
    let thin = refused(Sheet {
        thickness: 0.0,
        ..SHEET
    });
    assert_eq!(
        thin.to_string(),
        "thickness = 0: must be positive and finite"
    );
    let soft = refused(Sheet {
        youngs_modulus: f64::NAN,
        ..SHEET
    });
    assert_eq!(soft.name, "youngs_modulus");
    let stiffness = -1.0;
    let bending = Some(Bending {
        stiffness,
        damping: 0.0,
    });
    assert_eq!(
        refused(Sheet { bending, ..SHEET }).name,
        "bending.stiffness"
    );
}

/// B2: the tube around the beam, bent as a solid would bend it: a share E t (6/h + 2/d) of E_b.
///
/// Pure bending by a curvature κ strains along x by κ z and across by −ν κ z, everywhere. The ends are strained across as well,
/// (1 + ν)/(1 − ν²) ν² 2/L of what the sides store along, at most 1 %; edges that are not quite equilateral add another.
#[test]
fn tube_is_a_beam_of_its_faces() {
    let (length, height, depth) = (0.4, 0.04, 0.08);
    let cuboid = Cuboid {
        length,
        height,
        depth,
        edge_length: EDGE,
    };
    let mut membrane = Membrane::new(cuboid.mesh().expect("a cuboid"), &SHEET).unwrap();
    let (curvature, poisson) = (1e-3, POISSON_RATIO);
    for place in membrane.positions_mut() {
        let [x, y, z] = *place;
        let drop = 0.5 * curvature * (x * x + poisson * (z * z - y * y));
        *place = [
            x + curvature * x * z,
            y - poisson * curvature * y * z,
            z - drop,
        ];
    }
    let moment_of_area = depth * height * height * height / 12.0;
    let stored = membrane.elastic_energy();
    let share = 2.0 * stored / (curvature * curvature * length * moment_of_area);
    let expected = MODULUS * (6.0 / height + 2.0 / depth);
    println!("B2: {share:.4e} Pa, should be {expected:.4e} Pa");
    assert!((share / expected - 1.0).abs() < 0.02, "{share}");
}
