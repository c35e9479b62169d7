//! Which triangles each grain may touch.

use super::sheet::{Pair, Sheet};
use crate::lanes::{F64x8, Kernel, Lane, Mask, VectorWidth, dispatch};
use crate::membrane::Mesh;
use crate::neighbor::Cells;

/// Pairs of a grain and a triangle near it; kept so that later searches allocate nothing.
#[derive(Clone, Debug, Default)]
pub(super) struct Near {
    /// By grains, then by triangles.
    pairs: Vec<Pair>,
    /// As found: by triangles.
    found: Vec<Pair>,
    starts: Vec<u32>,
    centers: Vec<[f64; 3]>,
    cells: Cells,
}

impl Near {
    /// The pairs, by grains, then by triangles.
    pub(super) fn pairs(&self) -> &[Pair] {
        &self.pairs
    }

    /// Finds all pairs that are nearer than the grain's radius and `skin`.
    pub(super) fn search(&mut self, sheet: Sheet<'_>, mesh: &Mesh, skin: f64, width: VectorWidth) {
        self.found.clear();
        self.centers.clear();
        self.centers
            .extend(sheet.balls.iter().map(|&[x, y, z, _]| [x, y, z]));
        let largest = sheet.balls.iter().fold(0.0, |most: f64, b| most.max(b[3]));
        let farthest = largest + skin;
        if !sheet.balls.is_empty() {
            self.cells.sort(&self.centers, 2.0 * farthest);
            for t in 0..mesh.triangles().len() as u32 {
                self.note_cells(t, mesh.corners(t), farthest);
            }
        }
        let nearer = Nearer {
            sheet,
            skin,
            pairs: &mut self.found,
        };
        dispatch::<F64x8, _>(width, nearer);
        self.list(sheet.balls.len());
    }

    /// Notes all grains in the cells that triangle `t` can be reached from.
    fn note_cells(&mut self, t: u32, corners: [[f64; 3]; 3], farthest: f64) {
        let bound = |axis: usize, worse: fn(f64, f64) -> f64| {
            worse(worse(corners[0][axis], corners[1][axis]), corners[2][axis])
        };
        let low = [0, 1, 2].map(|axis| bound(axis, f64::min) - farthest);
        let high = [0, 1, 2].map(|axis| bound(axis, f64::max) + farthest);
        let within = |i: &u32| {
            let center = self.centers[*i as usize];
            (0..3).all(|axis| low[axis] <= center[axis] && center[axis] <= high[axis])
        };
        let cells = self.cells.near(low, high).filter(within);
        self.found.extend(cells.map(|i| [i, t]));
    }

    /// Sorts what was found by grains; it was found in the order of the triangles.
    fn list(&mut self, grains: usize) {
        self.starts.clear();
        self.starts.resize(grains + 1, 0);
        for &[i, _] in &self.found {
            self.starts[i as usize + 1] += 1;
        }
        for i in 0..grains {
            self.starts[i + 1] += self.starts[i];
        }
        self.pairs.clear();
        self.pairs.resize(self.found.len(), Pair::default());
        for &pair in &self.found {
            let place = &mut self.starts[pair[0] as usize];
            self.pairs[*place as usize] = pair;
            *place += 1;
        }
    }
}

/// Keeps the pairs that are nearer than the grain's radius and `skin`.
struct Nearer<'a> {
    sheet: Sheet<'a>,
    skin: f64,
    pairs: &'a mut Vec<Pair>,
}

impl Kernel<F64x8> for Nearer<'_> {
    type Output = ();

    #[inline(always)]
    fn run<W: Lane<Row = F64x8, Scalar = f64>>(self) {
        let mut kept = 0;
        for first in (0..self.pairs.len()).step_by(W::K) {
            let eight = first..self.pairs.len().min(first + W::K);
            let feet = self.sheet.feet::<W>(&self.pairs[eight.clone()]);
            let reach = feet.radius + W::constant(self.skin);
            let near = feet.square.lt(reach * reach).bits();
            for (e, pair) in eight.enumerate() {
                if near >> e & 1 == 1 {
                    self.pairs[kept] = self.pairs[pair];
                    kept += 1;
                }
            }
        }
        self.pairs.truncate(kept);
    }
}
