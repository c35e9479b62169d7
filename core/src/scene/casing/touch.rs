//! Where a grain touches the membrane: one contact for each patch, however many triangles it reaches.
//!
//! Forces are those of the patch's energy ([`super::patch`]), at the feet of its terms. Friction and viscosity act at one point:
//! the mean of the feet, each by its force, with the normal from there to the grain's center. What forces have beside that
//! normal is the contact's surplus; it acts as it is.
//!
//! The sheet has an inside. A grain whose center has crossed it is pushed back, but only if it touched there before:
//! a fold of the sheet beyond a neighboring grain shows its outside too, and so does one next to the grain, whose other
//! side shows its inside.

use super::Held;
use super::foot::Part;
use super::patch::{Patch, Place, Sphere, Term};
use super::reach::Reach;
use super::sheet::Sheet;
use crate::math::plain;
use crate::membrane::Mesh;

/// Center to foot over R, below which the center is as good as on the sheet.
const NO_DEPTH: f64 = 0.05;

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
    pub(super) sphere: Sphere,
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

/// What the force of a contact at several places is beside that along its normal at its point.
#[derive(Clone, Copy, Debug)]
pub(super) struct Surplus {
    /// The number of the contact.
    pub(super) touch: usize,
    /// The first of its places.
    place: usize,
    /// On the grain, over k.
    pub(super) force: [f64; 3],
    /// Where its pulls end.
    pub(super) pulls_end: usize,
}

/// A part of the opposite of a surplus.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Pull {
    pub(super) vertex: u32,
    /// Over k.
    pub(super) force: [f64; 3],
}

/// A foot at which grain and membrane push each other.
pub(super) struct Push {
    pub(super) normal: [f64; 3],
    pub(super) overlap: f64,
    pub(super) shares: [(u32, f64); 3],
}

/// What one vertex has of a contact at several places.
#[derive(Clone, Copy, Debug)]
struct Corner {
    vertex: u32,
    share: f64,
    pull: [f64; 3],
}

/// Finds the contacts of one grain after the other; keeps its memory.
#[derive(Clone, Debug, Default)]
pub(super) struct Finder {
    /// Of the grain at hand.
    patch: Patch,
    /// Of the contact at hand.
    corners: Vec<Corner>,
    /// All contacts so far.
    pub(super) touches: Vec<Touch>,
    /// Their shares, one contact's after the other's; a contact's sum to one.
    pub(super) shares: Vec<Share>,
    /// Of contacts at several places, ascending.
    pub(super) surpluses: Vec<Surplus>,
    /// The opposite of every surplus.
    pub(super) pulls: Vec<Pull>,
}

impl Finder {
    /// Forgets all contacts.
    pub(super) fn clear(&mut self) {
        self.touches.clear();
        self.shares.clear();
        self.surpluses.clear();
        self.pulls.clear();
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
        self.patch.places.clear();
        self.patch.terms.clear();
        // Where the grain is inside of all planes, it is inside of the sheet.
        let inside = reaches.iter().all(|reach| reach.height > 0.0);
        if inside {
            if let Some(only) = Reach::only(reaches)
                && only.depth() > NO_DEPTH * ball.sphere.radius
            {
                self.add_one(ball, &place(mesh, ball, only));
                return;
            }
            for reach in reaches {
                self.patch.places.push(place(mesh, ball, reach));
            }
        } else {
            let places = reaches
                .iter()
                .filter_map(|reach| sided(mesh, sheet, ball, (reaches, reach)));
            self.patch.places.extend(places);
            self.drop_outsides(mesh, ball.sphere.radius);
        }
        self.patch.find(mesh, ball.sphere);
        if let [only] = self.patch.terms[..]
            && inside
            && only.overlap < (1.0 - NO_DEPTH) * ball.sphere.radius
        {
            let place = only.alone(&self.patch.places[only.place]);
            self.add_one(ball, &place);
            return;
        }
        for k in 0..self.patch.places.len() {
            if self.patch.places[k].contact == k {
                self.add_contact(ball, k);
            }
        }
    }

