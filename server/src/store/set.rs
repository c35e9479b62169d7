//! Sets: the reductions of a sweep over whatever has finished, from the stored signals.

use std::collections::HashMap;
use std::sync::{Mutex, PoisonError};

use granary_api::id::SweepId;
use granary_api::job::JobState;
use granary_api::sweep::Choice;
use granary_api::table::{Page, SetRow};
use granary_core::identity::ArtifactHash;
use granary_core::memory::score::{Dots, Processing, Signal};
use granary_core::stage::StageSpec;
use serde_json::{Map, Value, json};

use super::point::wrong_cursor;
use super::sweep::SweepPlan;
use super::{Store, StoreError};
use crate::reduce::strength::ultimate_strength_fit;
use crate::reduce::study::study;
use crate::reduce::{Member, Scorer, key, length, mean_sem, set_key};
use crate::sweep::reduction::Reduction;
use crate::table::{TableQuery, compare};

/// Rows read at a time.
const CHUNK: i64 = 2000;
/// Dot products kept in memory, about 60 bytes each.
const MOST_DOTS: usize = 250_000;

/// Dot products of recalls that never change: by job and processing.
#[derive(Default)]
pub(super) struct DotsCache(Mutex<HashMap<(i64, Processing), Dots>>);

impl DotsCache {
    fn get(&self, key: (i64, Processing)) -> Option<Dots> {
        self.0
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .get(&key)
            .copied()
    }

    fn put(&self, key: (i64, Processing), dots: Dots) {
        let mut dots_by_job = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if dots_by_job.len() >= MOST_DOTS {
            dots_by_job.clear();
        }
        dots_by_job.insert(key, dots);
    }
}

/// A point's recall: number, parameters, job, state, ensemble, signal, spec (of no use, and empty, before there is a
/// signal), and what stopped it.
pub(super) type Row = (
    i64,
    String,
    i64,
    String,
    i64,
    Option<String>,
    String,
    Option<String>,
);

/// The zero recall of an ensemble.
pub(super) struct Zero {
    pub(super) open: bool,
    artifact: Option<ArtifactHash>,
    /// Read when it is first needed.
    signal: Option<Signal>,
}

impl Zero {
    /// Whether it was recalled.
    pub(super) fn is_there(&self) -> bool {
        self.artifact.is_some()
    }
}

impl Store {
    /// A page of a sweep's sets, in the order of its reductions.
    pub async fn set_list(
        &self,
        sweep: SweepId,
        query: &TableQuery,
    ) -> Result<Page<SetRow>, StoreError> {
        let plan = self.sweep_plan(sweep).await?;
        let mut sets = self.sets(&plan).await?;
        sets.retain(|set| {
            query
                .filters
                .iter()
                .all(|filter| filter.passes(&column(set, &plan, &filter.column)))
        });
        if let Some(sort) = &query.sort {
            sets.sort_by_cached_key(|set| Key(column(set, &plan, &sort.column), sort.descending));
        }
        let total = sets.len() as u64;
        let start = match &query.cursor {
            None => 0,
            Some(cursor) => {
                let last = cursor.parse::<u64>().map_err(|_| wrong_cursor(cursor))?;
                let place = sets.iter().position(|set| set.set == last);
                place.ok_or_else(|| wrong_cursor(cursor))? + 1
            }
        };
        let mut items: Vec<SetRow> = sets
            .into_iter()
            .skip(start)
            .take(query.limit as usize)
            .collect();
        let more = (start + items.len()) < total as usize;
        let next = items
            .last()
            .filter(|_| more)
            .map(|last| last.set.to_string());
        for set in &mut items {
            set.parameters.retain(|name, _| query.shows(name));
            set.results.retain(|name, _| query.shows(name));
        }
        Ok(Page { items, next, total })
    }

    /// Every set, numbered.
    pub(super) async fn sets(&self, plan: &SweepPlan) -> Result<Vec<SetRow>, StoreError> {
        let mut all: Vec<SetRow> = vec![];
        let mut last: Option<Vec<SetRow>> = None;
        for reduction in &plan.reductions {
            let (before, sets) = match (reduction, last.take()) {
                (Reduction::GainFidelity { .. }, before) => {
                    (before, self.scores(plan, reduction).await?)
                }
                (Reduction::Recognition { .. }, before) => {
                    (before, self.recognitions(plan, reduction).await?)
                }
                (other, Some(sets)) => (None, self.reduced(plan, &sets, other).await?),
                (other, None) => {
                    let points = self.measured(plan).await?;
                    (None, self.reduced(plan, &points, other).await?)
                }
            };
            all.extend(sets.iter().cloned());
            // Reductions that see signals stand side by side for what is taken of them.
            last = Some(before.into_iter().flatten().chain(sets).collect());
        }
        for (number, set) in all.iter_mut().enumerate() {
            set.set = number as u64;
            if let Some(choice) = &plan.choice {
                bound(set, choice);
            }
        }
        Ok(all)
    }

