//! What the jobs behind the rows of a study took, preparation apart.

use std::collections::{HashMap, HashSet};

use granary_core::model::Model;
use granary_core::stage::StageKind;
use serde_json::{Map, Value};

use super::sweep::SweepPlan;
use super::{Store, StoreError};
use crate::reduce::study::Cost;

/// A point's parameters, and a job behind it: number, kind and core-seconds.
type Row = (String, i64, String, Option<f64>);

/// What is behind one row so far; every job counts once.
#[derive(Default)]
struct Sum {
    seen: HashSet<i64>,
    preparation: f64,
    run: f64,
    preparation_is_open: bool,
    run_is_open: bool,
}

impl Sum {
    fn add(&mut self, job: i64, is_preparation: bool, seconds: Option<f64>) {
        if !self.seen.insert(job) {
            return;
        }
        let (sum, is_open) = if is_preparation {
            (&mut self.preparation, &mut self.preparation_is_open)
        } else {
            (&mut self.run, &mut self.run_is_open)
        };
        match seconds {
            Some(seconds) => *sum += seconds,
            None => *is_open = true,
        }
    }

    fn cost(&self) -> Cost {
        Cost {
            preparation: (!self.preparation_is_open).then_some(self.preparation),
            run: (!self.run_is_open).then_some(self.run),
        }
    }
}

impl Store {
    /// The costs of the points that differ in `over` only, taken together, by `key_of` their other parameters.
    pub(super) async fn costs(
        &self,
        plan: &SweepPlan,
        key_of: impl Fn(&Map<String, Value>) -> String,
    ) -> Result<HashMap<String, Cost>, StoreError> {
        // Its own job, the two or three stages before it, and the zero waveform that it is compared with; of an ensemble's time
        // each job has its share, and a second attempt may have gone on from a checkpoint, so its time says nothing.
        const ROWS: &str = "
            with behind (parameters, job) as (
                select parameters, job from point where sweep = $1
                union all
                select p.parameters, j.needs from point p join job j on j.id = p.job where p.sweep = $1
                union all
                select p.parameters, b.needs from point p join job j on j.id = p.job join job b on b.id = j.needs
                 where p.sweep = $1
                union all
                select p.parameters, c.needs from point p join job j on j.id = p.job join job b on b.id = j.needs
                  join job c on c.id = b.needs
                 where p.sweep = $1
                union all
                select p.parameters, z.id from point p join job j on j.id = p.job join ensemble e on e.id = j.ensemble
                  join job z on z.hash = e.key join want w on w.job = z.id and w.sweep = p.sweep
                 where p.sweep = $1)
            select behind.parameters, j.id, e.kind,
                   case when j.attempts <= 1 then (o.provenance ->> 'cpu_s') / max(1.0, o.provenance ->> 'lanes') end
              from behind join job j on j.id = behind.job join ensemble e on e.id = j.ensemble
              left join outcome o on o.job = j.id";
        let rows = sqlx::query_as(ROWS).bind(plan.id);
        let rows: Vec<Row> = rows.fetch_all(self.readers()).await?;
        let mut sums: HashMap<String, Sum> = HashMap::new();
        for (parameters, job, kind, seconds) in rows {
            let parameters: Map<String, Value> =
                serde_json::from_str(&parameters).map_err(StoreError::corrupt("point"))?;
            let sum = sums.entry(key_of(&parameters)).or_default();
            sum.add(job, is_preparation(plan.model, &kind), seconds);
        }
        let costs = sums.into_iter();
        Ok(costs.map(|(key, sum)| (key, sum.cost())).collect())
    }
}

/// Whether a stage of this kind makes packings, which settings share unless they change them.
fn is_preparation(model: Model, kind: &str) -> bool {
    let kinds: &[StageKind] = match model {
        Model::Memory => &[StageKind::Pack],
        Model::Beam => &[StageKind::Grow, StageKind::Jam],
    };
    kinds.iter().any(|preparation| preparation.name() == kind)
}
