use std::collections::BTreeMap;

use granary_api::table::{PointRow, SetRow};
use granary_core::memory::waveform::{SAMPLES, Waveform, sample_u};
use serde_json::{Value, json};

use super::contact::CONTACTS;
use super::data::{History, Structure};
use super::drawing::{Chart, Panel, Style};
use super::*;

#[test]
fn figures_are_those_of_the_server_in_its_order() {
    let names: Vec<&str> = ALL.iter().map(|figure| figure.name).collect();
    let known = granary_server::figures::FIGURES.iter();
    assert_eq!(names, known.map(|figure| figure.name).collect::<Vec<_>>());
}

fn point(number: u64, parameters: &Value, results: &Value) -> PointRow {
    let job = format!("b3:{}", "0".repeat(64));
    let row = json!({"point": number, "state": "done", "parameters": parameters, "results": results,
        "warnings": [], "job": job, "result_hash": null});
    serde_json::from_value(row).expect("a point")
}

fn drawn(name: &str, data: &Data) -> Drawing {
    match Figure::named(name).expect("a figure").shown {
        Shown::Picture(draw) => draw(data),
        Shown::Table => panic!("{name} is no picture"),
    }
}

fn chart(drawing: &Drawing, panel: usize) -> &drawing::Chart {
    match &drawing.panels[panel] {
        Panel::Chart(chart) => chart,
        _ => panic!("no chart"),
    }
}

/// Two packings at two frictions, of two moduli; one has no strength.
fn beams(protocol: &str) -> Data {
    let mut points = vec![];
    for modulus in [5e6, 100e6] {
        for friction in [0.3, 1.2] {
            for seed in [1, 2] {
                let parameters = json!({"protocol": protocol, "youngs_modulus": modulus,
                    "friction_coefficient": friction, "packing_seed": seed});
                let strength = 1e-3 * modulus * friction + f64::from(seed) * 1e3;
                let mut results =
                    json!({"beam_stiffness": modulus / 20.0, "ultimate_strength": strength});
                if modulus < 1e7 && friction > 1.0 {
                    results["ultimate_strength"] = Value::Null;
                    results["ultimate_strength_reason"] = json!("not_prominent");
                }
                points.push(point(points.len() as u64, &parameters, &results));
            }
        }
    }
    Data {
        points,
        ..Data::default()
    }
}

#[test]
fn map_averages_packings_in_the_units_of_the_paper_and_gives_reasons() {
    let drawing = drawn("fig6", &beams("A"));
    let Panel::Heatmap(map) = &drawing.panels[1] else {
        panic!("no map");
    };
    assert_eq!(
        (&map.across, &map.upward),
        (&vec![0.3, 1.2], &vec![5.0, 100.0])
    );
    let tile = &map.tiles[1][0];
    assert!((tile.value.expect("a mean") - 31.5).abs() < 1e-9);
    assert!((tile.error.expect("two packings") - 0.5).abs() < 1e-9);
    let csv = drawing.panels[1].csv();
    let lines: Vec<&str> = csv[0].1.lines().collect();
    assert_eq!(
        lines[0],
        "friction_coefficient,youngs_modulus_mpa,ultimate_strength_kpa,sem,n,of,reason"
    );
    assert_eq!(lines[2], "1.2,5,,,0,2,not prominent");
}

#[test]
fn strengths_stand_beside_both_fits() {
    let mut data = beams("B");
    data.sets = vec![fit(100e6, "B")];
    let drawing = drawn("fig8", &data);
    let strength = chart(&drawing, 1);
    let of = |style: Style| {
        let mut all = strength
            .curves
            .iter()
            .filter(move |curve| curve.style == style && !curve.dots.is_empty());
        all.next_back().expect("a curve")
    };
    assert_eq!(of(Style::Open).label, "100 MPa, B");
    // (30 − 120) exp(−3·1.2) + 120 of ours, and Table I's row of both at the end of the axis.
    let last = |style: Style| of(style).dots.last().expect("dots").y;
    assert!((last(Style::Dashed) - 117.540_865).abs() < 1e-5);
    assert!((last(Style::Dotted) - 116.670_006).abs() < 1e-4);
}

