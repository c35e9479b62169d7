//! Speeds: what the jobs of each class cost on the machines that served this database.

use std::collections::BTreeMap;

use granary_api::sweep::Prediction;
use sqlx::SqliteExecutor;

use super::pace::Taken;
use super::{StoreError, Writing};

/// Speeds remembered per class.
const SAMPLES: i64 = 101;

/// Grain-steps per second of one core, summed over lanes, before anything was measured here:
/// below what the engine reached where it was written (docs/speed.md).
fn default_speed(class: &str) -> f64 {
    let (class, share) = match class.rsplit_once('/') {
        Some((class, "M1")) => (class, 0.9),
        Some((class, "M2")) => (class, 0.5),
        _ => (class, 1.0),
    };
    let speed = match class.split('/').collect::<Vec<_>>()[..] {
        ["recall", "sphere", "f32"] => 1e8,
        ["recall", "sphere", _] => 4e7,
        ["recall", _, "f32"] => 2e7,
        ["recall", ..] => 8e6,
        // 4.3 ms a step for 2,176 neurons.
        ["classifier"] => 5e5,
        [_, "sphere", ..] => 1e7,
        // 2.1 ms a step for 17,000 grains and vertices.
        [_, "beam", ..] => 17e3 / 2.1e-3,
        _ => 4e6,
    };
    share * speed
}

/// Remembers the speed of one finished job.
pub(super) async fn speed_add(
    transaction: &mut Writing,
    class: &str,
    grain_steps_per_second: f64,
) -> Result<(), StoreError> {
    const ADD: &str = "insert into speed (class, grain_steps_per_second) values ($1, $2)";
    const FORGET: &str = "
        delete from speed
         where class = $1 and id <= (select id from speed where class = $1 order by id desc limit 1 offset $2)";
    let added = sqlx::query(ADD).bind(class).bind(grain_steps_per_second);
    added.execute(&mut **transaction).await?;
    let forget = sqlx::query(FORGET).bind(class).bind(SAMPLES);
    forget.execute(&mut **transaction).await?;
    Ok(())
}

/// The median speed of each class that was measured here.
async fn medians<'e>(
    connection: impl SqliteExecutor<'e>,
) -> Result<BTreeMap<String, f64>, StoreError> {
    const ALL: &str =
        "select class, grain_steps_per_second from speed order by class, grain_steps_per_second";
    let rows: Vec<(String, f64)> = sqlx::query_as(ALL).fetch_all(connection).await?;
    let mut by_class: BTreeMap<String, Vec<f64>> = BTreeMap::new();
    for (class, speed) in rows {
        by_class.entry(class).or_default().push(speed);
    }
    let median = |speeds: Vec<f64>| speeds[speeds.len() / 2];
    Ok(by_class
        .into_iter()
        .map(|(class, speeds)| (class, median(speeds)))
        .collect())
}

/// The open jobs of one class: how many, their grain-steps still to do, and the memory of the largest ensemble.
type Open = (String, i64, f64, i64);

async fn open_jobs(
    connection: &mut sqlx::SqliteConnection,
    sweep: i64,
) -> Result<Vec<Open>, StoreError> {
    // Jobs are gathered by ensemble first: sorting numbers is what makes this quick for a large sweep.
    const OPEN: &str = "
        select e.class, sum(u.jobs), total(e.grain_steps * u.undone), max(e.bytes)
          from (select j.ensemble as ensemble, count(*) as jobs,
                       total(1.0 - case when j.steps > 0 then min(1.0, 1.0 * j.step / j.steps) else 0.0 end) as undone
                  from want w join job j on j.id = w.job
                 where w.sweep = $1 and w.state in ('blocked', 'ready', 'leased')
                 group by j.ensemble) u
          join ensemble e on e.id = u.ensemble
         group by e.class";
    let open = sqlx::query_as(OPEN).bind(sweep);
    Ok(open.fetch_all(connection).await?)
}

/// What the jobs of `sweep` that are still open will take.
pub(super) async fn speed_predict(
    connection: &mut sqlx::SqliteConnection,
    sweep: i64,
) -> Result<Prediction, StoreError> {
    let rows = open_jobs(connection, sweep).await?;
    let speeds = medians(&mut *connection).await?;
    let (mut core_seconds, mut memory, mut storage, mut measured) = (0.0, 0, 0, 0);
    for (class, count, grain_steps, bytes) in &rows {
        let speed = speeds.get(class).copied();
        measured += usize::from(speed.is_some());
        core_seconds += grain_steps / speed.unwrap_or_else(|| default_speed(class));
        memory = memory.max(*bytes as u64);
        storage += *count as u64 * stored_bytes(class, *bytes as u64);
    }
    let basis = match measured {
        0 if !rows.is_empty() => "default",
        n if n == rows.len() => "measured",
        _ => "mixed",
    };
    Ok(Prediction {
        core_seconds,
        memory_bytes: memory,
        storage_bytes: storage,
        basis: basis.to_owned(),
    })
}

/// Seconds of one thread that the open jobs of `sweep` will take at the rate at which its latest jobs went.
///
/// A class of which the sweep has finished nothing yet is expected at its predicted speed, times what the other
/// classes took over what was predicted for them.
pub(super) async fn speed_remaining(
    connection: &mut sqlx::SqliteConnection,
    sweep: i64,
    taken: &BTreeMap<String, Taken>,
) -> Result<f64, StoreError> {
    let rows = open_jobs(connection, sweep).await?;
    let medians = medians(&mut *connection).await?;
    let predicted = |class: &str| {
        let median = medians.get(class).copied();
        median.unwrap_or_else(|| default_speed(class))
    };
    let (mut actual, mut expected) = (0.0, 0.0);
    for (class, taken) in taken {
        actual += taken.seconds;
        expected += taken.grain_steps / predicted(class);
    }
    let slowness = if expected > 0.0 {
        actual / expected
    } else {
        1.0
    };
    let seconds = |(class, _, grain_steps, _): &Open| match taken.get(class) {
        Some(taken) => grain_steps * taken.seconds / taken.grain_steps,
        None => grain_steps / predicted(class) * slowness,
    };
    Ok(rows.iter().map(seconds).sum())
}

/// Files that one job leaves: the last stages leave curves, the others a state.
///
/// A state is about as large as the memory of a lone run, which for a beam is a generous guess.
fn stored_bytes(class: &str, memory: u64) -> u64 {
    match class.split('/').collect::<Vec<_>>()[..] {
        ["recall", ..] => 100_000,
        // The weights of words of ten bits.
        ["classifier"] => 10_000_000,
        ["bend", ..] => 1_000_000,
        [_, "beam", ..] => memory / 16,
        _ => memory,
    }
}
