//! A grain before several triangles of the sheet: what of it is one contact, and with what energy.
//!
//! Before a triangle, side or corner at distance d a grain of radius R has the overlap p = R − d, and alone with it the energy
//! u(p) = (2/5) k √R p^(5/2). With the sheet it has, by inclusion and exclusion,
//!
//! U = Σ u(p) of triangles − Σ u(p) of the sides between two of them + Σ u(p) of the corners among them.
//!
//! - On a flat sheet, or one that bulges toward the grain, all but the nearest point cancel: one contact, whatever triangles,
//!   sides and corners it lies on.
//! - In a shallow valley both faces are reached and so is the side between: u + u − u is all but one contact. The deeper the
//!   valley, the more it is two. There is no angle at which one becomes the other.
//! - The distance to a convex set has a continuous gradient in the grain's and the set's places, so forces, F = −∂U, are
//!   continuous, and what moves slowly in them neither gains energy nor loses any. (A rule that picks the deepest face and
//!   pushes along a mean normal has no U, and drives the vertices of a wrinkled sheet for ever.)
//!
//! What the grain reaches without a gap is one contact: faces that share a side or a corner within reach.
//!
//! A foot in the inside of a side or corner counts for the side itself and for all triangles that have their foot there.

use super::foot::Part;
use super::reach::Bounds;
use crate::math::plain;
use crate::membrane::Mesh;

/// A triangle that the grain at hand reaches.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    pub(super) triangle: u32,
    pub(super) corners: [u32; 3],
    /// What the foot is on.
    pub(super) part: Part,
    pub(super) weights: [f64; 3],
    /// From the membrane into the grain.
    pub(super) normal: [f64; 3],
    /// p.
    pub(super) overlap: f64,
    /// Which sides, but for their ends, and which corners the grain reaches.
    pub(super) bounds: Bounds,
    /// The first place of its contact.
    pub(super) contact: usize,
    /// Behind which sides there is another place, a bit to each.
    pub(super) joined: u8,
}

impl Place {
    /// The ends of side s, which joins corner s to the next.
    #[inline(always)]
    fn side(&self, s: usize) -> [u32; 2] {
        [self.corners[s], self.corners[(s + 1) % 3]]
    }

    /// The side from this corner to the next; neighbors run their common side in opposite directions.
    #[inline(always)]
    fn side_from(&self, corner: u32) -> usize {
        usize::from(self.corners[1] == corner) + 2 * usize::from(self.corners[2] == corner)
    }
}

/// A side between two places.
#[derive(Clone, Copy, Debug)]
struct Between {
    /// The later place and the earlier one.
    places: [usize; 2],
    /// Its number in each.
    sides: [usize; 2],
    ends: [u32; 2],
}

/// A part of the energy of the grain at hand.
#[derive(Clone, Copy, Debug)]
pub(super) struct Term {
    /// The place that it goes with.
    pub(super) place: usize,
    /// How often it counts; never zero.
    pub(super) count: f64,
    pub(super) overlap: f64,
    /// From its foot to the center.
    pub(super) normal: [f64; 3],
    pub(super) corners: [u32; 3],
    pub(super) weights: [f64; 3],
}

impl Term {
    /// The place of a contact that has no other term.
    #[inline(always)]
    pub(super) fn alone(&self, place: &Place) -> Place {
        Place {
            corners: self.corners,
            weights: self.weights,
            normal: self.normal,
            overlap: self.overlap,
            ..*place
        }
    }
}

/// The triangles that one grain reaches, and the terms of its energy.
#[derive(Clone, Debug, Default)]
pub(super) struct Patch {
    pub(super) places: Vec<Place>,
    pub(super) terms: Vec<Term>,
    between: Vec<Between>,
}

/// The grain at hand.
#[derive(Clone, Copy)]
pub(super) struct Sphere {
    pub(super) center: [f64; 3],
    pub(super) radius: f64,
}

impl Patch {
    /// Finds which places are one contact, and all terms.
    #[inline(always)]
    pub(super) fn find(&mut self, mesh: &Mesh, sphere: Sphere) {
        self.terms.clear();
        self.between.clear();
        let mut corners = false;
        for k in 0..self.places.len() {
            self.places[k].contact = k;
            corners |= self.places[k].bounds.any_corner();
            self.find_between(mesh, k);
        }
        for k in 0..self.places.len() {
            self.add_triangle(k);
        }
        for n in 0..self.between.len() {
            self.add_side(mesh, sphere, self.between[n]);
        }
        if corners {
            self.add_vertices(mesh, sphere);
        }
    }

