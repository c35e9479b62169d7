//! Expansion: the points of a plan and the jobs they need, a chunk at a time, in bounded memory.
//!
//! Points that share all stages but the last, as recalls in one trained pack do, are expanded together (a *trunk*),
//! whatever the order of the axes, so that a pack is named once and its recalls stand side by side in the queue.
//! A point keeps the number that the declared order of the axes gives it.

use std::collections::HashSet;

use granary_core::identity::{StageId, canonical_json};
use granary_core::memory::classifier::ClassifierSpec;
use granary_core::model::{Model, ModelPoint};
use granary_core::stage::{StageKind, StageSpec, Work};
use serde_json::Value;

use super::{Axis, Plan};

/// The most different warnings of one sweep.
const MOST_WARNINGS: usize = 20;

/// A stage to be queued.
#[derive(Clone, Debug)]
pub struct NewJob {
    /// Its identity.
    pub id: StageId,
    /// Its spec.
    pub spec: StageSpec,
    /// The ensemble that it runs in.
    pub ensemble: StageId,
}

/// Jobs that run side by side, and what each costs.
#[derive(Clone, Debug)]
pub struct NewEnsemble {
    /// Their common key.
    pub key: StageId,
    /// The kind of stage.
    pub kind: StageKind,
    /// Jobs of one class run at one speed.
    pub class: String,
    /// How many run side by side.
    pub lanes: usize,
    /// The size of one.
    pub work: Work,
}

/// A row of the sweep's table.
#[derive(Clone, Debug)]
pub struct NewPoint {
    /// Its number.
    pub point: u64,
    /// Its last stage.
    pub job: StageId,
    /// The parameters that vary, as JSON.
    pub parameters: String,
}

/// Rows to insert together.
#[derive(Debug, Default)]
pub struct Chunk {
    /// Every ensemble of `jobs`.
    pub ensembles: Vec<NewEnsemble>,
    /// In an order in which each comes after the one it needs.
    pub jobs: Vec<NewJob>,
    /// Their jobs are in this chunk.
    pub points: Vec<NewPoint>,
}

/// The points of a plan that are still to come.
pub struct Expansion<'a> {
    plan: &'a Plan,
    /// The text `"name":value` of every axis where no grid says otherwise.
    columns: Vec<(&'static str, String)>,
    needs_zero: bool,
    grid: usize,
    first_point: u64,
    trunk: u64,
    leaf: u64,
    current: Option<Trunk>,
    /// Points seen so far, kept only if several grids can name one twice.
    seen: Option<HashSet<[u8; 16]>>,
    warnings: Vec<String>,
    /// Classifiers that are to be queued yet.
    classifiers: Vec<ClassifierSpec>,
}

/// Everything that points share which differ in their leaves only.
struct Trunk {
    point: ModelPoint,
    /// The stage before the last.
    needs: StageId,
    ensemble: StageId,
    /// Every stage before the last, for what follows them.
    before: Vec<StageSpec>,
    /// The beginnings that are queued already.
    begun: HashSet<StageId>,
}

impl<'a> Expansion<'a> {
    /// All points of `plan`.
    #[must_use]
    pub fn new(plan: &'a Plan) -> Self {
        let column = |name: &'static str| (name, fragment(name, &plan.fixed[name]));
        Self {
            plan,
            columns: plan.axes().into_iter().map(column).collect(),
            needs_zero: plan.needs_zero(),
            grid: 0,
            first_point: 0,
            trunk: 0,
            leaf: 0,
            current: None,
            seen: (plan.grids.len() > 1).then(HashSet::new),
            warnings: vec![],
            classifiers: plan.classifiers(),
        }
    }

    /// What is allowed but unwise about the points so far.
    #[must_use]
    pub fn into_warnings(self) -> Vec<String> {
        self.warnings
    }

