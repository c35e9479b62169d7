//! The top and the bottom face of a bent beam, and the middle between them.

use serde::{Deserialize, Serialize};

use super::{Packing, mean};

/// Vertical lines through each slab, evenly over the depth: wrinkles average out.
const LINES: usize = 9;

/// Heights of both faces along the beam, slab by slab of 1 d_p.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Faces {
    /// x of the middle of the first slab \[m\].
    from: f64,
    /// Of each slab \[m\].
    width: f64,
    /// The slabs, at least one.
    slabs: Vec<Slab>,
}

/// Heights in one slab, averaged over the depth \[m\].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Slab {
    /// Where vertical lines enter the membrane from below.
    pub bottom: f64,
    /// Where they leave it.
    pub top: f64,
}

/// A quantity of both halves of the beam, above and below its middle.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Halves<T> {
    /// Nearer to the top face: compressed when the beam is bent.
    pub top: T,
    /// Nearer to the bottom face: in tension.
    pub bottom: T,
}

impl Faces {
    /// The faces of `packing`; `None` without grains, whose diameter sets the width of the slabs.
    #[must_use]
    pub fn of(packing: &Packing<'_>) -> Option<Self> {
        let diameter = packing.mean_diameter()?;
        let [low, high] = packing.membrane().bounds();
        let length = high[0] - low[0];
        // A membrane much longer than its grains asks for no more slabs than there are triangles.
        let most = packing.snapshot().triangles.len();
        let count = ((length / diameter).ceil() as usize).clamp(1, most);
        let width = length / count as f64;
        let from = low[0] + 0.5 * width;
        let slabs = (0..count).map(|k| slab(packing, from + width * k as f64));
        Some(Self {
            from,
            width,
            slabs: slabs.collect::<Option<Vec<Slab>>>()?,
        })
    }

    /// Height of the middle between the faces at `x` \[m\], straight from slab to slab and beyond the last.
    #[must_use]
    pub fn middle(&self, x: f64) -> f64 {
        let middle = |k: usize| 0.5 * (self.slabs[k].bottom + self.slabs[k].top);
        let last = self.slabs.len() - 1;
        if last == 0 {
            return middle(0);
        }
        let place = (x - self.from) / self.width;
        let k = (place.max(0.0) as usize).min(last - 1);
        middle(k) + (place - k as f64) * (middle(k + 1) - middle(k))
    }

    /// h' \[m\]: how far `point` is above the middle at its x, vertically.
    #[must_use]
    pub fn height(&self, point: [f64; 3]) -> f64 {
        point[2] - self.middle(point[0])
    }

    /// Whether `point` is nearer to the top face than to the bottom face.
    #[must_use]
    pub fn is_top(&self, point: [f64; 3]) -> bool {
        self.height(point) > 0.0
    }

    /// The mean of what is known of the grains, in each half.
    #[must_use]
    pub fn halves(&self, packing: &Packing<'_>, values: &[Option<f64>]) -> Halves<Option<f64>> {
        let of = |top: bool| {
            let grains = packing.snapshot().positions.iter().zip(values);
            let inside = grains.filter(|(position, _)| self.is_top(**position) == top);
            mean(inside.filter_map(|(_, value)| *value))
        };
        Halves {
            top: of(true),
            bottom: of(false),
        }
    }
}

/// The slab around `x`; `None` if no line there meets the membrane.
fn slab(packing: &Packing<'_>, x: f64) -> Option<Slab> {
    let [low, high] = packing.membrane().bounds();
    let (mut bottoms, mut tops) = (vec![], vec![]);
    for line in 0..LINES {
        let share = (line as f64 + 0.5) / LINES as f64;
        let y = low[1] + share * (high[1] - low[1]);
        let (mut bottom, mut top) = (f64::INFINITY, f64::NEG_INFINITY);
        packing.membrane().visit_crossings(x, y, |crossing| {
            bottom = bottom.min(crossing.height);
            top = top.max(crossing.height);
        });
        if bottom <= top {
            bottoms.push(bottom);
            tops.push(top);
        }
    }
    Some(Slab {
        bottom: mean(bottoms)?,
        top: mean(tops)?,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::beam::structure::fixture::{Beam, bent, box_membrane};

    const SIZE: [f64; 3] = [40.0, 8.0, 4.0];

    fn beam() -> Beam {
        let positions = [[10.0, 4.0, 1.0], [20.0, 4.0, 3.0], [30.0, 4.0, 3.5]];
        Beam::of(box_membrane([0.0; 3], SIZE, [80, 8, 4]), positions, 0.5)
    }

    #[test]
    fn the_middle_of_a_straight_beam_is_half_its_height_everywhere() {
        let faces = Faces::of(&beam().packing()).expect("grains");
        for x in [-1.0, 0.0, 0.3, 17.0, 40.0, 44.0] {
            assert!((faces.middle(x) - 2.0).abs() < 1e-12);
        }
        assert!((faces.height([7.0, 1.0, 2.75]) - 0.75).abs() < 1e-12);
    }

    #[test]
    fn the_middle_of_a_bent_beam_follows_the_bend() {
        let (angle, radius) = (0.5, 80.0);
        let packing = beam().moved(|at| bent(at, SIZE[0], SIZE[2], angle));
        let faces = Faces::of(&packing.packing()).expect("grains");
        for k in -7..=7 {
            let x = 2.0 * f64::from(k);
            // Both faces are circles around (0, radius), 2 farther and nearer than the middle one.
            let face = |r: f64| radius - f64::sqrt(r * r - x * x);
            let expected = 0.5 * (face(radius - 2.0) + face(radius + 2.0));
            // Straight pieces of 1 are off by at most 1/8 radius, the membrane's edges by less.
            assert!((faces.middle(x) - expected).abs() < 0.002, "{x}");
        }
    }

    #[test]
    fn halves_are_told_apart_by_the_nearer_face() {
        let values = [Some(1.0), Some(2.0), Some(4.0)];
        let mut beam = beam();
        for _ in 0..2 {
            let packing = beam.packing();
            let faces = Faces::of(&packing).expect("grains");
            let found = faces.halves(&packing, &values);
            assert_eq!((found.top, found.bottom), (Some(3.0), Some(1.0)));
            let none = faces.halves(&packing, &[None; 3]);
            assert_eq!(none, Halves::default());
            beam = beam.moved(|at| bent(at, SIZE[0], SIZE[2], 0.9));
        }
    }

    #[test]
    fn without_grains_there_are_no_faces() {
        let empty = Beam::empty(box_membrane([0.0; 3], SIZE, [4, 2, 2]));
        assert_eq!(Faces::of(&empty.packing()), None);
    }
}
