//! A scene: grains, walls and contacts in K replicas, and the step that moves them.

use crate::contact::slices::Slices;
use crate::contact::{Components, TangentialLaw};
use crate::crew;
use crate::force::{AffineRate, BodyForce};
use crate::grains::{Grains, Size};
use crate::lanes::{F32x8, F32x16, F64x1, F64x8, Row, Scalar, VectorWidth};
use crate::material::Material;
use crate::neighbor::Key;
use crate::shape::{Body, GradedSphere, Shape};
use crate::wall::Walls;

mod blocks;
pub mod casing;
pub(crate) mod contacts;
mod interact;
mod lone;
mod motion;
mod motions;
pub(crate) mod step;
pub mod surroundings;
pub(crate) mod survey;

use casing::Casing;
pub use contacts::FARTHEST_SKIN;
use contacts::{Contacts, Live};
use surroundings::Surroundings;

/// What a scene models, as types: what is absent has size zero and costs nothing.
pub trait Physics: Copy + Send + Sync + 'static {
    /// The shape of every grain.
    type Shape: Shape;
    /// The force in the contact plane.
    type Tangential: TangentialLaw;
    /// What acts on every grain besides contacts.
    type Body: BodyForce;
    /// What grains lie in besides the walls of the box.
    type Surroundings: Surroundings;

    /// Whether grains have an orientation.
    const ORIENTED: bool = Self::Shape::SPHERES > 1;
    /// Whether each grain has a size of its own.
    const GRADED: bool = Self::Shape::GRADED;
    /// Whether anything can spin a grain: a pull along its surface, or a push off its center.
    const SPINS: bool =
        Self::Tangential::TANGENTIAL || Self::Shape::SPHERES > 1 || Self::Surroundings::SPINS;
}

/// A shape, a tangential law and a body force.
#[derive(Clone, Copy, Debug)]
pub struct With<S, T, B>(std::marker::PhantomData<(S, T, B)>);

impl<S: Shape, T: TangentialLaw, B: BodyForce> Physics for With<S, T, B> {
    type Shape = S;
    type Tangential = T;
    type Body = B;
    type Surroundings = ();
}

/// Spheres of different sizes in a membrane, under a tangential law and a body force.
#[derive(Clone, Copy, Debug)]
pub struct Encased<T, B>(std::marker::PhantomData<(T, B)>);

impl<T: TangentialLaw, B: BodyForce> Physics for Encased<T, B> {
    type Shape = GradedSphere;
    type Tangential = T;
    type Body = B;
    type Surroundings = Casing;
}

/// The laws of a scene and how it is integrated.
#[derive(Clone)]
pub struct Laws<P: Physics> {
    /// The rigid body of every grain.
    pub body: Body,
    /// Normal forces.
    pub material: Material,
    /// Forces in the contact plane.
    pub tangential: P::Tangential,
    /// What acts on every grain besides contacts.
    pub body_force: P::Body,
    /// \[t_c\].
    pub time_step: f64,
    /// How single precision rounds in the next step: [`crate::lanes::dither`], or 0 for the nearest number.
    pub dither: f64,
    /// How far beyond touching the list of candidates reaches at least \[R\].
    pub skin: f64,
    /// The vector instructions to use.
    pub width: VectorWidth,
}

/// How K replicas take a step: the lanes of a vector are replicas, or, for a lone run, contacts.
pub trait Replicas: Row {
    /// What a step needs besides the state.
    #[doc(hidden)]
    type Work: Work<Self>;

    /// Takes one step; returns how far anything can have moved \[R\].
    #[doc(hidden)]
    fn step<P: Physics>(scene: &mut Scene<Self, P>) -> f64;
}

/// What a step needs besides the state; nothing in it outlives the step.
#[doc(hidden)]
pub trait Work<R: Row>: Clone + Send + Sync {
    /// Room for the steps of `grains`.
    fn new<P: Physics>(grains: &Grains<R>) -> Self;

    /// Bytes it takes.
    fn bytes(&self) -> usize;
}