    /// The next rows, about `most` of them; none at the end.
    pub fn next_chunk(&mut self, most: usize) -> Option<Chunk> {
        let mut chunk = Chunk::default();
        for classifier in std::mem::take(&mut self.classifiers) {
            let spec = StageSpec::Classifier(classifier);
            let id = spec.id();
            chunk.ensembles.push(new_ensemble(id, &spec, &[]));
            chunk.jobs.push(NewJob {
                id,
                spec,
                ensemble: id,
            });
        }
        while chunk.jobs.len() < most && self.grid < self.plan.grids.len() {
            self.point(&mut chunk);
            self.advance();
        }
        (!chunk.jobs.is_empty() || self.grid < self.plan.grids.len()).then_some(chunk)
    }

    fn axes(&self) -> &'a [Axis] {
        &self.plan.grids[self.grid]
    }

    /// Adds the point at hand, and the jobs of its trunk if it is the first there.
    fn point(&mut self, chunk: &mut Chunk) {
        let choice = Choice::of(self.plan.model, self.axes(), self.trunk, self.leaf);
        let mut trunk = if let Some(trunk) = self.current.take() {
            trunk
        } else {
            let trunk = self.plant(&choice, chunk);
            self.warn(trunk.narrowed());
            trunk
        };
        let parameters = self.parameters(&choice);
        if self.is_new(&parameters) {
            let mut point = trunk.point.clone();
            choice.set_leaves(self.axes(), &mut point);
            self.warn(point.warnings());
            let (beginning, spec) = point.ends(trunk.needs);
            if let Some(beginning) = beginning {
                trunk.begin(beginning, chunk);
            }
            let id = spec.id();
            chunk.points.push(NewPoint {
                point: self.first_point + choice.number,
                job: id,
                parameters,
            });
            chunk.jobs.push(NewJob {
                id,
                spec,
                ensemble: trunk.ensemble,
            });
        }
        self.current = Some(trunk);
    }

    fn advance(&mut self) {
        self.leaf += 1;
        let size = |leaves| size(self.plan.model, self.axes(), leaves);
        let (leaves, trunks) = (size(true), size(false));
        if self.leaf < leaves {
            return;
        }
        (self.leaf, self.trunk, self.current) = (0, self.trunk + 1, None);
        if self.trunk < trunks {
            return;
        }
        self.first_point += leaves * trunks;
        (self.trunk, self.grid) = (0, self.grid + 1);
    }

    /// Makes the trunk of `choice` and queues its stages but the last, and its zero recall if that is asked for.
    fn plant(&self, choice: &Choice, chunk: &mut Chunk) -> Trunk {
        let mut map = self.plan.fixed.clone();
        for (axis, &index) in self.axes().iter().zip(&choice.indices) {
            map.insert(axis.name.to_owned(), axis.values[index].clone());
        }
        let point = self.plan.model.point(map);
        let point = point.expect("the plan holds every parameter, each checked against the table");
        let stages = point.bare().stages();
        // Each of them is the key of its own ensemble, and names the one before it, so no hash is made twice.
        let named = "a stage names the one before it";
        let mut ids: Vec<StageId> = stages[1..]
            .iter()
            .map(|stage| stage.needs().expect(named))
            .collect();
        let needs = ids[ids.len() - 1];
        let ensemble = stages[stages.len() - 1].id();
        ids.push(ensemble);
        let queued = stages.len() - usize::from(!self.needs_zero);
        for (k, (&id, spec)) in ids.iter().zip(&stages).enumerate() {
            chunk.ensembles.push(new_ensemble(id, spec, &stages[..k]));
            if k < queued {
                chunk.jobs.push(NewJob {
                    id,
                    spec: spec.clone(),
                    ensemble: id,
                });
            }
        }
        Trunk {
            point,
            needs,
            ensemble,
            before: stages[..stages.len() - 1].to_vec(),
            begun: HashSet::new(),
        }
    }

    /// The parameters of a point that vary in the sweep, as JSON in the order of the axes.
    fn parameters(&self, choice: &Choice) -> String {
        let axes = self.axes();
        let mut text = String::from("{");
        for (name, fixed) in &self.columns {
            if text.len() > 1 {
                text.push(',');
            }
            match axes.iter().position(|axis| axis.name == *name) {
                Some(k) => text.push_str(&fragment(name, &axes[k].values[choice.indices[k]])),
                None => text.push_str(fixed),
            }
        }
        text.push('}');
        text
    }

    fn is_new(&mut self, parameters: &str) -> bool {
        let Some(seen) = &mut self.seen else {
            return true;
        };
        let hash = blake3::hash(parameters.as_bytes());
        let mut short = [0; 16];
        short.copy_from_slice(&hash.as_bytes()[..16]);
        seen.insert(short)
    }

    fn warn(&mut self, warnings: impl IntoIterator<Item = String>) {
        for warning in warnings {
            if self.warnings.len() < MOST_WARNINGS && !self.warnings.contains(&warning) {
                self.warnings.push(warning);
            }
        }
    }
}

