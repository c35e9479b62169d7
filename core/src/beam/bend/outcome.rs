//! What a bending says: the curve, its stiffness and strength, and how far the run can be trusted.

use std::collections::BTreeMap;

use super::history::History;
use super::record::Row;
use super::snapshots::Snapshots;
use super::{Bench, Bending};
use crate::beam::curve::{ByDimensions, Curve, Dimensions, Sample, first_loading};
use crate::beam::hysteresis::unloading_loss;
use crate::beam::probe;
use crate::beam::rig::Friction;
use crate::beam::run::Run;
use crate::beam::stiffness::{ELASTIC_STRAIN, Flag, NoStiffness, Stiffness, beam_stiffness};
use crate::beam::strength::{NoStrength, Reason, Strength, ultimate_strength};
use crate::identity::canonical_json;
use crate::outcome::{HISTORY, Outcome};

/// Strain from which on the beam must be in balance.
const BALANCED_FROM: f64 = 5e-4;
/// Control 1: the largest imbalance of rods and supports.
const LARGEST_IMBALANCE: f64 = 0.02;
/// Control 2: the largest kinetic over elastic energy.
const LARGEST_ENERGY_RATIO: f64 = 1e-4;
/// Control 3: the largest inertial number.
const LARGEST_INERTIAL_NUMBER: f64 = 1e-4;
/// Mean overlap beyond which Hertz's law is out of its range.
const HERTZ_RANGE: f64 = 0.1;

/// Numbers by name, and why some are none.
#[derive(Default)]
struct Table {
    results: BTreeMap<String, Option<f64>>,
    reasons: BTreeMap<String, String>,
}

impl Table {
    fn put(&mut self, name: &str, value: impl Into<Option<f64>>) {
        self.results.insert(name.to_owned(), value.into());
    }

    fn none(&mut self, name: &str, reason: &str) {
        self.put(name, None);
        self.reasons.insert(name.to_owned(), reason.to_owned());
    }
}

pub(super) fn outcome<T: Friction>(
    bench: &Bench<'_>,
    run: &Run<T>,
    (bending, snapshots): (&Bending, &Snapshots),
) -> Outcome {
    let zero = bending.drive.zero().unwrap_or(0.0);
    let rows = bending.record.since_touch(zero);
    let [length, height, depth] = bending.actual;
    let dimensions = ByDimensions {
        nominal: bench.past.grow.dimensions(),
        actual: Dimensions {
            length,
            height,
            depth,
        },
    };
    let samples: Vec<Sample> = rows.iter().map(|row| row.sample(zero)).collect();
    let mut table = Table::default();
    let mut warnings = bench.past.warnings.clone();
    let frequency = controls(bench, rows, &dimensions.nominal, zero, &mut table);
    strengths(&samples, &dimensions, &mut table);
    periods(bench, &samples, &dimensions.nominal, frequency, &mut table);
    table.put("unloading_loss", unloading_loss(&samples));
    coordinations(bending, &mut table);
    state(bench, run, bending, rows, &mut table);
    warn(&table, rows, &mut warnings);
    warnings.extend(run.warnings("in the test"));
    let grow = &bench.past.grow;
    let most = grow.membrane_youngs_modulus * bench.jam.membrane_thickness * grow.depth;
    warnings.extend(overloaded(bending.largest_pull, most));
    let mold = dimensions.nominal;
    let mut artifacts = snapshots.artifacts(run, bench.spec, |time| {
        // The row whose means were being taken; a snapshot needs a row before it, and the test ends with one.
        let row = &rows[rows.partition_point(|row| row.time < time)];
        (mold.strain(zero - row.height), mold.stress(row.force))
    });
    let history = History::of(rows, &samples, dimensions);
    artifacts.insert(HISTORY.to_owned(), canonical_json(&history).into_bytes());
    Outcome {
        results: table.results,
        reasons: table.reasons,
        artifacts,
        warnings,
        steps: run.step,
    }
}

/// Controls 1 to 3; returns the predicted frequency of the first mode, over whose period forces are balanced.
fn controls(
    bench: &Bench<'_>,
    rows: &[Row],
    mold: &Dimensions,
    zero: f64,
    table: &mut Table,
) -> f64 {
    let frequency = bench.jam.prediction(&bench.past.grow).first_frequency();
    let period = 1.0 / frequency;
    let (mut imbalances, mut ratios, mut numbers) = (vec![], vec![], vec![]);
    let mut from = 0;
    for (n, row) in rows.iter().enumerate() {
        while rows[from].time < row.time - period {
            from += 1;
        }
        let strain = mold.strain(zero - row.height);
        if strain >= BALANCED_FROM {
            let window = &rows[from..=n];
            let (force, reaction) = window
                .iter()
                .fold((0.0, 0.0), |(f, r), row| (f + row.force, r + row.reaction));
            imbalances.push(((reaction - force) / force).abs());
            ratios.push(row.kinetic_energy / row.elastic_energy);
        }
        if n > 0 {
            let before = &rows[n - 1];
            let rate = mold.strain(before.height - row.height).abs() / (row.time - before.time);
            let diameter = bench.past.grow.radius_min + bench.past.grow.radius_max;
            let inertia = (bench.past.grow.density / bench.jam.confining_pressure.abs()).sqrt();
            numbers.push(rate * diameter * inertia);
        }
    }
    for (name, values) in [
        ("imbalance", imbalances),
        ("kinetic_energy_ratio", ratios),
        ("inertial_number", numbers),
    ] {
        let finite = || values.iter().copied().filter(|x| x.is_finite());
        let count = finite().count();
        let most = (count > 0).then(|| finite().fold(0.0, f64::max));
        let mean = (count > 0).then(|| finite().sum::<f64>() / count as f64);
        table.put(&format!("{name}_max"), most);
        table.put(&format!("{name}_mean"), mean);
    }
    frequency
}

