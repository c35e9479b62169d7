//! The pressure that confines a sheet: a load that follows the triangles.

use crate::lanes::{F64x8, Lane};
use crate::math::{Vec3, plain};

/// A triangle as it is in the running step, in two lines of the cache.
///
/// Its corners and its unit normal, outward, a spare number beside each corner and twice the area beside the normal.
/// Without area, its normal is zero.
pub type Face = [F64x8; 2];

/// Adds −p A n̂/3 \[N\] of every triangle, in their order, to each of its corners; positive pressure pushes inward.
///
/// On a closed mesh this is −p ∂V/∂x, so the forces sum to zero, and to zero torque, and do the work −p dV.
pub fn add_pressure(
    (triangles, faces): (&[[u32; 3]], &[Face]),
    pressure: f64,
    forces: &mut [[f64; 3]],
) {
    let sixth = -pressure / 6.0;
    for (corners, face) in triangles.iter().zip(faces) {
        let &[x, y, z, doubled] = face[1].halves()[1];
        let share = plain::scale([x, y, z], doubled * sixth);
        for &vertex in corners {
            let force = &mut forces[vertex as usize];
            *force = plain::add(*force, share);
        }
    }
}

/// Notes the faces of all triangles.
#[inline(always)]
pub(super) fn note_faces<W: Lane<Row = F64x8, Scalar = f64>>(
    (triangles, vertices): (&[[u32; 3]], &[F64x8]),
    faces: &mut Vec<Face>,
) {
    faces.clear();
    let (eights, rest) = triangles.as_chunks();
    for eight in eights {
        note_eight::<W>(eight, vertices, faces);
    }
    if let Some(&last) = rest.last() {
        let mut eight = [last; 8];
        eight[..rest.len()].copy_from_slice(rest);
        note_eight::<W>(&eight, vertices, faces);
        faces.truncate(triangles.len());
    }
}

#[inline(always)]
fn note_eight<W: Lane<Row = F64x8, Scalar = f64>>(
    eight: &[[u32; 3]; 8],
    vertices: &[F64x8],
    faces: &mut Vec<Face>,
) {
    let at = |k: usize| Vec3::<W>::gathered(|e| vertices[eight[e][k] as usize].halves()[0]);
    let (a, b, c) = (at(0), at(1), at(2));
    let area = (b - a).cross(c - a);
    let doubled = area.dot(area).sqrt();
    let zero = W::constant(0.0);
    let inverse = (W::constant(1.0) / doubled).keep(zero.lt(doubled));
    let Vec3 { x, y, z } = area.scale(inverse);
    let first = W::transposed([a.x, a.y, a.z, zero, b.x, b.y, b.z, zero]);
    let second = W::transposed([c.x, c.y, c.z, zero, x, y, z, doubled]);
    for e in 0..W::K {
        let mut face = Face::default();
        first[e].store(&mut face[0]);
        second[e].store(&mut face[1]);
        faces.push(face);
    }
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
        let mut faces = vec![];
        note_faces::<F64x8>((mesh.triangles(), &vertices), &mut faces);
        add_pressure((mesh.triangles(), &faces), PRESSURE, &mut forces);
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
