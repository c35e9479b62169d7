//! Pictures as SVG, written by hand: axes, curves, marks and tiles are all that figures here need.

use std::fmt::Write;

use super::drawing::{Drawing, Panel};

mod chart;
mod disks;
mod heatmap;
mod ticks;

/// Size of a panel \[px\].
const PANEL: [f64; 2] = [440.0, 380.0];
/// Size of a panel that shows a beam from the side \[px\].
const LONG_PANEL: [f64; 2] = [880.0, 230.0];
/// Colors of curves, told apart also by those who see fewer.
const PALETTE: [&str; 8] = [
    "#0b6bb0", "#c2570c", "#00815f", "#a8438b", "#8a6d00", "#2b8fb8", "#6d4bb8", "#b03a48",
];
const INK: &str = "#221f1a";
const QUIET: &str = "#6b6459";
const LINE: &str = "#ddd7cc";

/// Where a text stands by its place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Anchor {
    Start,
    Middle,
    End,
}

impl Anchor {
    fn name(self) -> &'static str {
        match self {
            Self::Start => "start",
            Self::Middle => "middle",
            Self::End => "end",
        }
    }
}

/// A rectangle \[px\], y downward.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Area {
    x: f64,
    y: f64,
    width: f64,
    height: f64,
}

/// The elements so far.
#[derive(Debug, Default)]
struct Canvas {
    body: String,
}

impl Canvas {
    fn text(&mut self, [x, y]: [f64; 2], anchor: Anchor, text: &str) {
        self.styled_text([x, y], anchor, "", text);
    }

    fn styled_text(&mut self, [x, y]: [f64; 2], anchor: Anchor, style: &str, text: &str) {
        let (anchor, text) = (anchor.name(), escaped(text));
        let _ = writeln!(
            self.body,
            "<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\"{style}>{text}</text>"
        );
    }

    /// A text that is read from below, around its middle.
    fn upright(&mut self, [x, y]: [f64; 2], text: &str) {
        let style = format!(" transform=\"rotate(-90 {x:.1} {y:.1})\"");
        self.styled_text([x, y], Anchor::Middle, &style, text);
    }

    fn rect(&mut self, area: Area, style: &str, told: &str) {
        let Area {
            x,
            y,
            width,
            height,
        } = area;
        let told = match told {
            "" => String::new(),
            told => format!("<title>{}</title>", escaped(told)),
        };
        let _ = writeln!(
            self.body,
            "<rect x=\"{x:.1}\" y=\"{y:.1}\" width=\"{width:.1}\" height=\"{height:.1}\" {style}>{told}</rect>"
        );
    }

    fn path(&mut self, points: &[[f64; 2]], style: &str) {
        let mut path = String::new();
        for (k, [x, y]) in points.iter().enumerate() {
            let _ = write!(path, "{}{x:.1} {y:.1}", if k == 0 { "M" } else { "L" });
        }
        let _ = writeln!(self.body, "<path d=\"{path}\" fill=\"none\" {style}/>");
    }

    fn disk(&mut self, [x, y]: [f64; 2], radius: f64, fill: &str) {
        let _ = writeln!(
            self.body,
            "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{radius:.2}\" fill=\"{fill}\" stroke=\"{INK}\" stroke-width=\"0.3\"/>"
        );
    }

    /// A small mark that shows how many others are beneath it.
    fn speck(&mut self, [x, y]: [f64; 2], color: &str) {
        let _ = writeln!(
            self.body,
            "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"1.6\" fill=\"{color}\" fill-opacity=\"0.3\"/>"
        );
    }

    fn mark(&mut self, [x, y]: [f64; 2], color: &str, open: bool) {
        let fill = if open { "#ffffff" } else { color };
        let _ = writeln!(
            self.body,
            "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"3.5\" fill=\"{fill}\" stroke=\"{color}\" stroke-width=\"1.4\"/>"
        );
    }
}

fn escaped(text: &str) -> String {
    let text = text.replace('&', "&amp;").replace('<', "&lt;");
    text.replace('>', "&gt;").replace('"', "&quot;")
}

/// The picture of `drawing`, named `title`.
pub(crate) fn picture(drawing: &Drawing, title: &str) -> String {
    let columns = drawing.columns.clamp(1, drawing.panels.len().max(1));
    let rows = drawing.panels.len().div_ceil(columns);
    let long = drawing
        .panels
        .iter()
        .any(|panel| matches!(panel, Panel::Disks(_)));
    let size = if long { LONG_PANEL } else { PANEL };
    let mut canvas = Canvas::default();
    for (k, panel) in drawing.panels.iter().enumerate() {
        let area = Area {
            x: (k % columns) as f64 * size[0],
            y: (k / columns) as f64 * size[1],
            width: size[0],
            height: size[1],
        };
        match panel {
            Panel::Chart(chart) => chart::draw(&mut canvas, area, chart),
            Panel::Heatmap(map) => heatmap::draw(&mut canvas, area, map),
            Panel::Disks(picture) => disks::draw(&mut canvas, area, picture),
        }
        if panel.is_empty() {
            let middle = [area.x + 0.5 * area.width, area.y + 0.4 * area.height];
            canvas.text(middle, Anchor::Middle, "no number yet");
        }
    }
    let (width, height) = (columns as f64 * size[0], rows as f64 * size[1]);
    let title = escaped(title);
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width:.0} {height:.0}\" width=\"{width:.0}\" height=\"{height:.0}\" \
         role=\"img\" aria-label=\"{title}\" font-family=\"system-ui, 'DejaVu Sans', sans-serif\" font-size=\"12\" fill=\"{INK}\">\n\
         <title>{title}</title>\n<rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>\n{}</svg>\n",
        canvas.body
    )
}

#[cfg(test)]
mod tests;
