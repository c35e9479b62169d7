//! The one place where a spec becomes types: every combination that is compiled is listed here.

use super::{Ensemble, StageSpec};
use crate::beam::{self, bend, grow, jam};
use crate::contact::TangentialLaw;
use crate::contact::frictionless::Frictionless;
use crate::contact::hooke::Hooke;
use crate::contact::mindlin_rescale::MindlinRescale;
use crate::contact::mindlin_sliced::MindlinSliced;
use crate::crew::helped;
use crate::force::{AffineDrag, BodyForce};
use crate::identity::StageId;
use crate::lanes::{F32x8, F32x16, F64x1, F64x8, VectorWidth};
use crate::material::Units;
use crate::memory::classifier::training;
use crate::memory::pack;
use crate::memory::recall::{self, Recalls, Start};
use crate::memory::spec::{ForceLaw, Precision, RecallSpec, ShapeName, TrainSpec};
use crate::memory::state::{PackState, Past};
use crate::memory::train::{self, Chosen};
use crate::observable::critical_time_step::Across;
use crate::outcome::{Outcome, Progress, StageFailure, Watch};
use crate::scene::With;
use crate::shape::{Shape, Sphere, Tetrahedron};

type Outcomes = Result<Vec<Result<Outcome, StageFailure>>, StageFailure>;

/// Runs an ensemble with the types that its specs ask for.
pub(super) fn run(ensemble: &Ensemble<'_>, width: VectorWidth, watch: Watch<'_>) -> Outcomes {
    let (first, steps) = match ensemble.specs.first() {
        // A beam's stages know their number of steps once they have read their input.
        Some(first) => (first, first.steps(&[])),
        None => return Ok(vec![]),
    };
    let mut progress = Progress { watch, steps };
    let key = first.ensemble_key();
    if ensemble.specs.len() > first.max_lanes()
        || ensemble.specs.iter().any(|spec| spec.ensemble_key() != key)
    {
        return Err(input(
            "the jobs of an ensemble must have one ensemble key and fit its lanes",
        ));
    }
    let checkpoint = ensemble
        .checkpoints
        .and_then(|checkpoints| checkpoints.first())
        .map(Vec::as_slice);
    let stage = first.id().to_string();
    match first {
        StageSpec::Pack(spec) => {
            let packed = || match spec.shape {
                ShapeName::Sphere => {
                    pack::run::<Sphere>(spec, &stage, checkpoint, width, &mut progress)
                }
                ShapeName::Tetrahedron => {
                    pack::run::<Tetrahedron>(spec, &stage, checkpoint, width, &mut progress)
                }
            };
            Ok(vec![helped(spec.grains as usize, packed)])
        }
        StageSpec::Train(spec) => {
            let state = read(ensemble.input)?;
            if StageSpec::Pack(state.past.pack.clone()).id() != spec.pack {
                return Err(input(
                    "the input is another pack than the one the stage names",
                ));
            }
            let job = Job::Train {
                spec,
                stage: &stage,
                state: &state,
                checkpoint,
            };
            let trained = || shaped(&job, &state.past, spec, width, &mut progress);
            helped(grains(&state.past), trained)
        }
        StageSpec::Classifier(spec) => {
            let trained = || training::run(spec, &stage, checkpoint, &mut progress);
            Ok(vec![helped(training::ROWS, trained)])
        }
        StageSpec::Encode(_) | StageSpec::Recall(_) => recalled(ensemble, width, &mut progress),
        StageSpec::Grow(_) | StageSpec::Jam(_) | StageSpec::Bend(_) => {
            let bent = || bent(ensemble, &stage, checkpoint, width, &mut progress);
            Ok(vec![helped(usize::MAX, bent)])
        }
    }
}

