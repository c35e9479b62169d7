//! Neighbors: which spheres may touch.
//!
//! A search returns, for every grain `i`, the candidates `(j, a, b)` with j > i: sphere `a` of `i` near sphere `b` of `j`.
//! Rows are sorted, so contacts are visited in an order that depends on grain numbers only.
//! A search knows no law and no replica; both methods find the same candidates.

mod all_pairs;
mod cell_grid;
mod cells;

pub use all_pairs::all_pairs;
pub use cell_grid::CellGrid;
pub use cells::Cells;

use crate::math::plain;

/// Sphere `a` of the row's grain near sphere `b` of grain `j`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Key {
    /// The other grain.
    pub j: u32,
    /// Sphere of the row's grain.
    pub a: u8,
    /// Sphere of the other grain.
    pub b: u8,
}

/// Sorted rows of candidates.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Rows {
    /// Row `i` is `keys[starts[i]..starts[i + 1]]`.
    pub starts: Vec<u32>,
    /// All rows, one after the other.
    pub keys: Vec<Key>,
}

impl Rows {
    /// The candidates of grain `i`.
    #[must_use]
    pub fn row(&self, i: usize) -> &[Key] {
        &self.keys[self.range(i)]
    }

    /// Where row `i` stands among all keys.
    #[inline(always)]
    #[must_use]
    pub fn range(&self, i: usize) -> std::ops::Range<usize> {
        self.starts[i] as usize..self.starts[i + 1] as usize
    }
}

/// What a search looks at.
#[derive(Clone, Copy, Debug)]
pub struct Spheres<'a> {
    /// Sphere centers, `per_grain` to a grain \[R\].
    pub centers: &'a [[f64; 3]],
    /// Spheres per grain.
    pub per_grain: usize,
    /// Distance of the centers from the center of mass.
    pub reach: f64,
    /// How far from its center here a sphere of each grain may reach in some replica.
    pub radii: &'a [f64],
    /// How far beyond touching to look.
    pub skin: f64,
}

impl Spheres<'_> {
    fn grains(&self) -> usize {
        self.radii.len()
    }

    fn of(&self, i: usize) -> &[[f64; 3]] {
        &self.centers[self.per_grain * i..self.per_grain * (i + 1)]
    }

    /// Adds the candidates of grains `i < j` to `keys`, in order.
    fn compare(&self, i: usize, j: usize, keys: &mut Vec<Key>) {
        let cutoff = self.skin + self.radii[i] + self.radii[j];
        for (a, &center) in self.of(i).iter().enumerate() {
            for (b, &other) in self.of(j).iter().enumerate() {
                let branch = plain::sub(center, other);
                if plain::dot(branch, branch) < cutoff * cutoff {
                    keys.push(Key {
                        j: j as u32,
                        a: a as u8,
                        b: b as u8,
                    });
                }
            }
        }
    }
}
