//! Defaults, and which parameters make which stages.

use super::*;
use crate::beam::parameters::parameter;
use crate::identity::canonical_json;

fn point(preset: &str) -> BeamPoint {
    BeamPoint::from_parameters(BeamPoint::defaults(preset).expect("preset"))
        .expect("valid defaults")
}

/// What the identity of a stage is made of, without its kind.
fn id(spec: &impl Serialize) -> StageId {
    StageId::of_bytes(canonical_json(spec).as_bytes())
}

fn grow_id(point: &BeamPoint) -> StageId {
    id(&point.grow())
}

fn jam_id(point: &BeamPoint) -> StageId {
    id(&point.jam(grow_id(point)))
}

fn bend_id(point: &BeamPoint) -> StageId {
    id(&point.bend(jam_id(point)))
}

#[test]
fn every_preset_makes_a_valid_point_with_the_table_s_fields() {
    for preset in PRESETS {
        let map = BeamPoint::defaults(preset.name).expect("preset");
        for (name, value) in &map {
            let row = parameter(name).expect("in the table");
            assert_eq!(row.check(value), Ok(value.clone()), "{name}");
        }
        let back = serde_json::to_value(point(preset.name)).expect("plain data");
        assert_eq!(back, Value::Object(map));
    }
}

#[test]
fn one_packing_serves_every_friction_of_b_and_that_of_a_at_0_3() {
    let of = |protocol, friction_coefficient| BeamPoint {
        protocol,
        friction_coefficient,
        ..point("draft")
    };
    let shared = jam_id(&of(Protocol::B, 0.3));
    for friction_coefficient in [0.6, 0.9, 1.2] {
        assert_eq!(jam_id(&of(Protocol::B, friction_coefficient)), shared);
    }
    // The whole run is the same at 0.3, where the protocols say the same.
    assert_eq!(
        bend_id(&of(Protocol::A, 0.3)),
        bend_id(&of(Protocol::B, 0.3))
    );
    assert_ne!(jam_id(&of(Protocol::A, 0.6)), shared);
    assert_eq!(
        grow_id(&of(Protocol::A, 0.6)),
        grow_id(&of(Protocol::B, 0.6))
    );
}

#[test]
fn bending_is_repeated_on_one_packing_and_pressure_on_one_growth() {
    let one = point("standard");
    let bent_otherwise = BeamPoint {
        support: Support::PinnedRoller,
        membrane_rest: MembraneRest::ResetAfterCompaction,
        rod_speed: Some(1e-3),
        strain_end: 0.05,
        strain_end_over_yield: 1.5,
        time_step_fraction: 0.2,
        cycles: 3,
        structure: true,
        ..one.clone()
    };
    assert_eq!(jam_id(&one), jam_id(&bent_otherwise));
    assert_ne!(bend_id(&one), bend_id(&bent_otherwise));
    let pressed_otherwise = BeamPoint {
        confining_pressure: 4.5e4,
        kt_model: TangentialStiffness::Mindlin,
        membrane_thickness: Some(1e-4),
        ..one.clone()
    };
    assert_eq!(grow_id(&one), grow_id(&pressed_otherwise));
    assert_ne!(jam_id(&one), jam_id(&pressed_otherwise));
}

#[test]
fn what_means_nothing_makes_no_other_stage() {
    let one = point("standard");
    let same = BeamPoint {
        cycle_strain: 0.004,
        snapshot_travel: 1e-3,
        allow_inflation: true,
        periods: 7.0,
        rod_speed: Some(one.resolved_rod_speed()),
        ..one.clone()
    };
    assert_eq!(bend_id(&one), bend_id(&same));
}

/// Rod speeds at 100 MPa, from a stiffness of 5 MPa: 4.2, 2.1 and 1.0 mm/s.
#[test]
fn presets_drive_the_rods_by_their_periods() {
    for (preset, speed) in [
        ("smoke", 20e-3),
        ("draft", 4.2e-3),
        ("standard", 2.1e-3),
        ("paper_fast", 1.03e-3),
        ("paper", 0.2e-3),
    ] {
        let found = point(preset).resolved_rod_speed();
        assert!((found / speed - 1.0).abs() < 0.05, "{preset}: {found}");
    }
}

#[test]
fn softer_grains_are_bent_more_slowly_for_the_same_periods() {
    let soft = BeamPoint {
        youngs_modulus: 5e6,
        ..point("standard")
    };
    let ratio = soft.resolved_rod_speed() / point("standard").resolved_rod_speed();
    assert!((ratio - 3.0 / 7.0).abs() < 0.03, "{ratio}");
}

#[test]
fn membrane_keeps_its_ratio_to_the_smaller_side() {
    let thickness = |preset| point(preset).resolved_membrane_thickness();
    for (preset, expected) in [
        ("draft", 0.18e-3),
        ("standard", 0.225e-3),
        ("paper", 0.3e-3),
    ] {
        assert!((thickness(preset) / expected - 1.0).abs() < 1e-12);
    }
    let upright = BeamPoint {
        height: 0.048,
        depth: 0.024,
        ..point("draft")
    };
    assert!((upright.resolved_membrane_thickness() / 0.18e-3 - 1.0).abs() < 1e-12);
    let thick = BeamPoint {
        scale_membrane: false,
        ..point("draft")
    };
    assert!((thick.resolved_membrane_thickness() / 0.3e-3 - 1.0).abs() < 1e-12);
}
