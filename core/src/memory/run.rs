//! What the stages of the memory experiment share: driving, checkpoints, and names of results.

use std::collections::BTreeMap;

use serde::Serialize;
use serde::de::DeserializeOwned;

use super::cycle::{Drive, Program, REPORT_EVERY};
use super::spec::Slices;
use super::state::{Checkpoint, PackState, Past};
use super::waveform::Waveform;
use crate::contact::TangentialLaw;
use crate::grains::{Grains, Pose};
use crate::guard::{Guard, Stop};
use crate::observable::Observation;
use crate::observable::critical_time_step::CriticalTimeStep;
use crate::outcome::{Progress, StageFailure};
use crate::scene::{Laws, Physics, Replicas, Scene, history_components};
use crate::state_file::Remembered;
use crate::wall::{WALLS, Walls};

/// The failure of a replica that the guard stopped.
pub(crate) fn stopped(step: u64, stop: Stop) -> StageFailure {
    StageFailure::Stopped {
        kind: stop.kind.to_owned(),
        step,
        detail: stop.detail,
        remedy: stop.remedy,
    }
}

/// The guard of a training or a recall.
pub(crate) fn guard(critical_at_start: CriticalTimeStep, slices: Option<Slices>) -> Guard {
    Guard {
        parameter: "time_step",
        deepest_slice: slices.map(|slices| slices.largest_overlap),
        critical_at_start,
    }
}

/// The program of a replica that is told nothing.
pub(crate) fn silent() -> Program {
    Program {
        gamma0: 0.0,
        curve: Waveform::Zero.curve(),
    }
}

/// Writes the complete state of one replica.
pub(crate) type Save<'a, R, P> = &'a dyn Fn(&Drive<R, P>, usize) -> Vec<u8>;

/// Steps `drive` up to, not including, step `end` of its cycle; `before` steps of the stage came first, or were done by another.
pub(crate) fn drive<R: Replicas, P: Physics>(
    drive: &mut Drive<R, P>,
    (before, end): (i64, u64),
    progress: &mut Progress<'_>,
    save: Save<'_, R, P>,
) -> Result<(), StageFailure> {
    while drive.step < end && !drive.is_over() {
        if drive.step.is_multiple_of(REPORT_EVERY) {
            let jobs = drive.programs.len();
            progress.ask(drive.step.saturating_add_signed(before), &|| {
                (0..jobs).map(|k| save(drive, k)).collect()
            })?;
        }
        drive.step_once();
    }
    Ok(())
}

/// The complete state of replica `k`.
pub(crate) fn checkpoint_of<R: Replicas, P: Physics, H>(
    scene: &Scene<R, P>,
    k: usize,
    header: H,
) -> Checkpoint<H> {
    let grains = &scene.grains;
    let offset = |i| {
        let (position, orientation) = grains.offset(i, k);
        Pose {
            position,
            orientation,
        }
    };
    Checkpoint {
        header,
        reference: grains.reference().to_vec(),
        offsets: (0..grains.len()).map(offset).collect(),
        motions: (0..grains.len()).map(|i| grains.motion(i, k)).collect(),
        contacts: remembered(scene, k),
    }
}

fn remembered<R: Replicas, P: Physics>(scene: &Scene<R, P>, k: usize) -> Vec<Remembered> {
    if history_components::<P::Tangential>() == 0 {
        return vec![];
    }
    scene
        .remembered(k)
        .map(|(i, key, history)| Remembered { i, key, history })
        .collect()
}

/// Reads a checkpoint and makes sure that it belongs to one of `stages`.
pub(crate) fn read_checkpoint<H: Serialize + DeserializeOwned>(
    stages: &[&str],
    bytes: &[u8],
    stage_of: impl Fn(&H) -> &String,
) -> Result<Checkpoint<H>, StageFailure> {
    let input = |detail: String| StageFailure::Input {
        detail: format!("checkpoint: {detail}"),
    };
    let saved = Checkpoint::<H>::from_bytes(bytes).map_err(input)?;
    let found = stage_of(&saved.header);
    if !stages.contains(&found.as_str()) {
        let own = stages.join(" or ");
        return Err(input(format!("it belongs to {found}, not to {own}")));
    }
    Ok(saved)
}

