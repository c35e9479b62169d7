//! Vectors and quaternions: over lanes for kernels, over plain `f64` for what happens rarely.

use std::ops::{Add, Sub};

use crate::lanes::{Lane, Mask, Row, Scalar, grown};

/// Three components; in memory over rows, in registers over lanes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Vec3<T> {
    /// Along x.
    pub x: T,
    /// Along y.
    pub y: T,
    /// Along z.
    pub z: T,
}

impl<T: Add<Output = T>> Add for Vec3<T> {
    type Output = Self;

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self {
            x: self.x + other.x,
            y: self.y + other.y,
            z: self.z + other.z,
        }
    }
}

impl<T: Sub<Output = T>> Sub for Vec3<T> {
    type Output = Self;

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self {
            x: self.x - other.x,
            y: self.y - other.y,
            z: self.z - other.z,
        }
    }
}

impl<R: Row> Vec3<R> {
    /// Reads all lanes.
    #[inline(always)]
    pub fn load<L: Lane<Row = R>>(&self) -> Vec3<L> {
        Vec3 {
            x: L::load(&self.x),
            y: L::load(&self.y),
            z: L::load(&self.z),
        }
    }

    /// The vector of one replica.
    #[must_use]
    pub fn lane(&self, k: usize) -> [f64; 3] {
        use crate::lanes::Scalar;
        [
            self.x.lanes()[k].to_f64(),
            self.y.lanes()[k].to_f64(),
            self.z.lanes()[k].to_f64(),
        ]
    }

    /// Sets the vector of one replica.
    pub fn set_lane(&mut self, k: usize, [x, y, z]: [f64; 3]) {
        use crate::lanes::Scalar;
        self.x.lanes_mut()[k] = R::Scalar::from_f64(x);
        self.y.lanes_mut()[k] = R::Scalar::from_f64(y);
        self.z.lanes_mut()[k] = R::Scalar::from_f64(z);
    }
}

impl<L: Lane> Vec3<L> {
    /// The first three numbers of one record for each lane.
    #[inline(always)]
    #[must_use]
    pub fn gathered<'a>(record: impl Fn(usize) -> &'a [L::Scalar; 4]) -> Self
    where
        L::Scalar: 'a,
    {
        let [x, y, z, _] = L::gather(record);
        Self { x, y, z }
    }

    /// Zero in every replica.
    #[inline(always)]
    #[must_use]
    pub fn zero() -> Self {
        Self::splat([0.0; 3])
    }

    /// The same vector, a constant of the physics, in every replica.
    #[inline(always)]
    #[must_use]
    pub fn splat([x, y, z]: [f64; 3]) -> Self {
        Self {
            x: L::constant(x),
            y: L::constant(y),
            z: L::constant(z),
        }
    }

    /// The same vector in every replica.
    #[inline(always)]
    #[must_use]
    pub fn broadcast([x, y, z]: [L::Scalar; 3]) -> Self {
        Self {
            x: L::splat(x),
            y: L::splat(y),
            z: L::splat(z),
        }
    }

    /// Writes all lanes.
    #[inline(always)]
    pub fn store(self, rows: &mut Vec3<L::Row>) {
        self.x.store(&mut rows.x);
        self.y.store(&mut rows.y);
        self.z.store(&mut rows.z);
    }

    /// `self · other`.
    #[inline(always)]
    #[must_use]
    pub fn dot(self, other: Self) -> L {
        self.x
            .mul_add(other.x, self.y.mul_add(other.y, self.z * other.z))
    }

    /// `self × other`.
    #[inline(always)]
    #[must_use]
    pub fn cross(self, other: Self) -> Self {
        Self {
            x: self.z.neg_mul_add(other.y, self.y * other.z),
            y: self.x.neg_mul_add(other.z, self.z * other.x),
            z: self.y.neg_mul_add(other.x, self.x * other.y),
        }
    }

    /// `self × other + addend`.
    #[inline(always)]
    #[must_use]
    pub fn cross_add(self, other: Self, addend: Self) -> Self {
        Self {
            x: self
                .z
                .neg_mul_add(other.y, self.y.mul_add(other.z, addend.x)),
            y: self
                .x
                .neg_mul_add(other.z, self.z.mul_add(other.x, addend.y)),
            z: self
                .y
                .neg_mul_add(other.x, self.x.mul_add(other.y, addend.z)),
        }
    }

    /// `self * factor`.
    #[inline(always)]
    #[must_use]
    pub fn scale(self, factor: L) -> Self {
        Self {
            x: self.x * factor,
            y: self.y * factor,
            z: self.z * factor,
        }
    }

    /// `self * factor + addend`.
    #[inline(always)]
    #[must_use]
    pub fn scale_add(self, factor: L, addend: Self) -> Self {
        Self {
            x: self.x.mul_add(factor, addend.x),
            y: self.y.mul_add(factor, addend.y),
            z: self.z.mul_add(factor, addend.z),
        }
    }

    /// `addend - self * factor`.
    #[inline(always)]
    #[must_use]
    pub fn scale_sub(self, factor: L, addend: Self) -> Self {
        Self {
            x: self.x.neg_mul_add(factor, addend.x),
            y: self.y.neg_mul_add(factor, addend.y),
            z: self.z.neg_mul_add(factor, addend.z),
        }
    }

    /// `self` where `mask`, else +0.
    #[inline(always)]
    #[must_use]
    pub fn keep(self, mask: L::Mask) -> Self {
        Self {
            x: self.x.keep(mask),
            y: self.y.keep(mask),
            z: self.z.keep(mask),
        }
    }

    /// `self + part` for a small part, as [`grown`] says.
    #[inline(always)]
    #[must_use]
    pub fn grown(self, part: Self, dither: L) -> Self {
        Self {
            x: grown(self.x, part.x, dither),
            y: grown(self.y, part.y, dither),
            z: grown(self.z, part.z, dither),
        }
    }

    /// `self` where `mask`, else `other`.
    #[inline(always)]
    #[must_use]
    pub fn select(self, mask: L::Mask, other: Self) -> Self {
        Self {
            x: self.x.select(mask, other.x),
            y: self.y.select(mask, other.y),
            z: self.z.select(mask, other.z),
        }
    }
}

