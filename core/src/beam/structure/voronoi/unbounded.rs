//! Radical Voronoi cells without a membrane: convex polyhedra cut by the planes of equal power.

use crate::beam::structure::Snapshot;
use crate::beam::structure::cells::PointGrid;
use crate::beam::structure::polyhedron::Polyhedron;
use crate::math::plain::dot;

/// How far grains are collected at first, in d_p: twice as far each time they do not suffice.
const NEAREST: f64 = 2.2;

/// Cuts the cells of one packing.
pub(super) struct Cutter<'a> {
    snapshot: &'a Snapshot<'a>,
    grid: PointGrid,
    nearest: f64,
    largest_radius: f64,
    /// The square of the distance, number and branch of the grains around.
    around: Vec<(f64, usize, [f64; 3])>,
    cell: Polyhedron,
}

impl<'a> Cutter<'a> {
    /// For the grains of `snapshot`, of mean diameter `diameter`.
    pub(super) fn new(snapshot: &'a Snapshot<'a>, diameter: f64) -> Self {
        Self {
            snapshot,
            grid: PointGrid::new(snapshot.positions, diameter),
            nearest: NEAREST * diameter,
            largest_radius: snapshot.radii.iter().copied().fold(0.0, f64::max),
            around: vec![],
            cell: Polyhedron::default(),
        }
    }

    /// The cell of grain `i` relative to its center, at most the cube of half side `reach`.
    pub(super) fn cell(&mut self, i: usize, reach: f64) -> &Polyhedron {
        self.cell.set_cube(reach);
        let mut squared_reach = self.cell.squared_reach();
        let (mut from, mut to) = (0.0, self.nearest);
        loop {
            self.collect(i, from, to);
            for at in 0..self.around.len() {
                let (square, j, branch) = self.around[at];
                if self.is_beyond(i, square.sqrt(), squared_reach.sqrt()) {
                    return &self.cell;
                }
                if self.cut(i, j, branch, square) {
                    squared_reach = self.cell.squared_reach();
                }
            }
            if self.is_beyond(i, to, squared_reach.sqrt()) || self.cell.is_empty() {
                return &self.cell;
            }
            (from, to) = (to, 2.0 * to);
        }
    }

    /// Collects the grains at `from` to `to` from grain `i`, nearest first.
    fn collect(&mut self, i: usize, from: f64, to: f64) {
        self.around.clear();
        let around = &mut self.around;
        self.grid
            .visit(self.snapshot.positions[i], to, |j, branch, square| {
                if j != i && square >= from * from {
                    around.push((square, j, branch));
                }
            });
        around.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    }

    /// Whether no grain at `distance` or farther has its plane within `reach` of grain `i`.
    ///
    /// The plane of j stands at (D² + R_i² − R_j²)/2D, which grows with D for the largest R_j.
    fn is_beyond(&self, i: usize, distance: f64, reach: f64) -> bool {
        let (radius, largest) = (self.snapshot.radii[i], self.largest_radius);
        let powers = distance * distance + radius * radius - largest * largest;
        powers > 2.0 * distance * reach
    }

    /// Cuts off what has less power for grain `j`; says whether that was anything.
    fn cut(&mut self, i: usize, j: usize, branch: [f64; 3], square: f64) -> bool {
        let (mine, other) = (self.snapshot.radii[i], self.snapshot.radii[j]);
        if dot(branch, branch) > 0.0 {
            let offset = 0.5 * (square + (mine - other) * (mine + other));
            return self.cell.cut(branch, offset, j);
        }
        // One center: all powers are less for the larger grain, and equals are told apart by their number.
        let all = other > mine || (other >= mine && j < i);
        all && self.cell.cut([0.0, 0.0, 1.0], f64::MIN, j)
    }
}
