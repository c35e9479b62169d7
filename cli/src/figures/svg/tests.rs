use super::*;
use crate::figures::drawing::{Axis, Chart, Curve, Dot, Heatmap, Note, Style, Tile, Vertical};

const STRAIN: Axis = Axis {
    symbol: "ε",
    unit: "",
    column: "strain",
};
const STRESS: Axis = Axis {
    symbol: "σ",
    unit: "kPa",
    column: "stress_kpa",
};

fn chart() -> Chart {
    let curve = Curve {
        label: "A & B".to_owned(),
        told: true,
        color: 1,
        style: Style::Solid,
        dots: vec![Dot::new(0.0, 0.0), Dot::new(100.0, 100.0)],
    };
    Chart {
        curves: vec![curve],
        ..Chart::new("(a)", STRAIN, STRESS)
    }
}

fn drawn(panel: Panel) -> String {
    let drawing = Drawing {
        panels: vec![panel],
        columns: 1,
    };
    picture(&drawing, "Figure 0")
}

#[test]
fn curve_runs_from_corner_to_corner_within_its_axes() {
    let text = drawn(Panel::Chart(chart()));
    // Axes from (66, 34), 360 by 242; both scales from 0 to 105, so the far end lies 100/105 of the way.
    assert!(
        text.contains("<path d=\"M66.0 276.0L408.9 45.5\" fill=\"none\" stroke=\"#c2570c\" stroke-width=\"1.6\"/>"),
        "{text}"
    );
}

#[test]
fn axes_and_legend_are_labelled_and_escaped() {
    let text = drawn(Panel::Chart(chart()));
    for label in [
        ">σ (kPa)<",
        ">ε<",
        ">(a)<",
        ">A &amp; B<",
        ">50<",
        "<title>Figure 0</title>",
    ] {
        assert!(text.contains(label), "{label}");
    }
}

#[test]
fn marks_errors_and_verticals_are_drawn() {
    let mut chart = chart();
    chart.curves[0].style = Style::OpenJoined;
    chart.curves[0].dots[1].error = Some(5.0);
    chart.verticals.push(Vertical {
        label: "Y_b".to_owned(),
        at: 50.0,
        color: 0,
    });
    let text = drawn(Panel::Chart(chart));
    // Two of the curve and one of the legend.
    assert_eq!(text.matches("<circle").count(), 3);
    assert!(text.contains("stroke-dasharray=\"2 3\""));
}

#[test]
fn notes_of_near_dots_stand_apart() {
    let mut chart = chart();
    let place = chart.curves[0].dots[0];
    for text in ["ramp 6000, drag 0.01", "preset draft", "as written"] {
        chart.notes.push(Note {
            x: place.x,
            y: place.y,
            text: text.to_owned(),
        });
    }
    let text = drawn(Panel::Chart(chart));
    let feet: Vec<&str> = text
        .lines()
        .filter(|line| line.contains("font-size=\"9.5\""))
        .map(|line| line.split(" text-anchor").next().expect("a place"))
        .collect();
    let places: std::collections::BTreeSet<&str> = feet.iter().copied().collect();
    assert_eq!((feet.len(), places.len()), (3, 3), "{feet:?}");
}

#[test]
fn dot_that_is_no_number_leaves_no_trace() {
    let mut chart = chart();
    chart.curves[0].dots.push(Dot::new(1.0, f64::NAN));
    assert!(!drawn(Panel::Chart(chart)).contains("NaN"));
}

#[test]
fn chart_without_numbers_says_so() {
    let empty = Chart::new("(a)", STRAIN, STRESS);
    assert!(drawn(Panel::Chart(empty)).contains(">no number yet<"));
    assert!(!drawn(Panel::Chart(chart())).contains("no number yet"));
}

#[test]
fn tiles_have_colors_numbers_and_reasons() {
    let tile = |value: Option<f64>, reason: &str| Tile {
        value,
        reason: reason.to_owned(),
        ..Tile::default()
    };
    let map = Heatmap {
        title: "(a)".to_owned(),
        x: STRAIN,
        y: STRAIN,
        value: STRESS,
        across: vec![0.1, 0.3, 0.6],
        upward: vec![5.0],
        tiles: vec![vec![
            tile(Some(20.0), ""),
            tile(Some(96.15), ""),
            tile(None, "not prominent"),
        ]],
    };
    let text = drawn(Panel::Heatmap(map));
    assert!(text.contains("fill=\"#440154\"><title>20 kPa</title>"));
    assert!(text.contains("fill=\"#fde725\"><title>96.15 kPa</title>"));
    assert!(text.contains(">96.2<"));
    assert!(text.contains("<title>not prominent</title>"));
    assert!(text.contains(">prominent<"));
}
