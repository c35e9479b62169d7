//! Which triangles each grain may touch.

use super::foot::{at, foot};
use crate::grains::Grains;
use crate::lanes::Row;
use crate::math::plain;
use crate::membrane::Mesh;
use crate::neighbor::Cells;

/// The triangles near each grain, ascending; kept so that later searches allocate nothing.
#[derive(Clone, Debug, Default)]
pub(super) struct Near {
    /// Of grain i: `triangles[starts[i]..starts[i + 1]]`.
    starts: Vec<u32>,
    triangles: Vec<u32>,
    /// (grain, triangle) as found.
    found: Vec<(u32, u32)>,
    centers: Vec<[f64; 3]>,
    cells: Cells,
}

impl Near {
    /// The triangles near grain `i`.
    pub(super) fn of(&self, i: usize) -> &[u32] {
        &self.triangles[self.starts[i] as usize..self.starts[i + 1] as usize]
    }

    /// Grains for which there is a list.
    pub(super) fn grains(&self) -> usize {
        self.starts.len().saturating_sub(1)
    }

    /// Finds all pairs that are nearer than the grain's radius and `skin`.
    pub(super) fn search<R: Row>(&mut self, grains: &Grains<R>, mesh: &Mesh, skin: f64) {
        self.found.clear();
        self.centers.clear();
        self.centers
            .extend((0..grains.len()).map(|i| grains.pose(i, 0).position));
        let largest = (0..grains.len()).fold(0.0, |most: f64, i| most.max(grains.radius(i)));
        let farthest = largest + skin;
        if !grains.is_empty() {
            self.cells.sort(&self.centers, 2.0 * farthest);
            for t in 0..mesh.triangles().len() as u32 {
                self.compare(grains, t, mesh.corners(t), skin, farthest);
            }
        }
        self.list(grains.len());
    }

    fn compare<R: Row>(
        &mut self,
        grains: &Grains<R>,
        t: u32,
        corners: [[f64; 3]; 3],
        skin: f64,
        farthest: f64,
    ) {
        let bound = |axis: usize, worse: fn(f64, f64) -> f64| {
            worse(worse(corners[0][axis], corners[1][axis]), corners[2][axis])
        };
        let low = [0, 1, 2].map(|axis| bound(axis, f64::min) - farthest);
        let high = [0, 1, 2].map(|axis| bound(axis, f64::max) + farthest);
        for i in self.cells.near(low, high) {
            let center = self.centers[i as usize];
            let to = plain::sub(center, at(foot(center, corners).weights, corners));
            let reach = grains.radius(i as usize) + skin;
            if plain::dot(to, to) < reach * reach {
                self.found.push((i, t));
            }
        }
    }

    /// Sorts what was found by grains; it was found in the order of the triangles.
    fn list(&mut self, grains: usize) {
        self.starts.clear();
        self.starts.resize(grains + 1, 0);
        for &(i, _) in &self.found {
            self.starts[i as usize + 1] += 1;
        }
        for i in 0..grains {
            self.starts[i + 1] += self.starts[i];
        }
        self.triangles.clear();
        self.triangles.resize(self.found.len(), 0);
        // Filled from behind, as `Cells` does.
        for &(i, t) in self.found.iter().rev() {
            self.starts[i as usize + 1] -= 1;
            self.triangles[self.starts[i as usize + 1] as usize] = t;
        }
        for i in 0..grains {
            self.starts[i] = self.starts[i + 1];
        }
        if let Some(end) = self.starts.last_mut() {
            *end = self.found.len() as u32;
        }
    }
}
