//! What docs/beam/archive holds beside what the paper says of it: trends, as far as a draft carries them.
//!
//! Nothing is computed here: the archive is what the service computed from `examples/beam-table1-draft.toml`.
//! Packings of this size scatter by 10 to 20 % in E_b and Y_b, the scatter of a beam of given packing is below 0.1 %:
//! what is compared is what the same grains do, placed alike before they grow.
//!
//! Source: H. Götz, T. Pöschel and O. D'Angelo, Phys. Rev. Research 6, 013061 (2024), Figs. 5 to 8, Table I.

use std::path::Path;

use granary_core::beam::point::BeamPoint;
use granary_core::stage::StageSpec;
use serde_json::{Value, json};

/// E_p \[MPa\] of all packings that are archived, each compacted with every friction of protocol A.
const COMPACTED: [f64; 3] = [10.0, 50.0, 100.0];

/// E_p \[MPa\] and seed of the packings that are bent with all frictions of both protocols.
const BENT: [(f64, u64); 3] = [(100.0, 1), (100.0, 2), (100.0, 3)];

/// μ of the packings and beams of protocol A.
const FRICTIONS: [f64; 7] = [0.0, 0.1, 0.2, 0.3, 0.6, 0.9, 1.2];

/// μ of the beams of protocol B.
const OF_B: [f64; 4] = [0.3, 0.6, 0.9, 1.2];

/// E_p \[MPa\] and μ of beams of protocol B that are archived for every one of these E_p, from soft to hard.
const OF_STIFFNESS: ([f64; 4], [f64; 4]) = ([5.0, 10.0, 50.0, 100.0], OF_B);

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

