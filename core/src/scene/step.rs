//! One step of an ensemble: every lane is a replica.
//!
//! A row is done in two sweeps, so that long chains of roots and divisions of different contacts overlap:
//! first every candidate is tested and those that any replica touches are noted, then the forces of the noted ones are found.

use crate::contact::{Components, TangentialLaw};
use crate::grains::Grains;
use crate::lanes::{Kernel, Lane, Mask, Row, prefetch};
use crate::math::Vec3;
use crate::shape::Shape;
use crate::wall::{MAX_LANES, WALLS};

use super::contacts::Contacts;
use super::interact::{Branch, Constants, Partner, branch, geometry, interact};
use super::motion::{
    Fastest, Load, MotionConstants, Moving, RowGrain, advance, push_of_wall, size,
};
use super::{Physics, Replicas, Scene, Work};

/// Touching pairs that are noted before their forces are found.
const NOTED: usize = 16;

/// How many candidates ahead the other grain is asked for: about two rows of spheres, one of tetrahedra.
const AHEAD: usize = 8;

/// The sums of the running step; zero between steps.
#[derive(Clone, Debug)]
pub struct Loads<R: Row> {
    force: Vec<Vec3<R>>,
    /// Empty where nothing can spin a grain.
    torque: Vec<Vec3<R>>,
}

impl<R: Row> Work<R> for Loads<R> {
    fn new<P: Physics>(grains: &Grains<R>) -> Self {
        let spinning = if P::SPINS { grains.len() } else { 0 };
        Self {
            force: vec![Vec3::default(); grains.len()],
            torque: vec![Vec3::default(); spinning],
        }
    }

    fn bytes(&self) -> usize {
        std::mem::size_of::<Vec3<R>>() * (self.force.len() + self.torque.len())
    }
}

impl<R: Row> Loads<R> {
    /// What has been summed on grain `i` so far; the sums start at zero again.
    #[inline(always)]
    fn take<L: Lane<Row = R>, P: Physics>(&mut self, i: usize) -> Load<L> {
        let force = self.force[i].load();
        Vec3::<L>::zero().store(&mut self.force[i]);
        let mut torque = Vec3::zero();
        if P::SPINS {
            torque = self.torque[i].load();
            Vec3::<L>::zero().store(&mut self.torque[i]);
        }
        Load { force, torque }
    }

    #[inline(always)]
    fn prefetch<P: Physics>(&self, i: usize) {
        prefetch(&self.force[i]);
        if P::SPINS {
            prefetch(&self.torque[i]);
        }
    }
}

/// The whole step; returns how far anything can have moved.
pub(super) struct Step<'a, R: Replicas, P: Physics> {
    pub(super) scene: &'a mut Scene<R, P>,
}

/// A pair that touches in some replica.
#[derive(Clone, Copy)]
struct Touch<L: Lane> {
    candidate: usize,
    touching: L::Mask,
    branch: Branch<L>,
    arm_j: Vec3<L>,
}

impl<R: Replicas<Work = Loads<R>>, P: Physics> Kernel<R> for Step<'_, R, P> {
    type Output = f64;

    #[inline(always)]
    fn run<L: Lane<Row = R, Scalar = R::Scalar>>(self) -> f64 {
        const {
            assert!(
                size_of::<P::Surroundings>() == 0,
                "only lone runs have surroundings"
            );
        }
        let Scene {
            laws,
            grains,
            walls,
            contacts,
            affine,
            work: loads,
            ..
        } = self.scene;
        let constants = Constants::<L, P::Tangential>::new(laws);
        let motion = MotionConstants::<L>::new(laws);
        walls.force = [[0.0; MAX_LANES]; WALLS];
        let mut fastest = Fastest::none();
        let nothing = Touch {
            candidate: 0,
            touching: L::constant(0.0).lt(L::constant(0.0)),
            branch: Branch {
                vector: Vec3::zero(),
                excess: L::constant(0.0),
            },
            arm_j: Vec3::zero(),
        };
        let mut touches = [nothing; NOTED];
        for i in 0..grains.len() {
            let at = RowGrain::<L>::load::<P>(grains, i);
            let mut load = loads.take::<L, P>(i);
            let (mut next, end) = (contacts.starts[i] as usize, contacts.starts[i + 1] as usize);
            while next < end {
                let noted = note::<L, P>(
                    &at,
                    (&mut next, end),
                    (grains, loads),
                    contacts,
                    &mut touches,
                );
                for touch in &touches[..noted] {
                    act::<L, P>(&constants, &at, touch, (grains, loads), contacts, &mut load);
                }
            }
            for c in contacts.wall_starts[i] as usize..contacts.wall_starts[i + 1] as usize {
                push_of_wall::<L, P>(&motion, &at, &contacts.wall_candidates[c], walls, &mut load);
            }
            let moved = advance::<L, P>(
                &motion.sized::<P>(|of| L::constant(of(&grains.sizes[i]))),
                (&laws.body_force, affine),
                grains.reference()[i].position.map(L::constant),
                &load,
                Moving::load::<P>(grains, i),
                &mut fastest,
            );
            moved.store::<P>(grains, i);
        }
        fastest.swept(laws, walls)
    }
}