    /// A link of the chain that is taken of the rows before it.
    async fn reduced(
        &self,
        plan: &SweepPlan,
        rows: &[SetRow],
        reduction: &Reduction,
    ) -> Result<Vec<SetRow>, StoreError> {
        Ok(match reduction {
            Reduction::UltimateStrengthFit { over } => ultimate_strength_fit(rows, over),
            Reduction::Study { over, settings } => {
                let scored = plan
                    .reductions
                    .iter()
                    .find(|link| link.processing().is_some());
                let (gone, by_length) = match scored {
                    Some(link) => (link.over(), link.by_length()),
                    None => (&[][..], false),
                };
                let of_set = |point: &_| set_key(point, gone, length(point, by_length));
                let costs = self.costs(plan, of_set).await?;
                let cost = |row: &SetRow| {
                    let known = costs.get(&key(&row.parameters, &[]));
                    known.copied().unwrap_or_default()
                };
                study(rows, over, settings, plan.model, cost)
            }
            other => mean_sem(rows, other.over()),
        })
    }

    async fn scores(
        &self,
        plan: &SweepPlan,
        reduction: &Reduction,
    ) -> Result<Vec<SetRow>, StoreError> {
        let processing = reduction.processing().unwrap_or_default();
        let (over, by_length) = (reduction.over(), reduction.by_length());
        let mut zeros = self.zeros(plan).await?;
        let mut scorers: Vec<(Processing, Scorer)> = processing
            .iter()
            .map(|&p| (p, Scorer::new(over, p, by_length)))
            .collect();
        let mut after = -1;
        loop {
            let rows = self.signal_rows(plan, after).await?;
            let Some(last) = rows.last() else {
                return Ok(scorers
                    .into_iter()
                    .flat_map(|(_, scorer)| scorer.finish())
                    .collect());
            };
            after = last.0;
            for row in &rows {
                for (processing, scorer) in &mut scorers {
                    scorer.add(&self.member(plan, row, *processing, &mut zeros).await?);
                }
            }
        }
    }

    /// Points and their recalls, in order, after this number; none at the end.
    pub(super) async fn signal_rows(
        &self,
        plan: &SweepPlan,
        after: i64,
    ) -> Result<Vec<Row>, StoreError> {
        const ROWS: &str = "
            select p.point, p.parameters, j.id, j.state, j.ensemble, o.artifacts ->> 'signal',
                   case when o.artifacts is not null then j.spec else '' end,
                   coalesce(j.failure ->> 'kind', j.failure ->> 'message')
              from point p join job j on j.id = p.job left join outcome o on o.job = j.id
             where p.sweep = $1 and p.point > $2 order by p.point limit $3";
        let rows = sqlx::query_as(ROWS).bind(plan.id).bind(after).bind(CHUNK);
        Ok(rows.fetch_all(self.readers()).await?)
    }

    /// One point as a score sees it.
    async fn member(
        &self,
        plan: &SweepPlan,
        row: &Row,
        processing: Processing,
        zeros: &mut HashMap<i64, Zero>,
    ) -> Result<Member, StoreError> {
        let (_, parameters, id, state, ensemble, signal, spec, failure) = row;
        let parameters: Map<String, Value> =
            serde_json::from_str(parameters).map_err(StoreError::corrupt("point"))?;
        let scale = ["youngs_modulus", "delta0", "gamma0"].map(|name| {
            let value = parameters.get(name).or_else(|| plan.fixed.get(name));
            value.and_then(Value::as_f64).unwrap_or(f64::NAN)
        });
        let done = state.parse() == Ok(JobState::Done);
        let mut open = state.parse().is_ok_and(|state: JobState| !state.is_final());
        if processing.needs_zero() && done {
            open = zeros.get(ensemble).is_none_or(|zero| zero.open);
        }
        let dots = match (self.inner.dots.get((*id, processing)), signal) {
            (Some(dots), _) => Some(dots),
            (None, Some(signal)) => {
                let zero = zeros.get_mut(ensemble).filter(|_| processing.needs_zero());
                self.dots((*id, processing), signal, spec, zero).await?
            }
            (None, None) => None,
        };
        Ok(Member {
            parameters,
            open,
            dots,
            done,
            failure: failure.clone(),
            scale,
        })
    }

