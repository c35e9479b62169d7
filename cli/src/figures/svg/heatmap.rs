//! A map of colored tiles with their numbers, and the scale of its colors beside it.

use super::{Anchor, Area, Canvas, INK, QUIET};
use crate::figures::drawing::{Heatmap, Tile};
use crate::table::number;

/// Room around the tiles: left, above, right, below \[px\].
const ROOM: [f64; 4] = [60.0, 34.0, 92.0, 60.0];
/// Colors from low to high: blue to yellow, as bright as they are large.
const COLORS: [[f64; 3]; 5] = [
    [68.0, 1.0, 84.0],
    [59.0, 82.0, 139.0],
    [33.0, 145.0, 140.0],
    [94.0, 201.0, 98.0],
    [253.0, 231.0, 37.0],
];
/// Steps of the scale.
const STEPS: u32 = 40;
/// More tiles than these in a row are drawn without their numbers.
const MOST_NUMBERS: usize = 10;

pub(super) fn draw(canvas: &mut Canvas, area: Area, map: &Heatmap) {
    let [left, above, right, below] = ROOM;
    let tiles = Area {
        x: area.x + left,
        y: area.y + above,
        width: area.width - left - right,
        height: area.height - above - below,
    };
    canvas.styled_text(
        [tiles.x, area.y + 20.0],
        Anchor::Start,
        " font-weight=\"bold\"",
        &map.title,
    );
    let range = map.range().unwrap_or([0.0, 1.0]);
    let size = [
        tiles.width / map.across.len().max(1) as f64,
        tiles.height / map.upward.len().max(1) as f64,
    ];
    for (row, y) in map.tiles.iter().enumerate() {
        for (column, tile) in y.iter().enumerate() {
            let place = Area {
                x: tiles.x + column as f64 * size[0],
                y: tiles.y + tiles.height - (row + 1) as f64 * size[1],
                width: size[0],
                height: size[1],
            };
            draw_tile(canvas, place, tile, map, range);
        }
    }
    canvas.rect(tiles, &format!("fill=\"none\" stroke=\"{INK}\""), "");
    axes(canvas, tiles, size, map);
    scale(canvas, tiles, map, range);
}

fn draw_tile(canvas: &mut Canvas, place: Area, tile: &Tile, map: &Heatmap, range: [f64; 2]) {
    let middle = [
        place.x + 0.5 * place.width,
        place.y + 0.5 * place.height + 4.0,
    ];
    let numbers = map.across.len() <= MOST_NUMBERS;
    let Some(value) = tile.value else {
        canvas.rect(place, "fill=\"#eeeeee\"", &tile.reason);
        let words = tile.reason.split_whitespace();
        for (k, word) in words.take(4).filter(|_| numbers).enumerate() {
            let style = format!(" font-size=\"8\" fill=\"{QUIET}\"");
            let at = [middle[0], middle[1] - 12.0 + 10.0 * k as f64];
            canvas.styled_text(at, Anchor::Middle, &style, word);
        }
        return;
    };
    let share = share(value, range);
    let told = format!("{} {}", number(value), map.value.unit);
    canvas.rect(place, &format!("fill=\"{}\"", color(share)), told.trim());
    if numbers {
        let ink = if share > 0.55 { "#000000" } else { "#ffffff" };
        let style = format!(" font-size=\"10\" fill=\"{ink}\"");
        canvas.styled_text(middle, Anchor::Middle, &style, &short(value));
    }
}

/// Three significant digits.
pub(super) fn short(value: f64) -> String {
    let places = (2.0 - value.abs().max(1e-9).log10().floor()).clamp(0.0, 9.0);
    number(
        format!("{value:.*}", places as usize)
            .parse()
            .unwrap_or(value),
    )
}

pub(super) fn share(value: f64, [low, high]: [f64; 2]) -> f64 {
    if high > low {
        (value - low) / (high - low)
    } else {
        0.5
    }
}

/// The color of a share from 0 to 1.
pub(super) fn color(share: f64) -> String {
    let place = share.clamp(0.0, 1.0) * (COLORS.len() - 1) as f64;
    let below = (place.floor() as usize).min(COLORS.len() - 2);
    let part = place - below as f64;
    let mixed = |k: usize| COLORS[below][k] + part * (COLORS[below + 1][k] - COLORS[below][k]);
    let [red, green, blue] = [0, 1, 2].map(|k| mixed(k).round() as u8);
    format!("#{red:02x}{green:02x}{blue:02x}")
}

fn axes(canvas: &mut Canvas, tiles: Area, size: [f64; 2], map: &Heatmap) {
    let small = format!(" font-size=\"11\" fill=\"{QUIET}\"");
    let bottom = tiles.y + tiles.height;
    // Values of a grid are long and many: some are named, rounded.
    let every = |count: usize| match count {
        0..=MOST_NUMBERS => 1,
        _ => count.div_ceil(MOST_NUMBERS / 2),
    };
    for (column, value) in map
        .across
        .iter()
        .enumerate()
        .step_by(every(map.across.len()))
    {
        let x = tiles.x + (column as f64 + 0.5) * size[0];
        canvas.styled_text([x, bottom + 15.0], Anchor::Middle, &small, &short(*value));
    }
    for (row, value) in map
        .upward
        .iter()
        .enumerate()
        .step_by(every(map.upward.len()))
    {
        let y = bottom - (row as f64 + 0.5) * size[1] + 4.0;
        canvas.styled_text([tiles.x - 6.0, y], Anchor::End, &small, &short(*value));
    }
    let middle = [tiles.x + 0.5 * tiles.width, tiles.y + 0.5 * tiles.height];
    canvas.text([middle[0], bottom + 36.0], Anchor::Middle, &map.x.title());
    canvas.upright([tiles.x - 44.0, middle[1]], &map.y.title());
}

fn scale(canvas: &mut Canvas, tiles: Area, map: &Heatmap, [low, high]: [f64; 2]) {
    let left = color_bar(canvas, tiles);
    let small = format!(" font-size=\"11\" fill=\"{QUIET}\"");
    for (y, value) in [(tiles.y + 10.0, high), (tiles.y + tiles.height, low)] {
        canvas.styled_text([left, y], Anchor::Start, &small, &short(value));
    }
    canvas.upright(
        [left + 38.0, tiles.y + 0.5 * tiles.height],
        &map.value.title(),
    );
}

/// Draws the scale of colors to the right of a map, as high as it; where its numbers begin.
pub(super) fn color_bar(canvas: &mut Canvas, tiles: Area) -> f64 {
    let left = tiles.x + tiles.width + 14.0;
    let step = tiles.height / f64::from(STEPS);
    for k in 0..STEPS {
        let place = Area {
            x: left,
            y: tiles.y + tiles.height - f64::from(k + 1) * step,
            width: 14.0,
            height: step + 0.5,
        };
        let share = (f64::from(k) + 0.5) / f64::from(STEPS);
        canvas.rect(place, &format!("fill=\"{}\"", color(share)), "");
    }
    left + 18.0
}
