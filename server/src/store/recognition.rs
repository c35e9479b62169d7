//! Recognitions: what trained classifiers say of the recalled signals of a sweep.

use std::collections::HashMap;
use std::panic::resume_unwind;
use std::sync::{Arc, Mutex, PoisonError};

use granary_api::job::JobState;
use granary_api::table::SetRow;
use granary_core::identity::{ArtifactHash, StageId};
use granary_core::memory::classifier::{network_of, recognize};
use granary_core::memory::score::Processing;
use granary_core::memory::waveform::Waveform;
use granary_core::stage::{STATE, StageSpec};
use serde_json::{Map, Value};
use tokio::task::spawn_blocking;

use super::set::{Row, Zero};
use super::sweep::SweepPlan;
use super::{Store, StoreError};
use crate::reduce::recognition::{Answer, Recalled, Validation, recognized};
use crate::reduce::{length, set_key, set_parameters};
use crate::sweep::reduction::{Reduction, bits};

/// Answers kept in memory, of at most 1,024 words each.
const MOST_ANSWERS: usize = 2000;

/// What classifiers said, which never changes: by classifier, processing and the recalls of the set.
#[derive(Default)]
pub(super) struct Answers(Mutex<HashMap<[u8; 32], Answer>>);

impl Answers {
    fn get(&self, key: &[u8; 32]) -> Option<Answer> {
        let answers = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        answers.get(key).cloned()
    }

    fn put(&self, key: [u8; 32], answer: Answer) {
        let mut answers = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if answers.len() >= MOST_ANSWERS {
            answers.clear();
        }
        answers.insert(key, answer);
    }
}

/// The recalls of a set that are there.
struct Set {
    /// L.
    bits: u32,
    recalled: Recalled,
    /// Job, ensemble and signal of each, in the order of the words.
    signals: Vec<(i64, i64, ArtifactHash)>,
}

/// What a signal is compared with.
#[derive(Clone, Copy)]
struct Background {
    open: bool,
    is_there: bool,
}

/// A classifier as far as it is trained.
enum Classifier {
    Trained {
        state: ArtifactHash,
        validation: Validation,
    },
    Not(Answer),
}

impl Store {
    /// The sets of a recognition.
    pub(super) async fn recognitions(
        &self,
        plan: &SweepPlan,
        reduction: &Reduction,
    ) -> Result<Vec<SetRow>, StoreError> {
        let mut classifiers = vec![];
        for spec in reduction.classifiers() {
            let id = StageSpec::Classifier(spec.clone()).id();
            classifiers.push((spec.bits, id, self.classifier(id).await?));
        }
        let mut zeros = self.zeros(plan).await?;
        let mut rows = vec![];
        for &processing in reduction.processing().unwrap_or_default() {
            for set in self.recalled(plan, reduction, processing, &zeros).await? {
                let asked = classifiers.iter().filter(|(bits, ..)| *bits == set.bits);
                let answers = self.answers(&set, processing, asked, &mut zeros).await?;
                rows.push(recognized(&set.recalled, processing, &answers));
            }
        }
        Ok(rows)
    }

    async fn classifier(&self, id: StageId) -> Result<Classifier, StoreError> {
        const FIND: &str = "
            select j.state, coalesce(j.failure ->> 'message', j.failure ->> 'kind'), o.artifacts ->> $2,
                   o.results ->> 'validation_accuracy', o.warnings ->> 0
              from job j left join outcome o on o.job = j.id
             where j.hash = $1";
        type Found = (
            String,
            Option<String>,
            Option<String>,
            Option<f64>,
            Option<String>,
        );
        let found = sqlx::query_as(FIND).bind(&id.as_bytes()[..]).bind(STATE);
        let found: Option<Found> = found.fetch_optional(self.readers()).await?;
        let Some((state, failure, artifact, accuracy, warning)) = found else {
            return Ok(Classifier::Not(Answer::Untrained));
        };
        if let Some(state) = artifact.and_then(|hash| hash.parse().ok()) {
            let accuracy = accuracy.unwrap_or(f64::NAN);
            let validation = Validation { accuracy, warning };
            return Ok(Classifier::Trained { state, validation });
        }
        let open = state.parse().is_ok_and(|state: JobState| !state.is_final());
        let why = || failure.unwrap_or_else(|| "failed or cancelled".to_owned());
        Ok(Classifier::Not(if open {
            Answer::Untrained
        } else {
            Answer::Failed(why())
        }))
    }

