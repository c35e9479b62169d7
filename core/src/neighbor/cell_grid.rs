//! Cell grid: grains sorted into cells at least as wide as they can reach, compared with the cells around.

use super::{Rows, Spheres};
use crate::math::plain;

/// The scratch memory of a search, kept so that later searches allocate nothing.
#[derive(Clone, Debug, Default)]
pub struct CellGrid {
    /// Center of mass of each grain.
    middles: Vec<[f64; 3]>,
    /// Cell of each grain.
    cells: Vec<u32>,
    /// Grains of cell c: `members[starts[c]..starts[c + 1]]`, ascending.
    starts: Vec<u32>,
    members: Vec<u32>,
    /// Grains near the one at hand.
    near: Vec<u32>,
}

/// The boxes that space is cut into.
struct Layout {
    low: [f64; 3],
    width: [f64; 3],
    count: [usize; 3],
}

impl Layout {
    /// Cells of at least `width`, and no more of them than about two a grain, however far apart the grains are.
    fn new(middles: &[[f64; 3]], width: f64) -> Self {
        let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        for middle in middles {
            for axis in 0..3 {
                low[axis] = low[axis].min(middle[axis]);
                high[axis] = high[axis].max(middle[axis]);
            }
        }
        let most = 2 * middles.len() + 64;
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

    fn coordinates(&self, point: [f64; 3]) -> [usize; 3] {
        std::array::from_fn(|k| {
            (((point[k] - self.low[k]) / self.width[k]) as usize).min(self.count[k] - 1)
        })
    }

    fn index(&self, [x, y, z]: [usize; 3]) -> usize {
        (z * self.count[1] + y) * self.count[0] + x
    }
}

impl CellGrid {
    /// Finds all candidates.
    pub fn search(&mut self, spheres: &Spheres<'_>, rows: &mut Rows) {
        rows.starts.clear();
        rows.keys.clear();
        rows.starts.push(0);
        if spheres.grains() == 0 {
            return;
        }
        let largest = spheres.radii.iter().fold(0.0, |most: f64, &r| most.max(r));
        let farthest = 2.0 * (spheres.reach + largest) + spheres.skin;
        self.find_middles(spheres);
        let layout = Layout::new(&self.middles, farthest);
        self.sort(&layout);
        for i in 0..spheres.grains() {
            self.find_near(&layout, spheres, i);
            for &j in &self.near {
                spheres.compare(i, j as usize, &mut rows.keys);
            }
            rows.starts.push(rows.keys.len() as u32);
        }
    }

    fn find_middles(&mut self, spheres: &Spheres<'_>) {
        self.middles.clear();
        let share = 1.0 / spheres.per_grain as f64;
        self.middles.extend((0..spheres.grains()).map(|i| {
            let sum = spheres
                .of(i)
                .iter()
                .fold([0.0; 3], |sum, &center| plain::add(sum, center));
            plain::scale(sum, share)
        }));
    }

    /// Counting sort of the grains by cell.
    fn sort(&mut self, layout: &Layout) {
        let cells = layout.count.iter().product::<usize>();
        self.cells.clear();
        self.cells.extend(
            self.middles
                .iter()
                .map(|&middle| layout.index(layout.coordinates(middle)) as u32),
        );
        self.starts.clear();
        self.starts.resize(cells + 1, 0);
        for &cell in &self.cells {
            self.starts[cell as usize + 1] += 1;
        }
        for cell in 0..cells {
            self.starts[cell + 1] += self.starts[cell];
        }
        self.members.clear();
        self.members.resize(self.cells.len(), 0);
        // Filled from behind, so that members ascend; `starts` ends up where it began.
        for (i, &cell) in self.cells.iter().enumerate().rev() {
            self.starts[cell as usize + 1] -= 1;
            self.members[self.starts[cell as usize + 1] as usize] = i as u32;
        }
        for cell in 0..cells {
            self.starts[cell] = self.starts[cell + 1];
        }
        self.starts[cells] = self.members.len() as u32;
    }

    /// Collects the grains j > i within reach of grain i, ascending.
    fn find_near(&mut self, layout: &Layout, spheres: &Spheres<'_>, i: usize) {
        self.near.clear();
        let middle = self.middles[i];
        let at = layout.coordinates(middle);
        let around =
            |axis: usize| at[axis].saturating_sub(1)..=(at[axis] + 1).min(layout.count[axis] - 1);
        for z in around(2) {
            for y in around(1) {
                let (first, last) = (*around(0).start(), *around(0).end());
                let from = self.starts[layout.index([first, y, z])] as usize;
                let to = self.starts[layout.index([last, y, z]) + 1] as usize;
                for &j in &self.members[from..to] {
                    let j_index = j as usize;
                    if j_index <= i {
                        continue;
                    }
                    let branch = plain::sub(middle, self.middles[j_index]);
                    let cutoff = 2.0 * spheres.reach
                        + spheres.skin
                        + spheres.radii[i]
                        + spheres.radii[j_index];
                    if plain::dot(branch, branch) < cutoff * cutoff {
                        self.near.push(j);
                    }
                }
            }
        }
        self.near.sort_unstable();
    }
}
