//! Curves over a pair of axes, with a legend beneath.

use super::ticks::{Range, powers};
use super::{Anchor, Area, Canvas, INK, LINE, PALETTE, QUIET};
use crate::figures::drawing::{Chart, Curve, Dot, Style};
use crate::table::number;

/// Room around the axes: left, above, right, below \[px\].
const ROOM: [f64; 4] = [66.0, 34.0, 14.0, 104.0];
/// Height of a line of the legend, and the length of its sample \[px\].
const LEGEND: [f64; 2] = [16.0, 22.0];
/// Mean width of a letter \[px\].
const LETTER: f64 = 6.6;
/// Height of a note, and mean width of its letters \[px\].
const NOTE: f64 = 9.5;
const NOTE_LETTER: f64 = 5.4;
/// Where the foot of a note may stand, right of its dot and down, or left of it \[px\].
const BESIDE: [[f64; 2]; 8] = [
    [6.0, -4.0],
    [6.0, 12.0],
    [-6.0, -4.0],
    [-6.0, 12.0],
    [6.0, -16.0],
    [6.0, 24.0],
    [-6.0, -16.0],
    [-6.0, 24.0],
];
/// Share of the axes that an inset takes.
const INSET: f64 = 0.46;

/// A chart with its scales.
struct Plot<'a> {
    chart: &'a Chart,
    area: Area,
    x: Range,
    y: Range,
}

pub(super) fn draw(canvas: &mut Canvas, area: Area, chart: &Chart) {
    let [left, above, right, below] = ROOM;
    let axes = Area {
        x: area.x + left,
        y: area.y + above,
        width: area.width - left - right,
        height: area.height - above - below,
    };
    canvas.styled_text(
        [area.x + left, area.y + 20.0],
        Anchor::Start,
        " font-weight=\"bold\"",
        &chart.title,
    );
    Plot::new(chart, axes).draw(canvas, 5.0);
    let middle = axes.y + 0.5 * axes.height;
    canvas.upright([area.x + 14.0, middle], &chart.y.title());
    let bottom = axes.y + axes.height;
    canvas.text(
        [axes.x + 0.5 * axes.width, bottom + 34.0],
        Anchor::Middle,
        &chart.x.title(),
    );
    legend(
        canvas,
        [area.x + 20.0, bottom + 54.0],
        area.width - 30.0,
        chart,
    );
    if let Some(inset) = &chart.inset {
        let [width, height] = [INSET * axes.width, INSET * axes.height];
        let place = Area {
            x: axes.x + axes.width - width - 8.0,
            y: bottom - height - 34.0,
            width,
            height,
        };
        canvas.rect(place, "fill=\"#ffffff\"", "");
        Plot::new(inset, place).draw(canvas, 3.0);
        let corner = [place.x + 6.0, place.y + 14.0];
        canvas.styled_text(corner, Anchor::Start, " font-size=\"10\"", &inset.title);
    }
}

impl<'a> Plot<'a> {
    fn new(chart: &'a Chart, area: Area) -> Self {
        let dots = || chart.curves.iter().flat_map(|curve| &curve.dots);
        let lines = chart.verticals.iter().map(|line| line.at);
        let ends = dots().flat_map(|dot| {
            let error = dot.error.unwrap_or_default();
            [dot.y - error, dot.y + error]
        });
        let across = dots().map(|dot| dot.x).chain(lines);
        let [x, y] = if chart.logarithmic {
            let upward = dots().map(|dot| dot.y.log10());
            [
                Range::around_powers(across.map(f64::log10)),
                Range::around_powers(upward),
            ]
        } else {
            [Range::around(across), Range::around(ends)]
        };
        Self { chart, area, x, y }
    }

    /// `value` as the axes measure it.
    fn scaled(&self, value: f64) -> f64 {
        if self.chart.logarithmic {
            value.log10()
        } else {
            value
        }
    }

    /// Where marks stand along one axis, and what they say.
    fn marks(&self, range: Range, count: f64) -> Vec<f64> {
        if self.chart.logarithmic {
            powers(range)
        } else {
            range.ticks(count)
        }
    }

    fn at(&self, x: f64, y: f64) -> [f64; 2] {
        let [x, y] = [self.scaled(x), self.scaled(y)];
        self.placed(x, y)
    }

    /// The place of numbers that the axes' own scale gives.
    fn placed(&self, x: f64, y: f64) -> [f64; 2] {
        let Area {
            x: left,
            y: top,
            width,
            height,
        } = self.area;
        [
            left + width * self.x.share(x),
            top + height * (1.0 - self.y.share(y)),
        ]
    }

    fn draw(&self, canvas: &mut Canvas, count: f64) {
        self.axes(canvas, count);
        for line in &self.chart.verticals {
            let at = self.scaled(line.at);
            let ends = [self.y.low, self.y.high].map(|y| self.placed(at, y));
            let color = PALETTE[line.color % PALETTE.len()];
            canvas.path(
                &ends,
                &format!("stroke=\"{color}\" stroke-width=\"1\" stroke-dasharray=\"2 3\""),
            );
        }
        for curve in &self.chart.curves {
            self.curve(canvas, curve);
        }
        self.notes(canvas);
        let frame = format!("fill=\"none\" stroke=\"{INK}\"");
        canvas.rect(self.area, &frame, "");
    }

