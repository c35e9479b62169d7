//! `[preparation]`: how a packing is made and put under pressure, and when it counts as at rest.

use crate::parameter::Bound::{Closed, Open};
use crate::parameter::{Parameter, Section};

const HERE: Section = Section::Preparation;

pub(super) const PREPARATION: &[Parameter] = &[
    Parameter::real(
        HERE,
        ("growth_time", "T_g", "s"),
        (Open(0.0), Closed(100.0)),
        0.1,
        "How long the grains grow, all by one factor per time.",
    ),
    Parameter::real(
        HERE,
        ("growth_rest", "T_rest", "s"),
        (Closed(0.0), Closed(100.0)),
        0.05,
        "How long the grown grains come to rest in the frozen membrane.",
    ),
    Parameter::real(
        HERE,
        ("pressure_ramp", "T_p", "s"),
        (Open(0.0), Closed(100.0)),
        0.3,
        "How long the confining pressure rises to its value.",
    ),
    Parameter::choice(
        HERE,
        ("mold", "mold"),
        &["even", "following"],
        "even",
        "Whether all walls of the mold move by one strain and take the membrane with them, so that the beam keeps its \
         proportions, or each pair follows the membrane for itself.",
    ),
    Parameter::real(
        HERE,
        ("mold_speed", "v_mold", "m/s"),
        (Open(0.0), Closed(10.0)),
        0.05,
        "Largest speed at which a wall of the mold moves inward.",
    ),
    Parameter::real(
        HERE,
        ("mold_load", "F_t/(Δp A)", ""),
        (Open(0.0), Open(1.0)),
        0.01,
        "Reaction at which a wall of the mold no longer follows, over the confining pressure on its area.",
    ),
    Parameter::real(
        HERE,
        ("release_time", "T_release", "s"),
        (Open(0.0), Closed(100.0)),
        0.05,
        "How long the mold is drawn away once the beam is at rest.",
    ),
    Parameter::real(
        HERE,
        ("rest_window", "T_window", "s"),
        (Open(0.0), Closed(100.0)),
        0.05,
        "How long the three signs of rest must hold.",
    ),
    Parameter::real(
        HERE,
        ("rest_volume_rate", "|V̇|/V", "1/s"),
        (Open(0.0), Closed(1e3)),
        1e-3,
        "Change of volume per volume and time below which a beam is at rest.",
    ),
    Parameter::real(
        HERE,
        ("rest_force_ratio", "⟨|ΣF|⟩/⟨|F_c|⟩", ""),
        (Open(0.0), Closed(1.0)),
        1e-3,
        "Mean net force on a grain over the mean contact force, below which a beam is at rest.",
    ),
    Parameter::real(
        HERE,
        ("rest_energy_ratio", "E_kin/E_el", ""),
        (Open(0.0), Closed(1.0)),
        1e-6,
        "Kinetic over elastic energy, below which a beam is at rest.",
    ),
    Parameter::real(
        HERE,
        ("longest_rest", "T_longest", "s"),
        (Open(0.0), Closed(1e4)),
        5.0,
        "How long a beam is waited for to come to rest before it is given up.",
    ),
    Parameter::real(
        HERE,
        ("background_damping", "α", "1/s"),
        (Closed(0.0), Closed(1e3)),
        20.0,
        "Drag per mass on grains and membrane until the beam is at rest without its mold; bending has bending_damping.",
    ),
    Parameter::real(
        HERE,
        ("preparation_time_step_fraction", "κ_prep", ""),
        (Open(0.0), Closed(1.5)),
        0.4,
        "Time step over the critical one, measured again and again, until bending begins.",
    ),
];
