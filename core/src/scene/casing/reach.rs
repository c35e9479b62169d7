//! Where grains reach triangles: every foot that is nearer than the radius, before it is known which of them are one contact.

use super::foot::Part;
use super::sheet::{Pair, Sheet};
use crate::lanes::{F64x8, Lane, Mask};

/// Sides and corners of a triangle, a bit to each: sides 0, 1, 2, then corners 0, 1, 2.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Bounds(u8);

impl Bounds {
    /// What is set in lane `e` of each side and each corner.
    #[inline(always)]
    fn of_lane(lanes: [u32; 6], e: usize) -> Self {
        let mut bits = 0;
        for (n, lanes) in lanes.into_iter().enumerate() {
            bits |= (lanes >> e & 1) << n;
        }
        Self(bits as u8)
    }

    #[inline(always)]
    pub(super) fn side(self, s: usize) -> bool {
        self.0 >> s & 1 == 1
    }

    #[inline(always)]
    pub(super) fn corner(self, c: usize) -> bool {
        self.0 >> (3 + c) & 1 == 1
    }

    #[inline(always)]
    pub(super) fn any_corner(self) -> bool {
        self.0 > 0b111
    }

    /// How many they are.
    #[inline(always)]
    fn count(self) -> usize {
        self.0.count_ones() as usize
    }
}

/// A place where a grain reaches a triangle.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reach {
    /// The foot's three barycentric coordinates and the code of its part;
    /// then the unit vector from it to the center, or into the beam from a face, and the center's distance along it.
    numbers: F64x8,
    pub(super) pair: Pair,
    /// How far the center is inside of the triangle's plane.
    pub(super) height: f64,
    /// Which sides, but for their ends, and which corners the grain reaches.
    pub(super) bounds: Bounds,
}

impl Reach {
    pub(super) fn part(&self) -> Part {
        Part::of(self.numbers.0[3])
    }

    /// The one triangle that counts among `reaches`, all from inside: the others have their feet on its sides, and the grain
    /// reaches no other side and no corner.
    #[inline(always)]
    pub(super) fn only(reaches: &[Self]) -> Option<&Self> {
        let mut face = None;
        for reach in reaches {
            match reach.part() {
                Part::Face if face.is_none() => face = Some(reach),
                // One side and no corner: that of the foot.
                Part::Side(_) if reach.bounds.count() == 1 && !reach.bounds.any_corner() => {}
                _ => return None,
            }
        }
        let beside =
            |face: &&Self| !face.bounds.any_corner() && face.bounds.count() + 1 == reaches.len();
        face.filter(beside)
    }

    pub(super) fn weights(&self) -> [f64; 3] {
        let &[u, v, w, _] = self.numbers.halves()[0];
        [u, v, w]
    }

    pub(super) fn normal(&self) -> [f64; 3] {
        let &[x, y, z, _] = self.numbers.halves()[1];
        [x, y, z]
    }

    /// Below zero only before a face.
    pub(super) fn depth(&self) -> f64 {
        self.numbers.0[7]
    }
}

/// Finds the places where grains of `pairs` reach their triangles, in the order of the pairs.
#[inline(always)]
pub(super) fn find<W: Lane<Row = F64x8, Scalar = f64>>(
    sheet: Sheet<'_>,
    pairs: &[Pair],
    found: &mut Vec<Reach>,
) {
    found.clear();
    let (zero, one) = (W::constant(0.0), W::constant(1.0));
    for eight in pairs.chunks(W::K) {
        let feet = sheet.feet::<W>(eight);
        let near = feet.square.lt(feet.radius * feet.radius).bits();
        if near == 0 {
            continue;
        }
        // Codes of faces are zero.
        let on_face = feet.foot.part.le(zero);
        let distance = feet.square.sqrt();
        let inverse = one / distance;
        let inward = feet.outward.scale(W::constant(-1.0));
        let normal = inward.select(on_face, feet.from.scale(inverse));
        let depth = feet.height.select(on_face, distance);
        let [u, v, w] = feet.foot.weights;
        let numbers = W::transposed([u, v, w, feet.foot.part, normal.x, normal.y, normal.z, depth]);
        let mut heights = F64x8::default();
        feet.height.store(&mut heights);
        let bounds = feet.reached();
        for (e, &pair) in eight.iter().enumerate() {
            if near >> e & 1 == 1 {
                let mut reach = Reach {
                    numbers: F64x8::default(),
                    pair,
                    height: heights.0[e],
                    bounds: Bounds::of_lane(bounds, e),
                };
                numbers[e].store(&mut reach.numbers);
                found.push(reach);
            }
        }
    }
}
