//! Beams for tests and timings: boxes of triangles, straight or bent, with grains in them.

use super::{ContactForce, Packing, Snapshot};

/// Vertices and triangles.
pub(super) type Mesh = (Vec<[f64; 3]>, Vec<[usize; 3]>);

/// A snapshot with all that it borrows.
#[derive(Clone, Debug)]
pub(super) struct Beam {
    pub(super) positions: Vec<[f64; 3]>,
    pub(super) radii: Vec<f64>,
    pub(super) friction_coefficient: f64,
    pub(super) contacts: Vec<ContactForce>,
    pub(super) membrane_contacts: Vec<usize>,
    pub(super) vertices: Vec<[f64; 3]>,
    pub(super) triangles: Vec<[usize; 3]>,
}

impl Beam {
    /// A membrane without grains.
    pub(super) fn empty((vertices, triangles): Mesh) -> Self {
        Self {
            positions: vec![],
            radii: vec![],
            friction_coefficient: 0.3,
            contacts: vec![],
            membrane_contacts: vec![],
            vertices,
            triangles,
        }
    }

    /// Touching grains of diameter `spacing` in a box that fits.
    pub(super) fn cubic_lattice(counts: [usize; 3], spacing: f64) -> Self {
        let size = counts.map(|count| spacing * count as f64);
        let positions = indices(counts).map(|at| at.map(|k| spacing * (k as f64 + 0.5)));
        Self::of(
            box_membrane([0.0; 3], size, counts),
            positions,
            0.5 * spacing,
        )
    }

    /// Grains of one radius in `mesh`.
    pub(super) fn of(
        mesh: Mesh,
        positions: impl IntoIterator<Item = [f64; 3]>,
        radius: f64,
    ) -> Self {
        let positions: Vec<[f64; 3]> = positions.into_iter().collect();
        let radii = vec![radius; positions.len()];
        Self {
            positions,
            radii,
            ..Self::empty(mesh)
        }
    }

    /// Moves the whole, grains and membrane.
    pub(super) fn moved(&self, place: impl Fn([f64; 3]) -> [f64; 3]) -> Self {
        let all = |points: &[[f64; 3]]| points.iter().map(|&point| place(point)).collect();
        Self {
            positions: all(&self.positions),
            vertices: all(&self.vertices),
            ..self.clone()
        }
    }

    pub(super) fn snapshot(&self) -> Snapshot<'_> {
        Snapshot {
            positions: &self.positions,
            radii: &self.radii,
            friction_coefficient: self.friction_coefficient,
            contacts: &self.contacts,
            membrane_contacts: &self.membrane_contacts,
            vertices: &self.vertices,
            triangles: &self.triangles,
        }
    }

    pub(super) fn packing(&self) -> Packing<'_> {
        Packing::new(self.snapshot()).expect("a sound snapshot")
    }
}

/// All [i, j, k] below `counts`, k slowest.
pub(super) fn indices([x, y, z]: [usize; 3]) -> impl Iterator<Item = [usize; 3]> {
    (0..z).flat_map(move |k| (0..y).flat_map(move |j| (0..x).map(move |i| [i, j, k])))
}

/// The surface of a box, each edge cut into `parts`, turned outward.
pub(super) fn box_membrane(low: [f64; 3], high: [f64; 3], parts: [usize; 3]) -> Mesh {
    let nodes = parts.map(|count| count + 1);
    let index = |[i, j, k]: [usize; 3]| (k * nodes[1] + j) * nodes[0] + i;
    let mut numbers = vec![usize::MAX; nodes.iter().product()];
    let mut vertices = vec![];
    for at in indices(nodes) {
        if (0..3).any(|k| at[k] == 0 || at[k] == parts[k]) {
            numbers[index(at)] = vertices.len();
            vertices.push(std::array::from_fn(|k| {
                low[k] + (high[k] - low[k]) * at[k] as f64 / parts[k] as f64
            }));
        }
    }
    let mut triangles = vec![];
    for axis in 0..3 {
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        for (far, side) in [(false, 0), (true, parts[axis])] {
            for [i, j, _] in indices([parts[u], parts[v], 1]) {
                let corner = |du: usize, dv: usize| {
                    let mut at = [0; 3];
                    (at[axis], at[u], at[v]) = (side, i + du, j + dv);
                    numbers[index(at)]
                };
                let [a, b, c, d] = [corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)];
                if far {
                    triangles.extend([[a, b, c], [a, c, d]]);
                } else {
                    triangles.extend([[a, c, b], [a, d, c]]);
                }
            }
        }
    }
    (vertices, triangles)
}

/// A point of a straight box from the origin, where it comes to lie when the box is bent by `angle`, its middle pressed down.
pub(super) fn bent(point: [f64; 3], length: f64, height: f64, angle: f64) -> [f64; 3] {
    let radius = length / angle;
    let turn = (point[0] - 0.5 * length) / radius;
    let arm = radius + 0.5 * height - point[2];
    [
        arm * libm::sin(turn),
        point[1],
        radius - arm * libm::cos(turn),
    ]
}
