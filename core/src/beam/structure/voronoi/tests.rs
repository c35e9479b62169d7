use super::*;
use crate::beam::structure::fixture::{Beam, bent, box_membrane};
use crate::math::plain::{dot, sub};
use crate::random::{Purpose, rotation, uniform3};

/// Grains of radii 0.4 to 0.6 anywhere in a box of 10 × 4 × 3, overlapping or not.
fn random(count: u64, seed: u64) -> Beam {
    let place = |n| {
        let [x, y, z] = uniform3(seed, Purpose::GasVelocity, n);
        [10.0 * x, 4.0 * y, 3.0 * z]
    };
    let mesh = box_membrane([0.0; 3], [10.0, 4.0, 3.0], [10, 4, 3]);
    let mut beam = Beam::of(mesh, (0..count).map(place), 0.5);
    for (n, radius) in (0..).zip(&mut beam.radii) {
        *radius += 0.2 * (uniform3(seed, Purpose::GasOrientation, n)[0] - 0.5);
    }
    beam
}

fn sum_matches(beam: &Beam) {
    let packing = beam.packing();
    let sum: f64 = cell_volumes(&packing).iter().sum();
    let off = sum / packing.membrane().volume() - 1.0;
    assert!(off.abs() < 1e-11, "{off:e}");
}

#[test]
fn cells_of_a_cubic_lattice_are_cubes_up_to_the_membrane() {
    // Eight cells meet in each corner, and all planes of the membrane are planes of cells.
    let volumes = cell_volumes(&Beam::cubic_lattice([5, 4, 3], 1.0).packing());
    assert!(volumes.iter().all(|volume| (volume - 1.0).abs() < 1e-12));
}

#[test]
fn two_grains_divide_their_box_at_the_radical_plane() {
    let mut beam = Beam::of(
        box_membrane([0.0; 3], [4.0, 2.0, 2.0], [4, 2, 2]),
        [[1.0; 3], [3.0, 1.0, 1.0]],
        1.0,
    );
    beam.radii = vec![0.8, 1.2];
    let volumes = cell_volumes(&beam.packing());
    // x − 1 = (D² + R_1² − R_2²)/2D = (4 + 0.64 − 1.44)/4 = 0.8.
    assert!((volumes[0] - 1.8 * 4.0).abs() < 1e-12);
    assert!((volumes[1] - 2.2 * 4.0).abs() < 1e-12);
}

#[test]
fn cells_fill_the_membrane_straight_bent_or_wrinkled() {
    for (count, seed) in [(1, 1), (2, 2), (7, 3), (100, 4), (300, 5)] {
        let straight = random(count, seed);
        sum_matches(&straight);
        sum_matches(&straight.moved(|at| bent(at, 10.0, 3.0, 1.4)));
        // Waves of the membrane as short as its edges, grains where they were.
        let mut wrinkled = straight.clone();
        for (n, vertex) in (0..).zip(&mut wrinkled.vertices) {
            let shift = uniform3(seed + 9, Purpose::GasVelocity, n);
            *vertex = std::array::from_fn(|k| vertex[k] + 0.6 * (shift[k] - 0.5));
        }
        sum_matches(&wrinkled);
        // Each tenth vertex moved onto another: triangles without area, and sheets folded over themselves.
        for k in (10..wrinkled.vertices.len()).step_by(10) {
            wrinkled.vertices[k] = wrinkled.vertices[k - 1];
        }
        sum_matches(&wrinkled);
    }
}

