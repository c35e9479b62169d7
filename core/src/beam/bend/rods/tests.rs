//! When a test has begun, is over, or comes to nothing.

use super::*;
use crate::beam::point::BeamPoint;
use crate::identity::StageId;

fn drive() -> (Drive, Dimensions) {
    let map = BeamPoint::defaults("smoke").expect("a preset");
    let point = BeamPoint::from_parameters(map).expect("valid defaults");
    let id = StageId::of_bytes(b"before");
    let (grow, jam, bend) = (point.grow(), point.jam(id), point.bend(id));
    let mold = grow.dimensions();
    let past = Past {
        grow,
        jam: None,
        warnings: vec![],
    };
    (Drive::new(&bend, &jam, &past), mold)
}

/// The rods have gone `travel`, bear `force`, and the middle is at `height`.
fn row(travel: f64, force: f64, height: f64) -> Row {
    Row {
        time: 1.0,
        travel,
        force,
        reaction: force,
        height,
        kinetic_energy: 0.0,
        elastic_energy: 1.0,
        volume_fraction: 0.6,
        coordination_number: Some(5.0),
        mean_force: 1.0,
        mean_normal_force: 1.0,
        mean_tangential_force: 0.0,
        coulomb_fraction: None,
        mean_overlap: 0.03,
    }
}

#[test]
fn rods_that_touch_nothing_after_twice_their_way_stop() {
    let (mut drive, mold) = drive();
    let expected = drive.gap() + rod_travel(&mold, ELASTIC_STRAIN);
    assert_eq!(drive.follow(&row(1.99 * expected, 0.0, 0.0), 1.0), Ok(()));
    let stop = drive.follow(&row(2.01 * expected, 0.0, 0.0), 1.0);
    assert_eq!(stop.expect_err("nothing is touched").kind, "no_contact");
}

#[test]
fn beam_that_does_not_bend_while_the_rods_go_on_stops() {
    let (mut drive, mold) = drive();
    let begun = row(drive.gap(), 1.0, 0.0);
    assert_eq!(drive.follow(&begun, 1.0), Ok(()));
    assert_eq!(drive.strain(&begun), Some(0.0));
    let most = 2.0 * (rod_travel(&mold, drive.strain_end) + drive.gap()) + 0.1 * mold.height;
    let half = -0.5 * drive.strain_end / mold.strain(1.0);
    assert_eq!(drive.follow(&row(0.99 * most, 1.0, half), 1.0), Ok(()));
    let stop = drive.follow(&row(1.01 * most, 1.0, half), 1.0);
    assert_eq!(stop.expect_err("it is not bent").kind, "run_too_short");
    // One that is bent as far as asked ends, however far the rods have gone.
    assert_eq!(
        drive.follow(&row(1.01 * most, 1.0, 2.01 * half), 1.0),
        Ok(())
    );
    assert!(drive.is_over());
}
