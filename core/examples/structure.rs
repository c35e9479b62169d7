//! Times every structural analysis on a pair of snapshots of a beam as large as the paper's: `structure`.
#![expect(
    clippy::print_stdout,
    clippy::disallowed_methods,
    reason = "an example that prints what it measures"
)]

use std::time::Instant;

use granary_core::beam::structure::{
    ContactForce, Packing, Snapshot, autocorrelation, bond_order, coordination, displacement,
    faces, force_network, neutral_plane, non_affine, pair_correlation, profile, voronoi,
};
use granary_core::random::{Purpose, uniform3};

#[expect(dead_code, reason = "tests use more of it")]
#[path = "../src/beam/structure/fixture.rs"]
mod fixture;

use fixture::{Beam, bent, box_membrane, indices};

/// The paper's beam: its number of grains, of triangles (10,764), and of d_p along each edge.
const GRAINS: usize = 11_744;
const SIZE: [f64; 3] = [81.0, 16.5, 7.5];

/// d_p \[m\].
const DIAMETER: f64 = 4.7e-3;

/// Grains in an fcc lattice, shaken by 0.2 d_p and packed to φ = 0.62, in a membrane as uneven as they are.
fn straight() -> Beam {
    let shaken = |n: u64, size: f64, at: [f64; 3]| {
        let shift = uniform3(1, Purpose::GasVelocity, n);
        std::array::from_fn(|k| at[k] + size * (shift[k] - 0.5))
    };
    let sites = indices([108, 22, 10]).filter(|at| (at[0] + at[1] + at[2]) % 2 == 0);
    let sites = sites
        .take(GRAINS)
        .map(|at| at.map(|k| 0.75 * (k as f64 + 0.5)));
    let positions = (0..).zip(sites).map(|(n, at)| shaken(n, 0.4, at));
    let mut beam = Beam::of(box_membrane([0.0; 3], SIZE, [90, 19, 9]), positions, 0.5);
    for (n, radius) in (0..).zip(&mut beam.radii) {
        *radius *= DIAMETER * (0.95 + 0.1 * uniform3(2, Purpose::GasOrientation, n)[0]);
    }
    for (n, vertex) in (100_000..).zip(&mut beam.vertices) {
        *vertex = shaken(n, 0.3, *vertex);
    }
    beam
}

/// The beam bent by `angle`, each grain moved by `stray` d_p, with a contact between those that overlap.
fn bend(beam: &Beam, angle: f64, stray: f64) -> Beam {
    let mut bent = beam.moved(|at| bent(at, SIZE[0], SIZE[2], angle).map(|x| DIAMETER * x));
    for (n, position) in (0..).zip(&mut bent.positions) {
        let shift = uniform3(3, Purpose::GasVelocity, n);
        *position = std::array::from_fn(|k| position[k] + stray * DIAMETER * (shift[k] - 0.5));
    }
    for (i, at) in bent.positions.iter().enumerate() {
        for (j, other) in bent.positions[..i].iter().enumerate() {
            let square: f64 = (0..3)
                .map(|k| (at[k] - other[k]) * (at[k] - other[k]))
                .sum();
            let reach = bent.radii[i] + bent.radii[j];
            if square < reach * reach {
                let normal_force = reach - square.sqrt();
                bent.contacts.push(ContactForce {
                    i,
                    j,
                    normal_force,
                    tangential_force: 0.1 * normal_force,
                });
            }
        }
    }
    bent
}

/// Says how long `work` took.
fn timed<T>(name: &str, total: &mut f64, work: impl FnOnce() -> T) -> T {
    let start = Instant::now();
    let done = work();
    let seconds = start.elapsed().as_secs_f64();
    *total += seconds;
    println!("{seconds:8.3} s  {name}");
    done
}

fn main() {
    let straight = straight();
    let (before, after) = (bend(&straight, 0.6, 0.0), bend(&straight, 0.61, 0.01));
    let total = &mut 0.0;
    let [before, after] = timed("checks, bulk (two snapshots)", total, || {
        [&before, &after].map(Beam::packing)
    });
    let z = timed("coordination", total, || coordination::coordination(&after));
    timed("force network", total, || {
        force_network::force_network(&after)
    });
    let g = timed("pair correlation to 8 d_p", total, || {
        pair_correlation::pair_correlation(&after, 8.0).expect("grains")
    });
    timed("bond order", total, || bond_order::bond_order(&after));
    let faces = timed("faces", total, || faces::Faces::of(&after).expect("grains"));
    let field = timed("displacement", total, || {
        displacement::displacement_field(&before, &after).expect("the same grains")
    });
    timed("neutral plane", total, || {
        neutral_plane::neutral_plane(&after, &field.expect("grains"))
    });
    let strays = timed("D_min", total, || {
        non_affine::non_affine(&before, &after, non_affine::VICINITY).expect("the same grains")
    });
    timed("autocorrelation to 10 d_p", total, || {
        autocorrelation::autocorrelation(&before, &strays.values, 10.0)
    });
    let fractions = timed("local volume fraction (two snapshots)", total, || {
        [&before, &after].map(voronoi::local_volume_fractions)
    });
    timed("changes, halves, height profile", total, || {
        let changes = voronoi::changes(&fractions[0], &fractions[1]);
        let profile = profile::height_profile(&after, &faces, &strays.values, 5);
        (faces.halves(&after, &changes), profile)
    });
    println!(
        "{total:8.3} s  in all, of {} grains in {} triangles",
        after.bulk().len(),
        after.snapshot().triangles.len()
    );
    let volume: f64 = voronoi::cell_volumes(&after).iter().sum();
    println!("z {:?}, {:?}", z.all, strays.excluded);
    println!(
        "highest g beyond 4 d_p {:?}",
        g.highest_beyond(4.0 * DIAMETER)
    );
    println!(
        "cells/membrane − 1 = {:e}",
        volume / after.membrane().volume() - 1.0
    );
}
