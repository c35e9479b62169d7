//! The parameter table of the memory experiment, its presets, and the rules between parameters.

use crate::parameter::{Bound, Choices, DefaultValue, Domain, Parameter, Preset, Rule, Section};

use super::sound::USUAL_DRAG;
use super::waveform::Waveform;

use Bound::{Closed, Open};
use DefaultValue::{Real, Text};

fn canonical_waveform(value: &serde_json::Value) -> Result<serde_json::Value, String> {
    Waveform::parse(value).map(|waveform| waveform.to_value())
}

/// Named trades of cost against accuracy: `standard` is the table's defaults.
pub const PRESETS: &[Preset] = &[
    Preset {
        name: "draft",
        values: &[("ramp", Real(4_500.0))],
        sentence: "Ramps four times faster, with the drag of `standard`, which damps what the haste stirs up.",
    },
    Preset {
        name: "standard",
        values: &[],
        sentence: "The paper's ramps at the largest time step that keeps the score, with a drag on the non-affine motion that damps sound.",
    },
    Preset {
        name: "paper",
        values: &[
            ("time_step", Real(1.0)),
            ("drag", Real(0.0)),
            ("hold", Real(2.0)),
            ("precision", Text("f64")),
        ],
        sentence: "The paper's ramps and hold, everything in double precision, without a drag.",
    },
];

/// The least γ0 that single precision sees: there it moves 𝒢 by 5 to 15 % in packs of 64 (docs/accuracy.md).
pub(super) const LEAST_SINGLE_GAMMA0: f64 = 1e-5;

/// Rules between parameters; the first of each is the one to change.
pub const RULES: &[Rule] = &[
    Rule {
        parameters: &["precision", "gamma0"],
        broken: |point| {
            let gamma0 = point["gamma0"].as_f64()?;
            (point["precision"] == "f32" && gamma0 < LEAST_SINGLE_GAMMA0).then(|| {
                format!(
                    "single precision cannot see a shear of gamma0 = {gamma0:?}: use precision = \"f64\", or a gamma0 of \
                     {LEAST_SINGLE_GAMMA0:?} and more"
                )
            })
        },
    },
    Rule {
        parameters: &["tangential_stiffness", "force_law"],
        broken: |point| {
            let stiffness = point["tangential_stiffness"].as_f64()?;
            let law = point["force_law"].as_str().filter(|&law| law != "H")?;
            Some(format!(
                "tangential_stiffness = {stiffness:?} N/m is the stiffness of law H; that of law {law} is Mindlin's and follows \
                 from the material: leave it out, or use force_law = \"H\""
            ))
        },
    },
];

/// The settings among which a sweep with `[accuracy]` may choose, cheapest first, and the reference that they are held
/// against; all of them say the same parameters. They are few, since a pilot computes them all.
pub const CHOICES: Choices = Choices {
    names: &["ramp", "drag", "time_step", "hold", "precision"],
    settings: &[
        &[Real(2_250.0), Real(0.1), Real(1.5), Real(0.2), Text("f32")],
        &[Real(4_500.0), Real(0.1), Real(1.5), Real(0.2), Text("f32")],
        &[Real(9_000.0), Real(0.1), Real(1.5), Real(0.2), Text("f32")],
        &[Real(18_000.0), Real(0.1), Real(1.5), Real(0.2), Text("f32")],
    ],
    // As slow as the paper, with half the drag, so that what drag costs is seen.
    reference: &[
        Real(18_000.0),
        Real(0.05),
        Real(1.0),
        Real(2.0),
        Text("f64"),
    ],
};