/// A stage of the beam, which runs alone and checks its own input.
fn bent(
    ensemble: &Ensemble<'_>,
    stage: &str,
    checkpoint: Option<&[u8]>,
    width: VectorWidth,
    progress: &mut Progress<'_>,
) -> Result<Outcome, StageFailure> {
    let from = (ensemble.input, checkpoint);
    match &ensemble.specs[0] {
        StageSpec::Grow(spec) => grow::run(spec, stage, checkpoint, width, progress),
        StageSpec::Jam(spec) => {
            let past = beam::state::past(ensemble.input)?;
            check_input(&StageSpec::Grow(past.grow), spec.grow)?;
            jam::run(spec, stage, from, width, progress)
        }
        StageSpec::Bend(spec) => {
            let past = beam::state::past(ensemble.input)?;
            let jam = past
                .jam
                .ok_or_else(|| input("the input is a beam that was not compacted"))?;
            check_input(&StageSpec::Jam(jam), spec.jam)?;
            bend::run(spec, stage, from, width, progress)
        }
        other => Err(input(&format!(
            "{} is no stage of a beam",
            other.kind().name()
        ))),
    }
}

/// That the state is the one that the stage names.
fn check_input(found: &StageSpec, named: StageId) -> Result<(), StageFailure> {
    if found.id() == named {
        return Ok(());
    }
    Err(input(
        "the input is another beam than the one the stage names",
    ))
}

fn recalled(ensemble: &Ensemble<'_>, width: VectorWidth, progress: &mut Progress<'_>) -> Outcomes {
    let recall = |spec: &StageSpec| match spec {
        StageSpec::Recall(recall) => Some((recall.clone(), None)),
        StageSpec::Encode(encode) => Some((encode.as_recall(), Some(encode.steps()))),
        _ => None,
    };
    let (specs, until): (Vec<RecallSpec>, Vec<Option<u64>>) =
        ensemble.specs.iter().filter_map(recall).unzip();
    let goes_on = specs[0].encode.is_some();
    if specs.iter().any(|spec| spec.encode.is_some() != goes_on) {
        return Err(input("the jobs of an ensemble must begin at one step"));
    }
    // One that goes on alone may be given its encoding's state as its input only.
    let alone;
    let (past, trained, saved) = if goes_on {
        let saved = if let Some(saved) = ensemble.checkpoints {
            saved
        } else {
            alone = [ensemble.input.to_vec()];
            &alone
        };
        (recall::past(ensemble.input)?, None, Some(saved))
    } else {
        let state = read(ensemble.input)?;
        (state.past.clone(), Some(state), ensemble.checkpoints)
    };
    let start = match (saved, &trained) {
        (Some(saved), _) => Start::Saved(saved),
        (None, Some(state)) => Start::Trained(state),
        (None, None) => return Err(input("there is nothing to begin with")),
    };
    let train = past
        .train
        .clone()
        .ok_or_else(|| input("the input is a pack that was not trained"))?;
    if StageSpec::Train(train.clone()).id() != specs[0].train {
        return Err(input(
            "the input is another trained pack than the one the stage names",
        ));
    }
    let stages: Vec<String> = ensemble
        .specs
        .iter()
        .map(|spec| spec.id().to_string())
        .collect();
    let recalls = Recalls {
        specs: &specs,
        stages: &stages,
        past: &past,
        start,
        until: until[0],
    };
    let job = Job::Recall(&recalls);
    helped(grains(&past), || {
        shaped(&job, &past, &train, width, progress)
    })
}

fn grains(past: &Past) -> usize {
    past.pack.grains as usize
}

fn input(detail: &str) -> StageFailure {
    StageFailure::Input {
        detail: detail.to_owned(),
    }
}

fn read(bytes: &[u8]) -> Result<PackState, StageFailure> {
    PackState::from_bytes(bytes).map_err(|detail| input(&format!("input: {detail}")))
}

/// A stage with friction, waiting for its types.
enum Job<'a> {
    Train {
        spec: &'a TrainSpec,
        stage: &'a str,
        state: &'a PackState,
        checkpoint: Option<&'a [u8]>,
    },
    Recall(&'a Recalls<'a>),
}

