//! Space cut into equal boxes, so that what is near is found without looking at all there is.
//!
//! The engine's own grid serves its neighbor lists; these answer single questions about points and boxes.

use std::ops::ControlFlow;

use crate::math::plain;

/// The boxes.
#[derive(Clone, Debug)]
struct Layout {
    low: [f64; 3],
    width: f64,
    count: [usize; 3],
}

impl Layout {
    /// Boxes of at least `width` from `low` to `high`, and at most four for each of the `items`.
    fn new(low: [f64; 3], high: [f64; 3], width: f64, items: usize) -> Self {
        let most = 4 * items + 64;
        let mut width = if width > 0.0 { width } else { 1.0 };
        loop {
            let count: [usize; 3] =
                std::array::from_fn(|k| (((high[k] - low[k]) / width) as usize).saturating_add(1));
            let cells = count[0]
                .checked_mul(count[1])
                .and_then(|cells| cells.checked_mul(count[2]));
            if cells.is_some_and(|cells| cells <= most) {
                return Self { low, width, count };
            }
            width *= 1.26;
        }
    }

    /// The box that holds `point`, or the nearest one. Conversion sends what is negative to 0.
    fn place(&self, point: [f64; 3]) -> [usize; 3] {
        std::array::from_fn(|k| {
            (((point[k] - self.low[k]) / self.width) as usize).min(self.count[k] - 1)
        })
    }

    fn index(&self, [x, y, z]: [usize; 3]) -> usize {
        (z * self.count[1] + y) * self.count[0] + x
    }

    fn cells(&self) -> usize {
        self.count.iter().product()
    }

    /// The indices of the rows of boxes, each along x, from the box `from` to the box `to`.
    fn rows(&self, from: [usize; 3], to: [usize; 3]) -> impl Iterator<Item = (usize, usize)> {
        (from[2]..=to[2]).flat_map(move |z| {
            (from[1]..=to[1])
                .map(move |y| (self.index([from[0], y, z]), self.index([to[0], y, z]) + 1))
        })
    }
}

/// The smallest box around `points`; empty around none.
pub(super) fn bounds(points: impl IntoIterator<Item = [f64; 3]>) -> Option<[[f64; 3]; 2]> {
    let mut points = points.into_iter();
    let first = points.next()?;
    Some(points.fold([first; 2], |[low, high], point| {
        [
            std::array::from_fn(|k| low[k].min(point[k])),
            std::array::from_fn(|k| high[k].max(point[k])),
        ]
    }))
}

/// Numbers sorted by cell: those of cell c stand in `members[starts[c]..starts[c + 1]]`, ascending.
fn sort_by_cell(cells: usize, of: &[(usize, usize)]) -> (Vec<usize>, Vec<usize>) {
    let mut starts = vec![0; cells + 1];
    for (cell, _) in of {
        starts[cell + 1] += 1;
    }
    for cell in 0..cells {
        starts[cell + 1] += starts[cell];
    }
    let mut next = starts.clone();
    let mut members = vec![0; of.len()];
    for (cell, member) in of {
        members[next[*cell]] = *member;
        next[*cell] += 1;
    }
    (starts, members)
}

/// Points to be found by their distance from a place.
#[derive(Clone, Debug)]
pub(super) struct PointGrid {
    layout: Layout,
    starts: Vec<usize>,
    members: Vec<usize>,
    /// The points in the order of `members`.
    points: Vec<[f64; 3]>,
}

impl PointGrid {
    /// `points` in cells of about `width`.
    pub(super) fn new(points: &[[f64; 3]], width: f64) -> Self {
        let [low, high] = bounds(points.iter().copied()).unwrap_or_default();
        let layout = Layout::new(low, high, width, points.len());
        let of: Vec<_> = points
            .iter()
            .enumerate()
            .map(|(i, &point)| (layout.index(layout.place(point)), i))
            .collect();
        let (starts, members) = sort_by_cell(layout.cells(), &of);
        let points = members.iter().map(|&i| points[i]).collect();
        Self {
            layout,
            starts,
            members,
            points,
        }
    }

    /// Calls `visit` with each point nearer than `radius` to `center`: its number, its branch from there and the square of its distance.
    pub(super) fn visit(
        &self,
        center: [f64; 3],
        radius: f64,
        mut visit: impl FnMut(usize, [f64; 3], f64),
    ) {
        let from = self.layout.place(center.map(|x| x - radius));
        let to = self.layout.place(center.map(|x| x + radius));
        for (first, end) in self.layout.rows(from, to) {
            for at in self.starts[first]..self.starts[end] {
                let branch = plain::sub(self.points[at], center);
                let square = plain::dot(branch, branch);
                if square < radius * radius {
                    visit(self.members[at], branch, square);
                }
            }
        }
    }
}

