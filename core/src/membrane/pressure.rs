//! The pressure that confines a sheet: a load that follows the triangles.

use crate::lanes::{F64x8, Lane};
use crate::math::{Vec3, plain};

/// A triangle as it is in the running step, in two lines of the cache.
///
/// Its corners and its unit normal, outward; beside each corner the height over the side that is opposite to it.
/// Without area, it has no normal.
pub type Face = [F64x8; 2];

/// Adds −p A n̂/3 \[N\] of every triangle, in their order, to each of its corners; positive pressure pushes inward.
///
/// On a closed mesh this is −p ∂V/∂x, so the forces sum to zero, and to zero torque, and do the work −p dV.
#[inline(always)]
pub fn add_pressure<W: Lane<Row = F64x8, Scalar = f64>>(
    sheet: (&[[u32; 3]], &[F64x8]),
    pressure: f64,
    forces: &mut [[f64; 3]],
    faces: &mut Vec<Face>,
) {
    let sixth = W::constant(-pressure / 6.0);
    note_faces::<W>(sheet, faces, |area, triangles| {
        spread(area.scale(sixth), triangles, forces);
    });
}

/// Notes the faces of all triangles; tells `with` twice the areas of eight, as vectors, outward.
#[inline(always)]
pub(super) fn note_faces<W: Lane<Row = F64x8, Scalar = f64>>(
    (triangles, vertices): (&[[u32; 3]], &[F64x8]),
    faces: &mut Vec<Face>,
    mut with: impl FnMut(Vec3<W>, &[[u32; 3]]),
) {
    faces.clear();
    let (eights, rest) = triangles.as_chunks();
    for eight in eights {
        with(faces_of::<W>(eight, vertices, faces), eight);
    }
    if let Some(&last) = rest.last() {
        let mut eight = [last; 8];
        eight[..rest.len()].copy_from_slice(rest);
        with(faces_of::<W>(&eight, vertices, faces), rest);
        faces.truncate(triangles.len());
    }
}

/// Adds a share to each corner of each triangle.
#[inline(always)]
fn spread<W: Lane<Row = F64x8, Scalar = f64>>(
    share: Vec3<W>,
    triangles: &[[u32; 3]],
    forces: &mut [[f64; 3]],
) {
    let mut shares = Vec3::default();
    share.store(&mut shares);
    for (e, &corners) in triangles.iter().enumerate() {
        let share = shares.lane(e);
        for vertex in corners {
            let force = &mut forces[vertex as usize];
            *force = plain::add(*force, share);
        }
    }
}

/// Adds the faces of eight triangles; twice their areas as vectors, outward.
#[inline(always)]
fn faces_of<W: Lane<Row = F64x8, Scalar = f64>>(
    eight: &[[u32; 3]; 8],
    vertices: &[F64x8],
    faces: &mut Vec<Face>,
) -> Vec3<W> {
    let at = |k: usize| Vec3::<W>::gathered(|e| vertices[eight[e][k] as usize].halves()[0]);
    let (a, b, c) = (at(0), at(1), at(2));
    let area = (b - a).cross(c - a);
    let square = area.dot(area);
    let doubled = square.sqrt();
    let outward = area.scale(W::constant(1.0) / doubled);
    let over = |side: Vec3<W>| (square / side.dot(side)).sqrt();
    let (over_a, over_b, over_c) = (over(c - b), over(a - c), over(b - a));
    let first = W::transposed([a.x, a.y, a.z, over_a, b.x, b.y, b.z, over_b]);
    let Vec3 { x, y, z } = outward;
    let second = W::transposed([c.x, c.y, c.z, over_c, x, y, z, W::constant(0.0)]);
    for e in 0..W::K {
        let mut face = Face::default();
        first[e].store(&mut face[0]);
        second[e].store(&mut face[1]);
        faces.push(face);
    }
    area
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::membrane::shapes::{cases, icosphere};
    use crate::membrane::{Mesh, record};
    use proptest::prelude::*;

    /// Δp \[Pa\].
    const PRESSURE: f64 = 9e4;

    /// A crumpled sphere of 162 vertices about 20 mm wide.
    fn crumpled(shifts: &[f64]) -> Mesh {
        let mut mesh = icosphere(2, 0.02);
        let places = mesh.positions_mut().as_flattened_mut();
        for (part, shift) in places.iter_mut().zip(shifts) {
            *part += 4e-3 * shift;
        }
        mesh
    }

    fn forces(mesh: &Mesh) -> Vec<[f64; 3]> {
        let mut forces = vec![[0.0; 3]; mesh.positions().len()];
        let still = |&place: &[f64; 3]| record(place, [0.0; 3]);
        let vertices: Vec<F64x8> = mesh.positions().iter().map(still).collect();
        let sheet = (mesh.triangles(), vertices.as_slice());
        add_pressure::<F64x8>(sheet, PRESSURE, &mut forces, &mut vec![]);
        forces
    }

    proptest! {
        #![proptest_config(cases(64))]

        /// M5.
        #[test]
        fn pressure_on_a_closed_sheet_neither_pushes_nor_turns_it(
            shifts in prop::collection::vec(-1.0..1.0f64, 486),
        ) {
            let mesh = crumpled(&shifts);
            let forces = forces(&mesh);
            let scale = PRESSURE * mesh.area();
            let sum = forces.iter().copied().fold([0.0; 3], plain::add);
            prop_assert!(plain::norm(sum) < 1e-12 * scale, "{:?}", sum);
            let torques = mesh.positions().iter().zip(&forces).map(|(&x, &f)| plain::cross(x, f));
            let torque = plain::norm(torques.fold([0.0; 3], plain::add));
            prop_assert!(torque < 1e-12 * scale * 0.02, "{}", torque);
        }

        /// M5: the volume is a cubic of the path, so one central difference over a short step is exact enough.
        #[test]
        fn work_of_the_pressure_is_that_of_the_volume(
            shifts in prop::collection::vec(-1.0..1.0f64, 486),
            steps in prop::collection::vec(-1.0..1.0f64, 486),
        ) {
            let mut mesh = crumpled(&shifts);
            let forces = forces(&mesh);
            let step = 1e-6;
            let along = |mesh: &mut Mesh, scale: f64| {
                let places = mesh.positions_mut().as_flattened_mut();
                places.iter_mut().zip(&steps).for_each(|(part, by)| *part += scale * by);
                mesh.volume()
            };
            let after = along(&mut mesh, step);
            let before = along(&mut mesh, -2.0 * step);
            let work: f64 = forces.as_flattened().iter().zip(&steps).map(|(f, s)| f * s * 2.0 * step).sum();
            let expected = -PRESSURE * (after - before);
            // Steps that happen to keep the volume do no work: what counts is the work of a step along the forces.
            let scale: f64 = forces.iter().map(|&f| plain::norm(f) * 2.0 * step).sum();
            prop_assert!((work - expected).abs() < 1e-6 * scale, "{} {}", work, expected);
        }
    }
}