/// Every parameter of the memory experiment.
///
/// Defaults are the paper's (Secs. II.1–II.3), what the paper leaves open is as in docs/choices.md §§2–3.
pub const PARAMETERS: &[Parameter] = &[
    Parameter::integer(
        Section::Fixed,
        ("grains", "N"),
        (1, 10_000_000),
        10_240,
        "Number of grains in the pack.",
    ),
    Parameter::choice(
        Section::Fixed,
        ("shape", "shape"),
        &["tetrahedron", "sphere"],
        "tetrahedron",
        "A grain is one sphere, or the rigid union of four spheres at the corners of a regular tetrahedron.",
    ),
    Parameter::real(
        Section::Fixed,
        ("overlap", "𝒪", ""),
        (Closed(0.0), Closed(1.0)),
        0.6,
        "How far the four spheres of a tetrahedral grain overlap: centre distance 2R(1 − 𝒪); 1 is a single sphere.",
    ),
    Parameter::real(
        Section::Fixed,
        ("radius", "R", "m"),
        (Open(0.0), Closed(1.0)),
        0.5e-3,
        "Radius of every sphere.",
    ),
    Parameter::real(
        Section::Fixed,
        ("density", "ρ", "kg/m³"),
        (Open(0.0), Closed(1e6)),
        1200.0,
        "Density of the grain material.",
    ),
    Parameter::real(
        Section::Fixed,
        ("youngs_modulus", "E", "Pa"),
        (Open(0.0), Closed(1e13)),
        1e7,
        "Young's modulus of the grain material.",
    ),
    Parameter::real(
        Section::Fixed,
        ("poisson_ratio", "ν", ""),
        (Open(-1.0), Closed(0.5)),
        0.49,
        "Poisson's ratio of the grain material.",
    ),
    Parameter::real(
        Section::Fixed,
        ("friction_coefficient", "μ", ""),
        (Closed(0.0), Closed(1e3)),
        1.0,
        "Coulomb friction between grains from the training cycle on; packs are made without friction.",
    ),
    Parameter::choice(
        Section::Fixed,
        ("force_law", "law"),
        &["H", "M1", "M2"],
        "H",
        "Tangential force law: H is a linear spring and dashpot under a Coulomb limit (Eq. 4); M1 is Mindlin's, whose spring \
         grows with the contact and is weakened as it shrinks (Eq. 5); M2 is Mindlin's with its whole history (App. D.2).",
    ),
    Parameter::real(
        Section::Fixed,
        ("typical_overlap", "p_typ", "R"),
        (Open(0.0), Closed(0.5)),
        0.04,
        "Overlap at which law H has the tangential stiffness of law M1; the paper does not print it, and 𝒢 goes as its root.",
    ),
    Parameter {
        name: "tangential_stiffness",
        symbol: "k_H",
        unit: "N/m",
        section: Section::Fixed,
        domain: Domain::Real(Open(0.0), Closed(1e12)),
        default: DefaultValue::Derived,
        sentence: "Stiffness of law H, and of no other; by default k_M √p_typ with k_M = 3 k_n (1 − ν)/(2 − ν).",
    },
    Parameter::real(
        Section::Fixed,
        ("normal_damping", "γ_n/k_n", "t_c"),
        (Closed(0.0), Closed(100.0)),
        0.23,
        "Damping of the normal force over its stiffness (Eq. 3).",
    ),
    Parameter::real(
        Section::Fixed,
        ("tangential_damping_ratio", "(γ_H/k_H)/(γ_n/k_n)", ""),
        (Closed(0.0), Closed(10.0)),
        0.3,
        "Damping over stiffness of the tangential force, relative to the normal force's.",
    ),
    Parameter::real(
        Section::Fixed,
        ("wall_stiffness", "k_w/k_n", ""),
        (Open(0.0), Closed(100.0)),
        2.828_427_124_746_190_3,
        "Hertz stiffness of a sphere at a flat rigid wall over that of two spheres: 2^(3/2) by Hertz.",
    ),
    Parameter::real(
        Section::Fixed,
        ("delta0", "δ0", ""),
        (Open(0.0), Closed(0.3)),
        0.05,
        "Volume strain of every compression; packs are prepared with the same.",
    ),
    Parameter::real(
        Section::Fixed,
        ("gamma0", "γ0", ""),
        (Open(0.0), Closed(0.5)),
        1e-3,
        "Amplitude of the shear strain that carries the waveform, half on each axis.",
    ),
    Parameter::real(
        Section::Fixed,
        ("servo_pressure", "p_z/E", ""),
        (Open(0.0), Closed(0.1)),
        2e-3,
        "Pressure that packs are assembled under, over Young's modulus.",
    ),
    Parameter::integer(
        Section::Fixed,
        ("packing_seed", "seed"),
        (0, 9_007_199_254_740_991),
        1,
        "Which realization of the random pack.",
    ),
    Parameter {
        name: "waveform",
        symbol: "I(u)",
        unit: "",
        section: Section::Fixed,
        domain: Domain::Notation(canonical_waveform),
        default: Text("zero"),
        sentence: "The waveform to store: zero, six/1 … six/6, binary_words/L/WORD, a table of bumps, or one of u and shear.",
    },
    Parameter::real(
        Section::Numerics,
        ("time_step", "Δt", "t_c"),
        (Open(0.0), Closed(100.0)),
        1.5,
        "Largest time step; it is shortened so that every sample falls on a step.",
    ),
    Parameter::real(
        Section::Numerics,
        ("ramp", "t0", "t_c"),
        (Closed(100.0), Closed(1e8)),
        18_000.0,
        "Duration of one compression or decompression.",
    ),
    Parameter::real(
        Section::Numerics,
        ("drag", "η", "1/t_c"),
        (Closed(0.0), Closed(1.0)),
        USUAL_DRAG,
        "Drag per mass on the motion that departs from the affine one, and on rotation: it damps the sound that ramps stir up.",
    ),
    Parameter::real(
        Section::Numerics,
        ("hold", "t_hold/t0", ""),
        (Closed(0.0), Closed(100.0)),
        0.2,
        "Storage time between encoding and decoding, in ramps.",
    ),
    Parameter::choice(
        Section::Numerics,
        ("precision", "precision"),
        &["f32", "f64"],
        "f32",
        "Numbers that a recall is computed in: displacements from the trained pack, which is always f64.",
    ),
    Parameter {
        name: "second_cycle",
        symbol: "cycle 2",
        unit: "",
        section: Section::Numerics,
        domain: Domain::Flag,
        default: DefaultValue::Flag(true),
        sentence: "Whether a second cycle without a waveform follows, which SUB2 and SUB2-BL need; it doubles a recall's cost, and is \
                   left out of sweeps that do not ask for it and have no reduction that needs it.",
    },
    Parameter::real(
        Section::Numerics,
        ("skin", "skin", "R"),
        (Open(0.0), Closed(1.0)),
        0.1,
        "How far beyond touching the neighbor list reaches.",
    ),
    Parameter::integer(
        Section::Numerics,
        ("slices", "Q"),
        (5, 10_000),
        100,
        "Values of √p at which law M2 keeps what a contact has been through; other laws keep nothing of the kind.",
    ),
    Parameter::real(
        Section::Numerics,
        ("slice_overlap", "p_max", "R"),
        (Open(0.0), Closed(0.5)),
        0.25,
        "Overlap at the last of law M2's slices; a run in which spheres overlap by more is stopped.",
    ),
    Parameter::real(
        Section::Preparation,
        ("gas_speed", "v_gas", "R/t_c"),
        (Open(0.0), Closed(0.1)),
        0.02,
        "Largest component of the random velocities that the lattice of grains starts with.",
    ),
    Parameter::real(
        Section::Preparation,
        ("gas_time", "t_gas", "t_c"),
        (Closed(0.0), Closed(1e6)),
        3_000.0,
        "How long the gas of grains is mixed in a fixed box.",
    ),
    Parameter::integer(
        Section::Preparation,
        ("preparation_cycles", "cycles"),
        (0, 10),
        2,
        "Frictionless compression cycles before the pack is called prepared.",
    ),
    Parameter::real(
        Section::Preparation,
        ("preparation_time_step", "Δt_prep", "t_c"),
        (Open(0.0), Closed(100.0)),
        1.0,
        "Time step while a pack is made.",
    ),
    Parameter::real(
        Section::Preparation,
        ("preparation_ramp", "t0_prep", "t_c"),
        (Closed(100.0), Closed(1e8)),
        18_000.0,
        "Duration of one compression or decompression while a pack is made.",
    ),
    Parameter::real(
        Section::Preparation,
        ("rest_kinetic_energy", "K_rest", "E R³"),
        (Open(0.0), Closed(1e-4)),
        1e-10,
        "Kinetic energy per grain below which a pack under the servo is at rest.",
    ),
];

/// The parameter called `name`.
#[must_use]
pub fn parameter(name: &str) -> Option<&'static Parameter> {
    PARAMETERS.iter().find(|parameter| parameter.name == name)
}
