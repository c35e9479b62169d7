//! When a test that looks for the yield ends.

use super::*;

const MOLD: Dimensions = Dimensions {
    length: 0.24,
    height: 0.024,
    depth: 0.048,
};

fn drive(strain_end_over_yield: f64) -> Drive {
    Drive {
        mold: MOLD,
        speed: 1e-3,
        start: 0.1,
        from: 0.0,
        to: 1.0,
        since: 0.0,
        contact_stress: 90.0,
        zero: Some(0.0),
        cycles: 0,
        cycle_strain: 0.0,
        strain_end: 0.08,
        strain_end_over_yield,
        sample_way: 1e-4,
        over: false,
    }
}

/// Rows of a beam that softens from 10 MPa and hardens again beyond this strain.
fn rows(turning: f64) -> Vec<Row> {
    let stress = |strain: f64| {
        let beyond = (strain - turning).max(0.0);
        8e4 * (1.0 - libm::exp(-strain / 8e-3)) + 2e8 * beyond * beyond
    };
    let row = |k: i32| {
        let strain = 5e-5 * f64::from(k);
        Row {
            time: f64::from(k),
            travel: 0.0,
            force: stress(strain) / MOLD.stress(1.0),
            reaction: 0.0,
            height: -strain / MOLD.strain(1.0),
            kinetic_energy: 0.0,
            elastic_energy: 0.0,
            volume_fraction: 0.6,
            coordination_number: None,
            mean_force: 0.0,
            mean_normal_force: 0.0,
            mean_tangential_force: 0.0,
            coulomb_fraction: None,
            mean_overlap: 0.0,
        }
    };
    (0..1600).map(row).collect()
}

fn strain(row: &Row) -> f64 {
    MOLD.strain(-row.height)
}

/// How many rows there are when the test ends, looking at each in turn.
fn end(mut drive: Drive, rows: &[Row]) -> Option<usize> {
    (1..=rows.len()).find(|&count| {
        drive.look_for_yield(&rows[..count]);
        drive.is_over()
    })
}

#[test]
fn a_beam_that_yielded_is_bent_half_as_far_again_but_to_5_percent() {
    let rows_of_early = rows(0.03);
    let early = end(drive(1.5), &rows_of_early).expect("it yields");
    // Looks are 20 rows apart, 0.001 of strain.
    let at = strain(&rows_of_early[early - 1]);
    assert!((0.05..0.051).contains(&at), "{at}");
    let rows = rows(0.042);
    let late = end(drive(1.5), &rows).expect("it yields");
    let wanted = |count: usize| {
        let samples: Vec<_> = rows[..count].iter().map(|row| row.sample(0.0)).collect();
        let found = ultimate_strength(&Curve::of(&samples, &MOLD));
        found.map_or(f64::INFINITY, |found| 1.5 * found.strain)
    };
    let at = |count: usize| strain(&rows[count - 1]);
    assert!(at(late) > 0.051 && at(late) >= wanted(late), "{}", at(late));
    assert!(at(late - ROWS_PER_LOOK) < wanted(late - ROWS_PER_LOOK));
}

#[test]
fn a_test_goes_on_where_nothing_is_asked_or_a_cycle_is_to_come() {
    assert_eq!(end(drive(0.0), &rows(0.03)), None);
    let cyclic = Drive {
        cycles: 1,
        ..drive(1.5)
    };
    assert_eq!(end(cyclic, &rows(0.03)), None);
    // It never hardens again.
    assert_eq!(end(drive(1.5), &rows(1.0)), None);
}
