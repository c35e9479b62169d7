//! All pairs: the search that cannot be wrong, for tests and for a handful of grains.

use super::{Rows, Spheres};

/// Compares every grain with every other.
pub fn all_pairs(spheres: &Spheres<'_>, rows: &mut Rows) {
    rows.starts.clear();
    rows.keys.clear();
    rows.starts.push(0);
    for i in 0..spheres.grains() {
        for j in i + 1..spheres.grains() {
            spheres.compare(i, j, &mut rows.keys);
        }
        rows.starts.push(rows.keys.len() as u32);
    }
}
