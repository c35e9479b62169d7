//! Where one grain touches the membrane: one contact for each place, however many triangles it reaches.
//!
//! 1. A foot counts where it is a local minimum of the distance: on a face always, on a side if both triangles of the side
//!    have their feet there, on a corner if all triangles around it have.
//! 2. Contacts of neighboring triangles whose normals differ by less than 30° are one: a pressed sheet wraps around a
//!    grain, and two faces of a shallow valley are one place. The overlap is the deepest; normal and lever are those of the
//!    overlaps' mean, so that force and torque are continuous as the grain moves from one face to the next.
//! 3. The sheet has an inside. A grain whose center has crossed it is pushed back, but only if it touched there before:
//!    a fold of the sheet beyond a neighboring grain shows its outside too, and so does one next to the grain, whose other
//!    side shows its inside.

use super::foot::{Foot, Part, at, foot};
use crate::math::plain;
use crate::membrane::Mesh;

/// cos 30°.
const ALIKE: f64 = 0.866_025_403_784_438_6;

/// A place where a grain reaches the membrane, before places are merged.
#[derive(Clone, Copy, Debug)]
struct Reach {
    triangle: u32,
    part: Part,
    /// Where it lies unless on the face, and how many triangles meet there.
    meeting: Option<(Place, usize)>,
    weights: [f64; 3],
    /// From the membrane into the grain.
    normal: [f64; 3],
    /// p.
    overlap: f64,
    /// Which merged contact it belongs to.
    group: usize,
}

/// A corner of a contact's share of the membrane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Share {
    pub(super) vertex: u32,
    pub(super) weight: f64,
}

/// One contact of a grain with the membrane.
#[derive(Clone, Copy, Debug)]
pub(super) struct Touch {
    /// The triangle of the deepest reach.
    pub(super) triangle: u32,
    /// From the membrane into the grain.
    pub(super) normal: [f64; 3],
    /// p.
    pub(super) overlap: f64,
    /// From the grain's center to the contact point.
    pub(super) lever: [f64; 3],
}

/// The membrane as it is in one step.
pub(super) struct Sheet<'a> {
    pub(super) mesh: &'a Mesh,
    /// All triangles as they are in this step.
    pub(super) faces: &'a [Face],
}

/// A triangle where it is now, side by side with what is asked of it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Face {
    corners: [[f64; 3]; 3],
    /// Unit normal.
    outward: [f64; 3],
}

/// All triangles of `mesh` as they are now.
pub(super) fn faces(mesh: &Mesh) -> impl Iterator<Item = Face> + '_ {
    let corners = (0..mesh.triangles().len() as u32).map(|t| mesh.corners(t));
    corners
        .zip(mesh.normals())
        .map(|(corners, outward)| Face { corners, outward })
}

/// A grain, and where it touched in the last step.
pub(super) struct Ball<'a> {
    pub(super) center: [f64; 3],
    pub(super) radius: f64,
    /// Triangles of its contacts in the last step.
    pub(super) touched: &'a dyn Fn(u32) -> bool,
}

/// Finds the contacts of one grain at a time; keeps its scratch memory.
#[derive(Clone, Debug, Default)]
pub(super) struct Finder {
    reaches: Vec<Reach>,
    /// The contacts of the last grain.
    pub(super) touches: Vec<Touch>,
    /// The shares of contact n: `shares[ends[n - 1]..ends[n]]`; they sum to one.
    pub(super) shares: Vec<Share>,
    pub(super) ends: Vec<usize>,
}

impl Finder {
    /// Finds the contacts of `ball` with the `near` triangles.
    pub(super) fn find(&mut self, sheet: &Sheet<'_>, ball: &Ball<'_>, near: &[u32]) {
        self.reaches.clear();
        for &t in near {
            if let Some(reach) = reach(sheet, ball, t) {
                self.reaches.push(reach);
            }
        }
        self.touches.clear();
        self.shares.clear();
        self.ends.clear();
        self.drop_outsides(sheet.mesh, ball.radius);
        if self.reaches.is_empty() {
            return;
        }
        self.keep_minima();
        self.group(sheet.mesh);
        self.merge(sheet.mesh, ball);
    }