/// E_b and Y_b by both sets of dimensions.
fn strengths(samples: &[Sample], dimensions: &ByDimensions<Dimensions>, table: &mut Table) {
    let ringing = table.results["imbalance_max"].is_some_and(|most| most > LARGEST_IMBALANCE);
    let curves = dimensions.map(|of| Curve::of(samples, of));
    let elastic = dimensions.map(|of| Curve::of(first_loading(samples), of));
    let stiffness = elastic.map(|curve| beam_stiffness(curve, ringing));
    put_stiffness(&stiffness.nominal, table);
    put_slopes(&stiffness.actual, "_actual", table);
    let strength = curves.map(ultimate_strength);
    put_strength(&strength.nominal, "", table);
    put_strength(&strength.actual, "_actual", table);
    let bound = curves.nominal.points().iter().map(|point| point.stress);
    table.put("ultimate_strength_lower_bound", bound.reduce(f64::max));
    match (&strength.nominal, &stiffness.nominal) {
        (Ok(strength), Ok(stiffness)) => table.put(
            "yield_slope_ratio",
            strength.least_slope / stiffness.beam_stiffness,
        ),
        _ => table.put("yield_slope_ratio", None),
    }
    let most = curves.nominal.points().iter().map(|point| point.strain);
    table.put("strain_reached", most.reduce(f64::max));
}

fn put_slopes(found: &Result<Stiffness, NoStiffness>, suffix: &str, table: &mut Table) {
    let names = ["beam_stiffness", "beam_stiffness_origin"].map(|name| format!("{name}{suffix}"));
    match found {
        Ok(stiffness) => {
            table.put(&names[0], stiffness.beam_stiffness);
            table.put(&names[1], stiffness.through_origin);
        }
        Err(reason) => names
            .iter()
            .for_each(|name| table.none(name, word(*reason))),
    }
}

fn put_stiffness(found: &Result<Stiffness, NoStiffness>, table: &mut Table) {
    put_slopes(found, "", table);
    let stiffness = found.as_ref().ok();
    table.put("beam_stiffness_intercept", stiffness.map(|s| s.intercept));
    table.put(
        "beam_stiffness_r_squared",
        stiffness.and_then(|s| s.r_squared),
    );
    table.put("beam_stiffness_residual", stiffness.map(|s| s.residual_rms));
    table.put(
        "beam_stiffness_samples",
        stiffness.map(|s| s.samples as f64),
    );
    for (name, flag) in [
        ("stiffness_few_points", Flag::FewPoints),
        ("stiffness_r2_low", Flag::R2Low),
        ("stiffness_ringing", Flag::Ringing),
        ("stiffness_slack", Flag::Slack),
    ] {
        table.put(
            name,
            stiffness.map(|s| f64::from(u8::from(s.flags.contains(&flag)))),
        );
    }
}

fn put_strength(found: &Result<Strength, NoStrength>, suffix: &str, table: &mut Table) {
    let name = format!("ultimate_strength{suffix}");
    match found {
        Ok(strength) => table.put(&name, strength.ultimate_strength),
        Err(none) => table.none(&name, reason(none.reason)),
    }
    if suffix.is_empty() {
        let strength = found.as_ref().ok();
        table.put("ultimate_strength_spread", strength.map(|s| s.spread));
        table.put("yield_strain", strength.map(|s| s.strain));
    }
}

fn word(reason: NoStiffness) -> &'static str {
    match reason {
        NoStiffness::NoSamples => "no_samples",
        NoStiffness::OneStrain => "one_strain",
    }
}

fn reason(reason: Reason) -> &'static str {
    match reason {
        Reason::NoInteriorMinimum => "no_interior_minimum",
        Reason::NotProminent => "not_prominent",
        Reason::WidthSensitive => "width_sensitive",
        Reason::RunTooShort => "run_too_short",
    }
}