    /// The sets with the recalls that are there, in the order in which they first appear.
    async fn recalled(
        &self,
        plan: &SweepPlan,
        reduction: &Reduction,
        processing: Processing,
        zeros: &HashMap<i64, Zero>,
    ) -> Result<Vec<Set>, StoreError> {
        let (over, by_length) = (reduction.over(), reduction.by_length());
        let mut places: HashMap<String, usize> = HashMap::new();
        let mut sets: Vec<Set> = vec![];
        let mut after = -1;
        loop {
            let rows = self.signal_rows(plan, after).await?;
            let Some(last) = rows.last() else {
                return Ok(sets);
            };
            after = last.0;
            for row in &rows {
                let parameters: Map<String, Value> =
                    serde_json::from_str(&row.1).map_err(StoreError::corrupt("point"))?;
                let waveform = parameters
                    .get("waveform")
                    .or_else(|| plan.fixed.get("waveform"));
                let length = length(&parameters, by_length);
                let key = set_key(&parameters, over, length);
                let place = *places.entry(key).or_insert_with(|| {
                    sets.push(Set {
                        bits: bits(waveform).unwrap_or_default(),
                        recalled: Recalled {
                            parameters: set_parameters(&parameters, over, length),
                            ..Recalled::default()
                        },
                        signals: vec![],
                    });
                    sets.len() - 1
                });
                let zero = zeros.get(&row.4);
                let background = Background {
                    open: processing.needs_zero() && zero.is_none_or(|zero| zero.open),
                    is_there: !processing.needs_zero() || zero.is_some_and(Zero::is_there),
                };
                sets[place].add(row, waveform, background);
            }
        }
    }

    /// What each classifier says of a set; nothing yet of one that is not whole.
    async fn answers(
        &self,
        set: &Set,
        processing: Processing,
        classifiers: impl Iterator<Item = &(u32, StageId, Classifier)>,
        zeros: &mut HashMap<i64, Zero>,
    ) -> Result<Vec<Answer>, StoreError> {
        let mut answers = vec![];
        // Read once, when the first classifier needs them.
        let mut signals = None;
        for (_, id, classifier) in classifiers {
            let (state, validation) = match classifier {
                Classifier::Trained { state, validation } if !set.recalled.open => {
                    (state, validation)
                }
                Classifier::Trained { .. } => continue,
                Classifier::Not(answer) => {
                    answers.push(answer.clone());
                    continue;
                }
            };
            let key = set.key(id, processing);
            if let Some(answer) = self.inner.answers.get(&key) {
                answers.push(answer);
                continue;
            }
            let known = match signals.take() {
                Some(known) => known,
                None => Arc::new(self.processed(set, processing, zeros).await?),
            };
            let shared = signals.insert(known).clone();
            let state = self.artifact_get(state).await?;
            let asked = spawn_blocking(move || {
                network_of(&state).map(|network| recognize(&network, &shared))
            });
            let told = asked.await;
            let told = told.unwrap_or_else(|failed| resume_unwind(failed.into_panic()));
            let answer = match told {
                Ok(Some(words)) => Answer::Words(words, validation.clone()),
                Ok(None) => Answer::Silence,
                Err(detail) => Answer::Failed(detail),
            };
            self.inner.answers.put(key, answer.clone());
            answers.push(answer);
        }
        Ok(answers)
    }

    /// The signals of a set, each freed from its background.
    async fn processed(
        &self,
        set: &Set,
        processing: Processing,
        zeros: &mut HashMap<i64, Zero>,
    ) -> Result<Vec<Vec<f64>>, StoreError> {
        let mut signals = vec![];
        for (_, ensemble, artifact) in &set.signals {
            let zero = zeros.get_mut(ensemble).filter(|_| processing.needs_zero());
            let background = self.background(zero).await?;
            let signal = self.signal(artifact).await?;
            let processed = processing.apply(&signal, background);
            signals.push(processed.ok_or_else(|| {
                let name = processing.name();
                StoreError::NotFound(format!("what {name} needs of signal {artifact}"))
            })?);
        }
        Ok(signals)
    }
}

impl Set {
    /// Adds a point.
    fn add(&mut self, row: &Row, waveform: Option<&Value>, background: Background) {
        let (_, _, job, state, ensemble, signal, _, failure) = row;
        let set = &mut self.recalled;
        set.of += 1;
        set.open |= state.parse().is_ok_and(|state: JobState| !state.is_final());
        set.open |= background.open;
        if set.failure.is_none() {
            set.failure.clone_from(failure);
        }
        let signal = signal.as_ref().filter(|_| background.is_there);
        let word = match waveform.map(Waveform::parse) {
            Some(Ok(Waveform::BinaryWord { word, .. })) => Some(word),
            _ => None,
        };
        let found = signal.and_then(|hash| hash.parse().ok()).zip(word);
        if let Some((artifact, word)) = found {
            set.words.push(word);
            self.signals.push((*job, *ensemble, artifact));
        }
    }

    fn key(&self, classifier: &StageId, processing: Processing) -> [u8; 32] {
        let mut hasher = blake3::Hasher::new();
        hasher.update(classifier.as_bytes());
        hasher.update(processing.name().as_bytes());
        for (job, _, _) in &self.signals {
            hasher.update(&job.to_le_bytes());
        }
        *hasher.finalize().as_bytes()
    }
}