    /// Where the grain at hand is pushed: in contacts at one place, and at the feet of those at several.
    pub(super) fn pushes(&self) -> impl Iterator<Item = Push> {
        let of_one = self.touches.iter().enumerate().filter_map(|(k, touch)| {
            let several = self.surpluses.iter().any(|surplus| surplus.touch == k);
            let last = self.shares[..touch.shares_end].last_chunk::<3>();
            last.filter(|_| !several).map(|shares| Push {
                normal: touch.normal,
                overlap: touch.overlap,
                shares: shares.map(|share| (share.vertex, share.weight)),
            })
        });
        let of_several = |term: &&Term| {
            let contact = self.patch.places[term.place].contact;
            term.count > 0.0
                && self
                    .surpluses
                    .iter()
                    .any(|surplus| surplus.place == contact)
        };
        let terms = self.patch.terms.iter().filter(of_several);
        of_one.chain(terms.map(|term| Push {
            normal: term.normal,
            overlap: term.overlap,
            shares: [0, 1, 2].map(|n| (term.corners[n], term.weights[n])),
        }))
    }

    /// Adds a contact at one place.
    #[inline(always)]
    fn add_one(&mut self, ball: &Ball<'_>, place: &Place) {
        let shares = place.corners.into_iter().zip(place.weights);
        self.shares
            .extend(shares.map(|(vertex, weight)| Share { vertex, weight }));
        self.touches.push(Touch {
            grain: ball.grain,
            triangle: place.triangle,
            shares_end: self.shares.len(),
            normal: place.normal,
            overlap: place.overlap,
            lever: plain::scale(place.normal, place.overlap - ball.sphere.radius),
        });
    }

    /// Adds the contact whose first place is `first`.
    #[inline(always)]
    fn add_contact(&mut self, ball: &Ball<'_>, first: usize) {
        let radius = ball.sphere.radius;
        let places = &self.patch.places[first..];
        let own = places.iter().filter(|place| place.contact == first);
        let depth = |place: &Place| (radius - place.overlap).abs();
        let nearer = |a, b| if depth(b) < depth(a) { b } else { a };
        let Some(&nearest) = own.reduce(nearer) else {
            return;
        };
        let patch = &self.patch;
        let of_contact = |term: &&Term| patch.places[term.place].contact == first;
        let mut terms = patch.terms.iter().filter(of_contact);
        // Where the center has all but crossed the sheet there is no way to the feet to go by, and beyond it terms know no side.
        if nearest.overlap > (1.0 - NO_DEPTH) * radius {
            self.add_one(ball, &nearest);
        } else if let (Some(only), None) = (terms.next(), terms.next()) {
            let place = only.alone(&nearest);
            self.add_one(ball, &place);
        } else {
            self.add_several(ball, &nearest);
        }
    }

    /// Adds a contact of several terms, which reaches deepest at `deepest`.
    fn add_several(&mut self, ball: &Ball<'_>, deepest: &Place) {
        let first = deepest.contact;
        let radius = ball.sphere.radius;
        let (mut total, mut force, mut lever) = (0.0, [0.0; 3], [0.0; 3]);
        self.corners.clear();
        for term in &self.patch.terms {
            if self.patch.places[term.place].contact != first {
                continue;
            }
            let size = term.count * (radius * term.overlap).sqrt() * term.overlap;
            let part = plain::scale(term.normal, size);
            total += size;
            force = plain::add(force, part);
            lever = plain::sub(lever, plain::scale(part, radius - term.overlap));
            for (&vertex, &weight) in term.corners.iter().zip(&term.weights) {
                let (share, pull) = (weight * size, plain::scale(part, weight));
                match self.corners.iter_mut().find(|c| c.vertex == vertex) {
                    Some(corner) => {
                        corner.share += share;
                        corner.pull = plain::add(corner.pull, pull);
                    }
                    None => self.corners.push(Corner {
                        vertex,
                        share,
                        pull,
                    }),
                }
            }
        }
        let length = plain::norm(lever);
        let normal = if length > NO_DEPTH * radius * total.abs() {
            self.corners.iter_mut().for_each(|c| c.share /= total);
            lever = plain::scale(lever, 1.0 / total);
            plain::scale(lever, -1.0 / plain::norm(lever))
        } else {
            // Terms cancel, and leave no point to speak of.
            for corner in &mut self.corners {
                let is = |(vertex, _): &(u32, f64)| *vertex == corner.vertex;
                let weights = deepest.corners.into_iter().zip(deepest.weights);
                corner.share = weights.filter(is).map(|(_, weight)| weight).sum();
            }
            lever = plain::scale(deepest.normal, deepest.overlap - radius);
            deepest.normal
        };
        let along = plain::dot(force, normal).max(0.0);
        for corner in &self.corners {
            let (vertex, weight) = (corner.vertex, corner.share);
            self.shares.push(Share { vertex, weight });
            let at_point = plain::scale(normal, along * weight);
            let force = plain::sub(corner.pull, at_point);
            self.pulls.push(Pull { vertex, force });
        }
        let touch = self.touches.len();
        self.touches.push(Touch {
            grain: ball.grain,
            triangle: deepest.triangle,
            shares_end: self.shares.len(),
            normal,
            // That of one place with this force, k √(R p) p.
            overlap: libm::cbrt(along * along / radius),
            lever,
        });
        self.surpluses.push(Surplus {
            touch,
            place: first,
            force: plain::sub(force, plain::scale(normal, along)),
            pulls_end: self.pulls.len(),
        });
    }

