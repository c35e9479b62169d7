//! The beam as a scene: grains in their membrane, with the laws and materials of the specs.

use super::spec::{GrowSpec, JamSpec};
use super::state::Snapshot;
use crate::contact::TangentialLaw;
use crate::contact::frictionless::Frictionless;
use crate::contact::mindlin::{Mindlin, TangentialStiffness};
use crate::force::AffineDrag;
use crate::grains::{Grains, Pose, Size, UPRIGHT};
use crate::lanes::{F64x1, VectorWidth};
use crate::material::{Elastic, Material, Pair};
use crate::membrane::{Bending, Cuboid, Membrane, POISSON_RATIO, Sheet};
use crate::outcome::StageFailure;
use crate::scene::casing::{Casing, Grip, Press};
use crate::scene::{Encased, Laws, Scene};
use crate::shape::Body;
use crate::wall::Walls;
use crate::wall::press::VertexBall;

/// Grains in a membrane. A drag of rate zero changes no bit and costs less than a hundredth.
pub(super) type Beam<T> = Scene<F64x1, Encased<T, AffineDrag>>;

/// How far beyond touching the lists of neighbors reach \[smallest radius\]; no result depends on it.
const SKIN: f64 = 0.1;

/// A tangential law between grains, made from numbers.
pub(super) trait Friction: TangentialLaw {
    /// The law of `pair` with the stiffness and dashpot of `jam`, and μ.
    fn between(pair: Pair, jam: Option<&JamSpec>, friction_coefficient: f64) -> Self;

    /// κ: stiffness over the contact's radius \[Pa\].
    fn slope(&self) -> f64;
}

impl Friction for Frictionless {
    fn between(_: Pair, _: Option<&JamSpec>, _: f64) -> Self {
        Self
    }

    fn slope(&self) -> f64 {
        0.0
    }
}

impl Friction for Mindlin {
    fn between(pair: Pair, jam: Option<&JamSpec>, friction_coefficient: f64) -> Self {
        let (model, damping) = jam.map_or((TangentialStiffness::Paper, 0.0), |jam| {
            (jam.kt_model, jam.tangential_damping)
        });
        Self::new(pair, model, damping, friction_coefficient)
    }

    fn slope(&self) -> f64 {
        self.stiffness()
    }
}

/// What a beam is made of, and how it is told to behave.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rig<'a> {
    pub(super) grow: &'a GrowSpec,
    /// None while grains grow: then the membrane stands still and is smooth.
    pub(super) jam: Option<&'a JamSpec>,
    /// μ between grains.
    pub(super) friction_coefficient: f64,
    /// α \[1/s\].
    pub(super) damping: f64,
    pub(super) width: VectorWidth,
}

