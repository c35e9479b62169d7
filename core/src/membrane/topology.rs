//! Which triangles share what: edges, fans around vertices, neighbors of a triangle.
//!
//! Everything is found by sorting: N log N in the number of triangles, and the same order on every machine.

use super::mesh::MeshError;

/// Lists of numbers, one behind the other in one array.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Lists {
    /// Where each list starts, and where the last one ends.
    starts: Vec<u32>,
    items: Vec<u32>,
}

impl Lists {
    /// List `i`, ascending.
    pub(super) fn of(&self, i: u32) -> &[u32] {
        let i = i as usize;
        &self.items[self.starts[i] as usize..self.starts[i + 1] as usize]
    }

    fn gather<I: IntoIterator<Item = u32>>(lists: impl Iterator<Item = I>) -> Self {
        let (mut starts, mut items) = (vec![0], vec![]);
        for list in lists {
            items.extend(list);
            starts.push(items.len() as u32);
        }
        Self { starts, items }
    }
}

/// What follows from the triangles' corners alone.
#[derive(Clone, Debug, PartialEq, Default)]
pub(super) struct Topology {
    /// The two ends of every edge, the lower first; edges ascend.
    pub(super) edges: Vec<[u32; 2]>,
    /// The triangle that runs an edge from its lower to its higher end, and the one that runs it back.
    pub(super) edge_triangles: Vec<[Option<u32>; 2]>,
    /// The edges of every triangle; side s joins corner s to the next.
    pub(super) sides: Vec<[u32; 3]>,
    /// The triangles around every vertex.
    pub(super) fans: Lists,
    /// The triangle over each side.
    pub(super) over_sides: Vec<[Option<u32>; 3]>,
    /// Whether every edge has two triangles.
    pub(super) closed: bool,
}

/// One side of one triangle; the order of the fields sorts the sides of one edge together.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Side {
    ends: [u32; 2],
    /// Whether the triangle runs from the higher end to the lower.
    back: bool,
    triangle: u32,
    /// Its number in the triangle.
    place: u8,
}

impl Topology {
    /// The topology of triangles whose corners are three different numbers below `vertices`.
    pub(super) fn of(triangles: &[[u32; 3]], vertices: usize) -> Result<Self, MeshError> {
        let mut half_edges: Vec<Side> = (0u32..).zip(triangles).flat_map(sides_of).collect();
        half_edges.sort_unstable();
        let mut edges: Vec<[u32; 2]> = vec![];
        let mut edge_triangles: Vec<[Option<u32>; 2]> = vec![];
        let mut sides = vec![[0; 3]; triangles.len()];
        for half in half_edges {
            if edges.last() != Some(&half.ends) {
                edges.push(half.ends);
                edge_triangles.push([None; 2]);
            }
            let edge = edges.len() - 1;
            let known = &mut edge_triangles[edge][usize::from(half.back)];
            if let Some(first) = *known {
                return Err(MeshError::Orientation {
                    triangles: [first, half.triangle],
                    ends: half.ends,
                });
            }
            *known = Some(half.triangle);
            sides[half.triangle as usize][usize::from(half.place)] = edge as u32;
        }
        let fans = fans(triangles, vertices)?;
        Ok(Self {
            closed: edge_triangles.iter().flatten().all(Option::is_some),
            over_sides: over_sides(&sides, &edge_triangles),
            edges,
            edge_triangles,
            sides,
            fans,
        })
    }
}

fn sides_of((triangle, corners): (u32, &[u32; 3])) -> [Side; 3] {
    [0u8, 1, 2].map(|side| {
        let from = corners[usize::from(side)];
        let to = corners[usize::from((side + 1) % 3)];
        Side {
            ends: [from.min(to), from.max(to)],
            back: from > to,
            triangle,
            place: side,
        }
    })
}

fn fans(triangles: &[[u32; 3]], vertices: usize) -> Result<Lists, MeshError> {
    let mut corners: Vec<(u32, u32)> = (0u32..)
        .zip(triangles)
        .flat_map(|(t, corners)| corners.map(|vertex| (vertex, t)))
        .collect();
    corners.sort_unstable();
    let of_vertices = corners.chunk_by(|a, b| a.0 == b.0);
    let missing = (0u32..)
        .zip(of_vertices.clone())
        .find_map(|(expected, fan)| (fan[0].0 != expected).then_some(expected));
    let found = of_vertices.clone().count();
    if let Some(vertex) = missing.or((found < vertices).then_some(found as u32)) {
        return Err(MeshError::UnusedVertex { vertex });
    }
    Ok(Lists::gather(
        of_vertices.map(|fan| fan.iter().map(|&(_, t)| t)),
    ))
}

fn over_sides(sides: &[[u32; 3]], edge_triangles: &[[Option<u32>; 2]]) -> Vec<[Option<u32>; 3]> {
    let other = |t: u32, edge: u32| {
        let [there, back] = edge_triangles[edge as usize];
        if there == Some(t) { back } else { there }
    };
    (0u32..)
        .zip(sides)
        .map(|(t, edges)| edges.map(|edge| other(t, edge)))
        .collect()
}
