use super::*;
use crate::membrane::shapes;
use proptest::prelude::*;

/// The corner of a cube: normals point outward.
fn tetrahedron() -> (Vec<[f64; 3]>, Vec<[u32; 3]>) {
    let corners = vec![
        [0.0, 0.0, 0.0],
        [1.0, 0.0, 0.0],
        [0.0, 1.0, 0.0],
        [0.0, 0.0, 1.0],
    ];
    let faces = vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
    (corners, faces)
}

#[test]
fn tetrahedron_has_the_topology_and_the_volume_of_one() {
    let (corners, faces) = tetrahedron();
    let mesh = Mesh::new(corners, faces).unwrap();
    mesh.check_closed().unwrap();
    let edges = [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]];
    assert_eq!(mesh.edges(), edges);
    assert_eq!(mesh.edge_triangles()[0], [Some(1), Some(0)]);
    assert_eq!(mesh.sides(3), [3, 5, 4]);
    assert_eq!(mesh.over_sides(3), [Some(0), Some(2), Some(1)]);
    assert_eq!(mesh.fan(3), [1, 2, 3]);
    assert!((0..4).all(|t| mesh.are_neighbors(1, t)));
    assert_eq!(mesh.euler_characteristic(), 2);
    assert!((mesh.volume() - 1.0 / 6.0).abs() < 1e-16);
    assert!((mesh.area() - 1.5 - 0.75f64.sqrt()).abs() < 1e-15);
    assert!(plain::norm(mesh.area_vector_sum()) < 1e-16);
    assert_eq!(mesh.bounds(), [[0.0; 3], [1.0; 3]]);
}

#[test]
fn open_sheets_have_the_euler_characteristics_of_disk_and_tube() {
    let strip = shapes::strip(6, 4, 1.0);
    assert_eq!(strip.euler_characteristic(), 1);
    assert!(matches!(strip.check_closed(), Err(MeshError::Open { .. })));
    let border = strip.edge_triangles().iter();
    assert_eq!(border.filter(|both| both.contains(&None)).count(), 20);
    let tube = shapes::tube(12, 5, 1.0);
    assert_eq!(tube.euler_characteristic(), 0);
    assert!(!tube.is_closed());
    let sphere = shapes::icosphere(2, 1.0);
    assert_eq!(sphere.euler_characteristic(), 2);
    sphere.check_closed().unwrap();
    // Twelve triangles touch one with three six-valent corners, eleven where a corner is five-valent.
    let touching = |t| {
        (0..320)
            .filter(|&other| sphere.are_neighbors(t, other))
            .count()
            - 1
    };
    assert!((0..320).all(|t| touching(t) == 12 || touching(t) == 11));
}

#[test]
fn what_is_no_mesh_is_told_so() {
    let (corners, faces) = tetrahedron();
    let refused = |corners: &[[f64; 3]], faces: &[[u32; 3]]| {
        Mesh::new(corners.to_vec(), faces.to_vec()).unwrap_err()
    };
    assert_eq!(refused(&corners, &[]), MeshError::Empty);
    let unknown = refused(&corners, &[[0, 1, 4]]);
    let message = "triangle 0 names vertex 4: there are 4";
    assert_eq!(unknown.to_string(), message);
    let triangle = 0;
    let same = refused(&corners, &[[0, 1, 1]]);
    assert_eq!(same, MeshError::NoArea { triangle });
    let unused = refused(&corners, &[[0, 1, 3]]);
    assert_eq!(unused, MeshError::UnusedVertex { vertex: 2 });
    let last = refused(&corners, &[[0, 1, 2]]);
    assert_eq!(last, MeshError::UnusedVertex { vertex: 3 });
    let mut turned = faces.clone();
    turned[3] = [1, 3, 2];
    let turned = refused(&corners, &turned);
    assert!(matches!(turned, MeshError::Orientation { .. }), "{turned}");
    let mut line = corners.clone();
    line[2] = [2.0, 0.0, 0.0];
    assert_eq!(refused(&line, &faces), MeshError::NoArea { triangle });
    let mut lost = corners.clone();
    lost[2][1] = f64::NAN;
    let lost = refused(&lost, &faces);
    assert!(matches!(lost, MeshError::NonFinite { vertex: 2, .. }));
    let inward = faces.iter().map(|&[a, b, c]| [a, c, b]).collect();
    let inward = Mesh::new(corners, inward).unwrap().check_closed();
    assert!(matches!(inward, Err(MeshError::InsideOut { .. })));
}

proptest! {
    #![proptest_config(shapes::cases(32))]

    /// Volume and area vectors do not depend on where the mesh is.
    #[test]
    fn geometry_moves_with_the_mesh(shift in prop::array::uniform3(-10.0..10.0)) {
        let mut mesh = shapes::icosphere(1, 1.0);
        let (volume, area) = (mesh.volume(), mesh.area());
        for place in mesh.positions_mut() {
            *place = plain::add(*place, shift);
        }
        prop_assert!((mesh.volume() / volume - 1.0).abs() < 1e-13);
        prop_assert!((mesh.area() / area - 1.0).abs() < 1e-13);
        prop_assert!(plain::norm(mesh.area_vector_sum()) < 1e-13);
    }
}
