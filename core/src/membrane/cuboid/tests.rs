use super::*;
use crate::math::plain;
use crate::membrane::shapes::cases;
use proptest::prelude::*;

const BEAM: Cuboid = Cuboid {
    length: 0.4,
    height: 0.04,
    depth: 0.08,
    edge_length: 4.7e-3,
};

/// Half of each side.
fn halves(cuboid: &Cuboid) -> [f64; 3] {
    [cuboid.length, cuboid.depth, cuboid.height].map(|side| 0.5 * side)
}

/// Whether `place` lies on the cuboid.
#[expect(clippy::float_cmp, reason = "to the bit")]
fn on_surface(cuboid: &Cuboid, place: [f64; 3]) -> bool {
    let halves = halves(cuboid);
    let inside = (0..3).all(|axis| place[axis].abs() <= halves[axis]);
    inside && (0..3).any(|axis| place[axis].abs() == halves[axis])
}

/// Edges of the long faces without the half edges at the ends and the rim.
#[expect(clippy::float_cmp, reason = "to the bit")]
fn lattice_edges(mesh: &Mesh, cuboid: &Cuboid) -> Vec<f64> {
    let at_end = |vertex: u32| mesh.positions()[vertex as usize][0].abs() == 0.5 * cuboid.length;
    let normals: Vec<_> = mesh.normals().collect();
    let on_long_face = |&t: &u32| normals[t as usize][0].abs() < 0.5;
    let edges = mesh.edges().iter().zip(mesh.edge_triangles());
    let mut lengths = vec![];
    for ((ends, both), length) in edges.zip(mesh.edge_lengths()) {
        let half = ends.iter().any(|&vertex| at_end(vertex)) && length < 0.6 * cuboid.edge_length;
        if both.iter().flatten().all(on_long_face) && !half {
            lengths.push(length);
        }
    }
    lengths
}

fn check(cuboid: &Cuboid, mesh: &Mesh) {
    mesh.check_closed().unwrap();
    assert_eq!(mesh.euler_characteristic(), 2);
    let [l, h, d] = [cuboid.length, cuboid.height, cuboid.depth];
    assert!((mesh.volume() / (l * h * d) - 1.0).abs() < 1e-12);
    let area = 2.0 * (l * h + h * d + d * l);
    assert!((mesh.area() / area - 1.0).abs() < 1e-12);
    assert!(plain::norm(mesh.area_vector_sum()) < 1e-12 * area);
    assert!(mesh.positions().iter().all(|&x| on_surface(cuboid, x)));
    let halves = halves(cuboid);
    assert_eq!(mesh.bounds(), [halves.map(|x| -x), halves]);
    for length in lattice_edges(mesh, cuboid) {
        let deviation = (length / cuboid.edge_length - 1.0).abs();
        assert!(deviation <= EDGE_TOLERANCE * (1.0 + 1e-9), "{deviation}");
    }
}

/// The places of the corners of all triangles, each mirrored in `axis` if asked, sorted.
fn corner_sets(mesh: &Mesh, mirror: Option<usize>) -> Vec<Vec<[u64; 3]>> {
    let bits = |mut place: [f64; 3]| {
        if let Some(axis) = mirror {
            place[axis] = -place[axis];
        }
        // Zero has two signs.
        place.map(|x| (x + 0.0).to_bits())
    };
    let corners = |t| {
        let mut corners = mesh.corners(t).map(bits).to_vec();
        corners.sort_unstable();
        corners
    };
    let mut all: Vec<_> = (0..mesh.triangles().len() as u32).map(corners).collect();
    all.sort_unstable();
    all
}

