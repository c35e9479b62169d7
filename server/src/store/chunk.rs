//! Chunks: part of an expansion becomes rows of ensembles, jobs, points and wants.
//!
//! What is known already is looked up by its hash once; everything new is numbered here, before it is inserted,
//! so that no row has to find by hash the rows it names.

use std::collections::hash_map::Entry;
use std::collections::{BTreeMap, HashMap, HashSet};

use granary_api::job::JobState;
use granary_core::identity::{StageId, canonical_json};
use granary_core::stage::StageKind;

use super::bulk::insert_all;
use super::job::{self, NewRow};
use super::{StoreError, Writing, signed};
use crate::queue;
use crate::sweep::expansion::Chunk;

/// Where the rows of one sweep go.
pub(super) struct Rows {
    sweep: i64,
    /// The number of the next new ensemble.
    ensemble: i64,
    /// The number of the next new job.
    job: i64,
    /// Jobs that were not known before.
    pub(super) new: u64,
}

/// How many points a job serves, and which is the first.
#[derive(Default)]
struct Want {
    points: u64,
    first: Option<u64>,
}

type Jobs = HashMap<StageId, (i64, JobState)>;

impl Rows {
    /// For the rows of `sweep`; nobody else inserts any while the transaction is open.
    pub(super) async fn begin(transaction: &mut Writing, sweep: i64) -> Result<Self, StoreError> {
        const NEXT: &str = "
            select (select coalesce(max(id), 0) + 1 from ensemble), (select coalesce(max(id), 0) + 1 from job)";
        let (ensemble, job) = sqlx::query_as(NEXT).fetch_one(&mut **transaction).await?;
        Ok(Self {
            sweep,
            ensemble,
            job,
            new: 0,
        })
    }

    /// Inserts what is new of a chunk, and notes what of it the sweep wants.
    pub(super) async fn insert(
        &mut self,
        transaction: &mut Writing,
        chunk: &Chunk,
    ) -> Result<(), StoreError> {
        let ensembles = self.ensembles(transaction, chunk).await?;
        let jobs = self.jobs(transaction, chunk, &ensembles).await?;
        self.wants(transaction, chunk, &jobs).await?;
        self.points(transaction, chunk, &jobs).await
    }

    /// The numbers of all ensembles that the chunk names.
    async fn ensembles(
        &mut self,
        transaction: &mut Writing,
        chunk: &Chunk,
    ) -> Result<HashMap<StageId, i64>, StoreError> {
        const KNOWN: &str = "
            select v.key, e.id from json_each($1) v join ensemble e on e.key = unhex(v.value)";
        const ADD: &str = "insert into ensemble (id, key, kind, class, lanes, steps, grain_steps, bytes, physics) ";
        let named: HashSet<StageId> = chunk.jobs.iter().map(|job| job.ensemble).collect();
        let named: Vec<StageId> = named.into_iter().collect();
        let known: Vec<(i64, i64)> = sqlx::query_as(KNOWN)
            .bind(hashes(&named))
            .fetch_all(&mut **transaction)
            .await?;
        let known = known.into_iter().map(|(k, id)| (named[k as usize], id));
        let mut ids: HashMap<StageId, i64> = known.collect();
        let mut rows = vec![];
        for new in &chunk.ensembles {
            if let Entry::Vacant(place) = ids.entry(new.key) {
                rows.push((self.ensemble, new));
                place.insert(self.ensemble);
                self.ensemble += 1;
            }
        }
        insert_all(transaction, (ADD, ""), &rows, |row, (id, new)| {
            row.push_bind(*id).push_bind(&new.key.as_bytes()[..]);
            row.push_bind(new.kind.name()).push_bind(new.class.as_str());
            row.push_bind(signed(new.lanes as u64))
                .push_bind(signed(new.work.steps));
            row.push_bind(signed(new.work.grain_steps));
            row.push_bind(signed(new.work.bytes))
                .push_bind(new.kind.physics());
        })
        .await?;
        Ok(ids)
    }