    /// Drops every triangle that shows its outside while a neighbor of it shows its inside: the sheet is folded there.
    fn drop_outsides(&mut self, mesh: &Mesh, radius: f64) {
        let places = &mut self.patch.places;
        let insides: Vec<u32> = places
            .iter()
            .filter(|place| place.overlap <= radius)
            .map(|place| place.triangle)
            .collect();
        let folded = |t: u32| insides.iter().any(|&other| mesh.are_neighbors(t, other));
        places.retain(|place| place.overlap <= radius || !folded(place.triangle));
    }
}

/// A reach as a place.
#[inline(always)]
fn place(mesh: &Mesh, ball: &Ball<'_>, reach: &Reach) -> Place {
    let triangle = reach.pair[1];
    Place {
        triangle,
        corners: mesh.triangles()[triangle as usize],
        part: reach.part(),
        weights: reach.weights(),
        normal: reach.normal(),
        overlap: ball.sphere.radius - reach.depth(),
        bounds: reach.bounds,
        contact: 0,
        joined: 0,
    }
}

/// A reach seen from the side of the sheet that the center is on; none if that is the outside, unless the grain touched there
/// before and the foot is a local minimum of the distance.
fn sided(
    mesh: &Mesh,
    sheet: Sheet<'_>,
    ball: &Ball<'_>,
    (all, reach): (&[Reach], &Reach),
) -> Option<Place> {
    let (triangle, part) = (reach.pair[1], reach.part());
    let mut place = place(mesh, ball, reach);
    if part != Part::Face {
        let mean = mean_outward(mesh, sheet, triangle, part);
        if reach.depth() == 0.0 {
            place.normal = plain::scale(mean, -1.0 / plain::norm(mean));
        } else if plain::dot(place.normal, mean) > 0.0 {
            // Inside, the way to the center leads against the outward normals around the foot.
            place.normal = plain::scale(place.normal, -1.0);
            place.overlap = ball.sphere.radius + reach.depth();
        }
    }
    let inside = place.overlap <= ball.sphere.radius;
    (inside || ball.touched(mesh, triangle) && is_minimum(mesh, all, triangle, part))
        .then_some(place)
}

/// Whether all triangles that meet where the foot of triangle `t` is have their feet there.
fn is_minimum(mesh: &Mesh, all: &[Reach], t: u32, part: Part) -> bool {
    let corners = mesh.triangles()[t as usize];
    let ends = match part {
        Part::Face => return true,
        Part::Side(s) => [corners[s], corners[(s + 1) % 3]],
        Part::Corner(c) => [corners[c]; 2],
    };
    let has_foot_there = |other: u32| {
        let own = mesh.triangles()[other as usize];
        let reach = all.iter().find(|reach| reach.pair[1] == other);
        reach.is_some_and(|reach| match (part, reach.part()) {
            (Part::Side(_), Part::Side(s)) => [own[(s + 1) % 3], own[s]] == ends || other == t,
            (Part::Corner(_), Part::Corner(c)) => own[c] == ends[0],
            _ => false,
        })
    };
    let around = mesh.fan(ends[0]).iter().copied();
    let meeting = { around }.filter(|other| mesh.triangles()[*other as usize].contains(&ends[1]));
    { meeting }.all(has_foot_there)
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
