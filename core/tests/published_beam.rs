//! What docs/beam/archive holds beside what the paper says of it: trends, as far as a draft carries them.
//!
//! Nothing is computed here: the archive is what the service computed from `examples/beam-table1-draft.toml`.
//! Single packings scatter by 3 % in E_b and 5 % in Y_b; margins are several times that, or the difference is one between
//! tests of the very same packing, which do not scatter.
//!
//! Source: H. Götz, T. Pöschel and O. D'Angelo, Phys. Rev. Research 6, 013061 (2024), Figs. 5 to 8, Table I.

use std::path::Path;

use granary_core::beam::point::BeamPoint;
use granary_core::stage::StageSpec;
use serde_json::{Value, json};

/// E_p \[MPa\] of all packings that are archived, each compacted with every friction of protocol A.
const COMPACTED: [f64; 1] = [100.0];

/// E_p \[MPa\] of all beams that are archived.
const BENT: [f64; 1] = [100.0];

/// μ of the packings and beams of protocol A.
const FRICTIONS: [f64; 7] = [0.0, 0.1, 0.2, 0.3, 0.6, 0.9, 1.2];

/// μ of the beams of protocol B.
const OF_B: [f64; 4] = [0.3, 0.6, 0.9, 1.2];

/// E_p \[MPa\] and μ of beams of protocol B that are archived for every one of these E_p, from soft to hard.
const OF_STIFFNESS: ([f64; 2], [f64; 2]) = ([5.0, 100.0], [0.3, 0.6]);

