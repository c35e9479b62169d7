//! Cell grid: grains sorted into cells at least as wide as they can reach, compared with the cells around.

use std::ops::Range;

use super::{Cells, Rows, Spheres};
use crate::crew;
use crate::math::plain;

/// The scratch memory of a search, kept so that later searches allocate nothing.
#[derive(Clone, Debug, Default)]
pub struct CellGrid {
    /// Center of mass of each grain.
    middles: Vec<[f64; 3]>,
    cells: Cells,
    /// One for each thread of the job.
    parts: Vec<Part>,
}

/// What one thread finds.
#[derive(Clone, Debug, Default)]
struct Part {
    grains: Range<usize>,
    /// Grains near the one at hand.
    near: Vec<u32>,
    found: Rows,
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
        let (grains, threads) = (spheres.grains(), crew::size());
        self.parts.resize_with(threads, Part::default);
        for (n, part) in self.parts.iter_mut().enumerate() {
            part.grains = n * grains / threads..(n + 1) * grains / threads;
        }
        let (middles, cells) = (&self.middles[..], &self.cells);
        crew::each(&mut self.parts, &|part: &mut Part| {
            part.search(spheres, (middles, cells), largest);
        });
        let all = self.parts.iter().map(|part| part.found.keys.len()).sum();
        rows.keys.reserve_exact(all);
        for part in &self.parts {
            let before = rows.keys.len() as u32;
            let starts = part.found.starts.iter().map(|start| before + start);
            rows.starts.extend(starts);
            rows.keys.extend_from_slice(&part.found.keys);
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
}

impl Part {
    /// Finds the rows of its grains; `starts` of what is found are where they end.
    fn search(
        &mut self,
        spheres: &Spheres<'_>,
        (middles, cells): (&[[f64; 3]], &Cells),
        largest: f64,
    ) {
        self.found.starts.clear();
        self.found.keys.clear();
        for i in self.grains.clone() {
            self.find_near(spheres, (middles, cells), largest, i);
            for &j in &self.near {
                spheres.compare(i, j as usize, &mut self.found.keys);
            }
            self.found.starts.push(self.found.keys.len() as u32);
        }
    }

    /// Collects the grains j > i within reach of grain i, ascending; no grain's radius is larger than `largest`.
    fn find_near(
        &mut self,
        spheres: &Spheres<'_>,
        (middles, cells): (&[[f64; 3]], &Cells),
        largest: f64,
        i: usize,
    ) {
        self.near.clear();
        let reach = 2.0 * spheres.reach + spheres.skin + spheres.radii[i];
        let middle = middles[i];
        let around = [-1.0, 1.0].map(|side| middle.map(|x| x + side * (reach + largest)));
        for j in cells.near(around[0], around[1]) {
            let other = j as usize;
            if other <= i {
                continue;
            }
            let branch = plain::sub(middle, middles[other]);
            let cutoff = reach + spheres.radii[other];
            if plain::dot(branch, branch) < cutoff * cutoff {
                self.near.push(j);
            }
        }
        self.near.sort_unstable();
    }
}
