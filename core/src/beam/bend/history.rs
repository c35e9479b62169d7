//! The artifact `history`: everything recorded along the curve of a bending.

use serde::Serialize;

use super::record::Row;
use crate::beam::curve::{ByDimensions, Dimensions, Sample};

/// The curve and all that was recorded along it, column by column; SI units.
#[derive(Serialize)]
pub(super) struct History {
    dimensions: ByDimensions<Dimensions>,
    time: Vec<f64>,
    rod_travel: Vec<f64>,
    force: Vec<f64>,
    support_reaction: Vec<f64>,
    deflection: Vec<f64>,
    strain: Vec<f64>,
    stress: Vec<f64>,
    kinetic_energy: Vec<f64>,
    elastic_energy: Vec<f64>,
    volume_fraction: Vec<f64>,
    coordination_number: Vec<Option<f64>>,
    mean_contact_force: Vec<f64>,
    mean_normal_force: Vec<f64>,
    mean_tangential_force: Vec<f64>,
    coulomb_fraction: Vec<Option<f64>>,
}

impl History {
    /// The columns of these rows, each a sample of the curve.
    pub(super) fn of(
        rows: &[Row],
        samples: &[Sample],
        dimensions: ByDimensions<Dimensions>,
    ) -> Self {
        let column = |value: fn(&Row) -> f64| rows.iter().map(value).collect::<Vec<f64>>();
        let mold = dimensions.nominal;
        Self {
            dimensions,
            time: column(|row| row.time),
            rod_travel: column(|row| row.travel),
            force: column(|row| row.force),
            support_reaction: column(|row| row.reaction),
            deflection: samples.iter().map(|sample| sample.deflection).collect(),
            strain: samples
                .iter()
                .map(|sample| mold.strain(sample.deflection))
                .collect(),
            stress: rows.iter().map(|row| mold.stress(row.force)).collect(),
            kinetic_energy: column(|row| row.kinetic_energy),
            elastic_energy: column(|row| row.elastic_energy),
            volume_fraction: column(|row| row.volume_fraction),
            coordination_number: rows.iter().map(|row| row.coordination_number).collect(),
            mean_contact_force: column(|row| row.mean_force),
            mean_normal_force: column(|row| row.mean_normal_force),
            mean_tangential_force: column(|row| row.mean_tangential_force),
            coulomb_fraction: rows.iter().map(|row| row.coulomb_fraction).collect(),
        }
    }
}