#[test]
fn sheet_of_the_beam_has_sixty_rows_of_eighty_seven_edges() {
    let grid = Grid::of(&BEAM).unwrap();
    assert_eq!((grid.length, grid.depth, grid.height), (87, 20, 10));
    let mesh = BEAM.mesh().unwrap();
    check(&BEAM, &mesh);
    // 30 rows of 88 and 30 of 89 vertices, 2 × 19 × 9 inside the ends; 60 strips of 175, 2 × 400 at the ends.
    assert_eq!(mesh.positions().len(), 5652);
    assert_eq!(mesh.triangles().len(), 11_300);
    let lengths = lattice_edges(&mesh, &BEAM);
    let shortest = lengths.iter().copied().fold(f64::INFINITY, f64::min);
    let longest = lengths.iter().copied().fold(0.0, f64::max);
    assert!(shortest > 4.59e-3 && longest < 4.62e-3);
}

#[test]
fn sheet_is_its_own_mirror_image() {
    let mesh = BEAM.mesh().unwrap();
    let plain = corner_sets(&mesh, None);
    for axis in 0..3 {
        assert!(corner_sets(&mesh, Some(axis)) == plain, "axis {axis}");
    }
    let odd = Cuboid {
        height: 0.036,
        ..BEAM
    };
    let mesh = odd.mesh().unwrap();
    assert_eq!(Grid::of(&odd).unwrap().height, 9);
    assert!(corner_sets(&mesh, Some(0)) == corner_sets(&mesh, None));
}

#[test]
fn smaller_beams_and_coarser_sheets_are_meshed_too() {
    let sizes = [
        (0.12, 0.02, 0.02, 4.7e-3),
        (0.24, 0.024, 0.048, 4.7e-3),
        (0.3, 0.03, 0.06, 4.7e-3),
        (0.4, 0.04, 0.08, 8e-3),
        (0.4, 0.04, 0.08, 2.35e-3),
        (0.4, 0.08, 0.04, 4.7e-3),
    ];
    for (length, height, depth, edge_length) in sizes {
        let cuboid = Cuboid {
            length,
            height,
            depth,
            edge_length,
        };
        check(&cuboid, &cuboid.mesh().unwrap());
    }
}

#[test]
fn sizes_that_do_not_fit_are_refused_by_name() {
    let refused = |cuboid: Cuboid| cuboid.mesh().unwrap_err();
    for value in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let depth = refused(Cuboid {
            depth: value,
            ..BEAM
        });
        assert!(depth.to_string().starts_with("depth = "), "{depth}");
    }
    let thick = refused(Cuboid {
        edge_length: 0.06,
        ..BEAM
    });
    assert!(matches!(thick, CuboidError::Unfit { .. }), "{thick}");
    let fine = refused(Cuboid {
        edge_length: 1e-9,
        ..BEAM
    });
    assert!(matches!(fine, CuboidError::TooFine { .. }), "{fine}");
    let [length, height, depth] = [1e-160; 3].map(|a| 20.0 * a);
    let tiny = refused(Cuboid {
        length,
        height,
        depth,
        edge_length: 1e-160,
    });
    assert!(matches!(tiny, CuboidError::Mesh(_)), "{tiny}");
}

proptest! {
    #![proptest_config(cases(64))]

    #[test]
    fn cuboids_of_any_size_are_closed(
        edge_length in 1e-3..1e-2f64,
        length in 20.0..60.0f64,
        height in 4.0..12.0f64,
        depth in 4.0..12.0f64,
    ) {
        let [length, height, depth] = [length, height, depth].map(|edges| edges * edge_length);
        let cuboid = Cuboid { length, height, depth, edge_length };
        check(&cuboid, &cuboid.mesh().unwrap());
    }

    /// Whatever is asked for is a sound mesh or an error.
    #[test]
    fn short_cuboids_are_closed_or_refused(sides in prop::array::uniform3(0.1..6.0f64)) {
        let [length, height, depth] = sides;
        let cuboid = Cuboid { length, height, depth, edge_length: 1.0 };
        match cuboid.mesh() {
            Ok(mesh) => check(&cuboid, &mesh),
            Err(error) => prop_assert!(matches!(error, CuboidError::Unfit { .. }), "{}", error),
        }
    }
}