impl Trunk {
    /// Says so if its ensembles hold fewer replicas than vectors have room for.
    fn narrowed(&self) -> Option<String> {
        let (_, last) = self.point.bare().ends(self.needs);
        let (lanes, most) = (last.lanes(&self.before), last.max_lanes());
        (lanes < most).then(|| {
            format!(
                "{lanes} replicas side by side instead of {most}, which would take more than 10 GiB; recalls take up to {} times as long",
                most / lanes
            )
        })
    }

    /// Queues what some of its last stages share, once.
    fn begin(&mut self, beginning: StageSpec, chunk: &mut Chunk) {
        let id = beginning.id();
        if !self.begun.insert(id) {
            return;
        }
        let ensemble = beginning.ensemble_key();
        chunk
            .ensembles
            .push(new_ensemble(ensemble, &beginning, &self.before));
        chunk.jobs.push(NewJob {
            id,
            spec: beginning,
            ensemble,
        });
    }
}

/// Which value each axis of a grid has at one point.
struct Choice {
    indices: Vec<usize>,
    /// The point's number in the declared order, the last axis fastest.
    number: u64,
}

impl Choice {
    fn of(model: Model, axes: &[Axis], mut trunk: u64, mut leaf: u64) -> Self {
        let mut indices = vec![0; axes.len()];
        for (k, axis) in axes.iter().enumerate().rev() {
            let n = axis.values.len() as u64;
            let part = if is_leaf(model, axis) {
                &mut leaf
            } else {
                &mut trunk
            };
            indices[k] = (*part % n) as usize;
            *part /= n;
        }
        let number = axes.iter().zip(&indices).fold(0, |number, (axis, &index)| {
            number * axis.values.len() as u64 + index as u64
        });
        Self { indices, number }
    }

    /// Gives `point` the values of the axes that are leaves.
    fn set_leaves(&self, axes: &[Axis], point: &mut ModelPoint) {
        for (axis, &index) in axes.iter().zip(&self.indices) {
            point.set_leaf(axis.name, &axis.values[index]);
        }
    }
}

fn is_leaf(model: Model, axis: &Axis) -> bool {
    model.leaves().contains(&axis.name)
}

/// The number of combinations of the axes that are leaves, or of those that are not.
fn size(model: Model, axes: &[Axis], leaves: bool) -> u64 {
    let some = axes.iter().filter(|axis| is_leaf(model, axis) == leaves);
    some.map(|axis| axis.values.len() as u64).product()
}

fn fragment(name: &str, value: &Value) -> String {
    format!("\"{name}\":{}", canonical_json(value))
}

fn new_ensemble(key: StageId, spec: &StageSpec, before: &[StageSpec]) -> NewEnsemble {
    NewEnsemble {
        key,
        kind: spec.kind(),
        class: spec.class(before),
        lanes: spec.lanes(before),
        work: spec.work(before),
    }
}
