//! The training of a classifier: epochs of shuffled batches, then its accuracy on signals that it never learned from.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::network::{Network, Workspace};
use super::signals::Signals;
use super::{BATCH, ClassifierSpec, HIDDEN};
use crate::crew;
use crate::memory::waveform::SAMPLES;
use crate::outcome::{Outcome, Progress, STATE, StageFailure};
use crate::physics;
use crate::state_file::{Reader, Writer};

/// Signals that are classified together.
pub(crate) const LOOKED_AT: usize = 256;

/// Signals that one thread makes at a time.
const MADE: usize = 8;

/// Steps from one report to the next: 0.1 s.
const REPORT_EVERY: u64 = 50;

/// Below this share of the validation's signals the network has not learned its words (App. C: "greater than 99.9 %").
const LEARNED: f64 = 0.999;

/// What a checkpoint of a training, or the network that it leads to, says besides the weights.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Header {
    stage: String,
    step: u64,
    bits: u32,
    /// Sum of the losses of the epoch so far.
    loss: f64,
    /// Of the validation, once it has begun.
    correct: u64,
}

/// A training under way.
struct Run<'a> {
    spec: &'a ClassifierSpec,
    signals: Signals<'a>,
    header: Header,
    network: Network,
    workspace: Workspace,
    batch: Vec<f32>,
}

/// Trains a classifier, or goes on from a checkpoint.
pub(crate) fn run(
    spec: &ClassifierSpec,
    stage: &str,
    checkpoint: Option<&[u8]>,
    progress: &mut Progress<'_>,
) -> Result<Outcome, StageFailure> {
    let input = |detail: String| StageFailure::Input { detail };
    spec.check().map_err(input)?;
    let (header, network) = match checkpoint {
        None => {
            let header = Header {
                stage: stage.to_owned(),
                step: 0,
                bits: spec.bits,
                loss: 0.0,
                correct: 0,
            };
            (
                header,
                Network::new(spec.classifier_seed, spec.words() as usize),
            )
        }
        Some(bytes) => read(bytes)
            .and_then(|(header, network)| {
                if header.stage == stage {
                    return Ok((header, network));
                }
                Err(format!("it belongs to {}, not to {stage}", header.stage))
            })
            .map_err(|detail| input(format!("checkpoint: {detail}")))?,
    };
    let mut run = Run {
        spec,
        signals: Signals::new(spec),
        header,
        workspace: network.workspace(LOOKED_AT),
        network,
        batch: vec![0.0; LOOKED_AT * SAMPLES],
    };
    let (training, validation) = run.signals.split();
    run.learn(&training, progress)?;
    run.validate(&validation, progress)?;
    Ok(run.outcome(training.len(), validation.len()))
}

/// The threads that a training is worth, in rows of grains as [`crew::helped`] counts: one for each block of a hidden layer.
pub(crate) const ROWS: usize = HIDDEN;

impl Run<'_> {
    fn learn(&mut self, training: &[u32], progress: &mut Progress<'_>) -> Result<(), StageFailure> {
        let batches = self.spec.batches();
        let end = u64::from(self.spec.epochs) * batches;
        let rate = self.spec.learning_rate as f32;
        let mut order = vec![];
        while self.header.step < end {
            let (epoch, batch) = (self.header.step / batches, self.header.step % batches);
            if order.is_empty() || batch == 0 {
                order = self.signals.order(training, epoch);
            }
            if batch == 0 {
                self.header.loss = 0.0;
            }
            self.report(progress)?;
            let first = batch as usize * BATCH;
            let numbers = &order[first..first + BATCH];
            self.fill(numbers);
            let words: Vec<usize> = numbers.iter().map(|&n| self.signals.word(n)).collect();
            let signals = &self.batch[..numbers.len() * SAMPLES];
            self.header.loss += self
                .network
                .learn(signals, &words, rate, &mut self.workspace);
            self.header.step += 1;
        }
        Ok(())
    }

    fn validate(
        &mut self,
        validation: &[u32],
        progress: &mut Progress<'_>,
    ) -> Result<(), StageFailure> {
        let learned = u64::from(self.spec.epochs) * self.spec.batches();
        let done = (self.header.step - learned) as usize;
        for numbers in validation.chunks(LOOKED_AT).skip(done) {
            self.report(progress)?;
            self.fill(numbers);
            let taken_for = self.network.words(&self.batch[..numbers.len() * SAMPLES]);
            let right = numbers
                .iter()
                .zip(taken_for)
                .filter(|&(&number, word)| self.signals.word(number) == word as usize);
            self.header.correct += right.count() as u64;
            self.header.step += 1;
        }
        Ok(())
    }

    fn report(&self, progress: &mut Progress<'_>) -> Result<(), StageFailure> {
        if !self.header.step.is_multiple_of(REPORT_EVERY) {
            return Ok(());
        }
        progress.ask(self.header.step, &|| {
            vec![written(&self.header, &self.network)]
        })
    }

    /// Makes the signals of these numbers.
    fn fill(&mut self, numbers: &[u32]) {
        let chunks = self.batch.chunks_mut(MADE * SAMPLES);
        let mut parts: Vec<_> = chunks.zip(numbers.chunks(MADE)).collect();
        let signals = &self.signals;
        crew::each(&mut parts, &|(batch, numbers)| {
            for (signal, &number) in batch.chunks_mut(SAMPLES).zip(*numbers) {
                signals.write(number, signal);
            }
        });
    }

    fn outcome(&self, training: usize, validation: usize) -> Outcome {
        let accuracy = self.header.correct as f64 / validation as f64;
        let results = [
            ("validation_accuracy", accuracy),
            ("validation_signals", validation as f64),
            ("training_signals", training as f64),
            (
                "training_loss",
                self.header.loss / (self.spec.batches() * BATCH as u64) as f64,
            ),
        ];
        let results: BTreeMap<String, Option<f64>> = results
            .into_iter()
            .map(|(name, value)| (name.to_owned(), value.is_finite().then_some(value)))
            .collect();
        let warning = (accuracy < LEARNED).then(|| {
            format!(
                "the classifier tells only {:.2} % of its validation's signals: it has not learned its words, and what it says of \
                 recalled ones is too low; more epochs or transformations may help",
                100.0 * accuracy
            )
        });
        let state = written(&self.header, &self.network);
        Outcome {
            results,
            reasons: BTreeMap::new(),
            artifacts: [(STATE.to_owned(), state)].into(),
            warnings: warning.into_iter().collect(),
            steps: self.header.step,
        }
    }
}

fn written(header: &Header, network: &Network) -> Vec<u8> {
    let mut writer = Writer::new(physics::CLASSIFIER, header);
    for numbers in network.numbers() {
        writer.singles(numbers);
    }
    writer.into_bytes()
}

fn read(bytes: &[u8]) -> Result<(Header, Network), String> {
    let (header, mut reader): (Header, _) = Reader::new(physics::CLASSIFIER, bytes)?;
    if !super::BITS.contains(&header.bits) {
        return Err(format!(
            "there is no network for words of {} bits",
            header.bits
        ));
    }
    let network = Network::from_numbers(1 << header.bits, |n| reader.many_singles(n))?;
    reader.end()?;
    Ok((header, network))
}

/// The network in the state that a training left.
///
/// # Errors
/// Why it is none, in words.
pub fn network_of(state: &[u8]) -> Result<Network, String> {
    read(state).map(|(_, network)| network)
}
