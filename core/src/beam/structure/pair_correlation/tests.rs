use super::*;
use crate::beam::structure::fixture::{Beam, bent, box_membrane, indices};
use crate::math::plain::{dot, sub};
use crate::random::{Purpose, uniform3};

const SIZE: [f64; 3] = [24.0, 14.0, 9.0];

/// Grains of diameter 1 anywhere in a box, the n-th kept if `keep` says so.
fn scattered(count: u64, mut keep: impl FnMut([f64; 3], &[[f64; 3]]) -> bool) -> Beam {
    let mut positions: Vec<[f64; 3]> = vec![];
    for n in 0..count {
        let share = uniform3(5, Purpose::GasVelocity, n);
        let at = std::array::from_fn(|k| share[k] * SIZE[k]);
        if keep(at, &positions) {
            positions.push(at);
        }
    }
    let mesh = box_membrane([0.0; 3], SIZE, [24, 14, 9]);
    Beam::of(mesh, positions, 0.5)
}

/// The mean of g from `from` to `to` d_p.
fn plateau(found: &PairCorrelation, from: f64, to: f64) -> f64 {
    let all = found.distances.iter().zip(&found.normalized);
    let inside = all.filter(|(r, _)| (from..to).contains(*r));
    crate::beam::structure::mean(inside.map(|(_, g)| g.expect("shells reach"))).expect("bins")
}

fn is_flat_from(found: &PairCorrelation, from: u32, to: u32) {
    for r in from..to {
        let g = plateau(found, f64::from(r), f64::from(r) + 1.0);
        assert!((g - 1.0).abs() < 0.02, "{r} {g}");
    }
}

#[test]
fn grains_anywhere_have_the_plateau_1_in_a_straight_and_in_a_bent_beam() {
    // Pairs per d_p of r are more than 10⁵, so chance moves g by less than 1 %.
    let beam = scattered(4000, |_, _| true);
    let found = |beam: &Beam| pair_correlation(&beam.packing(), 8.0).expect("grains");
    is_flat_from(&found(&beam), 1, 8);
    let bend = |at| bent(at, SIZE[0], SIZE[2], 0.8);
    // Bending stretches one side and squeezes the other by a fifth, and the density with them.
    let even = scattered(6000, |at, _| {
        let n = (1e6 * (at[0] + at[1] + at[2])) as u64;
        let wanted = 1.0 - 0.8 / SIZE[0] * (at[2] - 0.5 * SIZE[2]);
        1.2 * uniform3(6, Purpose::GasOrientation, n)[0] < wanted
    });
    is_flat_from(&found(&even.moved(bend)), 1, 8);
}

#[test]
fn hard_grains_that_the_membrane_keeps_off_have_the_plateau_1_from_5_diameters_on() {
    let grid_of = |at: [f64; 3]| at.map(|x| x as usize);
    let mut near = std::collections::BTreeMap::<[usize; 3], Vec<[f64; 3]>>::new();
    let beam = scattered(60_000, |at, _| {
        let inside = (0..3).all(|k| at[k] >= 0.5 && at[k] <= SIZE[k] - 0.5);
        let cell = grid_of(at);
        let free = inside
            && indices([3; 3]).all(|step| {
                let beside: [usize; 3] =
                    std::array::from_fn(|k| (cell[k] + step[k]).wrapping_sub(1));
                near.get(&beside).is_none_or(|others| {
                    others
                        .iter()
                        .all(|&other| dot(sub(at, other), sub(at, other)) >= 1.0)
                })
            });
        if free {
            near.entry(cell).or_default().push(at);
        }
        free
    });
    let packing = beam.packing();
    assert!(packing.volume_fraction() > 0.25);
    let found = pair_correlation(&packing, 8.0).expect("grains");
    is_flat_from(&found, 5, 8);
    let first = found.distances.iter().zip(&found.normalized);
    assert!(
        first
            .filter(|(r, _)| **r < 0.99)
            .all(|(_, g)| *g == Some(0.0))
    );
    assert!(plateau(&found, 1.0, 1.1) > 1.3);
    assert!(found.highest_beyond(4.0).expect("bins") < 1.15);
}

#[test]
fn a_lattice_has_peaks_where_its_neighbors_are_and_is_not_amorphous() {
    let beam = Beam::cubic_lattice([24, 14, 9], 1.0);
    let found = pair_correlation(&beam.packing(), 6.0).expect("grains");
    for (r, g) in found.distances.iter().zip(&found.normalized) {
        // Squares of distances are sums of three squares: bins between 1 and √2, and between √3 and 2, hold nothing.
        let empty = [(0.0, 0.98), (1.02, 1.39), (1.75, 1.97)];
        let inside = empty.iter().any(|(from, to)| r > from && r < to);
        assert!(!inside || *g == Some(0.0), "{r} {g:?}");
    }
    assert!(found.highest_beyond(4.0).expect("bins") > 2.0);
}

#[test]
fn the_paper_s_function_counts_surfaces_that_cut_a_sphere() {
    // Two grains of radii 0.5 and 0.3, 2 apart: seen from the first, the other cuts spheres from 1.7 to 2.3.
    let mut beam = Beam::of(
        box_membrane([0.0; 3], [9.0; 3], [9; 3]),
        [[3.0, 4.0, 4.0], [5.0, 4.0, 4.0]],
        0.5,
    );
    beam.radii[1] = 0.3;
    let found = pair_correlation(&beam.packing(), 5.0).expect("grains");
    let all = found.paper.all.expect("two grains");
    for (&r, g) in found.distances.iter().zip(&all) {
        let cut = |radius: f64| f64::from((2.0 - r).abs() < radius);
        let sphere = 4.0 * std::f64::consts::PI * (r / 0.4) * (r / 0.4);
        let expected = 0.5 * (cut(0.5) + cut(0.3)) / sphere;
        assert!((g - expected).abs() < 1e-15, "{r} {g} {expected}");
    }
}

#[test]
fn the_paper_s_function_has_the_plateau_3_phi_over_2_pi_in_the_bulk() {
    // Of equal spheres anywhere; a further 1 + R²/3r², and the membrane is 2 d_p away.
    let beam = scattered(9000, |_, _| true);
    let packing = beam.packing();
    let found = pair_correlation(&packing, 2.0).expect("grains");
    let bulk = found.paper.bulk.expect("a bulk");
    let expected = 1.5 * packing.volume_fraction() / std::f64::consts::PI;
    for (r, g) in found
        .distances
        .iter()
        .zip(&bulk)
        .filter(|(r, _)| **r > 0.6 && **r < 1.4)
    {
        let correction = 1.0 + 0.25 / (3.0 * r * r);
        // Some 10⁴ surfaces in each bin, of which neighboring bins share most.
        assert!((g / expected / correction - 1.0).abs() < 0.03, "{r} {g}");
    }
}

#[test]
fn few_grains_have_defined_answers() {
    let mesh = || box_membrane([0.0; 3], [9.0; 3], [9; 3]);
    assert_eq!(pair_correlation(&Beam::empty(mesh()).packing(), 5.0), None);
    for positions in [vec![[4.5; 3]], vec![[4.5; 3]; 2], vec![[0.1; 3]; 2]] {
        let beam = Beam::of(mesh(), positions, 0.5);
        let found = pair_correlation(&beam.packing(), 5.0).expect("grains");
        let known = found.normalized.iter().flatten();
        let paper = [found.paper.all, found.paper.bulk];
        let all = known.chain(paper.iter().flatten().flatten());
        assert!(all.copied().all(f64::is_finite));
    }
}
