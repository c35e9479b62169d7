//! `[numerics]`: how bending itself is driven, integrated and recorded.

use crate::parameter::Bound::{Closed, Open};
use crate::parameter::{Parameter, Section};

const HERE: Section = Section::Numerics;

pub(super) const NUMERICS: &[Parameter] = &[
    Parameter::real(
        HERE,
        ("time_step_fraction", "κ", ""),
        (Open(0.0), Closed(1.5)),
        0.8,
        "Time step over the critical one, measured again and again, while the beam is bent; from 1 on a run stops.",
    ),
    Parameter::real(
        HERE,
        ("periods", "n_per", ""),
        (Open(0.0), Closed(1e4)),
        5.0,
        "Expected periods of the beam's first mode until ε = 0.002, which set the speed of the rods where rod_speed does not.",
    ),
    Parameter::derived(
        HERE,
        ("rod_speed", "v_rod", "m/s"),
        (Open(0.0), Closed(10.0)),
        "Speed of the rods; by default that of `periods` at the stiffness expected of such grains, and the paper's is 0.2 mm/s.",
    ),
    Parameter::real(
        HERE,
        ("bending_damping", "α_bend", "1/s"),
        (Closed(0.0), Closed(1e3)),
        0.0,
        "Drag per mass on grains and membrane while the beam is bent; the paper has none.",
    ),
    Parameter::real(
        HERE,
        ("strain_end", "ε_end", ""),
        (Closed(0.002), Closed(0.5)),
        0.08,
        "Strain at which bending ends.",
    ),
    Parameter::real(
        HERE,
        ("sample_strain", "Δε", ""),
        (Open(0.0), Closed(0.01)),
        5e-5,
        "Strain between two samples of the stress–strain curve.",
    ),
    Parameter::flag(
        HERE,
        ("structure", "structure"),
        false,
        "Whether the packing's structure is analyzed while it is bent.",
    ),
    Parameter::flag(
        HERE,
        ("snapshots", "snapshots"),
        false,
        "Whether the whole beam is stored while it is bent, for OVITO and ParaView.",
    ),
    Parameter::real(
        HERE,
        ("snapshot_travel", "Δz_rod", "m"),
        (Open(0.0), Closed(1.0)),
        5e-4,
        "Way of the rods between two snapshots, stored or analyzed.",
    ),
    Parameter::real(
        HERE,
        ("strain_end_over_yield", "ε_end/ε_Y", ""),
        (Closed(0.0), Closed(100.0)),
        0.0,
        "Bending also ends once the beam has yielded, at so many times the strain at which it did and not before ε = 0.05; 0 is never.",
    ),
];
