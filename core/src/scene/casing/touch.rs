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

use super::Held;
use super::foot::Part;
use super::reach::Reach;
use super::sheet::Sheet;
use crate::math::plain;
use crate::membrane::Mesh;

/// cos 30°.
const ALIKE: f64 = 0.866_025_403_784_438_6;

/// A place where the grain at hand reaches the membrane, before places are merged.
#[derive(Clone, Copy, Debug)]
struct Place {
    triangle: u32,
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
#[derive(Clone, Copy)]
pub(super) struct Ball<'a> {
    pub(super) grain: u32,
    pub(super) radius: f64,
    /// All contacts of the last step, by grains.
    pub(super) held: &'a [Held],
}

impl Ball<'_> {
    /// Whether a triangle is, or is next to, one of its contacts in the last step.
    fn touched(&self, mesh: &Mesh, triangle: u32) -> bool {
        let first = self.held.partition_point(|held| held.grain < self.grain);
        let mut own = self.held[first..]
            .iter()
            .take_while(|held| held.grain == self.grain);
        own.any(|held| mesh.are_neighbors(held.triangle, triangle))
    }
}

/// Finds the contacts of one grain after the other; keeps its memory.
#[derive(Clone, Debug, Default)]
pub(super) struct Finder {
    /// Of the grain at hand.
    places: Vec<Place>,
    /// What each of its feet is on.
    meetings: Vec<Option<Meeting>>,
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
        // Where the grain is inside of all planes, it is inside of the sheet.
        if reaches.iter().all(|reach| reach.height > 0.0) {
            self.add_inside(mesh, ball, reaches);
        } else {
            self.add_sided(mesh, sheet, ball, reaches);
        }
    }

    /// Adds the contacts of a grain whose center is inside of all planes.
    #[inline(always)]
    fn add_inside(&mut self, mesh: &Mesh, ball: &Ball<'_>, reaches: &[Reach]) {
        self.meetings.clear();
        let meeting = |reach: &Reach| Meeting::of(mesh, reach.pair[1], reach.part());
        self.meetings.extend(reaches.iter().map(meeting));
        let minimal = |k: &usize| is_minimum(mesh, &self.meetings, *k);
        let mut minima = (0..reaches.len()).filter(minimal);
        match (minima.next(), minima.next()) {
            (Some(only), None) => self.add_one(mesh, ball, &reaches[only]),
            (None, _) => {
                let depth = |k: &usize| reaches[*k].depth();
                let deeper = |a, b| if depth(&b) < depth(&a) { b } else { a };
                // If rounding leaves no minimum, the deepest stays.
                if let Some(deepest) = (0..reaches.len()).reduce(deeper) {
                    self.add_one(mesh, ball, &reaches[deepest]);
                }
            }
            (Some(first), Some(second)) => {
                self.places.clear();
                let all = [first, second].into_iter().chain(minima);
                self.places
                    .extend(all.map(|k| place(ball, &reaches[k], self.meetings[k])));
                self.group(mesh);
                self.merge(mesh, ball);
            }
        }
    }

    /// Adds a contact at one place, inside of the sheet.
    #[inline(always)]
    fn add_one(&mut self, mesh: &Mesh, ball: &Ball<'_>, reach: &Reach) {
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

    /// Adds the contacts of a grain whose center is outside of some plane.
    fn add_sided(&mut self, mesh: &Mesh, sheet: Sheet<'_>, ball: &Ball<'_>, reaches: &[Reach]) {
        self.places.clear();
        self.places.extend(
            reaches
                .iter()
                .filter_map(|reach| sided(mesh, sheet, ball, reach)),
        );
        self.drop_outsides(mesh, ball.radius);
        if self.places.is_empty() {
            return;
        }
        self.keep_minima(mesh);
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
        self.meetings.clear();
        self.meetings
            .extend(self.places.iter().map(|place| place.on));
        let mut next = 0..;
        self.places.retain(|_| {
            let k = next.next().unwrap_or_default();
            is_minimum(mesh, &self.meetings, k)
        });
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

/// Whether foot `k` of a grain is a local minimum of the distance, by what each of its feet is on.
///
/// Feet that are on one edge or vertex are one: the first.
#[inline(always)]
fn is_minimum(mesh: &Mesh, on: &[Option<Meeting>], k: usize) -> bool {
    let Some(meeting) = on[k] else {
        return true;
    };
    let there = |other: &&Option<Meeting>| **other == Some(meeting);
    let found = on[k..].iter().filter(there).count();
    // Nowhere on a closed mesh does a triangle meet none.
    (found > 1 || !mesh.is_closed())
        && found == meeting.triangles(mesh)
        && !on[..k].iter().any(|other| there(&other))
}

/// A reach as a place.
fn place(ball: &Ball<'_>, reach: &Reach, on: Option<Meeting>) -> Place {
    Place {
        triangle: reach.pair[1],
        on,
        weights: reach.weights(),
        normal: reach.normal(),
        overlap: ball.radius - reach.depth(),
        weight: reach.weight,
        group: 0,
    }
}

/// A reach seen from the side of the sheet that the center is on; none if that is the outside, and it did not touch before.
fn sided(mesh: &Mesh, sheet: Sheet<'_>, ball: &Ball<'_>, reach: &Reach) -> Option<Place> {
    let (triangle, part) = (reach.pair[1], reach.part());
    let mut place = place(ball, reach, Meeting::of(mesh, triangle, part));
    if part != Part::Face {
        let mean = mean_outward(mesh, sheet, triangle, part);
        if reach.depth() == 0.0 {
            place.normal = plain::scale(mean, -1.0 / plain::norm(mean));
        } else if plain::dot(place.normal, mean) > 0.0 {
            // Inside, the way to the center leads against the outward normals around the foot.
            place.normal = plain::scale(place.normal, -1.0);
            place.overlap = ball.radius + reach.depth();
        }
    }
    (place.overlap <= ball.radius || ball.touched(mesh, triangle)).then_some(place)
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
