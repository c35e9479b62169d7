//! Where a grain touches the membrane: one contact for each place, however many triangles it reaches.
//!
//! 1. A foot counts where it is a local minimum of the distance: on a face always, on a side if both triangles of the side
//!    have their feet there, on a corner if all triangles around it have.
//! 2. Contacts of neighboring triangles whose normals differ by less than 30° are one: a pressed sheet wraps around a
//!    grain, and two faces of a shallow valley are one place. The overlap is the deepest; normal and lever are those of the
//!    overlaps' mean, so that force and torque are continuous as the grain moves from one face to the next.
//! 3. The sheet has an inside. A grain whose center has crossed it is pushed back, but only if it touched there before:
//!    a fold of the sheet beyond a neighboring grain shows its outside too, and so does one next to the grain, whose other
//!    side shows its inside.

use super::foot::Part;
use super::reach::Reach;
use super::sheet::Sheet;
use crate::math::plain;
use crate::membrane::Mesh;

/// cos 30°.
const ALIKE: f64 = 0.866_025_403_784_438_6;

/// Marks of places, before they have groups.
const KEPT: usize = 0;
const DROPPED: usize = 1;

/// A place where the grain at hand reaches the membrane, before places are merged.
#[derive(Clone, Copy, Debug)]
struct Place {
    triangle: u32,
    part: Part,
    /// The edge or the vertex that it is on; none of a face.
    on: Option<Meeting>,
    weights: [f64; 3],
    /// From the membrane into the grain.
    normal: [f64; 3],
    /// p.
    overlap: f64,
    /// How much it counts in the mean of a group.
    weight: f64,
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
    pub(super) grain: u32,
    /// The triangle of the deepest reach.
    pub(super) triangle: u32,
    /// Where its shares end.
    pub(super) shares_end: usize,
    /// From the membrane into the grain.
    pub(super) normal: [f64; 3],
    /// p.
    pub(super) overlap: f64,
    /// From the grain's center to the contact point.
    pub(super) lever: [f64; 3],
}

/// A grain, and where it touched in the last step.
pub(super) struct Ball<'a> {
    pub(super) grain: u32,
    pub(super) radius: f64,
    /// Whether a triangle is, or is next to, one of its contacts in the last step.
    pub(super) touched: &'a dyn Fn(u32) -> bool,
}

/// Finds the contacts of one grain after the other; keeps its memory.
#[derive(Clone, Debug, Default)]
pub(super) struct Finder {
    /// Of the grain at hand.
    places: Vec<Place>,
    /// All contacts so far.
    pub(super) touches: Vec<Touch>,
    /// Their shares, one contact's after the other's; a contact's sum to one.
    pub(super) shares: Vec<Share>,
}

impl Finder {
    /// Forgets all contacts.
    pub(super) fn clear(&mut self) {
        self.touches.clear();
        self.shares.clear();
    }

    /// Adds the contacts of `ball`, which reaches the membrane at `reaches`.
    #[inline(always)]
    pub(super) fn add(
        &mut self,
        mesh: &Mesh,
        sheet: Sheet<'_>,
        ball: &Ball<'_>,
        reaches: &[Reach],
    ) {
        match reaches {
            [only] if only.height > 0.0 && only.part() == Part::Face => {
                self.add_face(mesh, ball, only);
            }
            _ => self.add_all(mesh, sheet, ball, reaches),
        }
    }

    /// Adds a contact with one face.
    #[inline(always)]
    fn add_face(&mut self, mesh: &Mesh, ball: &Ball<'_>, reach: &Reach) {
        let triangle = reach.pair[1];
        self.share(mesh, triangle, reach.weights(), 1.0);
        self.touches.push(Touch {
            grain: ball.grain,
            triangle,
            shares_end: self.shares.len(),
            normal: reach.normal(),
            overlap: ball.radius - reach.depth(),
            lever: plain::scale(reach.normal(), -reach.depth()),
        });
    }

