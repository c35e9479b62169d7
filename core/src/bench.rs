//! Scenes to time: a packing at rest, under law H, in as many lanes as asked for.
//!
//! The engine reads no clock; who calls [`Bench::run`] does.

use serde::Deserialize;

use crate::contact::hooke::Hooke;
use crate::grains::{Grains, Pose, UPRIGHT};
use crate::lanes::{F32x8, F32x16, F64x1, F64x8, VectorWidth};
use crate::material::{Material, Units};
use crate::memory::spec::{Precision, ShapeName};
use crate::scene::{Laws, Physics, Replicas, Scene, With};
use crate::shape::{Body, Sphere, Tetrahedron};
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

/// How to time.
#[derive(Clone, Copy, Debug)]
pub struct Settings {
    /// Replicas: 1, 8 or 16.
    pub lanes: usize,
    /// Numbers.
    pub precision: Precision,
    /// \[t_c\].
    pub time_step: f64,
    /// \[R\].
    pub skin: f64,
    /// Vector instructions.
    pub width: VectorWidth,
}

/// A scene that can be stepped, whatever its types.
pub trait Bench {
    /// Takes `steps` steps.
    fn run(&mut self, steps: u64);

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
    fn run(&mut self, steps: u64) {
        for _ in 0..steps {
            self.step();
        }
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
    match pack.kind.as_str() {
        "spheres" => with_shape::<Sphere>(pack, settings, Body::sphere(), ShapeName::Sphere),
        "tetra" => with_shape::<Tetrahedron>(
            pack,
            settings,
            Body::tetrahedron(pack.overlap),
            ShapeName::Tetrahedron,
        ),
        _ => None,
    }
}

fn with_shape<S: crate::shape::Shape>(
    pack: &PackFile,
    settings: &Settings,
    body: Body,
    shape: ShapeName,
) -> Option<Box<dyn Bench>> {
    match (settings.precision, settings.lanes) {
        (Precision::F64, 1) => Some(scene::<F64x1, S>(pack, settings, body, shape)),
        (Precision::F64, 8) => Some(scene::<F64x8, S>(pack, settings, body, shape)),
        (Precision::F32, 8) => Some(scene::<F32x8, S>(pack, settings, body, shape)),
        (Precision::F32, 16) => Some(scene::<F32x16, S>(pack, settings, body, shape)),
        _ => None,
    }
}

fn scene<R: Replicas, S: crate::shape::Shape>(
    pack: &PackFile,
    settings: &Settings,
    body: Body,
    shape: ShapeName,
) -> Box<dyn Bench> {
    let per_radius = |point: [f64; 3]| point.map(|x| x / pack.radius);
    let reference: Vec<Pose> = match shape {
        ShapeName::Sphere => pack
            .positions
            .iter()
            .map(|&p| Pose {
                position: per_radius(p),
                orientation: UPRIGHT,
            })
            .collect(),
        ShapeName::Tetrahedron => pack
            .com
            .iter()
            .zip(&pack.quat)
            .map(|(&p, &[x, y, z, w])| Pose {
                position: per_radius(p),
                orientation: [w, x, y, z],
            })
            .collect(),
    };
    let order = crate::grains::spatial_order(&reference);
    let reference = order.into_iter().map(|i| reference[i]).collect();
    // The peers' parameters: silicone rubber, k_H = 670 N/m, μ = 1.
    let units = Units::new(pack.radius, pack.density, 1e7);
    let stiffness = units.stiffness_from_si(670.0);
    let laws: Laws<With<S, Hooke, ()>> = Laws {
        body,
        material: Material::new(0.49, 0.23, std::f64::consts::SQRT_2),
        tangential: Hooke {
            stiffness,
            damping: 0.3 * 0.23 * stiffness,
            friction_coefficient: 1.0,
        },
        body_force: (),
        time_step: settings.time_step,
        skin: settings.skin,
        width: settings.width,
    };
    let grains = Grains::at_rest(reference, &laws.body, true);
    let walls: Vec<f64> = pack
        .r#box
        .iter()
        .flatten()
        .map(|x| x / pack.radius)
        .collect();
    let walls = Walls::at_rest(walls.try_into().unwrap_or_default());
    Box::new(Scene::<R, With<S, Hooke, ()>>::new(laws, grains, walls))
}
