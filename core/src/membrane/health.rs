//! What goes wrong with a sheet: short edges, collapsed or inverted triangles, sharp folds.

use super::mesh::Mesh;
use crate::math::plain;

/// An edge shorter than this part of its rest length is worth a warning.
const SHORT_EDGE: f64 = 0.3;
/// A triangle smaller than this part of its area at rest has collapsed.
const COLLAPSED_AREA: f64 = 1e-6;
/// cos 120°: a normal that turned by more between two looks has flipped.
const FLIPPED: f64 = -0.5;
/// −cos 30° = cos 150°: two triangles folded by more are about to touch.
const SHARP_FOLD: f64 = -0.866_025_403_784_438_6;

/// Something wrong with the sheet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Finding {
    /// An edge is shorter than 0.3 ℓ₀.
    ShortEdge {
        /// A triangle that has it.
        triangle: u32,
        /// Its number.
        edge: u32,
        /// ℓ/ℓ₀.
        ratio: f64,
    },
    /// A triangle is smaller than 1e-6 of its area at rest.
    Collapsed {
        /// Its number.
        triangle: u32,
        /// A/A₀.
        ratio: f64,
    },
    /// A triangle's normal has turned by more than 120° since the last look, and it lies against two of its neighbors, or all:
    /// it is turned over. A part of the sheet that snaps into a gap turns as fast, but lies against one neighbor at most.
    Flipped {
        /// Its number.
        triangle: u32,
        /// Cosine of the turn.
        cosine: f64,
    },
    /// Two triangles are folded by more than 150°, where 0° is flat.
    SharpFold {
        /// Their numbers.
        triangles: [u32; 2],
        /// Cosine of the fold.
        cosine: f64,
    },
}

impl Finding {
    /// Whether the sheet is beyond repair; the others are warnings.
    #[must_use]
    pub fn is_collapse(&self) -> bool {
        matches!(self, Self::Collapsed { .. } | Self::Flipped { .. })
    }
}

/// The sizes of edges and triangles at rest.
#[derive(Clone, Copy, Debug)]
pub struct Rest<'a> {
    /// ℓ₀ of every edge \[m\].
    pub lengths: &'a [f64],
    /// A₀ of every triangle \[m²\].
    pub areas: &'a [f64],
}

/// What is wrong with `mesh`, given the triangles' normals now and at the last look: edges, triangles, folds, each in order.
///
/// Sizes that are not a number are findings too.
#[must_use]
pub fn findings(mesh: &Mesh, rest: Rest<'_>, [now, before]: [&[[f64; 3]]; 2]) -> Vec<Finding> {
    let mut found = short_edges(mesh, rest.lengths);
    found.extend(lost_triangles(mesh, rest.areas, [now, before]));
    found.extend(sharp_folds(mesh, now));
    found
}

fn short_edges(mesh: &Mesh, rest: &[f64]) -> Vec<Finding> {
    let ratios = mesh.edge_lengths().zip(rest).map(|(now, rest)| now / rest);
    (0u32..)
        .zip(ratios)
        .zip(mesh.edge_triangles())
        .filter(|((_, ratio), _)| *ratio < SHORT_EDGE || ratio.is_nan())
        .filter_map(|((edge, ratio), both)| {
            let triangle = both[0].or(both[1])?;
            Some(Finding::ShortEdge {
                triangle,
                edge,
                ratio,
            })
        })
        .collect()
}

fn lost_triangles(mesh: &Mesh, rest: &[f64], [now, before]: [&[[f64; 3]]; 2]) -> Vec<Finding> {
    let ratios = mesh.areas().zip(rest).map(|(now, rest)| now / rest);
    let turns = now.iter().zip(before).map(|(&a, &b)| plain::dot(a, b));
    let lost = |((triangle, ratio), cosine): ((u32, f64), f64)| {
        if ratio < COLLAPSED_AREA || ratio.is_nan() {
            Some(Finding::Collapsed { triangle, ratio })
        } else if cosine < FLIPPED && is_turned_over(mesh, now, triangle) {
            Some(Finding::Flipped { triangle, cosine })
        } else {
            None
        }
    };
    (0u32..).zip(ratios).zip(turns).filter_map(lost).collect()
}

