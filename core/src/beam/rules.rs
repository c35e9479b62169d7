//! Rules between parameters that are each allowed: what no beam can be made of, and what is allowed but unwise.

use serde_json::{Map, Value};

use super::curve::Dimensions;
use super::point::{BeamPoint, PROTOCOL_B_FRICTION};
use super::prediction::{grains, rod_travel, vertices};
use super::stiffness::ELASTIC_STRAIN;
use crate::membrane::Cuboid;
use crate::parameter::Rule;

/// The most grains, and the most vertices of a membrane.
const MOST_BODIES: f64 = 1e7;

/// The most snapshots times grains and vertices: 2 GB of text. The paper's beam takes 120 snapshots of 17,000.
const MOST_IN_SNAPSHOTS: f64 = 2e7;

/// The most snapshots: names of files number them by four digits.
const MOST_SNAPSHOTS: f64 = 1e4;

/// Volume fraction beyond which spheres are hardly ever placed one by one at random.
const LARGEST_RANDOM: f64 = 0.35;

/// Every rule; the first parameter is the one to change.
pub const RULES: &[Rule] = &[
    Rule {
        parameters: &["friction_coefficient", "protocol"],
        broken: protocol_b,
    },
    Rule {
        parameters: &["radius_min", "radius_max"],
        broken: radii,
    },
    Rule {
        parameters: &["confining_pressure", "allow_inflation"],
        broken: inflation,
    },
    Rule {
        parameters: &["initial_volume_fraction", "growth_factor"],
        broken: placement,
    },
    Rule {
        parameters: &[
            "radius_max",
            "radius_min",
            "length",
            "height",
            "depth",
            "initial_volume_fraction",
        ],
        broken: size,
    },
    Rule {
        parameters: &[
            "membrane_edge",
            "radius_min",
            "radius_max",
            "length",
            "height",
            "depth",
        ],
        broken: mesh,
    },
    Rule {
        parameters: &["rod_radius", "length", "height"],
        broken: rods,
    },
    Rule {
        parameters: &["cycle_strain", "cycles", "strain_end"],
        broken: cycles,
    },
    Rule {
        parameters: &["overlap_warning", "overlap_limit"],
        broken: overlaps,
    },
    Rule {
        parameters: &[
            "snapshot_travel",
            "structure",
            "snapshots",
            "cycles",
            "strain_end",
            "cycle_strain",
            "length",
            "height",
            "depth",
            "membrane_edge",
            "initial_volume_fraction",
            "radius_min",
            "radius_max",
        ],
        broken: snapshots,
    },
];

/// A number of the point; NaN, which breaks no rule, if it is derived.
fn number(point: &Map<String, Value>, name: &str) -> f64 {
    point.get(name).and_then(Value::as_f64).unwrap_or(f64::NAN)
}

fn mold(point: &Map<String, Value>) -> Dimensions {
    Dimensions {
        length: number(point, "length"),
        height: number(point, "height"),
        depth: number(point, "depth"),
    }
}

/// a: as given, or a mean diameter.
fn edge(point: &Map<String, Value>) -> f64 {
    let given = point.get("membrane_edge").and_then(Value::as_f64);
    given.unwrap_or_else(|| number(point, "radius_min") + number(point, "radius_max"))
}

fn protocol_b(point: &Map<String, Value>) -> Option<String> {
    let friction = number(point, "friction_coefficient");
    let below = point.get("protocol")? == "B" && friction < PROTOCOL_B_FRICTION;
    below.then(|| {
        format!(
            "{friction} is less than {PROTOCOL_B_FRICTION}, the friction that protocol B compacts with: \
             the packing would compact again while it is bent"
        )
    })
}

fn radii(point: &Map<String, Value>) -> Option<String> {
    let (min, max) = (number(point, "radius_min"), number(point, "radius_max"));
    (min > max).then(|| format!("radius_min = {min} is larger than radius_max = {max}"))
}

fn inflation(point: &Map<String, Value>) -> Option<String> {
    let pressure = number(point, "confining_pressure");
    let refused = pressure < 0.0 && point.get("allow_inflation")? == false;
    refused.then(|| {
        format!("{pressure} would inflate the membrane: set allow_inflation = true if it should")
    })
}

fn placement(point: &Map<String, Value>) -> Option<String> {
    let (fraction, factor) = (
        number(point, "initial_volume_fraction"),
        number(point, "growth_factor"),
    );
    let before = fraction / (factor * factor * factor);
    (before > LARGEST_RANDOM).then(|| {
        format!(
            "{fraction} is {before:.2} before the grains grow by growth_factor = {factor}: \
             more than {LARGEST_RANDOM} cannot be placed at random"
        )
    })
}