fn fit(modulus: f64, protocol: &str) -> SetRow {
    let row = json!({"set": 0, "reduce": "ultimate_strength_fit", "shape": "exponential",
        "parameters": {"youngs_modulus": modulus, "protocol": protocol},
        "results": {"strength_zero_friction": 30e3, "strength_zero_friction_error": 2e3,
            "strength_infinite_friction": 120e3, "strength_rate": 3.0},
        "n": 4, "of": 4, "provisional": false});
    serde_json::from_value(row).expect("a set")
}

#[test]
fn table_has_the_published_parameters_beside_ours() {
    let data = Data {
        sets: vec![fit(100e6, "B"), fit(20e6, "A")],
        ..Data::default()
    };
    let text = tables::fits(&data).render();
    let words = |line: &str| line.split_whitespace().collect::<Vec<_>>().join(" ");
    let lines: Vec<String> = text.lines().map(words).collect();
    // What was never published has no number beside it.
    assert_eq!(lines[1], "20 A 30.00 ± 2.00 120.00 3.00 exponential 4 of 4");
    assert_eq!(
        lines[2],
        "100 B 30.00 ± 2.00 35.65 120.00 119.41 3.00 2.85 exponential 4 of 4"
    );
    let csv = tables::fits_csv(&data);
    assert!(
        csv.ends_with("100,B,30,2,35.65,120,,119.41,3,,2.85,exponential,4,4\n"),
        "{csv}"
    );
}

#[test]
fn curve_is_drawn_with_its_stiffness_its_strength_and_a_cycle() {
    let found =
        json!({"beam_stiffness": 1e7, "beam_stiffness_intercept": 0.0, "ultimate_strength": 90e3});
    let history = History {
        strain: vec![0.0, 0.001, 0.002, 0.05],
        stress: vec![0.0, 10e3, 20e3, 100e3],
        ..History::default()
    };
    let cyclic = History {
        rod_travel: vec![0.0, 2.0, 0.5, 1.0, 3.0],
        strain: vec![0.0, 0.002, 0.0005, 0.001, 0.01],
        stress: vec![0.0, 20e3, 3e3, 9e3, 60e3],
        ..History::default()
    };
    let data = Data {
        points: vec![
            point(0, &json!({"cycles": 0}), &found),
            point(1, &json!({"cycles": 3}), &found),
        ],
        histories: BTreeMap::from([(0, history), (1, cyclic)]),
        ..Data::default()
    };
    let drawing = drawn("fig5", &data);
    let whole = chart(&drawing, 0);
    let labels: Vec<&str> = whole
        .curves
        .iter()
        .map(|curve| curve.label.as_str())
        .collect();
    assert_eq!(labels, ["bending", "E_b", "Y_b"]);
    let end = whole.curves[1].dots[1];
    assert!((end.x - 0.01).abs() < 1e-12 && (end.y - 100.0).abs() < 1e-9);
    let inset = whole.inset.as_ref().expect("a cycle");
    // There, back, and again as far as it went before.
    let strains: Vec<f64> = inset.curves[0].dots.iter().map(|dot| dot.x).collect();
    assert_eq!(strains, [0.0, 0.002, 0.0005, 0.001]);
    let files: Vec<&str> = drawing.panels[0]
        .csv()
        .iter()
        .map(|(what, _)| *what)
        .collect();
    assert_eq!(files, ["", "-inset"]);
}

#[test]
fn forces_are_drawn_over_stress_with_a_line_at_the_strength() {
    let row = point(
        0,
        &json!({"friction_coefficient": 0.3}),
        &json!({"ultimate_strength": 80e3}),
    );
    let history = History {
        stress: vec![1e3; 20],
        mean_contact_force: vec![2.0; 20],
        mean_normal_force: vec![1.9; 20],
        mean_tangential_force: vec![0.3; 20],
        coulomb_fraction: (0..20).map(|k| (k >= 10).then_some(0.2)).collect(),
        ..History::default()
    };
    let data = Data {
        points: vec![row],
        histories: BTreeMap::from([(0, history)]),
        ..Data::default()
    };
    let drawing = drawn("fig9", &data);
    assert_eq!(chart(&drawing, 0).curves[0].dots.len(), 2);
    assert!((chart(&drawing, 2).curves[0].dots[1].y - 0.3).abs() < 1e-9);
    assert_eq!(chart(&drawing, 3).curves[0].dots.len(), 1);
    assert!((chart(&drawing, 3).verticals[0].at - 80.0).abs() < 1e-9);
}

