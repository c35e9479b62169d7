//! The bending-beam experiment: its parameters, the stages they lead to, and what its measurements say about the beam.
//!
//! Source: H. Götz, T. Pöschel, O. D'Angelo, *Structural features of jammed-granulate metamaterials*, Phys. Rev. Research 6, 013061 (2024) ("the paper").
//!
//! The modules follow the numbers: forces and deflections become a curve, a curve yields a stiffness E_b and a strength Y_b, and strengths at several frictions yield the three parameters of Eq. (4).
//! Whatever cannot be found is a typed reason, never a number.

pub mod parameters;
pub mod point;
pub mod prediction;
pub mod results;
pub mod rules;
pub mod spec;
pub mod steps;

mod packing;
mod probe;
mod rig;
mod run;

mod frame;
mod interior;
pub(crate) mod state;

pub(crate) mod bend;
pub(crate) mod grow;
pub(crate) mod jam;

pub mod curve;
pub mod hysteresis;
pub(crate) mod line;

pub mod stiffness;
pub mod strength;

pub mod exponential_fit;

pub mod structure;

#[cfg(test)]
pub(crate) mod noise;