/// A rotation: scalar part `w`, vector part `v`, of unit length.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Quaternion<T> {
    /// cos(θ/2).
    pub w: T,
    /// sin(θ/2) times the axis.
    pub v: Vec3<T>,
}

impl<R: Row> Quaternion<R> {
    /// Reads all lanes.
    #[inline(always)]
    pub fn load<L: Lane<Row = R>>(&self) -> Quaternion<L> {
        Quaternion {
            w: L::load(&self.w),
            v: self.v.load(),
        }
    }

    /// No rotation, in every replica.
    #[must_use]
    pub fn identity() -> Self {
        use crate::lanes::Scalar;
        let mut one = R::default();
        one.lanes_mut().fill(R::Scalar::from_f64(1.0));
        Self {
            w: one,
            v: Vec3::default(),
        }
    }

    /// The rotation of one replica as `[w, x, y, z]`.
    #[must_use]
    pub fn lane(&self, k: usize) -> [f64; 4] {
        use crate::lanes::Scalar;
        let [x, y, z] = self.v.lane(k);
        [self.w.lanes()[k].to_f64(), x, y, z]
    }

    /// Sets the rotation of one replica.
    pub fn set_lane(&mut self, k: usize, [w, x, y, z]: [f64; 4]) {
        use crate::lanes::Scalar;
        self.w.lanes_mut()[k] = R::Scalar::from_f64(w);
        self.v.set_lane(k, [x, y, z]);
    }
}

impl<L: Lane> Quaternion<L> {
    /// Writes all lanes.
    #[inline(always)]
    pub fn store(self, rows: &mut Quaternion<L::Row>) {
        self.w.store(&mut rows.w);
        self.v.store(&mut rows.v);
    }

    /// How far the rotation moves the point `arm`: R(q) arm − arm = w (2v × arm) + v × (2v × arm).
    ///
    /// Written as a difference, so that small rotations keep their relative accuracy in single precision.
    #[inline(always)]
    #[must_use]
    pub fn shift(self, arm: Vec3<L>) -> Vec3<L> {
        let twice = (self.v + self.v).cross(arm);
        self.v.cross_add(twice, twice.scale(self.w))
    }