/// What is archived of a stage under its identity.
fn archived(spec: &StageSpec, ending: &str) -> Value {
    let directory = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/beam/archive");
    let path = directory.join(format!("{}.{ending}", spec.id().to_hex()));
    let bytes = std::fs::read(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    serde_json::from_slice(&bytes).expect("JSON")
}

fn outcome(spec: &StageSpec) -> Value {
    archived(spec, "json")["end"]["done"].clone()
}

fn number(outcome: &Value, name: &str) -> f64 {
    let value = outcome["results"][name].as_f64();
    value.unwrap_or_else(|| panic!("{name}: {:?}", outcome["reasons"]))
}

fn point(protocol: &str, modulus: f64, friction: f64) -> BeamPoint {
    let mut map = BeamPoint::defaults("draft").expect("a preset");
    let changes = json!({
        "protocol": protocol, "youngs_modulus": modulus * 1e6, "friction_coefficient": friction, "packing_seed": 1,
    });
    map.extend(changes.as_object().expect("by name").clone());
    BeamPoint::from_parameters(map).expect("valid parameters")
}

fn jam(point: &BeamPoint) -> StageSpec {
    StageSpec::Jam(point.jam(StageSpec::Grow(point.grow()).id()))
}

fn bend(point: &BeamPoint) -> StageSpec {
    StageSpec::Bend(point.bend(jam(point).id()))
}

/// A number of every beam of a protocol, by friction.
fn bent(protocol: &str, modulus: f64, name: &str) -> Vec<f64> {
    let frictions: &[f64] = if protocol == "A" { &FRICTIONS } else { &OF_B };
    let value =
        |friction: &f64| number(&outcome(&bend(&point(protocol, modulus, *friction))), name);
    frictions.iter().map(value).collect()
}

/// A number of every packing of protocol A, by friction.
fn compacted(modulus: f64, name: &str) -> Vec<f64> {
    let value = |friction: &f64| number(&outcome(&jam(&point("A", modulus, *friction))), name);
    FRICTIONS.iter().map(value).collect()
}

fn fall(values: &[f64]) -> bool {
    values.windows(2).all(|pair| pair[1] < pair[0])
}

/// T7: the rougher the grains, the looser is the packing and the fewer contacts it has; soft grains pack denser.
#[test]
fn packings_are_looser_and_have_fewer_contacts_the_rougher_and_the_harder_the_grains() {
    let rows = COMPACTED.map(|modulus| {
        let fractions = compacted(modulus, "volume_fraction");
        // From 0.6 on little changes (0.619 and 0.618 in the bulk).
        assert!(fall(&fractions[..5]), "{modulus}: {fractions:?}");
        let coordination = compacted(modulus, "coordination_number");
        assert!(fall(&coordination[..5]), "{modulus}: {coordination:?}");
        fractions
    });
    for pair in rows.windows(2) {
        let mut both = pair[0].iter().zip(&pair[1]);
        assert!(both.all(|(soft, hard)| soft > hard), "{rows:?}");
    }
}

/// T3: protocol A, hard grains: more friction is stronger up to 0.3.
///
/// Smooth grains ring through a draft: their strength is not asked for.
#[test]
fn friction_up_to_0_3_strengthens_beams_of_protocol_a() {
    for modulus in BENT {
        let strengths = [0.1, 0.2, 0.3].map(|friction| {
            number(
                &outcome(&bend(&point("A", modulus, friction))),
                "ultimate_strength",
            )
        });
        assert!(
            strengths.windows(2).all(|pair| pair[0] < pair[1]),
            "{strengths:?}"
        );
    }
}

/// T1, T2: harder grains make a stiffer and stronger beam; E_b rises with a power of E_p from 0.35 to 0.75.
#[test]
fn harder_grains_make_stiffer_and_stronger_beams() {
    let (moduli, frictions) = OF_STIFFNESS;
    for friction in frictions {
        let found = moduli.map(|modulus| {
            let beam = outcome(&bend(&point("B", modulus, friction)));
            ["beam_stiffness", "ultimate_strength"].map(|name| number(&beam, name))
        });
        for (ends, pair) in moduli.windows(2).zip(found.windows(2)) {
            assert!(pair[0][1] < pair[1][1], "{friction}: {found:?}");
            let exponent = (pair[1][0] / pair[0][0]).ln() / (ends[1] / ends[0]).ln();
            println!("{friction}: E_b rises like E_p^{exponent:.3}");
            assert!((0.35..0.75).contains(&exponent), "{friction}: {found:?}");
        }
    }
}

/// T4: protocol A: smooth grains make the softest beam, by far, and much friction does not make a stiffer one.
#[test]
fn smooth_grains_are_the_softest_of_protocol_a() {
    for modulus in BENT {
        let stiffness = bent("A", modulus, "beam_stiffness");
        let mut rough = stiffness[1..].iter();
        assert!(
            rough.all(|rough| *rough > 1.5 * stiffness[0]),
            "{stiffness:?}"
        );
        assert!(stiffness[6] <= 1.05 * stiffness[3], "{stiffness:?}");
    }
}

/// T5: protocol B, one packing: from 0.6 on friction does not stiffen the beam.
#[test]
fn stiffness_of_protocol_b_does_not_depend_on_friction() {
    for modulus in BENT {
        let stiffness = bent("B", modulus, "beam_stiffness");
        for other in &stiffness[1..] {
            assert!((other / stiffness[1] - 1.0).abs() < 0.03, "{stiffness:?}");
        }
        assert!(
            (stiffness[0] / stiffness[1] - 1.0).abs() < 0.15,
            "{stiffness:?}"
        );
    }
}

/// T6: hard grains: friction strengthens a packing, and less one that was compacted with it.
#[test]
fn strength_of_protocol_b_grows_with_friction() {
    for modulus in BENT {
        let strengths = bent("B", modulus, "ultimate_strength");
        let mut pairs = strengths.windows(2);
        assert!(pairs.all(|pair| pair[0] < pair[1]), "{strengths:?}");
        for friction in [0.6, 0.9, 1.2] {
            let of = |protocol| {
                let beam = outcome(&bend(&point(protocol, modulus, friction)));
                number(&beam, "ultimate_strength")
            };
            assert!(of("B") > of("A"), "{friction}");
        }
    }
}

/// A and B are one beam where they compact and bend with the same friction.
#[test]
fn protocols_are_one_at_the_friction_of_both() {
    let of = |protocol| bend(&point(protocol, 100.0, 0.3)).id();
    assert_eq!(of("A"), of("B"));
}

/// Samples of a running mean: contacts come and go from one to the next. 0.003 of strain, a tenth of ε_Y.
const SMOOTHED: usize = 60;

/// σ \[Pa\] where a column of a beam's record is largest, both smoothed.
fn stress_of_largest(spec: &StageSpec, column: &str) -> f64 {
    let record = archived(spec, "history");
    let smooth = |name: &str| -> Vec<f64> {
        let values = record[name].as_array().expect("a column").iter();
        let values: Vec<f64> = values.map(|value| value.as_f64().unwrap_or(0.0)).collect();
        let windows = values.windows(SMOOTHED);
        windows
            .map(|some| some.iter().sum::<f64>() / SMOOTHED as f64)
            .collect()
    };
    let pairs = smooth(column).into_iter().zip(smooth("stress"));
    let largest = pairs.max_by(|a, b| a.0.total_cmp(&b.0));
    largest.expect("samples").1
}

/// T11, T14: grains press hardest on one another, and are densest, where the beam yields; friction goes on rising.
#[test]
fn normal_force_and_volume_fraction_are_largest_at_the_ultimate_strength() {
    for modulus in BENT {
        for friction in OF_B {
            let spec = bend(&point("B", modulus, friction));
            let strength = number(&outcome(&spec), "ultimate_strength");
            for column in ["mean_normal_force", "mean_contact_force", "volume_fraction"] {
                let stress = stress_of_largest(&spec, column);
                println!(
                    "{friction}: {column} is largest at {stress:.0} Pa, Y_b = {strength:.0} Pa"
                );
                assert!((stress / strength - 1.0).abs() < 0.1, "{column}: {stress}");
            }
            let rubbing = stress_of_largest(&spec, "mean_tangential_force");
            assert!(rubbing > strength, "{rubbing}");
        }
    }
}
