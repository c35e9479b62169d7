//! Cell grid: grains sorted into cells at least as wide as they can reach, compared with the cells around.

use super::{Cells, Rows, Spheres};
use crate::math::plain;

/// The scratch memory of a search, kept so that later searches allocate nothing.
#[derive(Clone, Debug, Default)]
pub struct CellGrid {
    /// Center of mass of each grain.
    middles: Vec<[f64; 3]>,
    cells: Cells,
    /// Grains near the one at hand.
    near: Vec<u32>,
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
        self.cells.sort(&self.middles, farthest);
        for i in 0..spheres.grains() {
            self.find_near(spheres, farthest - largest + spheres.radii[i], i);
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

    /// Collects the grains j > i within reach of grain i, ascending; none is `farthest` away.
    fn find_near(&mut self, spheres: &Spheres<'_>, farthest: f64, i: usize) {
        self.near.clear();
        let middle = self.middles[i];
        let around = [-farthest, farthest].map(|by| middle.map(|x| x + by));
        for j in self.cells.near(around[0], around[1]) {
            let other = j as usize;
            if other <= i {
                continue;
            }
            let branch = plain::sub(middle, self.middles[other]);
            let cutoff =
                2.0 * spheres.reach + spheres.skin + spheres.radii[i] + spheres.radii[other];
            if plain::dot(branch, branch) < cutoff * cutoff {
                self.near.push(j);
            }
        }
        self.near.sort_unstable();
    }
}
