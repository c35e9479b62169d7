//! Scenes to time: a packing at rest, under one of the tangential laws, in as many lanes as asked for.
//!
//! The engine reads no clock; who calls [`Bench::run`] does.

use serde::Deserialize;

use crate::contact::TangentialLaw;
use crate::contact::hooke::Hooke;
use crate::contact::mindlin_rescale::MindlinRescale;
use crate::contact::mindlin_sliced::MindlinSliced;
use crate::crew::helped;
use crate::grains::{Grains, Pose, UPRIGHT};
use crate::lanes::{F32x8, F32x16, F64x1, F64x8, VectorWidth};
use crate::material::{Material, Units};
use crate::memory::spec::{ForceLaw, Precision, ShapeName};
use crate::scene::{Laws, Physics, Replicas, Scene, With};
use crate::shape::{Body, Shape, Sphere, Tetrahedron};
use crate::wall::Walls;

/// A packing at rest, as in the peers' pack files: SI units, walls at 0 and `r#box[axis][1]`.
#[derive(Clone, Debug, Deserialize)]
pub struct PackFile {
    /// `spheres` or `tetra`.
    pub kind: String,
    /// R \[m\].
    pub radius: f64,
    /// ρ \[kg/m³\].
    pub density: f64,
    /// Low and high wall along each axis \[m\].
    pub r#box: [[f64; 2]; 3],
    /// 𝒪 of tetrahedra.
    #[serde(default, rename = "overlap_O")]
    pub overlap: f64,
    /// Sphere centers \[m\].
    #[serde(default)]
    pub positions: Vec<[f64; 3]>,
    /// Centers of mass of tetrahedra \[m\].
    #[serde(default)]
    pub com: Vec<[f64; 3]>,
    /// Orientations of tetrahedra, (x, y, z, w).
    #[serde(default)]
    pub quat: Vec<[f64; 4]>,
}

/// ν of silicone rubber.
pub const POISSON_RATIO: f64 = 0.49;
/// E of silicone rubber \[Pa\].
const YOUNGS_MODULUS: f64 = 1e7;
/// γ_n/k_n \[t_c\].
const NORMAL_DAMPING: f64 = 0.23;
/// k_H \[N/m\].
const STIFFNESS: f64 = 670.0;
/// γ_H/k_H over γ_n/k_n.
const RELATIVE_DAMPING: f64 = 0.3;

impl PackFile {
    /// The shape of its grains; `None` if `kind` names none.
    #[must_use]
    pub fn shape(&self) -> Option<ShapeName> {
        match self.kind.as_str() {
            "spheres" => Some(ShapeName::Sphere),
            "tetra" => Some(ShapeName::Tetrahedron),
            _ => None,
        }
    }

    /// The rigid body of every grain; `None` as of [`PackFile::shape`].
    #[must_use]
    pub fn body(&self) -> Option<Body> {
        self.shape().map(|shape| match shape {
            ShapeName::Sphere => Body::sphere(),
            ShapeName::Tetrahedron => Body::tetrahedron(self.overlap),
        })
    }

    /// Every grain, in the order of the file; no grain without a shape.
    #[must_use]
    pub fn poses(&self) -> Vec<Pose> {
        let pose = |place: [f64; 3], orientation| Pose {
            position: place.map(|x| x / self.radius),
            orientation,
        };
        match self.shape() {
            None => vec![],
            Some(ShapeName::Sphere) => {
                let places = self.positions.iter();
                places.map(|&place| pose(place, UPRIGHT)).collect()
            }
            Some(ShapeName::Tetrahedron) => {
                let placed = self.com.iter().zip(&self.quat);
                placed
                    .map(|(&place, &[x, y, z, w])| pose(place, [w, x, y, z]))
                    .collect()
            }
        }
    }

    /// The units in which its scene is computed.
    #[must_use]
    pub fn units(&self) -> Units {
        Units::new(self.radius, self.density, YOUNGS_MODULUS)
    }
}

/// The normal law of every bench: silicone rubber.
#[must_use]
pub fn material() -> Material {
    Material::new(POISSON_RATIO, NORMAL_DAMPING, std::f64::consts::SQRT_2)
}

/// Law H with μ = 1.
#[must_use]
pub fn friction(units: &Units) -> Hooke {
    let stiffness = units.stiffness_from_si(STIFFNESS);
    Hooke {
        stiffness,
        damping: RELATIVE_DAMPING * NORMAL_DAMPING * stiffness,
        friction_coefficient: 1.0,
    }
}

/// Law M1 with μ = 1.
fn rescaled() -> MindlinRescale {
    let stiffness =
        3.0 * material().normal_stiffness * (1.0 - POISSON_RATIO) / (2.0 - POISSON_RATIO);
    MindlinRescale {
        stiffness,
        damping: RELATIVE_DAMPING * NORMAL_DAMPING * stiffness,
        friction_coefficient: 1.0,
    }
}