fn point(protocol: &str, (modulus, seed): (f64, u64), friction: f64) -> BeamPoint {
    let mut map = BeamPoint::defaults("draft").expect("a preset");
    let changes = json!({
        "protocol": protocol, "youngs_modulus": modulus * 1e6, "friction_coefficient": friction, "packing_seed": seed,
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
fn bent(protocol: &str, packing: (f64, u64), name: &str) -> Vec<f64> {
    let frictions: &[f64] = if protocol == "A" { &FRICTIONS } else { &OF_B };
    let value =
        |friction: &f64| number(&outcome(&bend(&point(protocol, packing, *friction))), name);
    frictions.iter().map(value).collect()
}

/// A number of every packing of protocol A, by friction.
fn compacted(modulus: f64, name: &str) -> Vec<f64> {
    let value = |friction: &f64| number(&outcome(&jam(&point("A", (modulus, 1), *friction))), name);
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
    for packing in BENT {
        let strengths = [0.1, 0.2, 0.3].map(|friction| {
            number(
                &outcome(&bend(&point("A", packing, friction))),
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
            let beam = outcome(&bend(&point("B", (modulus, 1), friction)));
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
    for packing in BENT {
        let stiffness = bent("A", packing, "beam_stiffness");
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
    for packing in BENT {
        let stiffness = bent("B", packing, "beam_stiffness");
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
    for packing in BENT {
        let strengths = bent("B", packing, "ultimate_strength");
        let mut pairs = strengths.windows(2);
        assert!(pairs.all(|pair| pair[0] < pair[1]), "{strengths:?}");
        for friction in [0.6, 0.9, 1.2] {
            let of = |protocol| {
                let beam = outcome(&bend(&point(protocol, packing, friction)));
                number(&beam, "ultimate_strength")
            };
            assert!(of("B") > of("A"), "{friction}");
        }
    }
}

/// A and B are one beam where they compact and bend with the same friction.
#[test]
fn protocols_are_one_at_the_friction_of_both() {
    let of = |protocol| bend(&point(protocol, (100.0, 1), 0.3)).id();
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
    for packing in BENT {
        for friction in OF_B {
            let spec = bend(&point("B", packing, friction));
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

/// The beams whose inside is archived, to ε = 0.06: E_p \[MPa\] and μ, protocol B.
const LOOKED_INTO: [(f64, f64); 3] = [(100.0, 0.3), (100.0, 1.2), (10.0, 0.3)];

/// What the inside of a beam does along its bending.
struct Inside {
    structure: Value,
    /// ε_Y.
    yield_strain: f64,
}

impl Inside {
    fn of(modulus: f64, friction: f64) -> Self {
        let spec = bend(&BeamPoint {
            structure: true,
            strain_end_over_yield: 0.0,
            ..point("B", (modulus, 1), friction)
        });
        Self {
            structure: archived(&spec, "structure"),
            yield_strain: number(&outcome(&spec), "yield_strain"),
        }
    }

    /// The median of a number of the changes between snapshots for ε from `from` to `to`: single bursts do not move it.
    fn median(&self, (from, to): (f64, f64), value: impl Fn(&Value) -> Option<f64>) -> f64 {
        let changes = self.structure["changes"].as_array().expect("a list");
        let strain = |change: &Value| change["strain"].as_f64().unwrap_or(0.0);
        let within = changes
            .iter()
            .filter(|change| (from..to).contains(&strain(change)));
        let mut values: Vec<f64> = within.filter_map(value).collect();
        values.sort_by(f64::total_cmp);
        values[values.len() / 2]
    }

    /// The median of ⟨Δφ⟩ or ⟨D_min⟩ in a half of the beam.
    fn half(&self, strains: (f64, f64), name: &str, half: &str) -> f64 {
        self.median(strains, |change| change[name][half].as_f64())
    }
}

/// T8: packings are amorphous.
#[test]
fn packings_are_amorphous() {
    for (modulus, friction) in LOOKED_INTO {
        let inside = Inside::of(modulus, friction);
        let order = inside.structure["snapshots"][0]["bond_order"]["bulk"]["global"].as_f64();
        let order = order.expect("a bulk");
        assert!(order < 0.05, "{modulus}, {friction}: {order}");
    }
}

/// T12: the top half is compressed until the beam yields, and less and less after; the bottom half dilates, the more the longer.
#[test]
fn top_is_compressed_until_the_yield_and_the_bottom_dilates() {
    for (modulus, friction) in LOOKED_INTO {
        let inside = Inside::of(modulus, friction);
        let at = inside.yield_strain;
        let parts = [
            (0.0, 0.5 * at),
            (0.5 * at, at),
            (at, 1.5 * at),
            (1.5 * at, 0.06),
        ];
        let of = |half| parts.map(|part| inside.half(part, "volume_fraction_change", half));
        let (top, bottom) = (of("top"), of("bottom"));
        println!("{modulus} MPa, {friction}: top {top:?}, bottom {bottom:?}");
        assert!(top[0] > 0.0 && top[1] > 0.0, "{top:?}");
        assert!(fall(&top) && top[3] < 0.15 * top[0], "{top:?}");
        assert!(
            fall(&bottom) && bottom[1..].iter().all(|change| *change < 0.0),
            "{bottom:?}"
        );
    }
}

/// T13: grains move more by themselves in the top half early, in the bottom half late.
#[test]
fn grains_rearrange_first_at_the_top_and_then_at_the_bottom() {
    for (modulus, friction) in LOOKED_INTO {
        let inside = Inside::of(modulus, friction);
        let ratio = |strains| {
            let of = |half| inside.half(strains, "non_affine", half);
            of("top") / of("bottom")
        };
        let (early, late) = (
            ratio((0.0, 0.003)),
            ratio((1.5 * inside.yield_strain, 0.06)),
        );
        println!("{modulus} MPa, {friction}: top over bottom {early:.2}, then {late:.2}");
        assert!(early > 1.0 && late < 0.7, "{early} {late}");
    }
}

/// T16: the neutral plane rises through the beam.
#[test]
fn neutral_plane_rises() {
    for (modulus, friction) in LOOKED_INTO {
        let inside = Inside::of(modulus, friction);
        let at = inside.yield_strain;
        let height = |change: &Value| {
            // Between the rods, a sixth of the span to either side.
            let slabs = change["neutral_plane"].as_array()?.iter();
            let between = slabs.filter(|slab| slab["x"].as_f64().is_some_and(|x| x.abs() < 0.04));
            let heights: Vec<f64> = between.filter_map(|slab| slab["height"].as_f64()).collect();
            Some(heights.iter().sum::<f64>() / heights.len() as f64)
        };
        let parts = [
            (0.0, 0.005),
            (0.4 * at, 0.8 * at),
            (0.8 * at, 1.2 * at),
            (1.2 * at, 1.6 * at),
        ];
        let heights = parts.map(|part| inside.median(part, height));
        println!("{modulus} MPa, {friction}: {heights:?} m above the middle");
        assert!(
            heights.windows(2).all(|pair| pair[0] < pair[1]),
            "{heights:?}"
        );
        assert!(heights[0] < 0.0 && heights[3] > 0.0, "{heights:?}");
    }
}
