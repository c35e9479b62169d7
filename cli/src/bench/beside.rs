//! LAMMPS and the engine in turn, so that what else the machine does falls on both alike.

use serde_json::{Value, json};

use super::lammps::Lammps;
use super::{Job, Timed, figures, time_all};

/// Times each of the two `repeats` times; the engine's own figures are those of all its runs together.
///
/// # Errors
/// If LAMMPS does not do its work, or the engine cannot do what is asked for.
pub(super) async fn time(job: &Job, lammps: &Lammps, repeats: u8) -> anyhow::Result<Value> {
    let prepared = lammps.prepare(&job.pack, &job.settings, job.limit)?;
    let (mut timed, mut lammps_rates) = (vec![], vec![]);
    for _ in 0..repeats {
        lammps_rates.push(prepared.run().await?);
        timed.extend(time_all(job, 1, 1)?);
    }
    let rates: Vec<f64> = timed.iter().map(rate).collect();
    let pairs = rates.iter().zip(&lammps_rates);
    let ratios: Vec<f64> = pairs.map(|(engine, lammps)| engine / lammps).collect();
    let mut figures = figures(&[together(&timed)], job);
    figures["repeats"] = json!(repeats);
    figures["median_grain_steps_per_cpu_second"] = json!(median(&rates));
    figures["lammps_median_grain_steps_per_cpu_second"] = json!(median(&lammps_rates));
    figures["median_ratio"] = json!(median(&ratios));
    figures["ratios"] = json!(ratios);
    figures["lammps_steps"] = json!(prepared.steps());
    figures["lammps_version"] = json!(lammps.version());
    Ok(figures)
}

/// Grain-steps per CPU second, over all lanes.
fn rate(timed: &Timed) -> f64 {
    let grains = timed.size.grains * timed.size.lanes;
    grains as f64 * timed.steps as f64 / timed.cpu.as_secs_f64()
}

/// Runs of one scene, one after the other, as one long run.
fn together(timed: &[Timed]) -> Timed {
    let mut size = timed[0].size;
    size.renewals = timed.iter().map(|timed| timed.size.renewals).sum();
    Timed {
        size,
        steps: timed.iter().map(|timed| timed.steps).sum(),
        wall: timed.iter().map(|timed| timed.wall).sum(),
        cpu: timed.iter().map(|timed| timed.cpu).sum(),
    }
}

/// The middle value, or the mean of the middle two.
fn median(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let half = sorted.len() / 2;
    if sorted.len() % 2 == 1 {
        sorted[half]
    } else {
        0.5 * (sorted[half - 1] + sorted[half])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn median_is_the_middle_or_the_mean_of_the_middle_two() {
        assert!((median(&[3.0, 9.0, 1.0]) - 3.0).abs() < 1e-15);
        assert!((median(&[4.0, 9.0, 1.0, 2.0]) - 3.0).abs() < 1e-15);
        assert!((median(&[7.0]) - 7.0).abs() < 1e-15);
    }
}