/// n_per: periods of the first mode, by the E_b found, until the end of the fit's window.
fn periods(
    bench: &Bench<'_>,
    samples: &[Sample],
    mold: &Dimensions,
    predicted: f64,
    table: &mut Table,
) {
    let jam = bench.jam.prediction(&bench.past.grow);
    let scale = table.results["beam_stiffness"]
        .filter(|found| *found > 0.0)
        .map(|found| (found / jam.beam_stiffness()).sqrt());
    let frequency = scale.map(|scale| predicted * scale);
    let time = samples
        .iter()
        .find(|sample| mold.strain(sample.deflection) >= ELASTIC_STRAIN)
        .map(|sample| sample.time - samples[0].time);
    table.put("first_frequency", frequency);
    table.put("periods", frequency.zip(time).map(|(f, t)| f * t));
}

fn state<T: Friction>(
    bench: &Bench<'_>,
    run: &Run<T>,
    bending: &Bending,
    rows: &[Row],
    table: &mut Table,
) {
    let start = rows.first();
    table.put("grains", run.beam.grains.len() as f64);
    let mold = bench.past.grow.dimensions();
    let volume = mold.length * mold.height * mold.depth;
    table.put(
        "initial_volume_fraction",
        probe::grain_volume(&run.beam) / volume,
    );
    table.put("volume_fraction", bending.volume_fraction);
    table.put(
        "coordination_number",
        start.and_then(|row| row.coordination_number),
    );
    table.put(
        "coulomb_fraction",
        start.and_then(|row| row.coulomb_fraction),
    );
    table.put("mean_contact_force", start.map(|row| row.mean_force));
    table.put("mean_normal_force", start.map(|row| row.mean_normal_force));
    table.put(
        "mean_tangential_force",
        start.map(|row| row.mean_tangential_force),
    );
    table.put("mean_overlap", start.map(|row| row.mean_overlap));
    table.put("largest_overlap", run.deepest);
    let [length, height, depth] = bending.actual;
    table.put("actual_length", length);
    table.put("actual_height", height);
    table.put("actual_depth", depth);
    let mesh = run.beam.surroundings.membrane.mesh();
    table.put("membrane_edge", bench.past.grow.membrane_edge);
    table.put("membrane_vertices", mesh.positions().len() as f64);
    table.put("membrane_triangles", mesh.triangles().len() as f64);
    table.put("critical_time_step", run.critical);
    table.put("time_step", bench.spec.time_step_fraction * run.critical);
    table.put("rod_speed", bench.spec.rod_speed);
    let most = rows.iter().map(|row| 0.5 * row.reaction.abs());
    table.put("support_reaction_max", most.reduce(f64::max));
    table.put("contact_updates", run.contact_updates as f64);
}

/// z under its other names, when the rods first touched.
fn coordinations(bending: &Bending, table: &mut Table) {
    let found = bending.coordination;
    for (name, value) in [
        ("bulk", found.and_then(|z| z.bulk)),
        ("without_rattlers", found.and_then(|z| z.without_rattlers)),
        ("with_membrane", found.and_then(|z| z.with_membrane)),
    ] {
        table.put(&format!("coordination_number_{name}"), value);
    }
    table.put("rattler_fraction", found.and_then(|z| z.rattler_fraction));
}

/// What a reader should know before believing a number.
fn warn(table: &Table, rows: &[Row], warnings: &mut Vec<String>) {
    let above = |name: &str, most: f64| table.results[name].filter(|value| *value > most);
    if let Some(value) = above("imbalance_max", LARGEST_IMBALANCE) {
        warnings.push(format!(
            "ringing: rods and supports are out of balance by up to {:.1} %; use more periods",
            100.0 * value
        ));
    }
    if let Some(value) = above("kinetic_energy_ratio_max", LARGEST_ENERGY_RATIO) {
        warnings.push(format!(
            "not quasi-static: kinetic energy is up to {value:.1e} of the elastic energy"
        ));
    }
    if let Some(value) = above("inertial_number_max", LARGEST_INERTIAL_NUMBER) {
        warnings.push(format!(
            "not quasi-static: the inertial number is up to {value:.1e}"
        ));
    }
    let overlap = rows.iter().map(|row| row.mean_overlap).fold(0.0, f64::max);
    if overlap > HERTZ_RANGE {
        warnings.push(format!(
            "hertz_out_of_range: grains overlap by {overlap:.2} of a radius on average"
        ));
    }
}

/// The warning that a support pulls by more than `most`, E_m t_m d, which would stretch a membrane to twice its length.
fn overloaded(pull: f64, most: f64) -> Option<String> {
    (pull > most).then(|| {
        format!(
            "support_overload: a support pulls by {pull:.2e} N, more than E_m t_m d = {most:.2e} N"
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn supports_that_are_torn_at_are_warned_about() {
        assert_eq!(overloaded(10.8, 10.8), None);
        let warning = overloaded(10.9, 10.8).expect("a warning");
        assert!(warning.starts_with("support_overload: a support pulls by 1.09e1 N"));
    }
}
