//! Vertices of the membrane with a part to play while the beam is bent.

use crate::membrane::Mesh;

/// Vertices with a part to play, by where they are in the mold.
pub(super) struct Places {
    pub(super) supports: [Vec<u32>; 2],
    /// In the middle of the bottom: their height is the deflection.
    pub(super) middle: Vec<u32>,
    /// Of each axis the two faces, without their rims, which stick out once the mold is gone.
    pub(super) faces: [[Vec<u32>; 2]; 3],
}

/// Mean coordinate of vertices.
pub(super) fn mean(mesh: &Mesh, vertices: &[u32], axis: usize) -> f64 {
    let sum: f64 = vertices
        .iter()
        .map(|&v| mesh.positions()[v as usize][axis])
        .sum();
    sum / vertices.len() as f64
}

/// Finds supports, middle and faces on the mesh as it is in the mold.
pub(super) fn places(mesh: &Mesh, edge: f64) -> Places {
    let [low, high] = mesh.bounds();
    let pick = |wanted: &dyn Fn(&[f64; 3]) -> bool| {
        (0u32..)
            .zip(mesh.positions())
            .filter(|(_, place)| wanted(place))
            .map(|(vertex, _)| vertex)
            .collect::<Vec<u32>>()
    };
    let bottom = |place: &[f64; 3]| place[2] < low[2] + 1e-6 * edge;
    let inside = |place: &[f64; 3], axis: usize| {
        (0..3).all(|k| k == axis || place[k].abs() < high[k] - 1.5 * edge)
    };
    let face = |axis: usize, sign: f64| {
        pick(&|place| sign * place[axis] > high[axis] - 1e-6 * edge && inside(place, axis))
    };
    Places {
        supports: [
            pick(&|place| bottom(place) && place[0] - low[0] <= 0.75 * edge),
            pick(&|place| bottom(place) && high[0] - place[0] <= 0.75 * edge),
        ],
        middle: pick(&|place| {
            bottom(place) && place[0].abs() <= edge && place[1].abs() <= 0.5 * high[1]
        }),
        faces: [0, 1, 2].map(|axis| [face(axis, -1.0), face(axis, 1.0)]),
    }
}