/// A beam of diameter 5 mm with one change at 180 kPa.
fn inside() -> Structure {
    serde_json::from_value(json!({
        "mean_diameter": 0.005, "snapshot_travel": 5e-4,
        "snapshots": [{"stress": 0.0, "pair_correlation":
            {"distances": [0.005, 0.010], "paper": {"all": [0.5, 0.3], "bulk": null}, "normalized": []}}],
        "changes": [{"stress": 180e3, "non_affine": {"all": 5e-5, "bulk": null},
            "height_profile": [{"height": -0.005, "value": 1.0, "count": 100},
                {"height": 0.0, "value": null, "count": 0}, {"height": 0.005, "value": 9.0, "count": 1}],
            "autocorrelation": {"distances": [0.0, 0.005], "printed": [], "connected": [], "decay_length": null},
            "displacement": {"low": [0.0, 0.0, 0.0], "spacing": [0.01, 1.0, 0.01], "count": [2, 1, 1],
                "values": [[1e-6, 0.0, 0.0], null]}}],
        "by_stress": {"height_profile": [{"from": 175e3, "curves": 1, "mean": [1.1, null, 9.0]}],
            "autocorrelation": [{"from": 175e3, "curves": 1, "mean": [0.5, 0.4]}]},
    }))
    .expect("a structure")
}

#[test]
fn inside_of_a_beam_is_told_in_diameters_and_intervals_of_stress() {
    let parameters = json!({"friction_coefficient": 0.3, "youngs_modulus": 100e6, "protocol": "A",
        "confining_pressure": 90e3, "initial_volume_fraction": 0.5});
    let data = Data {
        points: vec![point(0, &parameters, &json!({}))],
        structures: BTreeMap::from([(0, inside())]),
        ..Data::default()
    };
    let dots = |name: &str, panel: usize| {
        let drawing = drawn(name, &data);
        let curve = &chart(&drawing, panel).curves[0];
        let dots = curve.dots.iter().map(|dot| [dot.x, dot.y]);
        (curve.label.clone(), dots.collect::<Vec<_>>())
    };
    assert_eq!(
        dots("fig4", 0),
        ("φ_init = 0.5".to_owned(), vec![[1.0, 0.5], [2.0, 0.3]])
    );
    assert_eq!(
        dots("fig12", 0),
        ("175–200 kPa".to_owned(), vec![[0.0, 1.0], [1.0, 0.8]])
    );
    assert_eq!(dots("fig14", 0).1, [[-5.0, 1.1]]);
    assert_eq!(
        dots("fig15", 0),
        ("μ_p = 0.3".to_owned(), vec![[-5.0, 1.1]])
    );
    // 100 MPa by protocol A stands in the third row: ⟨D_min⟩ on the left.
    assert_eq!(dots("fig16", 4).1, [[180.0, 0.01]]);
    let field = drawn("fig10", &data);
    assert!(
        field.panels[0].csv()[0]
            .1
            .contains("\n10,0,,,0,0,too few grains\n")
    );
}

/// Two snapshots of three grains, one above the other; D_min and φ of the middle one are unknown at first.
const DUMP: &str = "ITEM: TIMESTEP
10
ITEM: NUMBER OF ATOMS
3
ITEM: BOX BOUNDS ff ff ff
-1 1
-1 1
-1 1
ITEM: ATOMS id type x y z radius vx vy vz d_min phi contacts
1 1 0 0 -0.005 0.0025 0 0 0 nan 0.5 2
2 1 0 0.02 0.001 0.0025 0 0 0 nan nan 2
3 1 0 0 0.005 0.0025 0 0 0 nan 0.6 2
ITEM: TIMESTEP
20
ITEM: NUMBER OF ATOMS
3
ITEM: BOX BOUNDS ff ff ff
-1 1
-1 1
-1 1
ITEM: ATOMS id type x y z radius vx vy vz d_min phi contacts
1 1 0 0 -0.005 0.0025 0 0 0 1e-4 0.49 2
2 1 0 0.02 0.001 0.0025 0 0 0 2e-4 0.55 2
3 1 0 0 0.005 0.0025 0 0 0 5e-5 0.63 2
";

