//! Contact laws: the force two touching spheres exert on each other.
//!
//! A law is a pair: Hertz along the contact normal ([`hertz`]) and a [`TangentialLaw`] in the contact plane.
//! Both see one contact at a time and know nothing of grains, neighbors or walls.
//! Throughout, `p` is the overlap, positive when touching, and `n̂` the unit normal from `j` into `i`.

use crate::lanes::{Lane, Row};
use crate::math::Vec3;

mod elongation;
pub mod frictionless;
pub mod hertz;
pub mod hooke;
pub mod mindlin;
pub mod mindlin_rescale;
pub mod mindlin_sliced;
pub mod path;
pub mod slices;

use slices::Slices;

/// One contact, in every lane; lanes that do not touch hold numbers without meaning that the caller drops.
#[derive(Clone, Copy, Debug)]
pub struct Contact<L> {
    /// n̂, from `j` into `i`.
    pub normal: Vec3<L>,
    /// Velocity of `i` against `j` at the contact point, without its part along n̂ \[R/t_c\].
    pub sliding_velocity: Vec3<L>,
    /// √p \[R^½\]; where grains differ in size √(R_eff p), the radius of the contact, 1/R_eff = 1/R_i + 1/R_j.
    pub root_overlap: L,
    /// 1/m = 1/m_i + 1/m_j.
    pub reduced_mass: L,
    /// f_n ≥ 0 \[E R²\].
    pub normal_force: L,
    /// The time step \[t_c\].
    pub time_step: L,
    /// How single precision rounds what grows by small parts, see [`crate::lanes::grown`].
    pub dither: L,
}

/// What one contact remembers: a fixed number of components.
pub trait Components<T: Copy>: Copy {
    /// One component after the other.
    fn from_fn(component: impl FnMut(usize) -> T) -> Self;

    /// All components.
    fn as_slice(&self) -> &[T];

    /// All components, to be changed.
    fn as_mut_slice(&mut self) -> &mut [T];
}

impl<T: Copy, const N: usize> Components<T> for [T; N] {
    #[inline(always)]
    fn from_fn(component: impl FnMut(usize) -> T) -> Self {
        std::array::from_fn(component)
    }

    #[inline(always)]
    fn as_slice(&self) -> &[T] {
        self
    }

    #[inline(always)]
    fn as_mut_slice(&mut self) -> &mut [T] {
        self
    }
}

/// Force in the contact plane, with whatever memory it needs.
pub trait TangentialLaw: Copy + Send + Sync + 'static {
    /// What one contact remembers from step to step, in memory (rows) or in registers (lanes); `[T; 0]` if nothing.
    type History<T: Copy + Send + Sync>: Components<T> + Send + Sync;

    /// What one contact remembers besides, of which a step seldom needs anything; `()` if nothing.
    type Slices<R: Row>: Slices<R::Scalar> + Clone + Default + Send + Sync;

    /// The law's constants in registers.
    type Constants<L: Lane>: Copy;

    /// Whether the law pulls along the surface. Rotation is skipped only if this is false *and* the shape is a sphere.
    const TANGENTIAL: bool;

    /// Loads the constants.
    fn constants<L: Lane>(&self) -> Self::Constants<L>;

    /// Tangential force on grain `i` \[E R²\], in every lane; advances what the contact remembers by one step.
    fn force<L: Lane>(
        constants: &Self::Constants<L>,
        contact: &Contact<L>,
        history: &mut Self::History<L>,
        slices: &mut impl Slices<L::Scalar>,
    ) -> Vec3<L>;

    /// How many slices a contact of this history remembers.
    #[must_use]
    fn slices(_history: &[f64]) -> usize {
        0
    }
}
