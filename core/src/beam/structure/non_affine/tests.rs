use super::*;
use crate::beam::structure::ContactForce;
use crate::beam::structure::fixture::{Beam, box_membrane, indices};
use crate::math::plain::{add, norm, rotate, scale};
use crate::random::{Purpose, rotation, uniform3};

fn noise(seed: u64, n: u64, size: f64) -> [f64; 3] {
    uniform3(seed, Purpose::GasVelocity, n).map(|x| size * (x - 0.5))
}

/// A disordered packing of 8³ grains of diameter 1; those nearer than 1.1 touch.
fn packed(seed: u64) -> Beam {
    let positions: Vec<[f64; 3]> = (0..)
        .zip(indices([8; 3]))
        .map(|(n, at)| add(at.map(|k| k as f64 + 0.5), noise(seed, n, 0.4)))
        .collect();
    let mut beam = Beam::of(box_membrane([-1.0; 3], [9.0; 3], [5; 3]), positions, 0.5);
    for i in 0..beam.positions.len() {
        for j in 0..i {
            if norm(sub(beam.positions[i], beam.positions[j])) < 1.1 {
                beam.contacts.push(ContactForce {
                    i,
                    j,
                    normal_force: 1.0,
                    tangential_force: 0.0,
                });
            }
        }
    }
    beam
}

/// The same beam with every grain moved by up to `size`/2.
fn stirred(beam: &Beam, seed: u64, size: f64) -> Beam {
    let mut stirred = beam.clone();
    for (n, position) in (0..).zip(&mut stirred.positions) {
        *position = add(*position, noise(seed, n, size));
    }
    stirred
}

fn values(before: &Beam, after: &Beam, vicinity: f64) -> Vec<Option<f64>> {
    let found = non_affine(&before.packing(), &after.packing(), vicinity);
    found.expect("the same grains").values
}

fn same(a: &[Option<f64>], b: &[Option<f64>], tolerance: f64) {
    for (a, b) in a.iter().zip(b) {
        assert_eq!(a.is_some(), b.is_some());
        let (a, b) = (a.unwrap_or(0.0), b.unwrap_or(0.0));
        assert!((a - b).abs() < tolerance, "{a} {b}");
    }
}

#[test]
fn any_affine_map_is_zero() {
    let beam = packed(1);
    for seed in 0..20 {
        let turn = rotation(seed, Purpose::GasOrientation, 0);
        let [a, b, c] = [1, 2, 3].map(|n| noise(seed, n, 2.0));
        let after = beam.moved(|at| {
            let strained = [dot(a, at), dot(b, at), dot(c, at)];
            add(rotate(turn, strained), [50.0, -20.0, 80.0])
        });
        // The beam stands up to 100 d_p from the origin: positions are rounded by 1e-14.
        for vicinity in [1.25, VICINITY, 2.0] {
            let values = values(&beam, &after, vicinity);
            assert!(values.iter().flatten().count() > 100);
            assert!(values.iter().flatten().all(|value| *value < 1e-12));
        }
    }
}

#[test]
fn rigid_motions_of_either_snapshot_change_nothing() {
    let before = packed(2);
    let after = stirred(&before, 7, 0.1);
    let known = values(&before, &after, VICINITY);
    assert!(
        known
            .iter()
            .flatten()
            .all(|value| *value > 1e-3 && *value < 0.2)
    );
    let turn = rotation(3, Purpose::GasOrientation, 0);
    let moved = |beam: &Beam| beam.moved(|at| add(rotate(turn, at), [4.0, 5.0, -6.0]));
    // Grains at 1.5 d_p within rounding might become neighbors; there are none.
    same(&known, &values(&before, &moved(&after), VICINITY), 1e-12);
    same(&known, &values(&moved(&before), &after, VICINITY), 1e-12);
}

