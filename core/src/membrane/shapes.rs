//! Meshes whose equilibria are known, and how a sheet comes to rest; for tests only.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use proptest::test_runner::{Config, RngSeed};

use super::mesh::{Mesh, unit};
use super::{Membrane, Sheet};
use crate::lanes::F64x8;
use crate::math::plain;

/// The same cases of a property at every run: what fails here fails everywhere.
pub(super) fn cases(cases: u32) -> Config {
    Config {
        cases,
        failure_persistence: None,
        rng_seed: RngSeed::Fixed(1),
        ..Config::default()
    }
}

/// The sheet of the paper: 10 MPa, 0.3 mm, 2000 kg/m³, 15 % of critical damping.
pub(super) const SHEET: Sheet = Sheet {
    youngs_modulus: 1e7,
    thickness: 0.3e-3,
    density: 2000.0,
    damping_ratio: 0.15,
    bending: None,
};

/// A flat lattice in the plane z = 0: `rows` + 1 bond rows along x of `edges` edges, the first at y = 0.
///
/// Every second row is shifted by half an edge, so the ends of the rows are a zigzag of whole triangles.
pub(super) fn strip(edges: u32, rows: u32, edge_length: f64) -> Mesh {
    let place = |row: u32, i: u32| {
        let x = f64::from(i) + 0.5 * f64::from(row % 2);
        [x, 0.75f64.sqrt() * f64::from(row), 0.0].map(|part| part * edge_length)
    };
    let positions = (0..=rows)
        .flat_map(|row| (0..=edges).map(move |i| place(row, i)))
        .collect();
    let mut triangles = vec![];
    for row in 0..rows {
        for i in 0..edges {
            triangles.extend(cell(i, i + 1, [row, row + 1].map(|r| r * (edges + 1)), row));
        }
    }
    Mesh::new(positions, triangles).expect("a strip is a mesh")
}

/// A tube about the z axis: `rings` + 1 bond rings of `edges` edges, the first at z = 0, normals outward.
pub(super) fn tube(edges: u32, rings: u32, radius: f64) -> Mesh {
    let half = 0.5 * TAU / f64::from(edges);
    // Edges of a ring are chords; those between rings are as long.
    let chord = 2.0 * radius * libm::sin(half);
    let sagitta = radius * (1.0 - libm::cos(half));
    let rise = (0.75 * chord * chord - sagitta * sagitta).sqrt();
    let place = |ring: u32, i: u32| {
        let angle = half * f64::from(2 * i + ring % 2);
        let (x, y) = (radius * libm::cos(angle), radius * libm::sin(angle));
        [x, y, rise * f64::from(ring)]
    };
    let positions = (0..=rings)
        .flat_map(|ring| (0..edges).map(move |i| place(ring, i)))
        .collect();
    let mut triangles = vec![];
    for ring in 0..rings {
        for i in 0..edges {
            let starts = [ring, ring + 1].map(|r| r * edges);
            triangles.extend(cell(i, (i + 1) % edges, starts, ring));
        }
    }
    Mesh::new(positions, triangles).expect("a tube is a mesh")
}

/// The two triangles between vertices `i` and `next` of two rows that start at `starts`, the second or the first shifted.
fn cell(i: u32, next: u32, [low, high]: [u32; 2], row: u32) -> [[u32; 3]; 2] {
    if row.is_multiple_of(2) {
        [
            [low + i, low + next, high + i],
            [low + next, high + next, high + i],
        ]
    } else {
        [
            [low + i, low + next, high + next],
            [low + i, high + next, high + i],
        ]
    }
}

/// An icosahedron whose faces are cut in four `levels` times, all vertices on the sphere: 10 · 4^levels + 2 of them.
pub(super) fn icosphere(levels: u32, radius: f64) -> Mesh {
    let (mut positions, mut triangles) = icosahedron();
    for _ in 0..levels {
        let mut middles = BTreeMap::new();
        let mut middle = |i: u32, j: u32| {
            *middles.entry([i.min(j), i.max(j)]).or_insert_with(|| {
                let sum = plain::add(positions[i as usize], positions[j as usize]);
                positions.push(unit(sum));
                positions.len() as u32 - 1
            })
        };
        let mut finer = vec![];
        for [a, b, c] in triangles {
            let [ab, bc, ca] = [middle(a, b), middle(b, c), middle(c, a)];
            finer.extend([[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]);
        }
        triangles = finer;
    }
    let positions = positions.iter().map(|&x| plain::scale(x, radius)).collect();
    Mesh::new(positions, triangles).expect("a sphere is a mesh")
}

fn icosahedron() -> (Vec<[f64; 3]>, Vec<[u32; 3]>) {
    let golden = 0.5 * (1.0 + 5.0f64.sqrt());
    let mut corners = vec![];
    for axis in 0..3 {
        for (a, b) in [
            (1.0, golden),
            (-1.0, golden),
            (1.0, -golden),
            (-1.0, -golden),
        ] {
            let mut corner = [0.0; 3];
            corner[axis] = a;
            corner[(axis + 1) % 3] = b;
            corners.push(corner);
        }
    }
    let near = |i: u32, j: u32| {
        let gap = plain::sub(corners[i as usize], corners[j as usize]);
        (plain::norm(gap) - 2.0).abs() < 1e-9
    };
    let mut faces = vec![];
    for i in 0..12 {
        for j in i + 1..12 {
            for k in (j + 1..12).filter(|&k| near(i, j) && near(j, k) && near(k, i)) {
                let [a, b, c] = [i, j, k].map(|n| corners[n as usize]);
                let outward = plain::dot(a, plain::cross(b, c)) > 0.0;
                faces.push(if outward { [i, j, k] } else { [i, k, j] });
            }
        }
    }
    let corners = corners.into_iter().map(unit).collect();
    (corners, faces)
}

/// Adds the sheet's own forces and `load` and moves it, with a drag of `rate` \[1/s\], until no free vertex feels more than
/// `tolerance` \[N\].
///
/// The forces are those of the last step, without drag.
pub(super) fn relax(
    membrane: &mut Membrane,
    rate: f64,
    tolerance: f64,
    load: impl Fn(&mut Membrane),
) {
    let time_step = 0.8 * membrane.critical_time_step(&[]);
    for _ in 0..200_000 {
        membrane.begin_step();
        membrane.add_internal_forces::<F64x8>();
        load(membrane);
        if largest_free_force(membrane) < tolerance {
            return;
        }
        let drag: Vec<_> = membrane
            .velocities()
            .iter()
            .zip(membrane.masses())
            .map(|(&velocity, mass)| plain::scale(velocity, -rate * mass))
            .collect();
        for (force, drag) in membrane.forces_mut().iter_mut().zip(drag) {
            *force = plain::add(*force, drag);
        }
        membrane.advance(time_step);
    }
    panic!("the sheet does not come to rest");
}

/// The largest force along an axis that is free \[N\].
fn largest_free_force(membrane: &Membrane) -> f64 {
    let mobilities = membrane.mobilities.as_flattened().iter();
    mobilities
        .zip(membrane.forces.as_flattened())
        .filter(|(mobility, _)| **mobility > 0.0)
        .map(|(_, force)| force.abs())
        .fold(0.0, f64::max)
}