/// Whether `triangle` lies against two of its neighbors, or against all if it has fewer.
fn is_turned_over(mesh: &Mesh, normals: &[[f64; 3]], triangle: u32) -> bool {
    let own = normals[triangle as usize];
    let neighbors = mesh.over_sides(triangle).into_iter().flatten();
    let against = |&other: &u32| plain::dot(own, normals[other as usize]) < FLIPPED;
    let count = neighbors.clone().filter(against).count();
    count >= neighbors.count().min(2)
}

fn sharp_folds(mesh: &Mesh, normals: &[[f64; 3]]) -> Vec<Finding> {
    let fold = |both: &[Option<u32>; 2]| {
        let triangles = [both[0]?, both[1]?];
        let [a, b] = triangles.map(|t| normals[t as usize]);
        let cosine = plain::dot(a, b);
        (cosine < SHARP_FOLD).then_some(Finding::SharpFold { triangles, cosine })
    };
    mesh.edge_triangles().iter().filter_map(fold).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::membrane::shapes::{icosphere, strip};

    /// What is wrong with `moved`, whose rest is `mesh`.
    fn look(mesh: &Mesh, moved: &Mesh) -> Vec<Finding> {
        let lengths: Vec<_> = mesh.edge_lengths().collect();
        let areas: Vec<_> = mesh.areas().collect();
        let rest = Rest {
            lengths: &lengths,
            areas: &areas,
        };
        let [before, now] = [mesh, moved].map(|mesh| mesh.normals().collect::<Vec<_>>());
        findings(moved, rest, [&now, &before])
    }

    #[test]
    fn sound_sheets_have_no_findings() {
        let mesh = icosphere(2, 1.0);
        let mut moved = mesh.clone();
        for place in moved.positions_mut() {
            *place = [0.5 * place[0], 0.8 * place[1], 1.5 * place[2]];
        }
        assert_eq!(look(&mesh, &moved), []);
    }

    /// Two triangles over one edge of length one, one of them turned about it by `angle`.
    fn folded(angle: f64) -> Mesh {
        let (sine, cosine) = (libm::sin(angle), libm::cos(angle));
        let places = vec![
            [0.0; 3],
            [1.0, 0.0, 0.0],
            [0.5, 1.0, 0.0],
            [0.5, -cosine, -sine],
        ];
        Mesh::new(places, vec![[0, 1, 2], [1, 0, 3]]).unwrap()
    }

    #[test]
    fn folds_sharper_than_150_degrees_are_warned_about() {
        for (degrees, sharp) in [(0.0f64, 0), (149.9, 0), (150.1, 1), (-150.1, 1), (179.0, 1)] {
            let mesh = folded(degrees.to_radians());
            let found = look(&mesh, &mesh);
            assert_eq!(found.len(), sharp, "{degrees}");
            for finding in found {
                let triangles = [0, 1];
                assert!(
                    matches!(finding, Finding::SharpFold { triangles: t, .. } if t == triangles)
                );
                assert!(!finding.is_collapse());
            }
        }
    }

    #[test]
    fn normals_that_turn_by_more_than_120_degrees_have_flipped() {
        for (degrees, flips) in [(119.9f64, false), (120.1, true)] {
            let found = look(&folded(0.0), &folded(degrees.to_radians()));
            let flipped =
                |finding: &Finding| matches!(finding, Finding::Flipped { triangle: 1, .. });
            assert_eq!(found.iter().any(flipped), flips, "{degrees}");
            assert_eq!(found.iter().any(Finding::is_collapse), flips);
        }
    }

    #[test]
    fn short_edges_are_warned_about_and_lost_areas_are_collapse() {
        let mesh = strip(1, 1, 1.0);
        let squeezed = |factor: f64| {
            let mut moved = mesh.clone();
            for place in moved.positions_mut() {
                place[0] *= factor;
            }
            look(&mesh, &moved)
        };
        assert_eq!(squeezed(0.31), []);
        let short = squeezed(0.29);
        assert_eq!(short.len(), 2);
        assert!(
            matches!(short[0], Finding::ShortEdge { triangle: 0, edge: 0, ratio } if ratio > 0.28)
        );
        assert!(!short.iter().any(Finding::is_collapse));
        let lost = squeezed(1e-7);
        let collapsed = lost.iter().filter(|finding| finding.is_collapse());
        let triangles: Vec<u32> = collapsed
            .map(|finding| match finding {
                Finding::Collapsed { triangle, .. } => *triangle,
                other => panic!("{other:?}"),
            })
            .collect();
        assert_eq!(triangles, [0, 1]);
        assert!(squeezed(f64::NAN).iter().any(Finding::is_collapse));
    }
}