/// The least of D² over the nine entries of 1 + ε, by conjugate directions that only evaluate D².
fn brute_force(branches: &[([f64; 3], [f64; 3])]) -> f64 {
    let value = |strain: &[f64; 9]| {
        let of = |&(before, after): &([f64; 3], [f64; 3])| {
            let row = |i: usize| {
                dot(
                    [strain[3 * i], strain[3 * i + 1], strain[3 * i + 2]],
                    before,
                )
            };
            let left = sub(after, [row(0), row(1), row(2)]);
            dot(left, left)
        };
        branches.iter().map(of).sum::<f64>() / branches.len() as f64
    };
    let along = |at: &[f64; 9], way: &[f64; 9], step: f64| -> [f64; 9] {
        std::array::from_fn(|k| at[k] + step * way[k])
    };
    // Central differences of a parabola are exact.
    let unit = |k: usize| std::array::from_fn(|j| f64::from(u8::from(j == k)));
    let gradient = |at: &[f64; 9]| -> [f64; 9] {
        std::array::from_fn(|k| {
            0.5 * (value(&along(at, &unit(k), 1.0)) - value(&along(at, &unit(k), -1.0)))
        })
    };
    let square = |a: &[f64; 9]| a.iter().map(|x| x * x).sum::<f64>();
    let mut at = [0.0; 9];
    for _ in 0..4 {
        let mut slope = gradient(&at);
        let mut way = slope.map(|x| -x);
        for _ in 0..9 {
            let (low, middle, high) = (
                value(&along(&at, &way, -1.0)),
                value(&at),
                value(&along(&at, &way, 1.0)),
            );
            let curvature = low - 2.0 * middle + high;
            if curvature <= 0.0 {
                break;
            }
            at = along(&at, &way, 0.5 * (low - high) / curvature);
            let next = gradient(&at);
            let turn = square(&next) / square(&slope);
            way = std::array::from_fn(|k| turn * way[k] - next[k]);
            slope = next;
        }
    }
    value(&at)
}

#[test]
fn random_neighborhoods_have_the_least_that_brute_force_finds() {
    for seed in 0..200 {
        let count = 6 + seed % 10;
        let branches: Vec<_> = (0..count)
            .map(|n| (noise(seed, n, 3.0), noise(seed, n + 100, 3.0)))
            .collect();
        let found = least_square(&branches).expect("not flat");
        assert!((found / brute_force(&branches) - 1.0).abs() < 1e-9);
    }
}

#[test]
fn one_grain_that_jumps_strays_and_so_do_its_neighbors() {
    let before = packed(4);
    let mut after = before.clone();
    let jumper = 8 * 8 * 4 + 8 * 4 + 4;
    after.positions[jumper] = add(after.positions[jumper], [0.3, 0.0, 0.0]);
    let values = values(&before, &after, VICINITY);
    for (i, value) in values.iter().enumerate() {
        let distance = norm(sub(before.positions[i], before.positions[jumper]));
        let moved = value.is_some_and(|value| value > 1e-3);
        assert_eq!(moved, value.is_some() && distance < VICINITY, "{i}");
    }
}

#[test]
fn grains_left_out_are_counted_under_their_reason() {
    let beam = packed(5);
    let found = non_affine(&beam.packing(), &beam.packing(), VICINITY).expect("the same");
    let few = beam
        .packing()
        .contact_counts()
        .iter()
        .filter(|count| **count < 3)
        .count();
    assert_eq!(found.excluded.few_contacts, few);
    let none = non_affine(&beam.packing(), &beam.packing(), 0.5).expect("the same");
    assert_eq!(none.excluded.few_neighbors, beam.positions.len() - few);
    // Neighbors in a plane, thin by 1e-3: cond(Y) ~ 10⁶.
    let flat: Vec<_> = (0..8)
        .map(|n| noise(1, n, 2.0))
        .map(|[x, y, z]| ([x, y, 1e-3 * z], [x, y, z]))
        .collect();
    assert_eq!(least_square(&flat), None);
    assert_eq!(least_square(&[([0.0; 3], [1.0; 3]); 8]), None);
    let mut thin = beam.clone();
    for position in &mut thin.positions {
        *position = add(scale(*position, 0.5), [0.0, 0.0, 2.0]);
        position[2] = 2.0 + 1e-3 * position[0];
    }
    let found = non_affine(&thin.packing(), &thin.packing(), VICINITY).expect("the same");
    assert_eq!(found.excluded.flat, beam.positions.len() - few);
}

#[test]
fn coincident_grains_and_empty_beams_have_defined_answers() {
    let mut beam = packed(6);
    beam.positions[100] = beam.positions[101];
    let after = stirred(&beam, 8, 0.1);
    let all = values(&beam, &after, VICINITY);
    assert!(all.iter().flatten().copied().all(f64::is_finite));
    let empty = Beam::empty(box_membrane([0.0; 3], [1.0; 3], [1; 3]));
    assert!(values(&empty, &empty, VICINITY).is_empty());
    let error = non_affine(&beam.packing(), &empty.packing(), VICINITY);
    assert_eq!(
        error.expect_err("other grains"),
        SnapshotError::Grains {
            before: 512,
            after: 0
        }
    );
}