    /// The dot products of one recall, if its zero is there.
    async fn dots(
        &self,
        key: (i64, Processing),
        artifact: &str,
        spec: &str,
        zero: Option<&mut Zero>,
    ) -> Result<Option<Dots>, StoreError> {
        let processing = key.1;
        let background = self.background(zero).await?;
        let Ok(artifact) = artifact.parse() else {
            return Ok(None);
        };
        let spec: StageSpec = serde_json::from_str(spec).map_err(StoreError::corrupt("spec"))?;
        let StageSpec::Recall(recall) = spec else {
            return Ok(None);
        };
        let signal = self.signal(&artifact).await?;
        let dots = processing
            .apply(&signal, background)
            .map(|p_sig| Dots::of(&p_sig, &recall.waveform.curve(), signal.resolution));
        if let Some(dots) = dots {
            self.inner.dots.put(key, dots);
        }
        Ok(dots)
    }

    /// The signal of a zero recall, read when it is first needed.
    pub(super) async fn background<'a>(
        &self,
        zero: Option<&'a mut Zero>,
    ) -> Result<Option<&'a Signal>, StoreError> {
        let Some(zero) = zero else {
            return Ok(None);
        };
        if let (None, Some(artifact)) = (&zero.signal, &zero.artifact) {
            zero.signal = Some(self.signal(artifact).await?);
        }
        Ok(zero.signal.as_ref())
    }

    pub(super) async fn signal(&self, artifact: &ArtifactHash) -> Result<Signal, StoreError> {
        let bytes = self.artifact_get(artifact).await?;
        serde_json::from_slice(&bytes).map_err(StoreError::corrupt("signal"))
    }

    /// The zero recalls that a sweep wants, by ensemble.
    pub(super) async fn zeros(&self, plan: &SweepPlan) -> Result<HashMap<i64, Zero>, StoreError> {
        const ZEROS: &str = "
            select j.ensemble, j.state, o.artifacts ->> 'signal'
              from want w join job j on j.id = w.job join ensemble e on e.id = j.ensemble and e.key = j.hash
              left join outcome o on o.job = j.id
             where w.sweep = $1 and e.kind = 'recall'";
        let rows: Vec<(i64, String, Option<String>)> = sqlx::query_as(ZEROS)
            .bind(plan.id)
            .fetch_all(self.readers())
            .await?;
        let zero = |(ensemble, state, signal): (i64, String, Option<String>)| {
            let zero = Zero {
                open: state.parse().is_ok_and(|state: JobState| !state.is_final()),
                artifact: signal.and_then(|hash| hash.parse().ok()),
                signal: None,
            };
            (ensemble, zero)
        };
        Ok(rows.into_iter().map(zero).collect())
    }
}

/// Adds to each result of a set how far the chosen settings may be off, by the worst scene of the pilot.
fn bound(set: &mut SetRow, choice: &Choice) {
    let names: Vec<String> = set.results.keys().cloned().collect();
    for name in names {
        let error = format!("{name}_deviation_bound");
        let bounds = choice
            .evidence
            .iter()
            .filter_map(|row| row.results.get(&error));
        if let Some(worst) = bounds.copied().flatten().reduce(f64::max) {
            set.results.insert(error, Some(worst));
        }
    }
}

/// A set's value in any column.
fn column(set: &SetRow, plan: &SweepPlan, name: &str) -> Value {
    match name {
        "set" => json!(set.set),
        "reduce" => json!(set.reduce),
        "processing" => json!(set.processing),
        "shape" => json!(set.shape),
        "setting" => json!(set.setting),
        "verdict" => json!(set.verdict),
        "n" => json!(set.n),
        "of" => json!(set.of),
        "provisional" => json!(set.provisional),
        name => match set.results.get(name) {
            Some(value) => json!(value),
            None if name == "bits" || plan.axes.iter().any(|axis| axis == name) => {
                set.parameters.get(name).cloned().unwrap_or(Value::Null)
            }
            None => plan.fixed.get(name).cloned().unwrap_or(Value::Null),
        },
    }
}

/// A value to sort by: `null` last, whatever the direction.
struct Key(Value, bool);

impl Ord for Key {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        let nulls = self.0.is_null().cmp(&other.0.is_null());
        let values = compare(&self.0, &other.0).unwrap_or(std::cmp::Ordering::Equal);
        nulls.then(if self.1 { values.reverse() } else { values })
    }
}

impl PartialOrd for Key {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Key {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Key {}