#[test]
fn single_grains_are_drawn_in_their_places_and_by_the_half_that_they_are_in() {
    let data = Data {
        points: vec![point(0, &json!({}), &json!({}))],
        structures: BTreeMap::from([(0, inside())]),
        grains: BTreeMap::from([(0, grains::read(DUMP.as_bytes()).expect("a dump"))]),
        ..Data::default()
    };
    // The one change is nearest to both stresses. The middle grain is not in the cut, 0.02 m behind it.
    let cut = drawn("fig11", &data);
    assert_eq!(cut.panels.len(), 2);
    let rows = "x_mm,z_mm,radius_mm,non_affine_d\n0,-5,2.5,0.02\n0,5,2.5,0.01\n";
    assert_eq!(cut.panels[0].csv()[0].1, rows);
    let picture = svg::picture(&cut, "Figure 11");
    assert_eq!(picture.matches("<circle").count(), 4);
    let over = drawn("fig13", &data);
    let dots = |panel: usize| chart(&over, panel).curves[0].dots.clone();
    let [top, bottom] = [dots(0), dots(1)];
    // φ of the middle grain was not known before.
    assert_eq!([top.len(), bottom.len()], [1, 1]);
    assert!((top[0].x - 0.03).abs() < 1e-12 && (top[0].y - 0.01).abs() < 1e-12);
    assert!((bottom[0].x + 0.01).abs() < 1e-12 && (bottom[0].y - 0.02).abs() < 1e-12);
    assert!((chart(&over, 0).verticals[0].at - 0.03).abs() < 1e-12);
}

#[test]
fn dump_with_a_broken_line_is_refused_with_the_line() {
    let broken = DUMP.replace("0.49 2", "0.49 2\n4 1 0 zero");
    let error = grains::read(broken.as_bytes()).expect_err("a broken line");
    assert!(error.to_string().contains("`4 1 0 zero`"), "{error}");
}

#[test]
fn figure_without_data_has_no_numbers_and_says_so() {
    let drawing = drawn("fig8", &Data::default());
    assert!(drawing.panels.iter().all(Panel::is_empty));
    let named = pictures("fig8", "fig8: E_b and Y_b over μ_p", &drawing);
    assert_eq!(named.len(), 1);
    assert!(named[0].1.contains("<title>fig8: E_b and Y_b over μ_p"));
}

#[test]
fn figures_of_one_contact_are_drawn_without_a_sweep() {
    let drawn = |name: &str| {
        let figure = CONTACTS.iter().find(|figure| figure.name == name);
        (figure.expect("a figure").draw)()
    };
    let charts = |drawing: &Drawing| -> Vec<Chart> {
        let charts = drawing.panels.iter().map(|panel| match panel {
            Panel::Chart(chart) => chart.clone(),
            other => panic!("{other:?}"),
        });
        charts.collect()
    };
    let last_but_end = |chart: &Chart, label: &str| {
        let curve = chart.curves.iter().find(|curve| curve.label == label);
        let dots = &curve.expect("a curve").dots;
        // At the largest overlap, before the contact parts.
        let deepest = dots.iter().rfind(|dot| dot.x >= 1.0).expect("pressed to 1");
        deepest.y
    };
    // 0.8 k_M √½ + 0.2 k_M, and k_H.
    let full = 0.8 * 0.5f64.sqrt() + 0.2;
    let laws = charts(&drawn("memory-10"));
    for (label, force) in [("M1", full), ("M2", full), ("H", 0.6)] {
        let found = last_but_end(&laws[1], label);
        assert!((found - force).abs() < 1e-12, "{label}: {found}");
    }
    // As printed: sheared at p = ½, where the outermost slice counts as a whole once the overlap has grown beyond it, less the
    // half of the first; then at 1 by the printed weight, x_p − ½.
    let width = 1.5f64.sqrt() / 99.0;
    let [at_half, at_one] = [0.5f64, 1.0].map(|overlap| overlap.sqrt() / width);
    let expected = width * (0.8 * (at_half.floor() + 0.5) + 0.2 * (at_one - 0.5));
    let slices = charts(&drawn("memory-15"));
    let printed = last_but_end(&slices[0], "Q = 100");
    assert!((printed - expected).abs() < 1e-12, "{printed} {expected}");
    let ours = last_but_end(&slices[1], "Q = 100");
    assert!((ours - full).abs() < 1e-12, "{ours}");
}

