//! The versions of the physics: raised whenever the bits of any outcome change.
//!
//! A stage's version is that of the engine when its outcomes changed last.
//! It enters every [`crate::identity::StageId`] and every state, so those of another version are never taken for this one's,
//! and what changes some leaves the outcomes of the others as they are.

/// Of the engine as a whole: a worker names it when it asks for work, and is given what an engine of that version computes.
pub const PHYSICS_VERSION: u32 = 10;

/// Of packs and trainings of the waveform-memory experiment, and of its files.
pub const MEMORY: u32 = 10;

/// Of recalls.
pub const RECALL: u32 = 10;

/// Of classifiers of binary words, which no engine has a part in.
pub const CLASSIFIER: u32 = 1;

/// Of the bending beam.
pub const BEAM: u32 = 6;

const _: () = assert!(
    PHYSICS_VERSION == MEMORY && PHYSICS_VERSION >= RECALL && PHYSICS_VERSION >= BEAM,
    "the engine's version is that of what changed last"
);
