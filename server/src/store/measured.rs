//! Points as the first rows of a chain of reductions: what a beam's stages measured, one row a point.

use std::collections::BTreeMap;

use granary_api::job::JobState;
use granary_api::table::{Scalar, SetRow};
use granary_core::beam::results::MEANS;

use super::point::read_or_default;
use super::sweep::SweepPlan;
use super::{Store, StoreError};

/// A point: parameters, state, results.
type Row = (String, String, Option<String>);

impl Store {
    /// Every point of a beam's sweep, with the results that means are taken of; all `null` until it is done.
    pub(super) async fn measured(&self, plan: &SweepPlan) -> Result<Vec<SetRow>, StoreError> {
        const ROWS: &str = "
            select p.parameters, j.state, o.results
              from point p join job j on j.id = p.job left join outcome o on o.job = j.id
             where p.sweep = $1 order by p.point";
        let rows = sqlx::query_as(ROWS).bind(plan.id);
        let rows: Vec<Row> = rows.fetch_all(self.readers()).await?;
        rows.into_iter().map(measured).collect()
    }
}

fn measured((parameters, state, results): Row) -> Result<SetRow, StoreError> {
    let measured: BTreeMap<String, Scalar> = read_or_default(results.as_deref(), "result")?;
    let number = |name: &str| measured.get(name)?.number();
    let open = state.parse().is_ok_and(|state: JobState| !state.is_final());
    let done = results.is_some();
    Ok(SetRow {
        set: 0,
        reduce: "point".to_owned(),
        processing: None,
        shape: None,
        setting: None,
        verdict: None,
        parameters: serde_json::from_str(&parameters).map_err(StoreError::corrupt("point"))?,
        results: MEANS
            .iter()
            .map(|name| ((*name).to_owned(), number(name)))
            .collect(),
        n: u64::from(done),
        of: 1,
        provisional: open,
        missing_reason: match (done, open) {
            (true, _) => reasons(&measured),
            (false, true) => Some("not done yet".to_owned()),
            (false, false) => Some(format!("the point is {state}")),
        },
        warning: None,
        confused: vec![],
    })
}

/// Every number that is missing, with its reason.
fn reasons(measured: &BTreeMap<String, Scalar>) -> Option<String> {
    let reason = |(name, scalar): (&String, &Scalar)| match scalar {
        Scalar::Word(word) => Some(format!("{}: {word}", name.trim_end_matches("_reason"))),
        _ => None,
    };
    let reasons: Vec<String> = measured.iter().filter_map(reason).collect();
    (!reasons.is_empty()).then(|| reasons.join(", "))
}
