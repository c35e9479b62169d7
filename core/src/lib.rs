//! The engine and the experiments of Granary: silent, deterministic, without I/O.
//!
//! # Units
//! Inside the engine the sphere radius R, the density ρ and Young's modulus E are 1.
//! Then the unit of time is t_c = R√(ρ/E), of pressure E, of force E R², of energy E R³.
//! SI units appear only at the boundary: in the parameter table and in the outcomes that name them.
//! The beam's scenes are in SI units throughout: grains that differ in size have no common R.
//!
//! # Signs
//! `normal` points from grain `j` into grain `i`; overlap, pressure and compressive strain are positive.
//!
//! # Reading order
//! The modules stand in the order in which they may import one another (see ARCHITECTURE.md).

pub mod crew;
pub mod identity;
pub mod outcome;
pub mod parameter;
pub mod physics;

pub mod lanes;
pub mod math;
pub mod random;
pub mod study;

pub mod material;
pub mod shape;

pub mod grains;

pub mod contact;
pub mod neighbor;

pub mod force;
pub mod membrane;
pub mod state_file;
pub mod wall;

pub mod scene;

pub mod observable;

pub mod guard;

pub mod protocol;

pub mod beam;
pub mod memory;

pub mod bench;
pub mod stage;

pub mod model;

pub use physics::PHYSICS_VERSION;