fn shaped(
    job: &Job<'_>,
    past: &Past,
    train: &TrainSpec,
    width: VectorWidth,
    progress: &mut Progress<'_>,
) -> Outcomes {
    match past.pack.shape {
        ShapeName::Sphere => lawful::<Sphere>(job, past, train, width, progress),
        ShapeName::Tetrahedron => lawful::<Tetrahedron>(job, past, train, width, progress),
    }
}

fn lawful<S: Shape>(
    job: &Job<'_>,
    past: &Past,
    train: &TrainSpec,
    width: VectorWidth,
    progress: &mut Progress<'_>,
) -> Outcomes {
    // μ = 0 gives no tangential force: the same trajectory without springs.
    if train.friction_coefficient == 0.0 {
        return dragged::<S, Frictionless>(
            job,
            train,
            (Frictionless, Across::default(), width),
            progress,
        );
    }
    let pack = &past.pack;
    let units = Units::new(pack.radius, pack.density, pack.youngs_modulus);
    let per_stiffness = train.tangential_damping_ratio * pack.normal_damping;
    let friction_coefficient = train.friction_coefficient;
    if train.force_law == ForceLaw::H {
        let stiffness = units.stiffness_from_si(train.tangential_stiffness);
        let law = Hooke {
            stiffness,
            damping: per_stiffness * stiffness,
            friction_coefficient,
        };
        let across = Across {
            stiffness,
            damping: law.damping,
            ..Across::default()
        };
        return dragged::<S, Hooke>(job, train, (law, across, width), progress);
    }
    let stiffness = units.stiffness_per_root_from_si(train.tangential_stiffness);
    let damping = per_stiffness * stiffness;
    let across = Across {
        stiffness_per_root: stiffness,
        damping_per_root: damping,
        ..Across::default()
    };
    match train.force_law {
        ForceLaw::H | ForceLaw::M1 => {
            let law = MindlinRescale {
                stiffness,
                damping,
                friction_coefficient,
            };
            dragged::<S, MindlinRescale>(job, train, (law, across, width), progress)
        }
        ForceLaw::M2 => {
            let slices = train
                .slices
                .ok_or_else(|| input("law M2 needs slices, and the training names none"))?;
            let law = MindlinSliced {
                stiffness,
                damping,
                friction_coefficient,
                slices: slices.number,
                largest_overlap: slices.largest_overlap,
            };
            dragged::<S, MindlinSliced>(job, train, (law, across, width), progress)
        }
    }
}

fn dragged<S: Shape, T: TangentialLaw>(
    job: &Job<'_>,
    train: &TrainSpec,
    (tangential, across, width): (T, Across, VectorWidth),
    progress: &mut Progress<'_>,
) -> Outcomes {
    let rate = match job {
        Job::Train { .. } => train.drag,
        Job::Recall(recalls) => recalls.specs[0].drag,
    };
    if rate == 0.0 {
        laned::<S, T, ()>(
            job,
            &Chosen {
                tangential,
                across,
                slices: train.slices,
                body_force: (),
                width,
            },
            progress,
        )
    } else {
        laned::<S, T, AffineDrag>(
            job,
            &Chosen {
                tangential,
                across,
                slices: train.slices,
                body_force: AffineDrag { rate },
                width,
            },
            progress,
        )
    }
}

fn laned<S: Shape, T: TangentialLaw, B: BodyForce>(
    job: &Job<'_>,
    chosen: &Chosen<With<S, T, B>>,
    progress: &mut Progress<'_>,
) -> Outcomes {
    match job {
        Job::Train {
            spec,
            stage,
            state,
            checkpoint,
        } => Ok(vec![train::run(
            spec,
            stage,
            (state, *checkpoint),
            chosen,
            progress,
        )]),
        Job::Recall(recalls) => match (recalls.specs[0].precision, recalls.specs.len()) {
            (Precision::F64, 1) => recall::run::<F64x1, _>(recalls, chosen, progress),
            (Precision::F64, _) => recall::run::<F64x8, _>(recalls, chosen, progress),
            (Precision::F32, ..=8) => recall::run::<F32x8, _>(recalls, chosen, progress),
            (Precision::F32, _) => recall::run::<F32x16, _>(recalls, chosen, progress),
        },
    }
}