fn size(point: &Map<String, Value>) -> Option<String> {
    let mold = mold(point);
    let fraction = number(point, "initial_volume_fraction");
    let (min, max) = (number(point, "radius_min"), number(point, "radius_max"));
    let side = mold.length.min(mold.height).min(mold.depth);
    if fraction > 0.0 && 2.0 * max > side {
        return Some(format!(
            "a grain of radius {max} m does not fit a side of {side} m"
        ));
    }
    let count = grains(&mold, fraction, (min, max));
    (count > MOST_BODIES)
        .then(|| format!("the beam would have {count:.1e} grains: at most {MOST_BODIES:.0e}"))
}

fn mesh(point: &Map<String, Value>) -> Option<String> {
    let (mold, edge) = (mold(point), edge(point));
    let side = mold.length.min(mold.height).min(mold.depth);
    if 2.0 * edge > side {
        return Some(format!(
            "triangles with an edge of {edge} m are too coarse for a side of {side} m: at least two must fit"
        ));
    }
    let count = vertices(&mold, edge);
    if count > MOST_BODIES {
        return Some(format!(
            "the membrane would have {count:.1e} vertices: at most {MOST_BODIES:.0e}"
        ));
    }
    let cuboid = Cuboid {
        length: mold.length,
        height: mold.height,
        depth: mold.depth,
        edge_length: edge,
    };
    let known = side.is_finite() && edge.is_finite();
    cuboid
        .check()
        .err()
        .filter(|_| known)
        .map(|error| error.to_string())
}

fn rods(point: &Map<String, Value>) -> Option<String> {
    let (length, height) = (number(point, "length"), number(point, "height"));
    let given = point.get("rod_radius").and_then(Value::as_f64);
    let radius = given.unwrap_or(0.25 * height);
    (6.0 * radius > length).then(|| {
        format!("rods of radius {radius} m at the thirds of a beam of {length} m would touch one another: at most a sixth of the length")
    })
}

fn cycles(point: &Map<String, Value>) -> Option<String> {
    let (turn, end) = (number(point, "cycle_strain"), number(point, "strain_end"));
    let beyond = number(point, "cycles") > 0.0 && turn > end;
    beyond.then(|| format!("cycles turn back at {turn}, beyond strain_end = {end}"))
}

fn snapshots(point: &Map<String, Value>) -> Option<String> {
    if point.get("structure")? == false && point.get("snapshots")? == false {
        return None;
    }
    let (mold, travel) = (mold(point), number(point, "snapshot_travel"));
    let way = |strain: &str| rod_travel(&mold, number(point, strain));
    let cycles = 2.0 * number(point, "cycles") * way("cycle_strain");
    let count = 1.0 + (way("strain_end") + cycles) / travel;
    let fraction = number(point, "initial_volume_fraction");
    let radii = (number(point, "radius_min"), number(point, "radius_max"));
    let bodies = grains(&mold, fraction, radii) + vertices(&mold, edge(point));
    let most = MOST_SNAPSHOTS.min(MOST_IN_SNAPSHOTS / bodies);
    (count > most).then(|| {
        format!("{travel} would take {count:.1e} snapshots of {bodies:.1e} grains and vertices: at most {most:.0}")
    })
}

fn overlaps(point: &Map<String, Value>) -> Option<String> {
    let (warning, stop) = (
        number(point, "overlap_warning"),
        number(point, "overlap_limit"),
    );
    (warning > stop)
        .then(|| format!("{warning} is above overlap_limit = {stop}, where the run stops"))
}

impl BeamPoint {
    /// What is allowed but unwise, in full sentences.
    #[must_use]
    pub fn warnings(&self) -> Vec<String> {
        let all = [
            self.unequal_grains(),
            self.few_grains(),
            self.fine_membrane(),
            self.coarse_membrane(),
            self.fast_rods(),
            self.compressed_growth(),
        ];
        all.into_iter().flatten().collect()
    }

    fn unequal_grains(&self) -> Option<String> {
        let ratio = self.radius_max / self.radius_min;
        (ratio * ratio * ratio > 1e3).then(|| {
            format!(
                "the largest grain is more than 1000 times as heavy as the smallest (radii {ratio:.1} to 1): \
                 the lightest sets the time step"
            )
        })
    }

    fn few_grains(&self) -> Option<String> {
        let across = self.height.min(self.depth) / (self.radius_min + self.radius_max);
        (across < 5.0 && self.initial_volume_fraction > 0.0).then(|| {
            format!(
                "the beam is {across:.1} grains across: more than half of them touch the membrane, \
                 and E_b and Y_b are no material's"
            )
        })
    }

    fn fine_membrane(&self) -> Option<String> {
        let edge = self.grow().membrane_edge;
        (edge < 1.7 * self.radius_max).then(|| {
            format!("membrane_edge = {edge} is less than 1.7 radii: one contact can reach over several triangles")
        })
    }

