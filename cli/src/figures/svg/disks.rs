//! Disks in their places, colored by a number, with the scale of the colors beside them.

use super::heatmap::{color, color_bar, share, short};
use super::ticks::Range;
use super::{Anchor, Area, Canvas, INK, QUIET};
use crate::figures::drawing::Disks;
use crate::table::number;

/// Room around the axes: left, above, right, below \[px\].
const ROOM: [f64; 4] = [66.0, 34.0, 92.0, 60.0];
/// Where what stands right of the axes ends \[px\].
const RIGHT: f64 = 86.0;
/// Share of the values that the scale of colors spans: a few grains move much farther than all others.
const SPANNED: f64 = 0.98;

pub(super) fn draw(canvas: &mut Canvas, area: Area, picture: &Disks) {
    let [left, above, right, below] = ROOM;
    let room = [area.width - left - right, area.height - above - below];
    let x = Range::around_all(
        picture
            .all
            .iter()
            .flat_map(|d| [d.x - d.radius, d.x + d.radius]),
    );
    let y = Range::around_all(
        picture
            .all
            .iter()
            .flat_map(|d| [d.y - d.radius, d.y + d.radius]),
    );
    let sides = [x.high - x.low, y.high - y.low];
    // One scale for both axes: disks are round.
    let scale = (room[0] / sides[0]).min(room[1] / sides[1]);
    let axes = Area {
        x: area.x + left,
        y: area.y + above + 0.5 * (room[1] - scale * sides[1]),
        width: scale * sides[0],
        height: scale * sides[1],
    };
    canvas.styled_text(
        [axes.x, axes.y - 10.0],
        Anchor::Start,
        " font-weight=\"bold\"",
        &picture.title,
    );
    let range = spanned(picture);
    for disk in &picture.all {
        let center = [
            axes.x + scale * (disk.x - x.low),
            axes.y + scale * (y.high - disk.y),
        ];
        let fill = disk
            .value
            .map_or_else(|| "#eeeeee".to_owned(), |value| color(share(value, range)));
        canvas.disk(center, scale * disk.radius, &fill);
    }
    canvas.rect(axes, &format!("fill=\"none\" stroke=\"{INK}\""), "");
    ticks(canvas, axes, [x, y], picture);
    bar(canvas, axes, picture, range);
}

/// From zero to what nearly all values stay below.
fn spanned(picture: &Disks) -> [f64; 2] {
    let mut values: Vec<f64> = picture.all.iter().filter_map(|disk| disk.value).collect();
    values.sort_by(f64::total_cmp);
    let last = (SPANNED * values.len() as f64) as usize;
    let high = values.get(last.min(values.len().saturating_sub(1)));
    [0.0, high.copied().unwrap_or(1.0)]
}

fn ticks(canvas: &mut Canvas, axes: Area, [x, y]: [Range; 2], picture: &Disks) {
    let small = format!(" font-size=\"11\" fill=\"{QUIET}\"");
    let bottom = axes.y + axes.height;
    for tick in x.ticks(6.0) {
        let place = [axes.x + axes.width * x.share(tick), bottom + 15.0];
        canvas.styled_text(place, Anchor::Middle, &small, &number(tick));
    }
    for tick in y.ticks(3.0) {
        let place = [axes.x - 6.0, bottom - axes.height * y.share(tick) + 4.0];
        canvas.styled_text(place, Anchor::End, &small, &number(tick));
    }
    let middle = axes.x + 0.5 * axes.width;
    canvas.text([middle, bottom + 34.0], Anchor::Middle, &picture.x.title());
    canvas.upright(
        [axes.x - 44.0, axes.y + 0.5 * axes.height],
        &picture.y.title(),
    );
}

/// The scale of the colors.
fn bar(canvas: &mut Canvas, axes: Area, picture: &Disks, [low, high]: [f64; 2]) {
    let left = color_bar(canvas, axes);
    let small = format!(" font-size=\"11\" fill=\"{QUIET}\"");
    let high = format!("≥ {}", short(high));
    for (y, value) in [(axes.y + 10.0, high), (axes.y + axes.height, short(low))] {
        canvas.styled_text([left, y], Anchor::Start, &small, &value);
    }
    canvas.text(
        [axes.x + axes.width + RIGHT, axes.y - 10.0],
        Anchor::End,
        &picture.value.title(),
    );
}
