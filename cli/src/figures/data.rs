//! What a figure is drawn from: the rows of its sweep, and the records of its bendings.

use std::collections::BTreeMap;

use anyhow::Context;
use granary_api::id::SweepId;
use granary_api::job::JobState;
use granary_api::table::{PointRow, Scalar, SetRow};
use granary_core::memory::score::Signal;
use granary_core::outcome::{GRAINS_DUMP, HISTORY, SIGNAL, STRUCTURE};
use serde::Deserialize;
use serde::de::DeserializeOwned;
use serde_json::Value;

use super::catalog::{Figure, Needs};
use super::drawing::Tile;
use super::grains::{self, Grain};
use crate::api_client::ApiClient;

/// What is drawn of the record of a bending; SI units.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default)]
pub(crate) struct History {
    pub(crate) rod_travel: Vec<f64>,
    pub(crate) strain: Vec<f64>,
    pub(crate) stress: Vec<f64>,
    pub(crate) volume_fraction: Vec<f64>,
    pub(crate) mean_contact_force: Vec<f64>,
    pub(crate) mean_normal_force: Vec<f64>,
    pub(crate) mean_tangential_force: Vec<f64>,
    pub(crate) coulomb_fraction: Vec<Option<f64>>,
}

/// What is drawn of the inside of a beam; SI units.
#[derive(Clone, Debug, Default, Deserialize)]
pub(crate) struct Structure {
    pub(crate) mean_diameter: Option<f64>,
    pub(crate) snapshots: Vec<Snapshot>,
    pub(crate) changes: Vec<Change>,
    pub(crate) by_stress: ByStress,
}

/// One snapshot.
#[derive(Clone, Debug, Deserialize)]
pub(crate) struct Snapshot {
    pub(crate) pair_correlation: Option<PairCorrelation>,
}

/// g(r) by Eq. (1).
#[derive(Clone, Debug, Deserialize)]
pub(crate) struct PairCorrelation {
    pub(crate) distances: Vec<f64>,
    pub(crate) paper: All<Vec<f64>>,
}

/// A value over all grains.
#[derive(Clone, Debug, Deserialize)]
pub(crate) struct All<T> {
    pub(crate) all: Option<T>,
}

/// What has changed from one snapshot to the next.
#[derive(Clone, Debug, Deserialize)]
pub(crate) struct Change {
    pub(crate) stress: f64,
    pub(crate) non_affine: All<f64>,
    pub(crate) height_profile: Vec<HeightBin>,
    pub(crate) autocorrelation: Option<Autocorrelation>,
    pub(crate) displacement: Option<Field>,
}

/// A height of the profile of D_min.
#[derive(Clone, Debug, Deserialize)]
pub(crate) struct HeightBin {
    pub(crate) height: f64,
    pub(crate) count: usize,
}

/// The distances at which D_min is compared.
#[derive(Clone, Debug, Deserialize)]
pub(crate) struct Autocorrelation {
    pub(crate) distances: Vec<f64>,
}

/// A displacement on a grid: node (i, 0, k) is `values[k n_x + i]`.
#[derive(Clone, Debug, Deserialize)]
pub(crate) struct Field {
    pub(crate) low: [f64; 3],
    pub(crate) spacing: [f64; 3],
    pub(crate) count: [usize; 3],
    pub(crate) values: Vec<Option<[f64; 3]>>,
}

/// Averages over intervals of stress.
#[derive(Clone, Debug, Default, Deserialize)]
pub(crate) struct ByStress {
    pub(crate) height_profile: Vec<StressBin>,
    pub(crate) autocorrelation: Vec<StressBin>,
}

/// One interval of 25 kPa.
#[derive(Clone, Debug, Deserialize)]
pub(crate) struct StressBin {
    pub(crate) from: f64,
    pub(crate) mean: Vec<Option<f64>>,
}

/// Everything that a figure may show.
#[derive(Debug, Default)]
pub(crate) struct Data {
    pub(crate) points: Vec<PointRow>,
    pub(crate) sets: Vec<SetRow>,
    /// By point.
    pub(crate) histories: BTreeMap<u64, History>,
    /// By point.
    pub(crate) structures: BTreeMap<u64, Structure>,
    /// Snapshots by point.
    pub(crate) grains: BTreeMap<u64, Vec<Vec<Grain>>>,
    /// Raw signals by point.
    pub(crate) signals: BTreeMap<u64, Signal>,
    /// Records of recalls by point.
    pub(crate) recalls: BTreeMap<u64, Recall>,
}

/// What is drawn of the record of a recall, at 256 values of u from 0 to 1; SI units.
#[derive(Clone, Debug, Default, Deserialize)]
pub(crate) struct Recall {
    /// `encode` and `decode`, and quantities by name.
    pub(crate) series: BTreeMap<String, BTreeMap<String, Vec<f64>>>,
}

