//! The map as a table and as a picture.

use std::fmt::Write as _;

use super::cells::Cell;
use super::{Found, Verdict};

const ROW: f64 = 15.0;
const LEFT: f64 = 260.0;
const WIDTH: f64 = 420.0;
/// Ends of the axis, decades of t_c.
const DECADES: [f64; 2] = [-2.0, 2.0];

/// One row for each cell that departs in one factor, one dot for each corner; green is right, yellow off by less than packings
/// differ, violet noise as its score says, gray stopped, red none of these.
pub(super) fn map(cells: &[Cell], found: &[Found]) -> String {
    let x = |critical: f64| {
        let share = (critical.log10() - DECADES[0]) / (DECADES[1] - DECADES[0]);
        LEFT + WIDTH * share.clamp(0.0, 1.0)
    };
    let (mut body, mut y) = (String::new(), 50.0);
    let (mut corners_at, mut corners, mut stopped) = (None, 0, 0);
    for (cell, found) in cells.iter().zip(found) {
        let corner = cell.factor == "corner";
        corners += u32::from(corner);
        let row = if corner {
            *corners_at.get_or_insert(y + 40.0)
        } else {
            y
        };
        if !corner {
            let name = if cell.beam && !cell.factor.starts_with("beam") {
                format!("beam: {} {}", cell.factor, cell.value)
            } else {
                format!("{} {}", cell.factor, cell.value)
            };
            let _ = write!(
                body,
                "<text x=\"{}\" y=\"{}\" text-anchor=\"end\">{name}</text>",
                LEFT - 12.0,
                row + 4.0
            );
            y += ROW;
        }
        // Corners are spread so that none hides another.
        let jitter = if corner {
            let n: usize = cell.value.parse().unwrap_or(0);
            (n * 7 % 20) as f64 * 3.0 - 30.0
        } else {
            0.0
        };
        let dot = match found {
            Found::Measured(m) => {
                let color = match m.verdict() {
                    Verdict::Right => "#2a7f3f",
                    Verdict::Scattered => "#c79a1e",
                    Verdict::Noise => "#7a6fae",
                    Verdict::Off => "#c0281c",
                };
                format!(
                    "<circle cx=\"{:.1}\" cy=\"{:.1}\" r=\"4\" fill=\"{color}\"/>",
                    x(m.critical),
                    row + jitter
                )
            }
            Found::Stopped(_) if corner => {
                stopped += 1;
                continue;
            }
            Found::Stopped(reason) => {
                let short: String = reason.chars().take(48).collect();
                format!(
                    "<text x=\"{}\" y=\"{}\" fill=\"#777\">{}</text>",
                    LEFT + 6.0,
                    row + 4.0,
                    short.replace('&', "&amp;").replace('<', "&lt;")
                )
            }
        };
        body.push_str(&dot);
    }
    let bottom = corners_at.map_or(y, |at| at + 45.0);
    if let Some(at) = corners_at {
        let _ = write!(
            body,
            "<text x=\"{}\" y=\"{}\" text-anchor=\"end\">{corners} corners, {stopped} of them stopped</text>",
            LEFT - 12.0,
            at + 4.0
        );
    }
    let mut axis = String::new();
    for decade in -2..=2 {
        let at = x(10f64.powi(decade));
        let _ = write!(
            axis,
            "<path d=\"M{at:.1} 40V{bottom:.1}\" stroke=\"#ddd\"/><text x=\"{at:.1}\" y=\"34\" text-anchor=\"middle\">{}</text>",
            10f64.powi(decade)
        );
    }
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {w} {h}\" font-family=\"sans-serif\" font-size=\"11\">\
         <rect width=\"{w}\" height=\"{h}\" fill=\"#fff\"/>\
         <text x=\"{LEFT}\" y=\"16\" font-size=\"13\">largest stable time step [t_c; beams: share of the measured one]</text>\
         {axis}{body}</svg>\n",
        w = LEFT + WIDTH + 100.0,
        h = bottom + 10.0
    )
}

/// The table of what was found.
pub(super) fn table(cells: &[Cell], found: &[Found]) -> String {
    let mut text = String::from(
        "| factor | value | Δt_crit | at 0.9: 𝒢 or E_b | 𝓕 | reference's own 𝒢 or E_b | 𝓕 | noise | f32 𝒢 | 𝓕 | beyond | verdict |\n\
         |---|---|---|---|---|---|---|---|---|---|---|---|\n",
    );
    let percent = |x: Option<&f64>| x.map_or("–".to_owned(), |x| format!("{:+.2} %", 100.0 * x));
    let plain = |x: Option<&f64>| x.map_or("–".to_owned(), |x| format!("{x:+.4}"));
    for (cell, found) in cells.iter().zip(found) {
        let row = match found {
            Found::Measured(m) => {
                let single = m.single.as_deref().unwrap_or_default();
                let noise = match m.fidelity {
                    Some(_) => format!("{:.4}", m.noise),
                    None => "–".to_owned(),
                };
                format!(
                    "{:.3} | {} | {} | {} | {} | {} | {} | {} | {} | {}",
                    m.critical,
                    percent(m.deviation.first()),
                    plain(m.deviation.get(1)),
                    percent(m.own.first()),
                    plain(m.own.get(1)),
                    noise,
                    percent(single.first()),
                    plain(single.get(1)),
                    m.beyond,
                    m.verdict().name()
                )
            }
            Found::Stopped(reason) => format!("– | – | – | – | – | – | – | – | – | {reason}"),
        };
        let _ = writeln!(text, "| {} | {} | {row} |", cell.factor, cell.value);
    }
    text
}
