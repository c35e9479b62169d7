use super::*;
use crate::beam::structure::fixture::{Beam, box_membrane};

const SIZE: [usize; 3] = [30, 8, 6];

fn field(before: &Beam, after: &Beam) -> Field {
    let found = displacement_field(&before.packing(), &after.packing());
    found.expect("the same grains").expect("grains")
}

#[test]
fn moving_as_a_whole_is_no_displacement() {
    let after = Beam::cubic_lattice(SIZE, 1.0);
    let before = after.moved(|at| add(at, [0.3, -0.2, 0.7]));
    let found = field(&before, &after);
    let known: Vec<[f64; 3]> = found.values.iter().flatten().copied().collect();
    // Every node of a full box has grains.
    assert_eq!(known.len(), SIZE.iter().product::<usize>());
    assert!(known.iter().flatten().all(|x| x.abs() < 1e-14));
}

#[test]
fn shrinking_along_x_moves_all_toward_the_center_the_farther_the_more() {
    let after = Beam::cubic_lattice(SIZE, 1.0);
    let strain = 0.01;
    let before = after.moved(|[x, y, z]| [15.0 + (1.0 + strain) * (x - 15.0), y, z]);
    let found = field(&before, &after);
    let along = |i: usize| found.at([i, 4, 3]).expect("grains");
    for i in [2, 6, 10] {
        let arm = found.coordinate(0, i) - 15.0;
        // ê_x is 1 but for at most half of (5/|arm|)² over the section; the kernel is even.
        let expected = -strain * arm.abs();
        assert!((along(i)[0] / expected - 1.0).abs() < 0.5 * 25.0 / (arm * arm));
        assert!(along(i)[1].abs() < 1e-15 && along(i)[2].abs() < 1e-15);
    }
    assert!(along(2)[0] < along(6)[0] && along(6)[0] < along(10)[0]);
}

#[test]
fn far_from_all_grains_the_field_has_no_value() {
    let mut beam = Beam::cubic_lattice(SIZE, 1.0);
    let keep: Vec<bool> = beam.positions.iter().map(|at| at[0] < 20.0).collect();
    let mut kept = keep.iter();
    beam.positions.retain(|_| *kept.next().expect("as many"));
    beam.radii.truncate(beam.positions.len());
    let found = field(&beam, &beam);
    assert!(found.at([15, 4, 3]).is_some() && found.at([27, 4, 3]).is_none());
}

#[test]
fn the_center_is_half_way_between_the_extremities() {
    let beam = Beam::cubic_lattice(SIZE, 1.0).moved(|at| add(at, [5.0, 1.0, -2.0]));
    let packing = beam.packing();
    let faces = Faces::of(&packing).expect("grains");
    let off = sub(center(&packing, &faces), [20.0, 5.0, 1.0]);
    assert!(norm(off) < 1e-12);
}

#[test]
fn few_grains_and_a_grain_at_the_center_have_defined_answers() {
    let mesh = || box_membrane([0.0; 3], [8.0; 3], [4; 3]);
    let empty = Beam::empty(mesh());
    assert_eq!(
        displacement_field(&empty.packing(), &empty.packing()),
        Ok(None)
    );
    let one = Beam::of(mesh(), [[4.0; 3]], 0.5);
    let found = field(&one.moved(|at| add(at, [0.1; 3])), &one);
    assert!(
        found
            .values
            .iter()
            .flatten()
            .flatten()
            .all(|x| x.abs() < 1e-15)
    );
    let lost = displacement_field(&empty.packing(), &one.packing());
    assert_eq!(
        lost,
        Err(SnapshotError::Grains {
            before: 0,
            after: 1
        })
    );
}

#[test]
fn the_mean_over_the_depth_is_one_layer_in_the_middle_of_what_is_known() {
    // Two by three by one nodes; at the second x only one of the three has a value.
    let field = Field {
        low: [0.5, 1.0, 7.0],
        spacing: [1.0, 2.0, 3.0],
        count: [2, 3, 1],
        values: vec![
            Some([1.0, 0.0, 3.0]),
            None,
            Some([2.0, 0.0, -3.0]),
            Some([8.0, 4.0, 1.0]),
            Some([3.0, 3.0, 0.0]),
            None,
        ],
    };
    let found = field.averaged_over_depth();
    assert_eq!(
        (found.low, found.spacing),
        ([0.5, 3.0, 7.0], [1.0, 6.0, 3.0])
    );
    assert_eq!(found.count, [2, 1, 1]);
    assert_eq!(found.at([0, 0, 0]), Some([2.0, 1.0, 0.0]));
    assert_eq!(found.at([1, 0, 0]), Some([8.0, 4.0, 1.0]));
}