    #[inline(always)]
    fn share(&mut self, mesh: &Mesh, triangle: u32, weights: [f64; 3], share: f64) {
        let corners = mesh.triangles()[triangle as usize];
        let shares = corners.into_iter().zip(weights);
        self.shares.extend(shares.map(|(vertex, weight)| Share {
            vertex,
            weight: share * weight,
        }));
    }

    fn add_all(&mut self, mesh: &Mesh, sheet: Sheet<'_>, ball: &Ball<'_>, reaches: &[Reach]) {
        self.places.clear();
        // Where the grain is inside of all planes, it is inside of the sheet.
        let inside = reaches.iter().all(|reach| reach.height > 0.0);
        for reach in reaches {
            let place = place(mesh, ball, reach);
            if inside {
                self.places.push(place);
            } else {
                let side = sided(mesh, sheet, ball, place, reach);
                self.places.extend(side);
            }
        }
        if !inside {
            self.drop_outsides(mesh, ball.radius);
        }
        if self.places.is_empty() {
            return;
        }
        if self.places.iter().any(|place| place.part != Part::Face) {
            self.keep_minima(mesh);
        }
        self.group(mesh);
        self.merge(mesh, ball);
    }

    /// Drops every triangle that shows its outside while a neighbor of it shows its inside: the sheet is folded there.
    fn drop_outsides(&mut self, mesh: &Mesh, radius: f64) {
        let insides: Vec<u32> = self
            .places
            .iter()
            .filter(|place| place.overlap <= radius)
            .map(|place| place.triangle)
            .collect();
        let folded = |t: u32| insides.iter().any(|&other| mesh.are_neighbors(t, other));
        self.places
            .retain(|place| place.overlap <= radius || !folded(place.triangle));
    }

    /// Drops every foot that is no local minimum; if rounding leaves none, the deepest stays.
    fn keep_minima(&mut self, mesh: &Mesh) {
        let deeper = |a: Place, b: &Place| if b.overlap > a.overlap { *b } else { a };
        let deepest = self.places.iter().fold(self.places[0], deeper);
        // Nowhere on a closed mesh does a triangle meet none.
        let closed = mesh.is_closed();
        for k in 0..self.places.len() {
            let Some(meeting) = self.places[k].on else {
                self.places[k].group = KEPT;
                continue;
            };
            let there = |other: &Place| other.on == Some(meeting);
            let first = !self.places[..k].iter().any(there);
            let found = self.places[k..].iter().filter(|other| there(other)).count();
            let minimal = first && (found > 1 || !closed) && found == meeting.triangles(mesh);
            self.places[k].group = if minimal { KEPT } else { DROPPED };
        }
        self.places.retain(|place| place.group == KEPT);
        if self.places.is_empty() {
            self.places.push(deepest);
        }
    }

    /// Gives neighbors of like normals one group.
    fn group(&mut self, mesh: &Mesh) {
        for k in 0..self.places.len() {
            self.places[k].group = k;
            for other in 0..k {
                let (a, b) = (self.places[k], self.places[other]);
                if a.group != b.group
                    && plain::dot(a.normal, b.normal) > ALIKE
                    && mesh.are_neighbors(a.triangle, b.triangle)
                {
                    let (from, to) = (a.group.max(b.group), a.group.min(b.group));
                    for place in &mut self.places[..=k] {
                        if place.group == from {
                            place.group = to;
                        }
                    }
                }
            }
        }
    }

