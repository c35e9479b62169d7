//! The result table of the memory experiment: symbol, unit and meaning of every number of a point or a set.

use crate::parameter::Quantity;
use crate::study::Judged;

/// What studies judge settings by: 𝒢 by its relative error, 𝓕 by its error.
pub const JUDGED: &[Judged] = &[
    Judged {
        name: "gain",
        relative: true,
    },
    Judged {
        name: "fidelity",
        relative: false,
    },
];

/// Every result, those of sets first; a set of means adds `_sem` to a name for its standard error.
pub const RESULTS: &[Quantity] = &[
    Quantity::new(
        "gain",
        ("𝒢", ""),
        "Gain: how much of the stored waveform comes back (Appendix B).",
    ),
    Quantity::new(
        "gain_e_delta0",
        ("𝒢·E·δ0", "Pa"),
        "Gain times Young's modulus and volume strain.",
    ),
    Quantity::new(
        "fidelity",
        ("𝓕", ""),
        "Fidelity: 1 if what comes back has exactly the stored shape; 1 − √(1 − C²) (Eq. 21).",
    ),
    Quantity::new(
        "correlation",
        ("C", ""),
        "Correlation of what comes back with the stored waveform; its sign is the gain's.",
    ),
    Quantity::new(
        "rounding_error",
        ("ρ", ""),
        "What a last digit of a pressure is of the recalled signals: rounding may move 𝒢 by ρ/|C| of itself, and 𝓕 by ρ; from 0.1 on there is no score.",
    ),
    Quantity::new(
        "noise_to_signal",
        ("σ/p", ""),
        "How much of the recalled signals scatters from sample to sample, as nothing stored does; in a pack at rest 0.02 and less, from 0.1 on a set is warned.",
    ),
    Quantity::new(
        "recognition_accuracy",
        ("A", ""),
        "Share of recalled words that a classifier, trained on the stored waveforms alone, takes for what they are (App. C); its standard error is that of several trainings, or of packings.",
    ),
    Quantity::new(
        "validation_accuracy",
        ("A_val", ""),
        "Share of transformed waveforms that the classifier tells, of those that it did not learn from.",
    ),
    Quantity::new(
        "encode_correlation",
        ("C_enc", ""),
        "Correlation of the shear stress with the waveform while it is stored.",
    ),
    Quantity::new(
        "hold_kinetic_energy",
        ("K_hold", "E R³"),
        "Kinetic energy per grain at the end of the hold.",
    ),
    Quantity::new(
        "largest_overlap",
        ("δ_max", "R"),
        "Largest overlap of two spheres in the whole run.",
    ),
    Quantity::new(
        "time_step",
        ("Δt", "t_c"),
        "Time step taken: the one asked for, shortened so that every sample falls on a step.",
    ),
    Quantity::new(
        "critical_time_step",
        ("Δt_crit", "t_c"),
        "Smallest critical time step measured in the run: below it no motion grew.",
    ),
    Quantity::new(
        "critical_time_step_error",
        ("δΔt_crit", "t_c"),
        "How much larger the critical time step can be at most.",
    ),
    Quantity::new(
        "sound_period",
        ("T_s", "t_c"),
        "Time of a swing of the longest sound that the walls can stir in the trained pack.",
    ),
    Quantity::new(
        "sound_decay_time",
        ("τ_s", "t_c"),
        "Time in which the energy of that sound falls to 1/e, drag included; a ramp of less than seven times that is warned about.",
    ),
    Quantity::new(
        "volume_fraction",
        ("φ", ""),
        "Volume fraction before the compression that encodes.",
    ),
    Quantity::new(
        "coordination_number",
        ("Z", ""),
        "Grains that touch a grain, on average, before the compression that encodes.",
    ),
    Quantity::new(
        "sphere_contacts_per_grain",
        ("Z_s", ""),
        "Touching pairs of spheres, each counted once, over the grains, before the compression that encodes.",
    ),
    Quantity::new(
        "wall_contacts_per_grain",
        ("Z_w", ""),
        "Spheres that touch a wall, over the grains, before the compression that encodes.",
    ),
    Quantity::new(
        "kinetic_energy",
        ("K", "E R³"),
        "Kinetic energy per grain before the compression that encodes.",
    ),
    Quantity::new(
        "volume_fraction_compressed",
        ("φ*", ""),
        "Volume fraction at full compression.",
    ),
    Quantity::new(
        "coordination_number_compressed",
        ("Z*", ""),
        "Grains that touch a grain, on average, at full compression.",
    ),
    Quantity::new(
        "sphere_contacts_per_grain_compressed",
        ("Z_s*", ""),
        "Touching pairs of spheres, each counted once, over the grains, at full compression.",
    ),
    Quantity::new(
        "wall_contacts_per_grain_compressed",
        ("Z_w*", ""),
        "Spheres that touch a wall, over the grains, at full compression.",
    ),
    Quantity::new(
        "kinetic_energy_compressed",
        ("K*", "E R³"),
        "Kinetic energy per grain at full compression.",
    ),
];