    /// Drops every triangle that shows its outside while a neighbor of it shows its inside: the sheet is folded there.
    fn drop_outsides(&mut self, mesh: &Mesh, radius: f64) {
        if self.reaches.iter().all(|reach| reach.overlap <= radius) {
            return;
        }
        let inside: Vec<u32> = self
            .reaches
            .iter()
            .filter(|reach| reach.overlap <= radius)
            .map(|reach| reach.triangle)
            .collect();
        let folded = |t: u32| {
            inside
                .iter()
                .any(|other| mesh.around(t).binary_search(other).is_ok())
        };
        self.reaches
            .retain(|reach| reach.overlap <= radius || !folded(reach.triangle));
    }

    /// Drops every foot that is no local minimum; if rounding leaves none, the deepest stays.
    fn keep_minima(&mut self) {
        let kept = |reach: &Reach| {
            let Some((place, triangles)) = reach.meeting else {
                return true;
            };
            let same = |other: &&Reach| other.meeting.is_some_and(|(at, _)| at == place);
            let mut others = self.reaches.iter().filter(same);
            let first = others.next().map(|other| other.triangle);
            first == Some(reach.triangle) && 1 + others.count() == triangles
        };
        let minima: Vec<Reach> = self.reaches.iter().filter(|r| kept(r)).copied().collect();
        if minima.is_empty() {
            let deeper = |a: Reach, b: &Reach| if b.overlap > a.overlap { *b } else { a };
            let deepest = self.reaches.iter().fold(self.reaches[0], deeper);
            self.reaches.clear();
            self.reaches.push(deepest);
        } else {
            self.reaches.clear();
            self.reaches.extend(minima);
        }
    }

    /// Gives neighbors of like normals one group.
    fn group(&mut self, mesh: &Mesh) {
        for k in 0..self.reaches.len() {
            self.reaches[k].group = k;
            for other in 0..k {
                let (a, b) = (self.reaches[k], self.reaches[other]);
                let neighbors = a.triangle == b.triangle
                    || mesh.around(a.triangle).binary_search(&b.triangle).is_ok();
                if a.group != b.group && neighbors && plain::dot(a.normal, b.normal) > ALIKE {
                    let (from, to) = (a.group.max(b.group), a.group.min(b.group));
                    for reach in &mut self.reaches[..=k] {
                        if reach.group == from {
                            reach.group = to;
                        }
                    }
                }
            }
        }
    }

    fn merge(&mut self, mesh: &Mesh, ball: &Ball<'_>) {
        for group in 0..self.reaches.len() {
            let members = || self.reaches.iter().filter(move |r| r.group == group);
            let Some(&first) = members().next() else {
                continue;
            };
            let deepest = members().fold(first, |a, b| if b.overlap > a.overlap { *b } else { a });
            // Where the center has all but crossed the sheet, the mean's levers have no length to be weighed by.
            let whole = members().all(|r| ball.radius - r.overlap > 0.05 * ball.radius);
            let part = |r: &Reach| fade(mesh, ball, r) * r.overlap / (ball.radius - r.overlap);
            let total: f64 = members().map(part).sum();
            let mean = whole && total > 0.0;
            let mut lever = [0.0; 3];
            for reach in members() {
                let share = if mean {
                    part(reach) / total
                } else {
                    f64::from(u8::from(reach.triangle == deepest.triangle))
                };
                let depth = ball.radius - reach.overlap;
                lever = plain::sub(lever, plain::scale(reach.normal, share * depth));
                let corners = mesh.triangles()[reach.triangle as usize];
                for (vertex, weight) in corners.into_iter().zip(reach.weights) {
                    self.shares.push(Share {
                        vertex,
                        weight: share * weight,
                    });
                }
            }
            let normal = if mean {
                plain::scale(lever, -1.0 / plain::norm(lever))
            } else {
                deepest.normal
            };
            self.touches.push(Touch {
                triangle: deepest.triangle,
                normal,
                overlap: deepest.overlap,
                lever,
            });
            self.ends.push(self.shares.len());
        }
    }
}