impl Replicas for F64x1 {
    type Work = lone::Records;

    fn step<P: Physics>(scene: &mut Scene<Self, P>) -> f64 {
        lone::step(scene)
    }
}

macro_rules! side_by_side {
    ($($row:ty),*) => {$(
        impl Replicas for $row {
            type Work = step::Loads<Self>;

            fn step<P: Physics>(scene: &mut Scene<Self, P>) -> f64 {
                step::step(scene)
            }
        }
    )*};
}

side_by_side!(F64x8, F32x8, F32x16);

/// Grains, walls and contacts in K replicas.
#[derive(Clone)]
pub struct Scene<R: Replicas, P: Physics> {
    /// The laws; the time step may be changed between steps.
    pub laws: Laws<P>,
    /// The grains.
    pub grains: Grains<R>,
    /// The walls.
    pub walls: Walls<R>,
    /// What grains lie in besides the walls.
    pub surroundings: P::Surroundings,
    pub(crate) contacts: Contacts<R, P::Tangential>,
    /// The affine motion of the box, for a drag.
    pub(crate) affine: AffineRate<R>,
    work: R::Work,
    /// Whether each replica still runs; the others are copies of one that does.
    running: Vec<bool>,
}

impl<R: Replicas, P: Physics> Scene<R, P> {
    /// A scene whose replicas all stand where `grains` and `walls` say.
    #[must_use]
    pub fn new(laws: Laws<P>, grains: Grains<R>, walls: Walls<R>) -> Self {
        Self::within(laws, grains, walls, P::Surroundings::default())
    }

    /// The same within `surroundings`.
    #[must_use]
    pub fn within(
        laws: Laws<P>,
        grains: Grains<R>,
        walls: Walls<R>,
        surroundings: P::Surroundings,
    ) -> Self {
        let contacts = Contacts::new(laws.skin);
        let mut scene = Self {
            laws,
            work: R::Work::new::<P>(&grains),
            grains,
            walls,
            surroundings,
            contacts,
            affine: AffineRate::default(),
            running: vec![true; R::K],
        };
        scene.renew_contacts();
        scene
    }

    /// Advances every replica by one step.
    ///
    /// 1. Forces at the present positions, with the velocities of the last half step; row by row, in order of grain numbers.
    /// 2. As soon as a grain's row is complete, nothing more acts on it: kick it by a whole step and let it drift.
    /// 3. If something may have come near that the list does not hold, renew the list.
    ///
    /// The caller has put the walls where they are at the present positions.
    pub fn step(&mut self) {
        self.contacts.share_out(crew::size());
        let swept = R::step(self);
        let reach = self.laws.body.reach();
        let live = Live {
            leader: leader(&self.running),
            running: &self.running,
        };
        let Self {
            grains,
            walls,
            surroundings,
            contacts,
            ..
        } = self;
        let renewed = contacts.follow(
            (swept, &|| surroundings.moved()),
            grains,
            walls,
            (reach, self.laws.time_step),
            live,
        );
        if renewed {
            surroundings.renew(grains, contacts.skin(), self.laws.width);
        }
    }

    /// Builds the list of candidates anew.
    pub fn renew_contacts(&mut self) {
        let live = Live {
            leader: leader(&self.running),
            running: &self.running,
        };
        let pace = (self.laws.body.reach(), self.laws.time_step);
        self.contacts.renew(&self.grains, &self.walls, pace, live);
        let (skin, width) = (self.contacts.skin(), self.laws.width);
        self.surroundings.renew(&self.grains, skin, width);
    }

    /// Gives every grain a new size; only where grains are graded.
    ///
    /// # Panics
    ///
    /// If there are not as many sizes as grains.
    pub fn resize(&mut self, sizes: impl ExactSizeIterator<Item = Size>) {
        assert_eq!(sizes.len(), self.grains.len(), "one size for each grain");
        let mut most = 0.0f64;
        for (size, new) in self.grains.sizes.iter_mut().zip(sizes) {
            most = most.max(new.radius - size.radius);
            *size = new;
        }
        self.contacts.swept += most;
    }

