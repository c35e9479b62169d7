//! What the stage `bend` yields; `grow` and `jam` yield those of these numbers that they know.

use crate::parameter::Quantity;

pub(super) const BENDING: &[Quantity] = &[
    Quantity::new(
        "beam_stiffness",
        ("E_b", "Pa"),
        "Beam stiffness: slope of stress over strain by least squares up to ε = 0.002, by the dimensions of the mold.",
    ),
    Quantity::new(
        "beam_stiffness_origin",
        ("E_b⁰", "Pa"),
        "Beam stiffness of the line through the origin.",
    ),
    Quantity::new(
        "beam_stiffness_actual",
        ("E_b*", "Pa"),
        "Beam stiffness by the dimensions of the beam as it is when bending begins.",
    ),
    Quantity::new(
        "beam_stiffness_origin_actual",
        ("E_b⁰*", "Pa"),
        "Beam stiffness of the line through the origin, by the dimensions of the beam as it is when bending begins.",
    ),
    Quantity::new(
        "beam_stiffness_intercept",
        ("c", "Pa"),
        "Stress of the fitted line at no strain: play between rods and beam.",
    ),
    Quantity::new(
        "beam_stiffness_r_squared",
        ("R²", ""),
        "How straight the curve is up to ε = 0.002.",
    ),
    Quantity::new(
        "beam_stiffness_residual",
        ("σ_rms", "Pa"),
        "Root mean square distance of the samples from the fitted line.",
    ),
    Quantity::new(
        "beam_stiffness_samples",
        ("n", ""),
        "Samples in the fit of the beam stiffness.",
    ),
    Quantity::new(
        "stiffness_few_points",
        ("few_points", ""),
        "1 if the beam stiffness rests on fewer than 20 samples.",
    ),
    Quantity::new(
        "stiffness_r2_low",
        ("r2_low", ""),
        "1 if R² of the beam stiffness is below 0.98.",
    ),
    Quantity::new(
        "stiffness_ringing",
        ("ringing", ""),
        "1 if rods and supports were out of balance by more than 2 %.",
    ),
    Quantity::new(
        "stiffness_slack",
        ("slack", ""),
        "1 if the intercept is more than a tenth of the stress at ε = 0.002.",
    ),
    Quantity::new(
        "ultimate_strength",
        ("Y_b", "Pa"),
        "Ultimate strength: stress at the least slope, by the dimensions of the mold; null, with a reason, where the beam does not yield.",
    ),
    Quantity::new(
        "ultimate_strength_actual",
        ("Y_b*", "Pa"),
        "Ultimate strength by the dimensions of the beam as it is when bending begins.",
    ),
    Quantity::new(
        "ultimate_strength_spread",
        ("ΔY_b", "Pa"),
        "Half the range of the ultimate strength over four widths of the filter.",
    ),
    Quantity::new(
        "ultimate_strength_lower_bound",
        ("σ_max", "Pa"),
        "Largest stress measured: a bound from below where there is no ultimate strength.",
    ),
    Quantity::new(
        "yield_strain",
        ("ε_Y", ""),
        "Strain at the ultimate strength.",
    ),
    Quantity::new(
        "yield_slope_ratio",
        ("σ'_min/E_b", ""),
        "Least slope over beam stiffness.",
    ),
    Quantity::new("strain_reached", ("ε_max", ""), "Largest strain measured."),
    Quantity::new(
        "imbalance_max",
        ("c₁", ""),
        "Control 1: largest imbalance of rods and supports over the rods' force, from ε = 0.0005 on; below 0.02 inertia plays no part.",
    ),
    Quantity::new("imbalance_mean", ("⟨c₁⟩", ""), "Control 1, its mean."),
    Quantity::new(
        "kinetic_energy_ratio_max",
        ("E_kin/E_el", ""),
        "Control 2: largest kinetic over elastic energy; below 0.0001 bending is quasi-static.",
    ),
    Quantity::new(
        "kinetic_energy_ratio_mean",
        ("⟨E_kin/E_el⟩", ""),
        "Control 2, its mean.",
    ),
    Quantity::new(
        "inertial_number_max",
        ("I", ""),
        "Control 3: largest inertial number; below 0.0001 bending is quasi-static.",
    ),
    Quantity::new("inertial_number_mean", ("⟨I⟩", ""), "Control 3, its mean."),
    Quantity::new(
        "periods",
        ("n_per", ""),
        "Periods of the beam's first mode until ε = 0.002, by the beam stiffness found.",
    ),
    Quantity::new(
        "first_frequency",
        ("f₁", "Hz"),
        "Frequency of the beam's first mode, by the beam stiffness found.",
    ),
    Quantity::new("grains", ("N", ""), "Number of grains."),
    Quantity::new(
        "initial_volume_fraction",
        ("φ_init", ""),
        "Volume fraction once the grains are grown.",
    ),
    Quantity::new(
        "volume_fraction",
        ("φ_bend", ""),
        "Volume fraction when bending begins.",
    ),
    Quantity::new(
        "coordination_number",
        ("z", ""),
        "Grains that touch a grain, on average.",
    ),
    Quantity::new(
        "coordination_number_bulk",
        ("z_bulk", ""),
        "The same of grains farther than two diameters from the membrane.",
    ),
    Quantity::new(
        "coordination_number_without_rattlers",
        ("z_nr", ""),
        "The same without grains that carry no load.",
    ),
    Quantity::new(
        "coordination_number_with_membrane",
        ("z_m", ""),
        "The same, contacts with the membrane counted too.",
    ),
    Quantity::new(
        "rattler_fraction",
        ("f_r", ""),
        "Share of the grains that carry no load.",
    ),
    Quantity::new(
        "coulomb_fraction",
        ("f_C", ""),
        "Share of the contacts at the limit of friction; null without friction.",
    ),
    Quantity::new(
        "mean_contact_force",
        ("⟨F⟩", "N"),
        "Mean force between grains when bending begins.",
    ),
    Quantity::new(
        "mean_normal_force",
        ("⟨F_n⟩", "N"),
        "Mean normal force between grains when bending begins.",
    ),
    Quantity::new(
        "mean_tangential_force",
        ("⟨F_t⟩", "N"),
        "Mean tangential force between grains when bending begins.",
    ),
    Quantity::new(
        "mean_overlap",
        ("⟨ξ⟩", "R"),
        "Mean overlap when bending begins, in smaller radii.",
    ),
    Quantity::new(
        "largest_overlap",
        ("ξ_max", "R"),
        "Largest overlap in the whole run, in smaller radii.",
    ),
    Quantity::new(
        "actual_length",
        ("L*", "m"),
        "Length of the beam when bending begins.",
    ),
    Quantity::new(
        "actual_height",
        ("h*", "m"),
        "Height of the beam when bending begins.",
    ),
    Quantity::new(
        "actual_depth",
        ("d*", "m"),
        "Depth of the beam when bending begins.",
    ),
    Quantity::new(
        "membrane_edge",
        ("a", "m"),
        "Mean edge of the membrane's triangles as built.",
    ),
    Quantity::new(
        "membrane_vertices",
        ("N_v", ""),
        "Vertices of the membrane.",
    ),
    Quantity::new(
        "membrane_triangles",
        ("N_t", ""),
        "Triangles of the membrane.",
    ),
    Quantity::new("time_step", ("Δt", "s"), "Smallest time step taken."),
    Quantity::new(
        "critical_time_step",
        ("Δt_crit", "s"),
        "Smallest critical time step found.",
    ),
    Quantity::new("rod_speed", ("v_rod", "m/s"), "Speed of the rods."),
    Quantity::new(
        "support_reaction_max",
        ("F_s", "N"),
        "Largest reaction of one support.",
    ),
    Quantity::new(
        "unloading_loss",
        ("ΔW/W", ""),
        "Share of the rods' work that the first cycle loses; null without cycles.",
    ),
    Quantity::new(
        "contact_updates",
        ("n_c", ""),
        "Contacts computed, of grains with grains and with the membrane, all steps together.",
    ),
];
