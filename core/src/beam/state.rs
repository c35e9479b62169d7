//! State files of the beam: between two stages, and between two steps.

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use super::rig::Beam;
use super::spec::{GrowSpec, JamSpec};
use crate::contact::TangentialLaw;
use crate::grains::{Motion, Pose, UPRIGHT};
use crate::outcome::StageFailure;
use crate::physics;
use crate::scene::casing::Held;
use crate::scene::history_components;
use crate::state_file::{Reader, Remembered, Writer, read_header};

/// What led to a state.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Past {
    /// How the grains were grown.
    pub(crate) grow: GrowSpec,
    /// How they were compacted, if they were.
    pub(crate) jam: Option<JamSpec>,
    /// What a reader of the numbers should know of it: the outcome of the last stage says it too.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(crate) warnings: Vec<String>,
}

/// Everything that moves, exactly.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Snapshot<H> {
    /// What it belongs to, and what its driver needs to go on.
    pub(crate) header: H,
    /// The grains' reference.
    pub(crate) reference: Vec<[f64; 3]>,
    /// Displacement from it.
    pub(crate) displacements: Vec<[f64; 3]>,
    pub(crate) motions: Vec<Motion>,
    pub(crate) radii: Vec<f64>,
    pub(crate) contacts: Vec<Remembered>,
    /// Where the vertices are, and how they move.
    pub(crate) vertices: Vec<[f64; 3]>,
    pub(crate) velocities: Vec<[f64; 3]>,
    pub(crate) held: Vec<Held>,
}

/// The specs that led to the state in `bytes`.
pub(crate) fn past(bytes: &[u8]) -> Result<Past, StageFailure> {
    read_header(physics::BEAM, bytes).map_err(|detail| unreadable(&detail))
}

fn unreadable(detail: &str) -> StageFailure {
    StageFailure::Input {
        detail: format!("state of a beam: {detail}"),
    }
}

impl<H: Serialize + DeserializeOwned> Snapshot<H> {
    /// The present state of `beam`.
    pub(crate) fn of<T: TangentialLaw>(beam: &Beam<T>, header: H) -> Self {
        let grains = &beam.grains;
        let remembered = |(i, key, history)| Remembered { i, key, history };
        let contacts = if history_components::<T>() == 0 {
            vec![]
        } else {
            beam.remembered(0).map(remembered).collect()
        };
        let membrane = &beam.surroundings.membrane;
        Self {
            header,
            reference: grains
                .reference()
                .iter()
                .map(|pose| pose.position)
                .collect(),
            displacements: (0..grains.len()).map(|i| grains.offset(i, 0).0).collect(),
            motions: (0..grains.len()).map(|i| grains.motion(i, 0)).collect(),
            radii: grains.sizes().iter().map(|size| size.radius).collect(),
            contacts,
            vertices: membrane.mesh().positions().to_vec(),
            velocities: membrane.velocities().to_vec(),
            held: beam.surroundings.held().copied().collect(),
        }
    }

    /// The bytes of the file.
    pub(crate) fn to_bytes(&self) -> Vec<u8> {
        let mut writer = Writer::new(physics::BEAM, &self.header);
        let pose = |&position: &[f64; 3]| Pose {
            position,
            orientation: UPRIGHT,
        };
        let poses: Vec<Pose> = self.reference.iter().map(pose).collect();
        writer.grains(&poses, &self.motions);
        writer.vectors(&self.displacements);
        writer.count(self.radii.len());
        writer.numbers(&self.radii);
        writer.contacts(&self.contacts);
        writer.vectors(&self.vertices);
        writer.vectors(&self.velocities);
        writer.count(self.held.len());
        for held in &self.held {
            writer.word(held.grain);
            writer.word(held.triangle);
            writer.numbers(&held.spring);
            writer.numbers(&[held.overlap, held.normal_force, held.tangential_force]);
        }
        writer.into_bytes()
    }

    /// Reads a file; the error says what is wrong with it.
    pub(crate) fn from_bytes(bytes: &[u8]) -> Result<Self, StageFailure> {
        Self::read(bytes)
            .and_then(alone)
            .map_err(|detail| unreadable(&detail))
    }

    /// Reads a checkpoint of `stage`, and of no other.
    pub(crate) fn of_stage(
        bytes: &[u8],
        stage: &str,
        named: impl Fn(&H) -> &String,
    ) -> Result<Self, StageFailure> {
        let found = Self::of_stage_with_rest(bytes, stage, named)?;
        alone(found).map_err(|detail| unreadable(&detail))
    }

    /// Reads a checkpoint of `stage`, and of no other, and returns what follows it.
    pub(crate) fn of_stage_with_rest<'a>(
        bytes: &'a [u8],
        stage: &str,
        named: impl Fn(&H) -> &String,
    ) -> Result<(Self, &'a [u8]), StageFailure> {
        let (saved, rest) = Self::read(bytes).map_err(|detail| unreadable(&detail))?;
        let found = named(&saved.header);
        if found == stage {
            return Ok((saved, rest));
        }
        let detail = format!("the checkpoint belongs to {found}, not to {stage}");
        Err(StageFailure::Input { detail })
    }

    fn read(bytes: &[u8]) -> Result<(Self, &[u8]), String> {
        let (header, mut reader) = Reader::new(physics::BEAM, bytes)?;
        let (poses, motions) = reader.grains()?;
        let reference: Vec<[f64; 3]> = poses.iter().map(|pose| pose.position).collect();
        let displacements = reader.vectors()?;
        let count = reader.word()?;
        let radii: Vec<f64> = (0..count)
            .map(|_| reader.numbers::<1>().map(|[radius]| radius))
            .collect::<Result<_, _>>()?;
        if displacements.len() != reference.len() || radii.len() != reference.len() {
            return Err("the grains' places, displacements and radii differ in number".to_owned());
        }
        let contacts = reader.contacts(reference.len())?;
        let vertices = reader.vectors()?;
        let velocities = reader.vectors()?;
        if vertices.len() != velocities.len() {
            return Err("the vertices' places and velocities differ in number".to_owned());
        }
        let held = held(&mut reader, reference.len())?;
        let snapshot = Self {
            header,
            reference,
            displacements,
            motions,
            radii,
            contacts,
            vertices,
            velocities,
            held,
        };
        Ok((snapshot, reader.rest()))
    }
}

/// A snapshot that nothing follows.
fn alone<H>((snapshot, rest): (Snapshot<H>, &[u8])) -> Result<Snapshot<H>, String> {
    if rest.is_empty() {
        Ok(snapshot)
    } else {
        Err(format!("{} bytes too many", rest.len()))
    }
}

fn held(reader: &mut Reader<'_>, grains: usize) -> Result<Vec<Held>, String> {
    let count = reader.word()?;
    let mut all: Vec<Held> = vec![];
    for _ in 0..count {
        let (grain, triangle) = (reader.word()?, reader.word()?);
        if grain as usize >= grains || all.last().is_some_and(|before| before.grain > grain) {
            return Err(format!(
                "contact of grain {grain} with the membrane is out of place"
            ));
        }
        let spring = reader.numbers()?;
        let [overlap, normal_force, tangential_force] = reader.numbers()?;
        all.push(Held {
            grain,
            triangle,
            spring,
            normal_force,
            tangential_force,
            overlap,
        });
    }
    Ok(all)
}