/// Tests candidates from `next` on until `touches` is full or the row ends; returns how many touch.
#[inline(always)]
fn note<L: Lane, P: Physics>(
    at: &RowGrain<L>,
    (next, end): (&mut usize, usize),
    (grains, loads): (&Grains<L::Row>, &Loads<L::Row>),
    contacts: &mut Contacts<L::Row, P::Tangential>,
    touches: &mut [Touch<L>; NOTED],
) -> usize {
    let mut noted = 0;
    while *next < end && noted < NOTED {
        let c = *next;
        *next += 1;
        if let Some(ahead) = contacts.candidates.get(c + AHEAD) {
            grains.prefetch(ahead.j as usize, P::SPINS, P::ORIENTED);
            loads.prefetch::<P>(ahead.j as usize);
        }
        let candidate = &contacts.candidates[c];
        let (j, a, b) = (
            candidate.j as usize,
            usize::from(candidate.a),
            usize::from(candidate.b),
        );
        let (mut shifted_j, mut arm_j) = (grains.displacement[j].load(), Vec3::zero());
        if P::ORIENTED {
            let arm = Vec3::broadcast(grains.lane_arms[P::Shape::SPHERES * j + b]);
            let shift = grains.turn[j].load::<L>().shift(arm);
            shifted_j = shifted_j + shift;
            arm_j = arm + shift;
        }
        let change = at.shifted[a] - shifted_j;
        let (radius_j, _) = size::<L, P>(grains, j);
        let branch = branch::<L, P>(
            candidate.reference.map(L::splat),
            change,
            at.radius + radius_j,
        );
        let touching = branch.excess.lt(L::constant(0.0));
        touches[noted] = Touch {
            candidate: c,
            touching,
            branch,
            arm_j,
        };
        let any = touching.any();
        if contacts.live[c] && !any {
            contacts.histories[c] = Components::from_fn(|_| L::Row::default());
        }
        contacts.live[c] = any;
        noted += usize::from(any);
    }
    noted
}

/// Adds the force of one touching pair.
#[inline(always)]
fn act<L: Lane, P: Physics>(
    constants: &Constants<L, P::Tangential>,
    at: &RowGrain<L>,
    touch: &Touch<L>,
    (grains, loads): (&Grains<L::Row>, &mut Loads<L::Row>),
    contacts: &mut Contacts<L::Row, P::Tangential>,
    load: &mut Load<L>,
) {
    let candidate = &contacts.candidates[touch.candidate];
    let (j, a) = (candidate.j as usize, usize::from(candidate.a));
    let rows = contacts.histories[touch.candidate].as_mut_slice();
    let mut history =
        <P::Tangential as TangentialLaw>::History::<L>::from_fn(|n| L::load(&rows[n]));
    let (radius_j, inverse_mass_j) = size::<L, P>(grains, j);
    let geometry = geometry::<L, P>(touch.branch, [at.radius, radius_j]);
    let partner_i = Partner {
        arm: at.arms[a],
        velocity: at.velocity,
        spin: at.spin,
        radius: at.radius,
        inverse_mass: at.inverse_mass,
    };
    let partner_j = Partner {
        arm: touch.arm_j,
        velocity: grains.velocity[j].load(),
        spin: if P::SPINS {
            grains.spin[j].load()
        } else {
            Vec3::zero()
        },
        radius: radius_j,
        inverse_mass: inverse_mass_j,
    };
    let action = interact::<L, P>(constants, &geometry, &partner_i, &partner_j, &mut history);
    for (row, lanes) in rows.iter_mut().zip(history.as_slice()) {
        lanes.keep(touch.touching).store(row);
    }
    // Lanes that do not touch may hold what is not a number, and add nothing.
    let force = action.force.keep(touch.touching);
    load.force = load.force + force;
    let on_j: Vec3<L> = loads.force[j].load();
    (on_j - force).store(&mut loads.force[j]);
    if P::SPINS {
        load.torque = load.torque + action.torque_i().keep(touch.touching);
        let on_j: Vec3<L> = loads.torque[j].load();
        (on_j + action.torque_j().keep(touch.touching)).store(&mut loads.torque[j]);
    }
}