/// A scene whose replica k is as `saved[k]` says; replicas beyond repeat the first.
pub(crate) fn restored<R: Replicas, P: Physics, H>(
    laws: Laws<P>,
    walls: [f64; WALLS],
    saved: &[Checkpoint<H>],
) -> Result<Scene<R, P>, StageFailure> {
    let input = |detail: &str| StageFailure::Input {
        detail: format!("checkpoint: {detail}"),
    };
    let first = saved.first().ok_or_else(|| input("there is none"))?;
    if saved.iter().any(|other| other.reference != first.reference) {
        return Err(input(
            "the jobs of one ensemble do not share their reference",
        ));
    }
    let mut grains = Grains::<R>::at_rest(first.reference.clone(), &laws.body, P::SPINS);
    let of = |k: usize| saved.get(k).unwrap_or(first);
    for k in 0..R::K {
        for (i, (offset, &motion)) in of(k).offsets.iter().zip(&of(k).motions).enumerate() {
            grains.set_offset(i, k, offset.position, offset.orientation);
            grains.set_motion(i, k, motion);
        }
    }
    let mut scene = Scene::new(laws, grains, Walls::at_rest(walls));
    for k in 0..R::K {
        give_memory(&mut scene, k, &of(k).contacts)?;
    }
    Ok(scene)
}

/// Gives replica `k` what its contacts remember.
pub(crate) fn give_memory<R: Replicas, P: Physics>(
    scene: &mut Scene<R, P>,
    k: usize,
    contacts: &[Remembered],
) -> Result<(), StageFailure> {
    let components = history_components::<P::Tangential>();
    for Remembered { i, key, history } in contacts {
        let slices = P::Tangential::slices(history);
        if history.len() != components + 2 * slices || !scene.remember(k, *i, *key, history) {
            let detail = format!(
                "the contact of grains {i} and {} does not fit the pack",
                key.j
            );
            return Err(StageFailure::Input { detail });
        }
    }
    Ok(())
}

/// The pack as the next stage will find it, from a lone run.
pub(crate) fn state_of<R: Replicas, P: Physics>(scene: &Scene<R, P>, past: Past) -> PackState {
    let grains = &scene.grains;
    PackState {
        past,
        poses: (0..grains.len()).map(|i| grains.pose(i, 0)).collect(),
        motions: (0..grains.len()).map(|i| grains.motion(i, 0)).collect(),
        contacts: remembered(scene, 0),
    }
}

/// An observation as results, their names ending in `suffix`.
pub(crate) fn observed(seen: &Observation, suffix: &str) -> BTreeMap<String, Option<f64>> {
    let named = [
        ("volume_fraction", seen.volume_fraction),
        ("coordination_number", seen.coordination_number),
        ("sphere_contacts_per_grain", seen.sphere_contacts_per_grain),
        ("wall_contacts_per_grain", seen.wall_contacts_per_grain),
        ("kinetic_energy", seen.kinetic_energy),
    ];
    named
        .into_iter()
        .map(|(name, value)| (format!("{name}{suffix}"), Some(value)))
        .collect()
}

/// A critical time step as results: none if nothing touched.
pub(crate) fn measured(critical: CriticalTimeStep) -> [(String, Option<f64>); 2] {
    let touched = critical != CriticalTimeStep::NONE;
    [
        ("critical_time_step", critical.at_least),
        (
            "critical_time_step_error",
            critical.at_most - critical.at_least,
        ),
    ]
    .map(|(name, value)| (name.to_owned(), touched.then_some(value)))
}
