//! What a figure shows, before it is a picture or a file: charts and maps of numbers.

use std::fmt::Write;

use crate::table::number;

/// What an axis, or the color of a map, stands for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Axis {
    /// The symbol of the paper.
    pub(crate) symbol: &'static str,
    /// Empty for a pure number.
    pub(crate) unit: &'static str,
    /// The name of its column in a file, unit included.
    pub(crate) column: &'static str,
}

impl Axis {
    /// Symbol and unit.
    pub(crate) fn title(&self) -> String {
        match self.unit {
            "" => self.symbol.to_owned(),
            unit => format!("{} ({unit})", self.symbol),
        }
    }
}

/// How a curve is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Style {
    /// A line.
    Solid,
    /// A dashed line.
    Dashed,
    /// A dotted, thin line: what others published.
    Dotted,
    /// Filled marks alone.
    Marks,
    /// Open marks alone.
    Open,
    /// Filled marks, joined.
    Joined,
    /// Open marks, joined by dashes.
    OpenJoined,
    /// Small marks that are seen through, for thousands of dots.
    Cloud,
}

/// One number over another, with the standard error of a mean.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Dot {
    pub(crate) x: f64,
    pub(crate) y: f64,
    pub(crate) error: Option<f64>,
}

impl Dot {
    /// A number without error.
    pub(crate) fn new(x: f64, y: f64) -> Self {
        Self { x, y, error: None }
    }
}

/// Dots that belong together.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Curve {
    /// What the legend and the file call it.
    pub(crate) label: String,
    /// Whether the legend names it.
    pub(crate) told: bool,
    /// Place in the palette.
    pub(crate) color: usize,
    pub(crate) style: Style,
    pub(crate) dots: Vec<Dot>,
}

/// A vertical line.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Vertical {
    /// What the file calls it.
    pub(crate) label: String,
    pub(crate) at: f64,
    pub(crate) color: usize,
}

/// A word beside a dot.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Note {
    pub(crate) x: f64,
    pub(crate) y: f64,
    pub(crate) text: String,
}

/// Curves over one pair of axes.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Chart {
    pub(crate) title: String,
    pub(crate) x: Axis,
    pub(crate) y: Axis,
    /// Whether both axes go by powers of ten; what is not positive is then not drawn.
    pub(crate) logarithmic: bool,
    pub(crate) notes: Vec<Note>,
    pub(crate) curves: Vec<Curve>,
    pub(crate) verticals: Vec<Vertical>,
    /// A smaller chart in its lower right corner.
    pub(crate) inset: Option<Box<Chart>>,
}

impl Chart {
    /// An empty chart.
    pub(crate) fn new(title: &str, x: Axis, y: Axis) -> Self {
        Self {
            title: title.to_owned(),
            x,
            y,
            logarithmic: false,
            notes: vec![],
            curves: vec![],
            verticals: vec![],
            inset: None,
        }
    }

    fn csv(&self) -> String {
        let mut text = csv_line(["series", self.x.column, self.y.column, "sem"]);
        for curve in &self.curves {
            for dot in &curve.dots {
                let error = dot
                    .error
                    .map_or_else(String::new, |error| error.to_string());
                let [x, y] = [dot.x, dot.y].map(|value| value.to_string());
                text += &csv_line([curve.label.as_str(), &x, &y, &error]);
            }
        }
        for line in &self.verticals {
            text += &csv_line([line.label.as_str(), &line.at.to_string(), "", ""]);
        }
        text
    }
}

/// One tile of a map: a mean over packings, or why there is none.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Tile {
    pub(crate) value: Option<f64>,
    pub(crate) error: Option<f64>,
    /// Packings with a number.
    pub(crate) n: usize,
    /// Packings in all.
    pub(crate) of: usize,
    /// Why packings have none.
    pub(crate) reason: String,
}

/// One number over two, as colors, without interpolation.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Heatmap {
    pub(crate) title: String,
    pub(crate) x: Axis,
    pub(crate) y: Axis,
    pub(crate) value: Axis,
    /// Values of `x`, rising.
    pub(crate) across: Vec<f64>,
    /// Values of `y`, rising.
    pub(crate) upward: Vec<f64>,
    /// By `upward`, then by `across`.
    pub(crate) tiles: Vec<Vec<Tile>>,
}