/// How much a reach counts in the mean of a group: less and less as its foot leaves the face by a side, over the radius √(R p)
/// of the contact; in a valley it is gone then, whatever its overlap.
fn fade(mesh: &Mesh, ball: &Ball<'_>, reach: &Reach) -> f64 {
    if reach.part != Part::Face {
        return 1.0;
    }
    let [a, b, c] = mesh.corners(reach.triangle);
    let sides = [plain::sub(c, b), plain::sub(a, c), plain::sub(b, a)];
    let doubled = plain::norm(plain::cross(sides[2], sides[1]));
    let away = |k: usize| reach.weights[k] * doubled / plain::norm(sides[k]);
    let least = away(0).min(away(1)).min(away(2));
    (least / (ball.radius * reach.overlap).sqrt()).clamp(0.0, 1.0)
}

/// An edge or a vertex of the mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Place {
    Edge(u32),
    Vertex(u32),
}

/// The edge or vertex that a foot is on, and how many triangles meet there; none for a face.
fn meeting(mesh: &Mesh, t: u32, part: Part) -> Option<(Place, usize)> {
    match part {
        Part::Face => None,
        Part::Side(s) => {
            let triangles = 1 + usize::from(mesh.over_sides(t)[s].is_some());
            Some((Place::Edge(mesh.sides(t)[s]), triangles))
        }
        Part::Corner(c) => {
            let vertex = mesh.triangles()[t as usize][c];
            Some((Place::Vertex(vertex), mesh.fan(vertex).len()))
        }
    }
}

/// Where the ball reaches triangle `t`, if it does.
fn reach(sheet: &Sheet<'_>, ball: &Ball<'_>, t: u32) -> Option<Reach> {
    let Face { corners, outward } = sheet.faces[t as usize];
    let height = -plain::dot(plain::sub(ball.center, corners[0]), outward);
    if height.abs() >= ball.radius {
        return None;
    }
    let Foot { part, weights } = foot(ball.center, corners);
    let (normal, depth) = match part {
        Part::Face => (plain::scale(outward, -1.0), height),
        Part::Side(_) | Part::Corner(_) => {
            let from = plain::sub(ball.center, at(weights, corners));
            let distance = plain::norm(from);
            let mean = mean_outward(sheet, t, part);
            // Inside, the way to the center leads against the outward normals around the foot.
            let sign = if plain::dot(from, mean) > 0.0 {
                -1.0
            } else {
                1.0
            };
            if distance > 0.0 {
                (plain::scale(from, sign / distance), sign * distance)
            } else {
                (plain::scale(mean, -1.0 / plain::norm(mean)), 0.0)
            }
        }
    };
    let reaches = depth.abs() < ball.radius && (depth >= 0.0 || (ball.touched)(t));
    reaches.then_some(Reach {
        triangle: t,
        part,
        meeting: meeting(sheet.mesh, t, part),
        weights,
        normal,
        overlap: ball.radius - depth,
        group: 0,
    })
}

/// The sum of the outward normals of the triangles that meet at a side or corner.
fn mean_outward(sheet: &Sheet<'_>, t: u32, part: Part) -> [f64; 3] {
    let normal = |t: u32| sheet.faces[t as usize].outward;
    match part {
        Part::Face => normal(t),
        Part::Side(s) => match sheet.mesh.over_sides(t)[s] {
            Some(other) => plain::add(normal(t), normal(other)),
            None => normal(t),
        },
        Part::Corner(c) => {
            let fan = sheet.mesh.fan(sheet.mesh.triangles()[t as usize][c]);
            fan.iter()
                .fold([0.0; 3], |sum, &t| plain::add(sum, normal(t)))
        }
    }
}
