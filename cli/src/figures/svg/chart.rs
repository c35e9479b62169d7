//! Curves over a pair of axes, with a legend beneath.

use super::ticks::Range;
use super::{Anchor, Area, Canvas, INK, LINE, PALETTE, QUIET};
use crate::figures::drawing::{Chart, Curve, Dot, Style};
use crate::table::number;

/// Room around the axes: left, above, right, below \[px\].
const ROOM: [f64; 4] = [66.0, 34.0, 14.0, 104.0];
/// Height of a line of the legend, and the length of its sample \[px\].
const LEGEND: [f64; 2] = [16.0, 22.0];
/// Mean width of a letter \[px\].
const LETTER: f64 = 6.6;
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
        Self {
            chart,
            area,
            x: Range::around(dots().map(|dot| dot.x).chain(lines)),
            y: Range::around(ends),
        }
    }

    fn at(&self, x: f64, y: f64) -> [f64; 2] {
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
            let ends = [self.y.low, self.y.high].map(|y| self.at(line.at, y));
            let color = PALETTE[line.color % PALETTE.len()];
            canvas.path(
                &ends,
                &format!("stroke=\"{color}\" stroke-width=\"1\" stroke-dasharray=\"2 3\""),
            );
        }
        for curve in &self.chart.curves {
            self.curve(canvas, curve);
        }
        let frame = format!("fill=\"none\" stroke=\"{INK}\"");
        canvas.rect(self.area, &frame, "");
    }

    fn axes(&self, canvas: &mut Canvas, count: f64) {
        let small = format!(" font-size=\"11\" fill=\"{QUIET}\"");
        let grid = format!("stroke=\"{LINE}\"");
        for tick in self.x.ticks(count) {
            let ends = [self.y.low, self.y.high].map(|y| self.at(tick, y));
            canvas.path(&ends, &grid);
            let place = [ends[0][0], ends[0][1] + 15.0];
            canvas.styled_text(place, Anchor::Middle, &small, &number(tick));
        }
        for tick in self.y.ticks(count) {
            let ends = [self.x.low, self.x.high].map(|x| self.at(x, tick));
            canvas.path(&ends, &grid);
            let place = [ends[0][0] - 5.0, ends[0][1] + 4.0];
            canvas.styled_text(place, Anchor::End, &small, &number(tick));
        }
    }

    fn curve(&self, canvas: &mut Canvas, curve: &Curve) {
        let color = PALETTE[curve.color % PALETTE.len()];
        let finite = |dot: &&Dot| dot.x.is_finite() && dot.y.is_finite();
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
