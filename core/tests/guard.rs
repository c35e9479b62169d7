//! The guard: a run that has left the physics is stopped with its reason, the step, and what to change.
//!
//! No outcome is lost to it that is one: how near the critical time step it lets runs come is in `critical_time_step.rs`.

use granary_core::lanes::VectorWidth;
use granary_core::stage::{Outcome, StageFailure, StageSpec};
use serde_json::{Value, json};

#[path = "fixture/tiny_pack.rs"]
#[allow(dead_code, reason = "every proof takes what it needs")]
mod tiny_pack;

use tiny_pack::{finish, tiny};

fn prepared(changes: &Value) -> Result<Outcome, StageFailure> {
    let spec = [StageSpec::Pack(tiny(changes).pack())];
    finish(&spec, &[], VectorWidth::widest()).remove(0)
}

#[test]
fn a_sphere_pressed_half_through_a_wall_is_stopped() {
    // One sphere has no other to overlap with.
    // At rest, 0.1 E on (3.08 R)² is k_w p^(3/2) with k_w = 1.75 E R^½: p = 0.66 R.
    let changes = json!({"shape": "sphere", "grains": 1, "servo_pressure": 0.1});
    let expected = StageFailure::Stopped {
        kind: "overlap".to_owned(),
        step: 600,
        detail: "a sphere and a wall overlap by 0.60 R, more than 0.5 R".to_owned(),
        remedy: "use a smaller delta0, gamma0 or servo_pressure, or a longer ramp".to_owned(),
    };
    assert_eq!(prepared(&changes), Err(expected));
}