    /// Each note beside its dot, in the first place where it covers no other note and no dot.
    fn notes(&self, canvas: &mut Canvas) {
        let small = format!(" font-size=\"{NOTE}\" fill=\"{QUIET}\"");
        let dots = self.chart.notes.iter().map(|note| {
            let [x, y] = self.at(note.x, note.y);
            [x - 4.0, y - 4.0, x + 4.0, y + 4.0]
        });
        let mut taken: Vec<[f64; 4]> = dots.collect();
        for note in &self.chart.notes {
            let [x, y] = self.at(note.x, note.y);
            let width = NOTE_LETTER * note.text.chars().count() as f64;
            let spot = |[right, down]: [f64; 2]| {
                let left = if right > 0.0 {
                    x + right
                } else {
                    x + right - width
                };
                [left, y + down - NOTE, left + width, y + down]
            };
            let fits = |spot: &[f64; 4]| {
                let [left, _, right, _] = *spot;
                left >= self.area.x
                    && right <= self.area.x + self.area.width
                    && !taken.iter().any(|other| overlap(spot, other))
            };
            let spots = BESIDE.into_iter().map(spot);
            let spot = spots.clone().find(fits).unwrap_or(spot(BESIDE[0]));
            canvas.styled_text([spot[0], spot[3]], Anchor::Start, &small, &note.text);
            taken.push(spot);
        }
    }

    fn axes(&self, canvas: &mut Canvas, count: f64) {
        let small = format!(" font-size=\"11\" fill=\"{QUIET}\"");
        let grid = format!("stroke=\"{LINE}\"");
        for tick in self.marks(self.x, count) {
            let at = self.scaled(tick);
            let ends = [self.y.low, self.y.high].map(|y| self.placed(at, y));
            canvas.path(&ends, &grid);
            let place = [ends[0][0], ends[0][1] + 15.0];
            canvas.styled_text(place, Anchor::Middle, &small, &number(tick));
        }
        for tick in self.marks(self.y, count) {
            let at = self.scaled(tick);
            let ends = [self.x.low, self.x.high].map(|x| self.placed(x, at));
            canvas.path(&ends, &grid);
            let place = [ends[0][0] - 5.0, ends[0][1] + 4.0];
            canvas.styled_text(place, Anchor::End, &small, &number(tick));
        }
    }

    fn curve(&self, canvas: &mut Canvas, curve: &Curve) {
        let color = PALETTE[curve.color % PALETTE.len()];
        let finite = |dot: &&Dot| self.scaled(dot.x).is_finite() && self.scaled(dot.y).is_finite();
        let dots: Vec<&Dot> = curve.dots.iter().filter(finite).collect();
        let places: Vec<[f64; 2]> = dots.iter().map(|dot| self.at(dot.x, dot.y)).collect();
        if let Some(stroke) = stroke(curve.style) {
            canvas.path(&places, &format!("stroke=\"{color}\" {stroke}"));
        }
        for (dot, place) in dots.iter().zip(&places) {
            if let Some(error) = dot.error {
                let ends = [dot.y - error, dot.y + error].map(|y| self.at(dot.x, y));
                canvas.path(&ends, &format!("stroke=\"{color}\""));
            }
            if let Some(open) = mark(curve.style) {
                canvas.mark(*place, color, open);
            }
            if curve.style == Style::Cloud {
                canvas.speck(*place, color);
            }
        }
    }
}

/// The line of a style, if it has one.
fn stroke(style: Style) -> Option<&'static str> {
    match style {
        Style::Solid | Style::Joined => Some("stroke-width=\"1.6\""),
        Style::Dashed | Style::OpenJoined => Some("stroke-width=\"1.6\" stroke-dasharray=\"6 4\""),
        Style::Dotted => Some("stroke-width=\"1.2\" stroke-dasharray=\"1.5 2.5\""),
        Style::Marks | Style::Open | Style::Cloud => None,
    }
}

/// Whether the marks of a style are open, if it has any.
fn mark(style: Style) -> Option<bool> {
    match style {
        Style::Marks | Style::Joined => Some(false),
        Style::Open | Style::OpenJoined => Some(true),
        Style::Solid | Style::Dashed | Style::Dotted | Style::Cloud => None,
    }
}

fn legend(canvas: &mut Canvas, [left, top]: [f64; 2], width: f64, chart: &Chart) {
    let [line, sample] = LEGEND;
    let [mut x, mut y] = [left, top];
    for curve in chart.curves.iter().filter(|curve| curve.told) {
        let wide = sample + 6.0 + LETTER * curve.label.chars().count() as f64 + 14.0;
        if x > left && x + wide > left + width {
            (x, y) = (left, y + line);
        }
        let color = PALETTE[curve.color % PALETTE.len()];
        if let Some(stroke) = stroke(curve.style) {
            let ends = [[x, y - 4.0], [x + sample, y - 4.0]];
            canvas.path(&ends, &format!("stroke=\"{color}\" {stroke}"));
        }
        if let Some(open) = mark(curve.style) {
            canvas.mark([x + 0.5 * sample, y - 4.0], color, open);
        }
        canvas.styled_text(
            [x + sample + 6.0, y],
            Anchor::Start,
            " font-size=\"11\"",
            &curve.label,
        );
        x += wide;
    }
}

/// Whether two boxes (left, top, right, bottom) have a place in common.
fn overlap(a: &[f64; 4], b: &[f64; 4]) -> bool {
    a[0] < b[2] && b[0] < a[2] && a[1] < b[3] && b[1] < a[3]
}