    /// The rotation after one more turn by the angle |`turn`| about `turn`.
    ///
    /// tan(x) of the half angle x is expanded to x⁵, and 1/√(1 + over) to over³ for what the length is too long by: exact to
    /// 1e-3 at one radian a step, to rounding below 0.01.
    #[inline(always)]
    #[must_use]
    pub fn turned(self, turn: Vec3<L>, dither: L) -> Self {
        let half = turn.scale(L::constant(0.5));
        let square = half.dot(half);
        let series = square.mul_add(L::constant(2.0 / 15.0), L::constant(1.0 / 3.0));
        let tangent = half.scale(series.mul_add(square, L::constant(1.0)));
        let w = self.w - tangent.dot(self.v);
        let v = if L::Scalar::COARSE {
            let change = tangent.cross_add(self.v, tangent.scale(self.w));
            self.v.grown(change, dither)
        } else {
            tangent.cross_add(self.v, tangent.scale_add(self.w, self.v))
        };
        let square = v.dot(v);
        let over = square + w.mul_add(w, L::constant(-1.0));
        let series = over.mul_add(L::constant(-0.3125), L::constant(0.375));
        let series = series.mul_add(over, L::constant(-0.5));
        let inverse_length = series.mul_add(over, L::constant(1.0));
        let unit = Self {
            w: w * inverse_length,
            v: v.scale(inverse_length),
        };
        if !L::Scalar::COARSE {
            return unit;
        }
        // Near 1, w has no digits for small turns, and a length corrected by them would shrink v at every step.
        let rest = L::constant(1.0) - square;
        let small = L::constant(0.5).lt(rest).and(L::constant(0.0).lt(w));
        Self {
            w: rest.max(L::constant(0.0)).sqrt().select(small, unit.w),
            v: v.select(small, unit.v),
        }
    }
}

/// Plain vector and quaternion arithmetic for preparation, lists and observables.
pub mod plain {
    /// `a + b`.
    #[must_use]
    pub fn add(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
        [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
    }

    /// `a − b`.
    #[must_use]
    pub fn sub(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
        [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
    }

    /// `a s`.
    #[must_use]
    pub fn scale(a: [f64; 3], s: f64) -> [f64; 3] {
        [a[0] * s, a[1] * s, a[2] * s]
    }

    /// `a · b`.
    #[must_use]
    pub fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
        a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
    }

    /// `a × b`.
    #[must_use]
    pub fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
        [
            a[1] * b[2] - a[2] * b[1],
            a[2] * b[0] - a[0] * b[2],
            a[0] * b[1] - a[1] * b[0],
        ]
    }

    /// |a|.
    #[must_use]
    pub fn norm(a: [f64; 3]) -> f64 {
        dot(a, a).sqrt()
    }

    /// The rotation `[w, x, y, z]` applied to `a`.
    #[must_use]
    pub fn rotate(q: [f64; 4], a: [f64; 3]) -> [f64; 3] {
        let v = [q[1], q[2], q[3]];
        let twice = scale(cross(v, a), 2.0);
        add(a, add(scale(twice, q[0]), cross(v, twice)))
    }

    /// The rotation `b` followed by `a`.
    #[must_use]
    pub fn compose(a: [f64; 4], b: [f64; 4]) -> [f64; 4] {
        let (va, vb) = ([a[1], a[2], a[3]], [b[1], b[2], b[3]]);
        let v = add(add(scale(vb, a[0]), scale(va, b[0])), cross(va, vb));
        let q = [a[0] * b[0] - dot(va, vb), v[0], v[1], v[2]];
        let length = (q[0] * q[0] + dot(v, v)).sqrt();
        q.map(|part| part / length)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lanes::F64x1;

    fn vector([x, y, z]: [f64; 3]) -> Vec3<F64x1> {
        Vec3 {
            x: F64x1([x]),
            y: F64x1([y]),
            z: F64x1([z]),
        }
    }

    #[test]
    fn a_thousand_small_turns_make_one_large_one() {
        // Axis (1, 2, 2)/3, angle 1.2 in 1000 steps: the series is exact to rounding, errors add up to 1000 × 1e-16.
        let axis = [1.0 / 3.0, 2.0 / 3.0, 2.0 / 3.0];
        let mut q = Quaternion {
            w: F64x1([1.0]),
            v: vector([0.0; 3]),
        };
        for _ in 0..1000 {
            q = q.turned(vector(plain::scale(axis, 1.2e-3)), F64x1([0.0]));
        }
        let expected = [
            0.6f64.cos(),
            0.6f64.sin() / 3.0,
            0.6f64.sin() * 2.0 / 3.0,
            0.6f64.sin() * 2.0 / 3.0,
        ];
        for (found, expected) in q.lane(0).iter().zip(expected) {
            assert!((found - expected).abs() < 1e-12, "{found} {expected}");
        }
        let arm = [0.3, -0.1, 0.7];
        let shifted = plain::add(arm, q.shift(vector(arm)).lane(0));
        let rotated = plain::rotate(expected, arm);
        assert!(plain::norm(plain::sub(shifted, rotated)) < 1e-12);
    }
}