/// Law M2 with μ = 1, Q = 100 and p_max = 0.25 R.
fn sliced() -> MindlinSliced {
    let MindlinRescale {
        stiffness,
        damping,
        friction_coefficient,
    } = rescaled();
    MindlinSliced {
        stiffness,
        damping,
        friction_coefficient,
        slices: 100,
        largest_overlap: 0.25,
    }
}

/// How to time.
#[derive(Clone, Copy, Debug)]
pub struct Settings {
    /// Replicas: 1, 8 or 16.
    pub lanes: usize,
    /// Numbers.
    pub precision: Precision,
    /// The tangential law.
    pub force_law: ForceLaw,
    /// \[t_c\].
    pub time_step: f64,
    /// \[R\].
    pub skin: f64,
    /// Vector instructions.
    pub width: VectorWidth,
}

/// A scene that can be stepped, whatever its types.
pub trait Bench {
    /// Takes a step, while there are to be more, on all threads of the caller's crew.
    fn run(&mut self, more: &mut (dyn FnMut() -> bool + Send));

    /// What the scene is made of.
    fn size(&self) -> Size;
}

/// What a scene is made of.
#[derive(Clone, Copy, Debug)]
pub struct Size {
    /// N.
    pub grains: usize,
    /// Replicas.
    pub lanes: usize,
    /// Touching pairs of spheres in the first replica.
    pub contacts: usize,
    /// Pairs in the list.
    pub candidates: usize,
    /// Bytes of state per grain, all replicas.
    pub bytes_per_grain: usize,
    /// Bytes per candidate, all replicas.
    pub bytes_per_candidate: usize,
    /// How often the list was built.
    pub renewals: u64,
}

impl<R: Replicas, P: Physics> Bench for Scene<R, P> {
    fn run(&mut self, more: &mut (dyn FnMut() -> bool + Send)) {
        helped(self.grains.len(), || {
            while more() {
                self.step();
            }
        });
    }

    fn size(&self) -> Size {
        Size {
            grains: self.grains.len(),
            lanes: R::K,
            contacts: self.remembered(0).count(),
            candidates: self.candidates(),
            bytes_per_grain: self.bytes_per_grain(),
            bytes_per_candidate: Self::bytes_per_candidate(),
            renewals: self.renewals(),
        }
    }
}

/// A scene of `pack` to time; `None` for a combination that is not compiled.
#[must_use]
pub fn bench(pack: &PackFile, settings: &Settings) -> Option<Box<dyn Bench>> {
    match pack.shape()? {
        ShapeName::Sphere => with_shape::<Sphere>(pack, settings),
        ShapeName::Tetrahedron => with_shape::<Tetrahedron>(pack, settings),
    }
}

fn with_shape<S: Shape>(pack: &PackFile, settings: &Settings) -> Option<Box<dyn Bench>> {
    match settings.force_law {
        ForceLaw::H => with_law::<S, _>(friction(&pack.units()), pack, settings),
        ForceLaw::M1 => with_law::<S, _>(rescaled(), pack, settings),
        ForceLaw::M2 => with_law::<S, _>(sliced(), pack, settings),
    }
}

fn with_law<S: Shape, T: TangentialLaw>(
    law: T,
    pack: &PackFile,
    settings: &Settings,
) -> Option<Box<dyn Bench>> {
    match (settings.precision, settings.lanes) {
        (Precision::F64, 1) => scene::<F64x1, S, T>(law, pack, settings),
        (Precision::F64, 8) => scene::<F64x8, S, T>(law, pack, settings),
        (Precision::F32, 8) => scene::<F32x8, S, T>(law, pack, settings),
        (Precision::F32, 16) => scene::<F32x16, S, T>(law, pack, settings),
        _ => None,
    }
}

fn scene<R: Replicas, S: Shape, T: TangentialLaw>(
    tangential: T,
    pack: &PackFile,
    settings: &Settings,
) -> Option<Box<dyn Bench>> {
    let poses = pack.poses();
    let order = crate::grains::spatial_order(&poses);
    let reference = order.into_iter().map(|i| poses[i]).collect();
    let laws: Laws<With<S, T, ()>> = Laws {
        body: pack.body()?,
        material: material(),
        tangential,
        body_force: (),
        time_step: settings.time_step,
        dither: 0.0,
        skin: settings.skin,
        width: settings.width,
    };
    let grains = Grains::at_rest(reference, &laws.body, true);
    let walls = pack.r#box.iter().flatten();
    let walls: Vec<f64> = walls.map(|x| x / pack.radius).collect();
    let walls = Walls::at_rest(walls.try_into().unwrap_or_default());
    Some(Box::new(Scene::<R, With<S, T, ()>>::new(
        laws, grains, walls,
    )))
}
