//! The scenes of the map: one factor at a time, and corners of all ranges at once.

use granary_core::random::{Purpose, uniform3};
use serde_json::{Map, Value, json};

/// Corners of the hypercube.
const CORNERS: usize = 200;

/// A scene.
pub(super) struct Cell {
    pub(super) factor: &'static str,
    pub(super) value: String,
    pub(super) changes: Map<String, Value>,
    pub(super) beam: bool,
}

/// One factor at a time.
pub(super) fn one_at_a_time() -> Vec<Cell> {
    let factors: [(&str, Vec<Value>); 14] = [
        ("default", vec![json!(null)]),
        ("shape", vec![json!("sphere")]),
        ("overlap", [0.0, 0.3, 0.9, 0.999].map(Value::from).to_vec()),
        (
            "friction_coefficient",
            [0.0, 1e-6, 1e3].map(Value::from).to_vec(),
        ),
        (
            "poisson_ratio",
            [-0.9, -0.5, 0.0, 0.3, 0.5].map(Value::from).to_vec(),
        ),
        (
            "delta0",
            [1e-4, 1e-3, 1e-2, 0.1, 0.15].map(Value::from).to_vec(),
        ),
        (
            "gamma0",
            [1e-8, 1e-6, 1e-4, 1e-2, 0.05, 0.2]
                .map(Value::from)
                .to_vec(),
        ),
        ("youngs_modulus", [1e2, 1e5, 1e12].map(Value::from).to_vec()),
        ("radius", [1e-6, 1e-2, 1.0].map(Value::from).to_vec()),
        (
            "normal_damping",
            [0.0, 0.023, 2.3, 23.0].map(Value::from).to_vec(),
        ),
        (
            "tangential_damping_ratio",
            [0.0, 1.0, 10.0].map(Value::from).to_vec(),
        ),
        (
            "servo_pressure",
            [1e-6, 1e-5, 1e-4, 1e-2, 5e-2].map(Value::from).to_vec(),
        ),
        ("typical_overlap", [1e-4, 0.5].map(Value::from).to_vec()),
        ("grains", [1, 2, 8, 64, 1024].map(Value::from).to_vec()),
    ];
    let beams: [(&str, Vec<Value>); 5] = [
        ("beam: default", vec![json!(null)]),
        (
            "youngs_modulus",
            [1e5, 1e6, 1e9, 1e12].map(Value::from).to_vec(),
        ),
        (
            "confining_pressure",
            [0.0, 1e3, 1e6].map(Value::from).to_vec(),
        ),
        (
            "membrane_edge",
            [2e-3, 4e-3, 6e-3, 2e-2].map(Value::from).to_vec(),
        ),
        ("rod_speed", [5e-4, 5e-3, 0.5].map(Value::from).to_vec()),
    ];
    let cells = |(factor, values): (&'static str, Vec<Value>), beam: bool| {
        values.into_iter().map(move |value| {
            let mut changes = Map::new();
            if !value.is_null() {
                changes.insert(factor.to_owned(), value.clone());
            }
            Cell {
                factor,
                value: if value.is_null() {
                    "–".to_owned()
                } else {
                    value.to_string()
                },
                changes,
                beam,
            }
        })
    };
    // Sound dies slowly in large packs; ramps as short as these need a drag.
    let large = [(3_267, 6000.0), (10_240, 6000.0), (100_000, 1500.0)].map(|(grains, ramp)| {
        let changes = json!({"grains": grains, "drag": 0.01, "ramp": ramp});
        Cell {
            factor: "grains",
            value: grains.to_string(),
            changes: changes.as_object().expect("an object").clone(),
            beam: false,
        }
    });
    let packs = factors.into_iter().flat_map(|factor| cells(factor, false));
    packs
        .chain(large)
        .chain(beams.into_iter().flat_map(|factor| cells(factor, true)))
        .collect()
}

/// Corners of all ranges at once: every factor's range is cut into as many parts as there are corners, and each part is taken
/// once.
pub(super) fn corners() -> Vec<Cell> {
    // Name, from, to; by decades where both are above zero and far apart.
    let factors: [(&str, f64, f64); 11] = [
        ("overlap", 0.0, 0.999),
        ("friction_coefficient", 1e-6, 1e3),
        ("poisson_ratio", -0.9, 0.5),
        ("delta0", 1e-4, 0.15),
        ("gamma0", 1e-8, 0.2),
        ("youngs_modulus", 1e2, 1e12),
        ("radius", 1e-6, 1.0),
        ("normal_damping", 2.3e-3, 23.0),
        ("tangential_damping_ratio", 1e-2, 10.0),
        ("servo_pressure", 1e-6, 5e-2),
        ("grains", 8.0, 325.0),
    ];
    let mut corners = vec![Map::new(); CORNERS];
    for (n, (name, from, to)) in factors.into_iter().enumerate() {
        let draw = |i: usize| uniform3(4, Purpose::GasVelocity, (1000 * n + i) as u64);
        let mut order: Vec<usize> = (0..CORNERS).collect();
        order.sort_by(|&a, &b| draw(a)[0].total_cmp(&draw(b)[0]));
        for (part, &i) in order.iter().enumerate() {
            let share = (part as f64 + draw(i)[1]) / CORNERS as f64;
            let value = if from > 0.0 && to / from > 30.0 {
                from * (to / from).powf(share)
            } else {
                from + (to - from) * share
            };
            let value = match name {
                "grains" => json!(value.round() as u32),
                // Three digits are enough to name a corner by.
                _ => json!(format!("{value:.2e}").parse::<f64>().expect("a number")),
            };
            corners[i].insert(name.to_owned(), value);
        }
    }
    let cell = |(i, mut changes): (usize, Map<String, Value>)| {
        if i.is_multiple_of(4) {
            changes.insert("shape".to_owned(), json!("sphere"));
        }
        Cell {
            factor: "corner",
            value: (i + 1).to_string(),
            changes,
            beam: false,
        }
    };
    corners.into_iter().enumerate().map(cell).collect()
}