#[test]
fn cells_agree_with_the_share_of_random_points_nearest_in_power() {
    let beam = random(40, 6).moved(|at| bent(at, 10.0, 3.0, 1.0));
    let packing = beam.packing();
    let [low, high] = packing.membrane().bounds();
    let (mut counts, samples) = ([0.0; 40], 400_000);
    for n in 0..samples {
        let share = uniform3(8, Purpose::GasOrientation, n);
        let point = std::array::from_fn(|k| low[k] + share[k] * (high[k] - low[k]));
        if packing.membrane().winding(point) == 0 {
            continue;
        }
        let power = |&i: &usize| {
            let arm = sub(point, beam.positions[i]);
            dot(arm, arm) - beam.radii[i] * beam.radii[i]
        };
        let nearest = (0..40).min_by(|i, j| power(i).total_cmp(&power(j)));
        counts[nearest.expect("40 grains")] += 1.0;
    }
    let each = (0..3).map(|k| high[k] - low[k]).product::<f64>() / samples as f64;
    for (volume, count) in cell_volumes(&packing).iter().zip(counts) {
        // Five standard deviations of a Poisson count.
        let tolerance = 5.0 * each * f64::max(count, 1.0).sqrt();
        assert!(
            (volume - each * count).abs() < tolerance,
            "{volume} {count}"
        );
    }
}

#[test]
fn a_rigid_motion_changes_no_cell() {
    let beam = random(120, 7);
    let turn = rotation(1, Purpose::GasOrientation, 0);
    let moved = beam.moved(|at| {
        let turned = crate::math::plain::rotate(turn, at);
        std::array::from_fn(|k| turned[k] + 3.0)
    });
    let volumes = cell_volumes(&beam.packing());
    for (before, after) in volumes.iter().zip(cell_volumes(&moved.packing())) {
        assert!((before - after).abs() < 1e-11);
    }
}

#[test]
fn coincident_grains_and_grains_outside_have_defined_cells() {
    // Neighbors of the coincident ones meet the same plane twice.
    for seed in 0..12 {
        let mut beam = random(30, seed);
        beam.positions[3] = beam.positions[2];
        beam.positions[4] = beam.positions[2];
        (beam.radii[2], beam.radii[3], beam.radii[4]) = (0.5, 0.55, 0.55);
        beam.positions[5] = [2.0, 2.0, 40.0];
        sum_matches(&beam);
        let fractions = local_volume_fractions(&beam.packing());
        let none = [fractions[2], fractions[4], fractions[5]];
        assert_eq!(none, [None; 3]);
        assert!(fractions[3].is_none_or(f64::is_finite));
    }
}

#[test]
fn a_grain_on_the_membrane_has_the_half_inside() {
    let mut beam = Beam::cubic_lattice([3, 3, 3], 1.0);
    for position in &mut beam.positions {
        position[2] -= 0.5;
    }
    let volumes = cell_volumes(&beam.packing());
    assert!((volumes[0] - 0.5).abs() < 1e-12 && (volumes[9] - 1.0).abs() < 1e-12);
    // The uppermost have what the others left.
    assert!((volumes[18] - 1.5).abs() < 1e-12);
}

#[test]
fn local_volume_fractions_average_to_the_beam_s_by_volume() {
    let beam = random(200, 9);
    let packing = beam.packing();
    let harmonic: f64 = local_volume_fractions(&packing)
        .iter()
        .zip(&beam.radii)
        .map(|(fraction, &radius)| ball_volume(radius) / fraction.expect("it has a cell"))
        .sum();
    let grains: f64 = beam.radii.iter().map(|&radius| ball_volume(radius)).sum();
    assert!((grains / harmonic / packing.volume_fraction() - 1.0).abs() < 1e-10);
}

#[test]
fn changes_are_of_grains_that_have_a_cell_before_and_after() {
    let known = changes(&[Some(0.5), None, Some(0.7)], &[Some(0.6), Some(1.0), None]);
    assert!((known[0].expect("both") - 0.1).abs() < 1e-15);
    assert_eq!(known[1..], [None, None]);
}

#[test]
fn a_beam_without_grains_has_no_cells() {
    let none = Beam::empty(box_membrane([0.0; 3], [1.0; 3], [1; 3]));
    assert!(cell_volumes(&none.packing()).is_empty());
    assert!(local_volume_fractions(&none.packing()).is_empty());
}
