//! Cells: points sorted into boxes of space.

/// Points by the boxes that they are in; kept so that later sorts allocate nothing.
#[derive(Clone, Debug, Default)]
pub struct Cells {
    layout: Layout,
    /// Cell of each point.
    of_points: Vec<u32>,
    /// Points of cell c: `members[starts[c]..starts[c + 1]]`, ascending.
    starts: Vec<u32>,
    members: Vec<u32>,
}

/// The boxes that space is cut into.
#[derive(Clone, Debug, Default)]
struct Layout {
    low: [f64; 3],
    width: [f64; 3],
    count: [usize; 3],
}

impl Layout {
    /// Cells of at least `width`, and no more of them than about two a point, however far apart the points are.
    fn new(points: &[[f64; 3]], width: f64) -> Self {
        let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        for point in points {
            for axis in 0..3 {
                low[axis] = low[axis].min(point[axis]);
                high[axis] = high[axis].max(point[axis]);
            }
        }
        let most = 2 * points.len() + 64;
        let mut widths = [width; 3];
        loop {
            let count: [usize; 3] =
                std::array::from_fn(|k| (((high[k] - low[k]) / widths[k]) as usize).max(1));
            match count[0]
                .checked_mul(count[1])
                .and_then(|n| n.checked_mul(count[2]))
            {
                Some(cells) if cells <= most => {
                    return Self {
                        low,
                        width: widths,
                        count,
                    };
                }
                _ => widths = widths.map(|w| w * 1.26),
            }
        }
    }

    /// The cell of a point; of one outside, the nearest.
    fn coordinates(&self, point: [f64; 3]) -> [usize; 3] {
        std::array::from_fn(|k| {
            (((point[k] - self.low[k]) / self.width[k]) as usize).min(self.count[k] - 1)
        })
    }

    fn index(&self, [x, y, z]: [usize; 3]) -> usize {
        (z * self.count[1] + y) * self.count[0] + x
    }
}

impl Cells {
    /// Sorts `points` into cells of at least `width`, by counting.
    pub fn sort(&mut self, points: &[[f64; 3]], width: f64) {
        self.layout = Layout::new(points, width);
        let layout = &self.layout;
        let cells = layout.count.iter().product::<usize>();
        self.of_points.clear();
        self.of_points.extend(
            points
                .iter()
                .map(|&point| layout.index(layout.coordinates(point)) as u32),
        );
        self.starts.clear();
        self.starts.resize(cells + 1, 0);
        for &cell in &self.of_points {
            self.starts[cell as usize + 1] += 1;
        }
        for cell in 0..cells {
            self.starts[cell + 1] += self.starts[cell];
        }
        self.members.clear();
        self.members.resize(self.of_points.len(), 0);
        // Filled from behind, so that members ascend; `starts` ends up where it began.
        for (i, &cell) in self.of_points.iter().enumerate().rev() {
            self.starts[cell as usize + 1] -= 1;
            self.members[self.starts[cell as usize + 1] as usize] = i as u32;
        }
        for cell in 0..cells {
            self.starts[cell] = self.starts[cell + 1];
        }
        self.starts[cells] = self.members.len() as u32;
    }

    /// The points of all cells that a box from `low` to `high` reaches into, rows of cells along x at a time.
    pub fn near(&self, low: [f64; 3], high: [f64; 3]) -> impl Iterator<Item = u32> + '_ {
        let (first, last) = (self.layout.coordinates(low), self.layout.coordinates(high));
        let rows =
            (first[2]..=last[2]).flat_map(move |z| (first[1]..=last[1]).map(move |y| (y, z)));
        rows.flat_map(move |(y, z)| {
            let from = self.starts[self.layout.index([first[0], y, z])] as usize;
            let to = self.starts[self.layout.index([last[0], y, z]) + 1] as usize;
            &self.members[from..to]
        })
        .copied()
    }
}