    /// Finds the sides between place `k` and earlier ones.
    #[inline(always)]
    fn find_between(&mut self, mesh: &Mesh, k: usize) {
        let over = mesh.over_sides(self.places[k].triangle);
        for earlier in 0..k {
            let triangle = Some(self.places[earlier].triangle);
            for (s, &beyond) in over.iter().enumerate() {
                if beyond == triangle {
                    let ends @ [_, to] = self.places[k].side(s);
                    let other = self.places[earlier].side_from(to);
                    self.places[k].joined |= 1 << s;
                    self.places[earlier].joined |= 1 << other;
                    self.between.push(Between {
                        places: [k, earlier],
                        sides: [s, other],
                        ends,
                    });
                }
            }
        }
    }

    /// Adds a triangle whose foot is in its inside, or on a side behind which there is no other place.
    #[inline(always)]
    fn add_triangle(&mut self, k: usize) {
        let place = &self.places[k];
        let counts = match place.part {
            Part::Face => true,
            Part::Side(s) => place.joined >> s & 1 == 0,
            Part::Corner(_) => false,
        };
        if counts {
            self.terms.push(Term {
                place: k,
                count: 1.0,
                overlap: place.overlap,
                normal: place.normal,
                corners: place.corners,
                weights: place.weights,
            });
        }
    }

    /// How often what has its foot in the inside of a side counts: both triangles less the side.
    #[inline(always)]
    fn count(&self, side: &Between) -> i32 {
        let foot = |n: usize| self.places[side.places[n]].part == Part::Side(side.sides[n]);
        i32::from(foot(0)) + i32::from(foot(1)) - 1
    }

    /// Adds a side between two places if the grain reaches its inside.
    #[inline(always)]
    fn add_side(&mut self, mesh: &Mesh, sphere: Sphere, side: Between) {
        let [k, earlier] = side.places;
        if !self.places[k].bounds.side(side.sides[0]) {
            return;
        }
        self.join(k, earlier);
        let count = self.count(&side);
        if count == 0 {
            return;
        }
        let [from, to] = side.ends;
        let [a, b] = side.ends.map(|end| mesh.positions()[end as usize]);
        let (along, way) = (plain::sub(b, a), plain::sub(sphere.center, a));
        let share = plain::dot(along, way) / plain::dot(along, along);
        let way = plain::sub(way, plain::scale(along, share));
        let distance = plain::norm(way);
        self.terms.push(Term {
            place: k,
            count: f64::from(count),
            overlap: (sphere.radius - distance).max(0.0),
            normal: plain::scale(way, 1.0 / distance),
            corners: [from, to, from],
            weights: [1.0 - share, share, 0.0],
        });
    }

    /// Adds every corner that the grain reaches, seen from the first place that has it.
    #[inline(always)]
    fn add_vertices(&mut self, mesh: &Mesh, sphere: Sphere) {
        for k in 0..self.places.len() {
            for c in 0..3 {
                let vertex = self.places[k].corners[c];
                let known = |place: &Place| place.corners.contains(&vertex);
                if self.places[k].bounds.corner(c) && !self.places[..k].iter().any(known) {
                    self.add_vertex(mesh, sphere, (k, vertex));
                }
            }
        }
    }

    fn add_vertex(&mut self, mesh: &Mesh, sphere: Sphere, (first, vertex): (usize, u32)) {
        let way = |end: u32| plain::sub(sphere.center, mesh.positions()[end as usize]);
        // Once for itself, but if the places around it leave gaps, then so that all that meets there is once for each stretch.
        let mut count = 1;
        for k in first..self.places.len() {
            let place = &self.places[k];
            if let Some(c) = place.corners.iter().position(|corner| *corner == vertex) {
                count += i32::from(place.part == Part::Corner(c)) - 1;
                self.join(first, k);
            }
        }
        for side in &self.between {
            if side.ends.contains(&vertex) {
                let inside = self.places[side.places[0]].bounds.side(side.sides[0]);
                let [a, b] = side.ends.map(|end| plain::dot(way(end), way(end)));
                let nearer = side.ends[usize::from(b < a)];
                let foot_here = !inside && nearer == vertex;
                count += 1 + if foot_here { self.count(side) } else { 0 };
            }
        }
        if count == 0 {
            return;
        }
        let way = way(vertex);
        let distance = plain::norm(way);
        self.terms.push(Term {
            place: first,
            count: f64::from(count),
            overlap: (sphere.radius - distance).max(0.0),
            normal: plain::scale(way, 1.0 / distance),
            corners: [vertex; 3],
            weights: [1.0, 0.0, 0.0],
        });
    }

    /// Makes the contacts of two places one.
    #[inline(always)]
    fn join(&mut self, a: usize, b: usize) {
        let (a, b) = (self.places[a].contact, self.places[b].contact);
        if a != b {
            for place in &mut self.places {
                if place.contact == a.max(b) {
                    place.contact = a.min(b);
                }
            }
        }
    }
}
