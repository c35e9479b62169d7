//! The stage `grow`: grains grow in the mold, without friction, until they fill as much of it as asked.
//!
//! Lubachevsky and Stillinger's method for soft spheres: all radii are R(0) s^(t/T_g), masses follow R³, and the membrane stands
//! still in its mold.

use std::collections::BTreeMap;
use std::f64::consts::PI;

use serde::{Deserialize, Serialize};

use super::packing::{Packing, packing};
use super::probe;
use super::rig::Rig;
use super::run::{Course, Run, stopped};
use super::spec::GrowSpec;
use super::state::{Past, Snapshot};
use crate::contact::frictionless::Frictionless;
use crate::grains::{Motion, Size};
use crate::lanes::VectorWidth;
use crate::outcome::{Outcome, Progress, STATE, StageFailure};

/// Beyond this the grains are crushed rather than jammed.
const LARGEST_VOLUME_FRACTION: f64 = 0.74;

/// Far more than the rounding of a sum of volumes: just the largest fraction is allowed.
const ROUNDING: f64 = 1e-9;

/// What a checkpoint remembers besides what moves.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Header {
    stage: String,
    course: Course,
    step: u64,
}

/// Grows the grains of `spec`, or goes on from a checkpoint.
pub(crate) fn run(
    spec: &GrowSpec,
    stage: &str,
    checkpoint: Option<&[u8]>,
    width: VectorWidth,
    progress: &mut Progress<'_>,
) -> Result<Outcome, StageFailure> {
    progress.steps = spec.predicted_steps();
    let packing = packing(spec).map_err(|stop| stopped(0, stop))?;
    let rig = Rig {
        grow: spec,
        jam: None,
        friction_coefficient: 0.0,
        damping: spec.background_damping,
        width,
    };
    let (snapshot, course) = match checkpoint {
        Some(bytes) => {
            let saved = Snapshot::<Header>::of_stage(bytes, stage, |header| &header.stage)?;
            let course = saved.header.course;
            (saved, course)
        }
        None => (placed(&packing, &rig, stage)?, Course::BEGINNING),
    };
    let mut beam = rig.restored::<Frictionless, _>(&snapshot)?;
    let all: Vec<u32> = (0..snapshot.vertices.len() as u32).collect();
    beam.surroundings.membrane.hold(&all, [true; 3]);
    let longest = longest_step(spec);
    let mut run = Run::new(
        beam,
        course,
        (spec.time_step_fraction, longest),
        spec.overlap,
    );
    let save = |run: &Run<Frictionless>| {
        let header = Header {
            stage: stage.to_owned(),
            course: run.course(),
            step: run.step,
        };
        Snapshot::of(&run.beam, header).to_bytes()
    };
    while run.time < spec.growth_time + spec.growth_rest {
        run.growth_rate = rate(spec, &packing, run.time);
        run.advance(progress, &save)?;
        let radii = grown(spec, &packing, run.time);
        run.beam
            .resize(radii.map(|radius| Size::sphere(radius, spec.density)));
    }
    outcome(spec, &run)
}

/// The grains at rest where they were placed.
fn placed(packing: &Packing, rig: &Rig<'_>, stage: &str) -> Result<Snapshot<Header>, StageFailure> {
    let vertices = rig.membrane()?.mesh().positions().to_vec();
    Ok(Snapshot {
        header: Header {
            stage: stage.to_owned(),
            course: Course::BEGINNING,
            step: 0,
        },
        reference: packing.places.clone(),
        displacements: vec![[0.0; 3]; packing.places.len()],
        motions: vec![Motion::default(); packing.places.len()],
        radii: packing.radii.clone(),
        contacts: vec![],
        velocities: vec![[0.0; 3]; vertices.len()],
        vertices,
        held: vec![],
    })
}

/// All radii at `time`.
fn grown<'a>(
    spec: &GrowSpec,
    packing: &'a Packing,
    time: f64,
) -> impl ExactSizeIterator<Item = f64> + 'a {
    let share = (time / spec.growth_time).min(1.0);
    let factor = libm::pow(packing.growth, share);
    packing.radii.iter().map(move |radius| factor * radius)
}

/// Ṙ/R at `time` \[1/s\].
fn rate(spec: &GrowSpec, packing: &Packing, time: f64) -> f64 {
    if time < spec.growth_time {
        libm::log(packing.growth) / spec.growth_time
    } else {
        0.0
    }
}

/// A fifth of the Rayleigh time of the smallest grain, and a thirtieth of the shortest impact: those of grains that meet
/// as fast as they grow.
fn longest_step(spec: &GrowSpec) -> f64 {
    let (radius, nu) = (spec.radius_min / spec.growth_factor, spec.poisson_ratio);
    let shear = spec.youngs_modulus / (2.0 * (1.0 + nu));
    let rayleigh = PI * radius * (spec.density / shear).sqrt() / (0.1631 * nu + 0.8766);
    let speed = 2.0 * spec.radius_max * libm::log(spec.growth_factor).max(0.01) / spec.growth_time;
    // Of two equal grains: m = m_i/2, R = R_i/2, E = E_i/(2(1 − ν²)).
    let mass = 2.0 / 3.0 * PI * spec.density * radius * radius * radius;
    let modulus = 0.5 * spec.youngs_modulus / (1.0 - nu * nu);
    let impact = 2.868
        * libm::pow(
            mass * mass / (0.5 * radius * modulus * modulus * speed),
            0.2,
        );
    (rayleigh / 5.0).min(impact / 30.0)
}

fn outcome(spec: &GrowSpec, run: &Run<Frictionless>) -> Result<Outcome, StageFailure> {
    let volume = run.beam.surroundings.membrane.mesh().volume();
    let volume_fraction = probe::grain_volume(&run.beam) / volume;
    if volume_fraction > LARGEST_VOLUME_FRACTION * (1.0 + ROUNDING) {
        let stop = crate::guard::Stop {
            kind: "overgrown",
            detail: format!(
                "the grains fill {volume_fraction:.3} of the mold, more than {LARGEST_VOLUME_FRACTION}"
            ),
            remedy: "use a smaller initial_volume_fraction".to_owned(),
        };
        return Err(stopped(run.step, stop));
    }
    let warnings = run.warnings("in growth");
    let past = Past {
        grow: spec.clone(),
        jam: None,
        warnings: warnings.clone(),
    };
    let state = Snapshot::of(&run.beam, past).to_bytes();
    let results = [
        ("grains", run.beam.grains.len() as f64),
        ("initial_volume_fraction", volume_fraction),
        ("largest_overlap", run.deepest),
    ];
    Ok(Outcome {
        results: BTreeMap::from(results.map(|(name, value)| (name.to_owned(), Some(value)))),
        artifacts: BTreeMap::from([(STATE.to_owned(), state)]),
        reasons: BTreeMap::new(),
        warnings,
        steps: run.step,
    })
}