impl Rig<'_> {
    fn grain(&self) -> Elastic {
        Elastic {
            youngs_modulus: self.grow.youngs_modulus,
            poisson_ratio: self.grow.poisson_ratio,
        }
    }

    fn sheet(&self) -> Elastic {
        Elastic {
            youngs_modulus: self.grow.membrane_youngs_modulus,
            poisson_ratio: POISSON_RATIO,
        }
    }

    fn laws<T: Friction>(&self) -> Laws<Encased<T, AffineDrag>> {
        let pair = self.grain().against(self.grain());
        Laws {
            body: Body::sphere(),
            material: Material::viscoelastic(pair, self.grow.relaxation_time),
            tangential: T::between(pair, self.jam, self.friction_coefficient),
            body_force: AffineDrag { rate: self.damping },
            time_step: 0.0,
            dither: 0.0,
            skin: SKIN * self.grow.radius_min,
            width: self.width,
        }
    }

    /// The membrane as it is made, in the mold.
    pub(super) fn membrane(&self) -> Result<Membrane, StageFailure> {
        let input = |detail: String| StageFailure::Input { detail };
        let grow = self.grow;
        let mesh = Cuboid {
            length: grow.length,
            height: grow.height,
            depth: grow.depth,
            edge_length: grow.membrane_edge,
        }
        .mesh()
        .map_err(|error| input(format!("membrane: {error}")))?;
        let bending = self.jam.map(|jam| Bending {
            stiffness: jam.membrane_bending_stiffness,
            damping: jam.membrane_bending_damping,
        });
        let sheet = Sheet {
            youngs_modulus: grow.membrane_youngs_modulus,
            // A membrane that stands still may weigh anything.
            thickness: self
                .jam
                .map_or(grow.radius_min, |jam| jam.membrane_thickness),
            density: self.jam.map_or(grow.density, |jam| jam.membrane_density),
            damping_ratio: self.jam.map_or(0.0, |jam| jam.membrane_damping_ratio),
            bending: bending.filter(|bending| bending.stiffness > 0.0),
        };
        Membrane::new(mesh, &sheet).map_err(|error| input(format!("membrane: {error}")))
    }

    fn casing(&self) -> Result<Casing, StageFailure> {
        let pair = self.grain().against(self.sheet());
        let grip = Grip {
            material: Material::viscoelastic(pair, self.grow.relaxation_time),
            tangential: Mindlin::between(
                pair,
                self.jam,
                self.jam
                    .map_or(0.0, |jam| jam.membrane_friction_coefficient),
            ),
            areal_density: self.jam.map_or(f64::INFINITY, |jam| {
                jam.membrane_density * jam.membrane_thickness
            }),
        };
        let press = Press {
            drag: self.damping,
            ball: VertexBall {
                radius: self.jam.map_or(0.0, |jam| jam.vertex_radius),
                material: Material::viscoelastic(
                    self.sheet().against_rigid(),
                    self.grow.relaxation_time,
                ),
            },
            ..Press::default()
        };
        Ok(Casing::new(self.membrane()?, grip, press))
    }

    /// The beam that `snapshot` describes.
    pub(super) fn restored<T: Friction, H>(
        &self,
        snapshot: &Snapshot<H>,
    ) -> Result<Beam<T>, StageFailure> {
        let input = |detail: &str| StageFailure::Input {
            detail: format!("state of a beam: {detail}"),
        };
        let laws = self.laws::<T>();
        let pose = |&position: &[f64; 3]| Pose {
            position,
            orientation: UPRIGHT,
        };
        let poses: Vec<Pose> = snapshot.reference.iter().map(pose).collect();
        let size = |&radius: &f64| Size::sphere(radius, self.grow.density);
        let sizes: Vec<Size> = snapshot.radii.iter().map(size).collect();
        let mut grains = Grains::<F64x1>::at_rest(poses, &laws.body, true).graded(sizes);
        for (i, &displacement) in snapshot.displacements.iter().enumerate() {
            grains.set_offset(i, 0, displacement, UPRIGHT);
            grains.set_motion(i, 0, snapshot.motions[i]);
        }
        let mut casing = self.casing()?;
        if casing.membrane.masses().len() != snapshot.vertices.len() {
            return Err(input("its membrane has another number of vertices"));
        }
        casing
            .membrane
            .positions_mut()
            .copy_from_slice(&snapshot.vertices);
        casing
            .membrane
            .velocities_mut()
            .copy_from_slice(&snapshot.velocities);
        let triangles = casing.membrane.rest_areas().len();
        if snapshot
            .held
            .iter()
            .any(|held| held.triangle as usize >= triangles)
        {
            return Err(input("a grain touches a triangle that is not there"));
        }
        casing.hold(&snapshot.held);
        let far = 1e9;
        let walls = Walls::at_rest([-far, far, -far, far, -far, far]);
        let mut beam = Scene::within(laws, grains, walls, casing);
        for contact in &snapshot.contacts {
            // A law without memory takes no history from one that had some.
            let history = &contact.history
                [..crate::scene::history_components::<T>().min(contact.history.len())];
            if !beam.remember(0, contact.i, contact.key, history) {
                return Err(input("a contact is too far apart to touch"));
            }
        }
        Ok(beam)
    }
}