/// Boxes to be found by what they overlap.
#[derive(Clone, Debug)]
pub(super) struct BoxGrid {
    layout: Layout,
    starts: Vec<usize>,
    members: Vec<usize>,
    /// The lowest cell of each box.
    first: Vec<[usize; 3]>,
}

impl BoxGrid {
    /// `boxes`, each its low and its high corner, in cells of about `width`.
    pub(super) fn new(boxes: &[[[f64; 3]; 2]], width: f64) -> Self {
        let [low, high] = bounds(boxes.iter().flatten().copied()).unwrap_or_default();
        let layout = Layout::new(low, high, width, boxes.len());
        let mut of = vec![];
        for (member, [low, high]) in boxes.iter().enumerate() {
            let (from, to) = (layout.place(*low), layout.place(*high));
            for (first, end) in layout.rows(from, to) {
                of.extend((first..end).map(|cell| (cell, member)));
            }
        }
        let (starts, members) = sort_by_cell(layout.cells(), &of);
        let first = boxes.iter().map(|[low, _]| layout.place(*low)).collect();
        Self {
            layout,
            starts,
            members,
            first,
        }
    }

    /// Calls `visit` once with each box that may overlap the one from `low` to `high`, until it breaks.
    ///
    /// A box that lies in several cells is met in the lowest cell that it shares with the question.
    pub(super) fn visit(
        &self,
        low: [f64; 3],
        high: [f64; 3],
        mut visit: impl FnMut(usize) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        let (from, to) = (self.layout.place(low), self.layout.place(high));
        for (first, end) in self.layout.rows(from, to) {
            for cell in first..end {
                for &member in &self.members[self.starts[cell]..self.starts[cell + 1]] {
                    let meeting = std::array::from_fn(|k| self.first[member][k].max(from[k]));
                    if self.layout.index(meeting) == cell {
                        visit(member)?;
                    }
                }
            }
        }
        ControlFlow::Continue(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::{Purpose, uniform3};

    fn random(count: u64) -> Vec<[f64; 3]> {
        let stretched = |n| {
            let [x, y, z] = uniform3(3, Purpose::GasVelocity, n);
            [7.0 * x, 3.0 * y, z]
        };
        (0..count).map(stretched).collect()
    }

    #[test]
    fn points_within_a_radius_are_all_found_once() {
        let points = random(500);
        for width in [0.1, 0.7, 50.0, 0.0] {
            let grid = PointGrid::new(&points, width);
            for center in random(20) {
                for radius in [0.3, 1.5, 100.0] {
                    let mut found = vec![];
                    grid.visit(center, radius, |i, _, _| found.push(i));
                    found.sort_unstable();
                    let near = |&i: &usize| plain::norm(plain::sub(points[i], center)) < radius;
                    let expected: Vec<usize> = (0..points.len()).filter(near).collect();
                    assert_eq!(found, expected);
                }
            }
        }
    }

    #[test]
    fn boxes_that_overlap_are_all_found_once() {
        let boxes: Vec<[[f64; 3]; 2]> = random(400)
            .into_iter()
            .map(|low| [low, plain::add(low, [0.4, 0.9, 0.1])])
            .collect();
        let grid = BoxGrid::new(&boxes, 0.5);
        for low in random(20) {
            let high = plain::add(low, [0.2, 0.3, 5.0]);
            let mut found = vec![];
            let end = grid.visit(low, high, |member| {
                found.push(member);
                ControlFlow::Continue(())
            });
            assert!(end.is_continue());
            found.sort_unstable();
            let apart = found.windows(2).all(|pair| pair[0] < pair[1]);
            assert!(apart, "one is found twice");
            for (member, [from, to]) in boxes.iter().enumerate() {
                let overlap = (0..3).all(|k| from[k] <= high[k] && to[k] >= low[k]);
                assert!(!overlap || found.binary_search(&member).is_ok());
            }
        }
    }

    #[test]
    fn grids_of_nothing_find_nothing() {
        PointGrid::new(&[], 1.0).visit([0.0; 3], 9.0, |_, _, _| panic!("there is no point"));
        let end = BoxGrid::new(&[], 1.0).visit([0.0; 3], [1.0; 3], |_| ControlFlow::Break(()));
        assert!(end.is_continue());
    }

    #[test]
    fn points_far_apart_make_few_cells() {
        let grid = PointGrid::new(&[[0.0; 3], [1e9, 1e9, 1e9]], 1e-3);
        assert!(grid.layout.cells() <= 72);
    }
}