    fn merge(&mut self, mesh: &Mesh, ball: &Ball<'_>) {
        let places = std::mem::take(&mut self.places);
        for (group, first) in places.iter().enumerate() {
            if first.group != group {
                continue;
            }
            let members = || {
                places[group..]
                    .iter()
                    .filter(move |place| place.group == group)
            };
            let (mut deepest, mut total) = (first, 0.0);
            for place in members() {
                total += place.weight;
                if place.overlap > deepest.overlap {
                    deepest = place;
                }
            }
            // Where the center has all but crossed the sheet, the mean's levers have no length to be weighed by.
            let mean = ball.radius - deepest.overlap > 0.05 * ball.radius && total > 0.0;
            let mut lever = [0.0; 3];
            for place in members() {
                let share = if mean {
                    place.weight / total
                } else {
                    f64::from(u8::from(place.triangle == deepest.triangle))
                };
                let depth = ball.radius - place.overlap;
                lever = plain::sub(lever, plain::scale(place.normal, share * depth));
                self.share(mesh, place.triangle, place.weights, share);
            }
            let normal = if mean {
                plain::scale(lever, -1.0 / plain::norm(lever))
            } else {
                deepest.normal
            };
            self.touches.push(Touch {
                grain: ball.grain,
                triangle: deepest.triangle,
                shares_end: self.shares.len(),
                normal,
                overlap: deepest.overlap,
                lever,
            });
        }
        self.places = places;
    }
}

/// A reach as a place.
fn place(mesh: &Mesh, ball: &Ball<'_>, reach: &Reach) -> Place {
    let (triangle, part) = (reach.pair[1], reach.part());
    Place {
        triangle,
        part,
        on: Meeting::of(mesh, triangle, part),
        weights: reach.weights(),
        normal: reach.normal(),
        overlap: ball.radius - reach.depth(),
        weight: reach.weight,
        group: 0,
    }
}

/// The place seen from the side of the sheet that the center is on; none if that is the outside, and it did not touch before.
fn sided(
    mesh: &Mesh,
    sheet: Sheet<'_>,
    ball: &Ball<'_>,
    mut place: Place,
    reach: &Reach,
) -> Option<Place> {
    if place.part != Part::Face {
        let mean = mean_outward(mesh, sheet, place.triangle, place.part);
        if reach.depth() == 0.0 {
            place.normal = plain::scale(mean, -1.0 / plain::norm(mean));
        } else if plain::dot(place.normal, mean) > 0.0 {
            // Inside, the way to the center leads against the outward normals around the foot.
            place.normal = plain::scale(place.normal, -1.0);
            place.overlap = ball.radius + reach.depth();
        }
    }
    (place.overlap <= ball.radius || (ball.touched)(place.triangle)).then_some(place)
}

/// An edge or a vertex of the mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Meeting {
    Edge(u32),
    Vertex(u32),
}

impl Meeting {
    /// Where `part` of triangle `t` lies.
    fn of(mesh: &Mesh, t: u32, part: Part) -> Option<Self> {
        match part {
            Part::Face => None,
            Part::Side(s) => Some(Self::Edge(mesh.sides(t)[s])),
            Part::Corner(c) => Some(Self::Vertex(mesh.triangles()[t as usize][c])),
        }
    }

    /// How many triangles meet there.
    fn triangles(self, mesh: &Mesh) -> usize {
        match self {
            Self::Edge(edge) => mesh.edge_triangles()[edge as usize]
                .iter()
                .flatten()
                .count(),
            Self::Vertex(vertex) => mesh.fan(vertex).len(),
        }
    }
}

/// The sum of the outward normals of the triangles that meet at a side or corner.
fn mean_outward(mesh: &Mesh, sheet: Sheet<'_>, t: u32, part: Part) -> [f64; 3] {
    match part {
        Part::Face => sheet.outward(t),
        Part::Side(s) => match mesh.over_sides(t)[s] {
            Some(other) => plain::add(sheet.outward(t), sheet.outward(other)),
            None => sheet.outward(t),
        },
        Part::Corner(c) => {
            let fan = mesh.fan(mesh.triangles()[t as usize][c]);
            fan.iter()
                .fold([0.0; 3], |sum, &t| plain::add(sum, sheet.outward(t)))
        }
    }
}