impl Data {
    /// Reads what `figure` needs of the sweep, as far as it is there.
    pub(crate) async fn read(
        client: &ApiClient,
        sweep: SweepId,
        figure: &Figure,
    ) -> anyhow::Result<Self> {
        let mut data = Self {
            points: client.rows(sweep, "points", &[]).await?,
            sets: client.rows(sweep, "sets", &[]).await?,
            ..Self::default()
        };
        if figure.needs == Needs::Results {
            return Ok(data);
        }
        for row in &data.points {
            if row.state != JobState::Done {
                continue;
            }
            let artifacts = client.job(row.job).await?.artifacts;
            if figure.needs == Needs::Signals {
                if let Some(hash) = artifacts.get(SIGNAL) {
                    let signal = parse(&client.artifact(*hash).await?, SIGNAL)?;
                    data.signals.insert(row.point, signal);
                }
                if let Some(hash) = artifacts.get(HISTORY) {
                    let recall = parse(&client.artifact(*hash).await?, HISTORY)?;
                    data.recalls.insert(row.point, recall);
                }
                continue;
            }
            if let Some(hash) = artifacts.get(HISTORY) {
                let history = parse(&client.artifact(*hash).await?, HISTORY)?;
                data.histories.insert(row.point, history);
            }
            if let Some(hash) = artifacts.get(STRUCTURE) {
                let structure = parse(&client.artifact(*hash).await?, STRUCTURE)?;
                data.structures.insert(row.point, structure);
            }
            if figure.needs == Needs::Grains
                && let Some(hash) = artifacts.get(GRAINS_DUMP)
            {
                let frames = grains::read(&client.artifact(*hash).await?)?;
                data.grains.insert(row.point, frames);
            }
        }
        Ok(data)
    }

    /// Points with `keep`, grouped by the number called `by`, rising.
    pub(crate) fn by(
        &self,
        by: &str,
        keep: impl Fn(&PointRow) -> bool,
    ) -> Vec<(f64, Vec<&PointRow>)> {
        let mut groups: Vec<(f64, Vec<&PointRow>)> = vec![];
        for row in self.points.iter().filter(|row| keep(row)) {
            let Some(value) = real(row, by) else { continue };
            match groups
                .iter_mut()
                .find(|(known, _)| known.total_cmp(&value).is_eq())
            {
                Some((_, rows)) => rows.push(row),
                None => groups.push((value, vec![row])),
            }
        }
        groups.sort_by(|a, b| a.0.total_cmp(&b.0));
        groups
    }
}

fn parse<T: DeserializeOwned>(bytes: &[u8], name: &str) -> anyhow::Result<T> {
    serde_json::from_slice(bytes)
        .with_context(|| format!("a file `{name}` is not what this release expects"))
}

/// A parameter of a point that is a number.
pub(crate) fn real(row: &PointRow, name: &str) -> Option<f64> {
    row.parameters.get(name).and_then(Value::as_f64)
}

/// Whether a point is of this protocol.
pub(crate) fn is_protocol(row: &PointRow, protocol: &str) -> bool {
    row.parameters.get("protocol").and_then(Value::as_str) == Some(protocol)
}

/// Whether a parameter is this number.
pub(crate) fn is(row: &PointRow, name: &str, value: f64) -> bool {
    real(row, name).is_some_and(|found| found.total_cmp(&value).is_eq())
}

/// A result of a point that is a number.
pub(crate) fn result(row: &PointRow, name: &str) -> Option<f64> {
    row.results.get(name).and_then(Scalar::number)
}

/// The mean of a result over the packings in `rows`, times `scale`.
pub(crate) fn mean(rows: &[&PointRow], name: &str, scale: f64) -> Tile {
    let values: Vec<f64> = rows
        .iter()
        .filter_map(|row| Some(result(row, name)? * scale))
        .collect();
    let n = values.len() as f64;
    let mean = (n > 0.0).then(|| values.iter().sum::<f64>() / n);
    let square = |mean: f64| values.iter().map(|x| (x - mean) * (x - mean)).sum::<f64>();
    let mut reasons: Vec<String> = rows.iter().filter_map(|row| reason(row, name)).collect();
    reasons.dedup();
    Tile {
        value: mean,
        error: mean
            .filter(|_| n > 1.0)
            .map(|mean| (square(mean) / (n - 1.0) / n).sqrt()),
        n: values.len(),
        of: rows.len(),
        reason: reasons.join("; "),
    }
}

/// Why a point has no such number.
fn reason(row: &PointRow, name: &str) -> Option<String> {
    if result(row, name).is_some() {
        return None;
    }
    if let Some(failure) = &row.failure {
        let kind = failure.kind.as_ref().unwrap_or(&failure.reason);
        return Some(format!("failed: {}", kind.replace('_', " ")));
    }
    if row.state != JobState::Done {
        return Some("not done".to_owned());
    }
    match row.results.get(&format!("{name}_reason")) {
        Some(Scalar::Word(word)) => Some(word.replace('_', " ")),
        _ => Some("no number".to_owned()),
    }
}