/// A mean over packings.
fn mean_of(parameters: &Value, processing: &str, results: &Value) -> SetRow {
    let row = json!({"set": 0, "reduce": "mean_sem", "processing": processing, "parameters": parameters,
        "results": results, "n": 3, "of": 3, "provisional": false});
    serde_json::from_value(row).expect("a set")
}

#[test]
fn memory_figures_show_means_beside_what_was_published() {
    let fidelity = |mu: f64, value: f64| {
        let results = json!({"fidelity": value, "fidelity_sem": 0.01});
        mean_of(&json!({"friction_coefficient": mu}), "SUB0", &results)
    };
    let data = Data {
        sets: vec![fidelity(1.0, 0.9), fidelity(0.0, 0.05)],
        ..Data::default()
    };
    let drawing = drawn("memory-8", &data);
    let curves = &chart(&drawing, 0).curves;
    let own: Vec<[f64; 2]> = curves[0].dots.iter().map(|dot| [dot.x, dot.y]).collect();
    assert_eq!(own, [[0.0, 0.05], [1.0, 0.9]]);
    assert_eq!(curves[0].dots[0].error, Some(0.01));
    let published: Vec<f64> = curves[1].dots.iter().map(|dot| dot.x).collect();
    assert_eq!(published, [0.0, 0.4, 1.0]);
    // (0.5236 + 0.5392 + 0.5438 + 0.5231 + 0.5177)/5, from the file by hand.
    assert!((curves[1].dots[1].y - 0.529_48).abs() < 1e-12);
    let words = |bits: u32, processing: &str, results: &Value| {
        mean_of(&json!({"bits": bits}), processing, results)
    };
    let data = Data {
        sets: vec![
            words(7, "SUB2-BL", &json!({"fidelity": 0.7})),
            words(3, "SUB2-BL", &json!({"fidelity": 0.8})),
            words(3, "SUB0", &json!({"fidelity": 0.75})),
            words(3, "SUB2-BL", &json!({"recognition_accuracy": 1.0})),
        ],
        ..Data::default()
    };
    let drawing = drawn("memory-14", &data);
    let lengths: Vec<Vec<f64>> = chart(&drawing, 0)
        .curves
        .iter()
        .map(|curve| curve.dots.iter().map(|dot| dot.x).collect())
        .collect();
    assert_eq!(lengths, [vec![3.0], vec![], vec![3.0, 7.0], vec![3.0]]);
}

#[test]
fn recalled_signals_are_scaled_to_what_was_stored() {
    // Two signals that come back 5 Pa per unit of J, on a background that the zero waveform has too.
    let waveforms = ["six/1", "six/4", "zero"];
    let mut data = Data::default();
    for (number, name) in (0..).zip(waveforms) {
        data.points.push(point(
            number,
            &json!({"waveform": name, "packing_seed": 1}),
            &json!({}),
        ));
        let curve = Waveform::parse(&json!(name)).expect("a waveform").curve();
        let decode = (0..SAMPLES).map(|k| 100.0 - 5.0 * curve.integral(sample_u(k)));
        let signal =
            json!({"encode": [], "decode": decode.collect::<Vec<f64>>(), "second_decode": []});
        let signal = serde_json::from_value(signal).expect("a signal");
        data.signals.insert(number, signal);
    }
    let drawing = drawn("memory-6", &data);
    assert_eq!(drawing.panels.len(), 2, "the zero waveform is no signal");
    for panel in 0..2 {
        let [recalled, stored] = &chart(&drawing, panel).curves[..] else {
            panic!("two curves");
        };
        for (a, b) in recalled.dots.iter().zip(&stored.dots) {
            assert!((a.y - b.y).abs() < 1e-12, "{} {}", a.y, b.y);
        }
    }
}