    /// The numbers and states of all jobs of the chunk.
    async fn jobs(
        &mut self,
        transaction: &mut Writing,
        chunk: &Chunk,
        ensembles: &HashMap<StageId, i64>,
    ) -> Result<Jobs, StoreError> {
        const KNOWN: &str = "
            select v.key, j.id, j.state from json_each($1) v join job j on j.hash = unhex(v.value)";
        // A trunk may have begun in an earlier chunk: then what its recalls need is there, and not in this one.
        let needed = chunk.jobs.iter().filter_map(|job| job.spec.needs());
        let named: HashSet<StageId> = chunk.jobs.iter().map(|job| job.id).chain(needed).collect();
        let named: Vec<StageId> = named.into_iter().collect();
        let known: Vec<(i64, i64, String)> = sqlx::query_as(KNOWN)
            .bind(hashes(&named))
            .fetch_all(&mut **transaction)
            .await?;
        let mut jobs = Jobs::with_capacity(named.len());
        for (k, id, state) in known {
            let state = state.parse();
            let state =
                state.map_err(|_| StoreError::NotFound("such state of a job".to_owned()))?;
            jobs.insert(named[k as usize], (id, state));
        }
        let mut rows = vec![];
        // Packs before trains before recalls: whoever takes the first jobs makes the most others ready.
        let by_kind = StageKind::ALL.into_iter().flat_map(|kind| {
            let of_kind = chunk.jobs.iter();
            of_kind.filter(move |job| job.spec.kind() == kind)
        });
        for new in by_kind {
            if jobs.contains_key(&new.id) {
                continue;
            }
            let needs = new.spec.needs().map(|id| jobs[&id]);
            let row = NewRow {
                id: self.job,
                hash: new.id,
                ensemble: ensembles[&new.ensemble],
                needs: needs.map(|(id, _)| id),
                state: queue::first_state(needs.map(|(_, state)| state)),
                spec: canonical_json(&new.spec),
            };
            jobs.insert(new.id, (row.id, row.state));
            rows.push(row);
            self.job += 1;
            self.new += 1;
        }
        job::job_add(transaction, &rows).await?;
        Ok(jobs)
    }

    /// Notes that the sweep wants every job of the chunk, and for how many of its points.
    async fn wants(
        &self,
        transaction: &mut Writing,
        chunk: &Chunk,
        jobs: &Jobs,
    ) -> Result<(), StoreError> {
        const WANT: &str = "insert into want (job, sweep, state, points, first_point) ";
        const AGAIN: &str = "
            on conflict (job, sweep) do update
               set points = points + excluded.points,
                   first_point = coalesce(min(first_point, excluded.first_point), first_point, excluded.first_point)
             where excluded.points > 0";
        let mut wants: BTreeMap<i64, (JobState, Want)> = BTreeMap::new();
        for new in &chunk.jobs {
            let (id, state) = jobs[&new.id];
            wants.entry(id).or_insert((state, Want::default()));
        }
        for point in &chunk.points {
            let (id, state) = jobs[&point.job];
            let (_, want) = wants.entry(id).or_insert((state, Want::default()));
            want.points += 1;
            want.first = Some(
                want.first
                    .map_or(point.point, |first| first.min(point.point)),
            );
        }
        let rows: Vec<(i64, (JobState, Want))> = wants.into_iter().collect();
        insert_all(
            transaction,
            (WANT, AGAIN),
            &rows,
            |row, (job, (state, want))| {
                row.push_bind(*job)
                    .push_bind(self.sweep)
                    .push_bind(state.name());
                row.push_bind(signed(want.points))
                    .push_bind(want.first.map(signed));
            },
        )
        .await
    }

    async fn points(
        &self,
        transaction: &mut Writing,
        chunk: &Chunk,
        jobs: &Jobs,
    ) -> Result<(), StoreError> {
        const POINTS: &str = "insert into point (sweep, point, job, parameters) ";
        insert_all(transaction, (POINTS, ""), &chunk.points, |row, point| {
            let (job, _) = jobs[&point.job];
            row.push_bind(self.sweep).push_bind(signed(point.point));
            row.push_bind(job).push_bind(point.parameters.as_str());
        })
        .await
    }
}

/// The hashes as a JSON array.
fn hashes(ids: &[StageId]) -> String {
    let mut text = String::with_capacity(67 * ids.len() + 2);
    for id in ids {
        text.push_str(if text.is_empty() { "[\"" } else { "\",\"" });
        text.push_str(&id.to_hex());
    }
    text.push_str(if ids.is_empty() { "[]" } else { "\"]" });
    text
}
