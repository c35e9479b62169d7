//! Figures of a single contact, which need no sweep: 10 and 15 of the memory paper.
//!
//! E. Dwight and D. Candela, arXiv:2603.14595.

use granary_core::contact::hooke::Hooke;
use granary_core::contact::mindlin_rescale::MindlinRescale;
use granary_core::contact::mindlin_sliced::MindlinSliced;
use granary_core::contact::path::{Place, Printed, exact, figure_10, response};

use super::drawing::{Axis, Chart, Curve, Dot, Drawing, Panel, Style};

/// A figure that is drawn at once.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ContactFigure {
    /// What the command line calls it.
    pub(crate) name: &'static str,
    /// What it shows, in a few words.
    pub(crate) shows: &'static str,
    pub(crate) draw: fn() -> Drawing,
}

/// All of them.
pub(crate) const CONTACTS: &[ContactFigure] = &[
    ContactFigure {
        name: "memory-10",
        shows: "σ and f_e of one contact over its overlap, laws H, M1 and M2",
        draw: laws,
    },
    ContactFigure {
        name: "memory-15",
        shows: "law M2 by slices, as printed and as it is here, beside the integral",
        draw: slices,
    },
];

const OVERLAP: Axis = Axis {
    symbol: "p",
    unit: "",
    column: "overlap",
};
const SLIP: Axis = Axis {
    symbol: "σ",
    unit: "",
    column: "slip",
};
const FORCE: Axis = Axis {
    symbol: "f_e",
    unit: "",
    column: "elastic_force",
};

/// Places of each leg of the path.
const STEPS: u32 = 200;
/// k_M, and k_H as much smaller as the paper draws it.
const MINDLIN: f64 = 1.0;
const HOOKE: f64 = 0.6;
/// p_max of Fig. 15.
const LARGEST_OVERLAP: f64 = 1.5;

fn over_overlap(
    (label, color, style): (&str, usize, Style),
    path: &[Place],
    values: &[f64],
) -> Curve {
    let dots = path.iter().zip(values);
    Curve {
        label: label.to_owned(),
        told: true,
        color,
        style,
        dots: dots.map(|(at, &y)| Dot::new(at.overlap, y)).collect(),
    }
}

/// Figure 10.
fn laws() -> Drawing {
    let path = figure_10(STEPS);
    let slips: Vec<f64> = path.iter().map(|place| place.slip).collect();
    let mut way = Chart::new("(a)", OVERLAP, SLIP);
    way.curves
        .push(over_overlap(("path", 0, Style::Solid), &path, &slips));
    let rescaled = MindlinRescale {
        stiffness: MINDLIN,
        damping: 0.0,
        friction_coefficient: 1.0,
    };
    let hooke = Hooke {
        stiffness: HOOKE,
        damping: 0.0,
        friction_coefficient: 1.0,
    };
    let mut forces = Chart::new("(b)", OVERLAP, FORCE);
    forces.curves = vec![
        over_overlap(("M2", 0, Style::Solid), &path, &exact(MINDLIN, &path)),
        over_overlap(("M1", 1, Style::Dashed), &path, &response(&rescaled, &path)),
        over_overlap(("H", 2, Style::Dotted), &path, &response(&hooke, &path)),
    ];
    Drawing {
        panels: vec![Panel::Chart(way), Panel::Chart(forces)],
        columns: 2,
    }
}

/// Figure 15, with the parting alone, and our own slices beside it.
fn slices() -> Drawing {
    let path = figure_10(STEPS);
    let printed = |slices: usize, with_h: bool| {
        let law = Printed {
            stiffness: MINDLIN,
            slices,
            largest_overlap: LARGEST_OVERLAP,
            with_h,
        };
        law.response(&path)
    };
    let ours = |slices: u32| {
        let law = MindlinSliced {
            stiffness: MINDLIN,
            damping: 0.0,
            friction_coefficient: 1.0,
            slices,
            largest_overlap: LARGEST_OVERLAP,
        };
        response(&law, &path)
    };
    let integral = exact(MINDLIN, &path);
    let integral = |chart: &mut Chart| {
        chart.curves.push(over_overlap(
            ("the integral", 0, Style::Solid),
            &path,
            &integral,
        ));
    };
    let mut as_printed = Chart::new("(a) as printed", OVERLAP, FORCE);
    integral(&mut as_printed);
    for (label, color, style, slices, with_h) in [
        ("Q = 20 without h", 2, Style::Dotted, 20, false),
        ("Q = 20", 1, Style::Dashed, 20, true),
        ("Q = 100", 3, Style::Dashed, 100, true),
    ] {
        let force = printed(slices, with_h);
        as_printed
            .curves
            .push(over_overlap((label, color, style), &path, &force));
    }
    let mut as_here = Chart::new("(b) contents of slices, as here", OVERLAP, FORCE);
    integral(&mut as_here);
    for (label, color, slices) in [("Q = 20", 1, 20), ("Q = 100", 3, 100)] {
        as_here.curves.push(over_overlap(
            (label, color, Style::Dashed),
            &path,
            &ours(slices),
        ));
    }
    Drawing {
        panels: vec![Panel::Chart(as_printed), Panel::Chart(as_here)],
        columns: 2,
    }
}