impl Heatmap {
    /// The least and the largest value.
    pub(crate) fn range(&self) -> Option<[f64; 2]> {
        let values = self.tiles.iter().flatten().filter_map(|tile| tile.value);
        values.fold(None, |range, value| match range {
            None => Some([value, value]),
            Some([low, high]) => Some([value.min(low), value.max(high)]),
        })
    }

    fn csv(&self) -> String {
        let columns = [self.x.column, self.y.column, self.value.column];
        let mut text = csv_line(columns.into_iter().chain(["sem", "n", "of", "reason"]));
        for (y, row) in self.upward.iter().zip(&self.tiles) {
            for (x, tile) in self.across.iter().zip(row) {
                let shown = |value: Option<f64>| value.map_or_else(String::new, |v| v.to_string());
                text += &csv_line([
                    x.to_string().as_str(),
                    &y.to_string(),
                    &shown(tile.value),
                    &shown(tile.error),
                    &tile.n.to_string(),
                    &tile.of.to_string(),
                    &tile.reason,
                ]);
            }
        }
        text
    }
}

/// A disk in its place, with a number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Disk {
    pub(crate) x: f64,
    pub(crate) y: f64,
    pub(crate) radius: f64,
    pub(crate) value: Option<f64>,
}

/// Disks on axes of one scale, colored by their numbers; later ones lie on top.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Disks {
    pub(crate) title: String,
    pub(crate) x: Axis,
    pub(crate) y: Axis,
    pub(crate) value: Axis,
    pub(crate) all: Vec<Disk>,
}

impl Disks {
    fn csv(&self) -> String {
        let columns = [self.x.column, self.y.column, "radius_mm", self.value.column];
        let mut text = csv_line(columns);
        for disk in &self.all {
            let value = disk
                .value
                .map_or_else(String::new, |value| value.to_string());
            let [x, y, radius] = [disk.x, disk.y, disk.radius].map(|number| number.to_string());
            text += &csv_line([x.as_str(), &y, &radius, &value]);
        }
        text
    }
}

/// One part of a figure.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Panel {
    Chart(Chart),
    Heatmap(Heatmap),
    Disks(Disks),
}

impl Panel {
    /// Its file, and that of its inset.
    pub(crate) fn csv(&self) -> Vec<(&'static str, String)> {
        match self {
            Self::Heatmap(map) => vec![("", map.csv())],
            Self::Disks(picture) => vec![("", picture.csv())],
            Self::Chart(chart) => {
                let inset = chart.inset.iter().map(|inset| ("-inset", inset.csv()));
                std::iter::once(("", chart.csv())).chain(inset).collect()
            }
        }
    }

    /// Whether there is any number in it.
    pub(crate) fn is_empty(&self) -> bool {
        match self {
            Self::Heatmap(map) => map.range().is_none(),
            Self::Disks(picture) => picture.all.is_empty(),
            Self::Chart(chart) => chart.curves.iter().all(|curve| curve.dots.is_empty()),
        }
    }
}

/// A figure: its panels, so many side by side.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Drawing {
    pub(crate) panels: Vec<Panel>,
    pub(crate) columns: usize,
}

/// One line of a file, quoted where it must be.
pub(crate) fn csv_line<'a>(cells: impl IntoIterator<Item = &'a str>) -> String {
    let quoted = |cell: &str| {
        if cell.contains([',', '"', '\n']) {
            format!("\"{}\"", cell.replace('"', "\"\""))
        } else {
            cell.to_owned()
        }
    };
    let mut line = String::new();
    for (k, cell) in cells.into_iter().enumerate() {
        let comma = if k == 0 { "" } else { "," };
        let _ = write!(line, "{comma}{}", quoted(cell));
    }
    line + "\n"
}

/// A parameter as a legend tells it.
pub(crate) fn told(symbol: &str, value: f64) -> String {
    format!("{symbol} = {}", number(value))
}