    fn coarse_membrane(&self) -> Option<String> {
        let edge = self.grow().membrane_edge;
        let radius = self.rod_radius.unwrap_or(0.25 * self.height);
        (edge > radius).then(|| {
            format!(
                "membrane_edge = {edge} exceeds the rods' radius {radius}: \
                 triangles can fold around a rod between their vertices"
            )
        })
    }

    fn fast_rods(&self) -> Option<String> {
        let grow = self.grow();
        let way = rod_travel(&grow.dimensions(), ELASTIC_STRAIN);
        let periods = self.prediction(&grow).first_frequency() * way / self.resolved_rod_speed();
        (periods < 2.0).then(|| {
            format!(
                "ε = {ELASTIC_STRAIN} is reached in {periods:.1} periods of the beam's first mode: \
                 E_b is off by 10 % and more below 2"
            )
        })
    }

    fn compressed_growth(&self) -> Option<String> {
        let fraction = self.initial_volume_fraction;
        (fraction > 0.64).then(|| {
            format!(
                "initial_volume_fraction = {fraction} is above random close packing: \
                 the grains are compressed as they grow"
            )
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn broken(changes: &Value) -> Vec<&'static str> {
        let mut point = BeamPoint::defaults("standard").expect("a preset");
        point.extend(changes.as_object().expect("a table").clone());
        let rules = RULES.iter().filter(|rule| (rule.broken)(&point).is_some());
        rules.map(|rule| rule.parameters[0]).collect()
    }

    #[test]
    fn presets_break_no_rule() {
        for preset in super::super::parameters::PRESETS {
            let point = BeamPoint::defaults(preset.name).expect("a preset");
            for rule in RULES {
                assert_eq!((rule.broken)(&point), None, "{}", preset.name);
            }
        }
    }

    #[test]
    fn each_rule_is_broken_by_what_it_forbids_and_not_by_its_edge() {
        for (changes, blamed) in [
            (
                json!({"protocol": "B", "friction_coefficient": 0.2}),
                "friction_coefficient",
            ),
            (
                json!({"radius_min": 2.5e-3, "radius_max": 2.4e-3}),
                "radius_min",
            ),
            (json!({"confining_pressure": -1.0}), "confining_pressure"),
            (
                json!({"initial_volume_fraction": 0.5, "growth_factor": 1.0}),
                "initial_volume_fraction",
            ),
            (json!({"radius_max": 0.016}), "radius_max"),
            (json!({"membrane_edge": 0.016}), "membrane_edge"),
            // Two and a half rows across the height.
            (json!({"membrane_edge": 0.0138}), "membrane_edge"),
            (json!({"rod_radius": 0.051}), "rod_radius"),
            (json!({"cycles": 1, "cycle_strain": 0.09}), "cycle_strain"),
            (json!({"overlap_warning": 0.9}), "overlap_warning"),
            (
                json!({"structure": true, "snapshot_travel": 4e-6}),
                "snapshot_travel",
            ),
            (
                json!({"snapshots": true, "cycles": 1000}),
                "snapshot_travel",
            ),
        ] {
            assert!(broken(&changes).contains(&blamed), "{changes}");
        }
        for allowed in [
            json!({"protocol": "B", "friction_coefficient": 0.3}),
            json!({"protocol": "A", "friction_coefficient": 0.0}),
            json!({"radius_min": 2.4e-3, "radius_max": 2.4e-3}),
            json!({"confining_pressure": 0.0}),
            json!({"confining_pressure": -1.0, "allow_inflation": true}),
            json!({"initial_volume_fraction": 0.0, "growth_factor": 1.0}),
            json!({"cycle_strain": 0.09}),
            json!({"membrane_edge": 8e-3}),
            json!({"structure": true, "snapshots": true}),
            json!({"cycles": 1000, "snapshot_travel": 4e-6}),
        ] {
            assert_eq!(broken(&allowed), [""; 0], "{allowed}");
        }
    }

    #[test]
    fn heavy_grains_few_grains_and_fast_rods_are_warned_about() {
        let point = BeamPoint::from_parameters(BeamPoint::defaults("standard").expect("a preset"));
        let usual = point.expect("valid defaults");
        assert_eq!(usual.warnings(), [""; 0]);
        for unwise in [
            BeamPoint {
                radius_min: 2.2e-4,
                membrane_edge: Some(4.7e-3),
                ..usual.clone()
            },
            BeamPoint {
                height: 0.022,
                ..usual.clone()
            },
            BeamPoint {
                rod_speed: Some(0.01),
                ..usual.clone()
            },
            BeamPoint {
                membrane_edge: Some(8e-3),
                ..usual.clone()
            },
        ] {
            assert_eq!(unwise.warnings().len(), 1, "{:?}", unwise.warnings());
        }
    }
}