    /// Whether replica `k` still runs.
    #[must_use]
    pub fn is_running(&self, k: usize) -> bool {
        self.running[k]
    }

    /// Takes replica `k` out; from now on all that are out are copies of the first that runs.
    ///
    /// The bits of those that run do not change.
    pub fn stop_lane(&mut self, k: usize) {
        self.running[k] = false;
        let Some(from) = self.running.iter().position(|&running| running) else {
            return;
        };
        for to in (0..R::K).filter(|&to| !self.running[to]) {
            self.grains.copy_lane(from, to);
            self.walls.copy_lane(from, to);
            self.contacts.copy_lane(from, to);
        }
    }

    /// Sets the strain rates of replica `k`'s box, for a drag on what departs from them.
    pub fn set_affine_rate(&mut self, k: usize, [x, y, z]: [f64; 3]) {
        self.affine.rate.x.lanes_mut()[k] = R::Scalar::from_f64(x);
        self.affine.rate.y.lanes_mut()[k] = R::Scalar::from_f64(y);
        self.affine.rate.z.lanes_mut()[k] = R::Scalar::from_f64(z);
    }

    /// Every pair in the list: grain `i`, and the pair.
    pub(crate) fn pairs(&self) -> impl Iterator<Item = (usize, Key)> + '_ {
        self.contacts.pairs()
    }

    /// Every pair in the list with what it remembers: zeros if it does not touch.
    pub(crate) fn histories(
        &self,
    ) -> impl Iterator<Item = (usize, Key, &<P::Tangential as TangentialLaw>::History<R>)> {
        self.contacts
            .pairs()
            .zip(&self.contacts.histories)
            .map(|((i, key), history)| (i, key, history))
    }

    /// Every contact of replica `k` that remembers something: grain `i`, the pair, and its history.
    pub fn remembered(&self, k: usize) -> impl Iterator<Item = (u32, Key, Vec<f64>)> + '_ {
        self.contacts.remembered(k)
    }

    /// Gives replica `k` a remembered contact; `false` if the pair is too far apart to touch.
    pub fn remember(&mut self, k: usize, i: u32, key: Key, history: &[f64]) -> bool {
        self.contacts.remember(k, i, key, history)
    }

    /// Pairs that touched in the last step, in any replica.
    #[must_use]
    pub fn touching(&self) -> usize {
        self.contacts.live.iter().filter(|live| **live).count()
    }

    /// How often the list of candidates was built.
    #[must_use]
    pub fn renewals(&self) -> u64 {
        self.contacts.renewals
    }

    /// Candidate pairs in the list.
    #[must_use]
    pub fn candidates(&self) -> usize {
        self.contacts.candidates.len()
    }

    /// Bytes per grain of state and of what a step needs besides, without lists and springs.
    #[must_use]
    pub fn bytes_per_grain(&self) -> usize {
        self.grains.bytes_per_grain() + self.work.bytes() / self.grains.len().max(1)
    }

    /// Bytes that one candidate and its history take, without slices.
    #[must_use]
    pub fn bytes_per_candidate() -> usize {
        std::mem::size_of::<contacts::Candidate<R::Scalar>>()
            + std::mem::size_of::<<P::Tangential as TangentialLaw>::History<R>>()
            + std::mem::size_of::<<P::Tangential as TangentialLaw>::Slices<R>>()
    }

    /// Bytes of all slices that contacts have remembered so far, of a law that has slices.
    #[must_use]
    pub fn slice_bytes(&self) -> usize {
        self.contacts.slices.iter().map(Slices::bytes).sum()
    }
}

fn leader(running: &[bool]) -> usize {
    running.iter().position(|&running| running).unwrap_or(0)
}

/// The number of components that a law's history has.
#[must_use]
pub fn history_components<T: TangentialLaw>() -> usize {
    T::History::<u8>::from_fn(|_| 0).as_slice().len()
}

#[cfg(test)]
mod tests;
