//! A network of two hidden layers: 256 → 1024 → 1024 → 2^L, ReLU, cross-entropy, stochastic gradient descent (App. C).
//!
//! Matrices of activations hold one signal in each row, those of weights what one neuron reads in each column, column after column.
//! Products are cut into blocks of fixed size, which threads share, so that no number depends on how many there are.

use nalgebra::{Dyn, MatrixView, MatrixViewMut};

use super::HIDDEN;
use crate::crew;
use crate::memory::waveform::SAMPLES;
use crate::random::{self, Purpose};

/// Neurons of a block of a product.
const BLOCK: usize = 256;

/// Products of fewer rows, columns or terms would go another way, which is wrong for matrices that stand as ours do.
const FEWEST: usize = 8;

/// What one layer does to its inputs.
#[derive(Clone, Debug, PartialEq)]
struct Layer {
    inputs: usize,
    outputs: usize,
    weights: Vec<f32>,
    biases: Vec<f32>,
}

/// A network, which tells 2^L words apart.
#[derive(Clone, Debug, PartialEq)]
pub struct Network {
    layers: [Layer; 3],
}

/// The activations of a batch, and what the loss says of each.
pub(crate) struct Workspace {
    /// One row for each signal; those of the last layer become their slopes.
    activations: [Vec<f32>; 3],
    slopes: [Vec<f32>; 2],
}

impl Network {
    /// Weights uniform in ±√(6/inputs), biases zero (He et al. 2015).
    pub(crate) fn new(seed: u64, words: usize) -> Self {
        let mut layer = 0;
        Self {
            layers: sizes(words).map(|(inputs, outputs)| {
                let bound = (6.0 / inputs as f64).sqrt();
                let mut weights = vec![0.0; inputs * outputs];
                random::symmetric(
                    seed,
                    Purpose::ClassifierWeight,
                    layer,
                    bound as f32,
                    &mut weights,
                );
                layer += 1;
                Layer {
                    inputs,
                    outputs,
                    weights,
                    biases: vec![0.0; outputs],
                }
            }),
        }
    }

    /// The words it tells apart.
    #[must_use]
    pub fn size(&self) -> usize {
        self.layers[2].outputs
    }

    /// All weights and biases, layer after layer.
    pub(crate) fn numbers(&self) -> impl Iterator<Item = &[f32]> {
        let layers = self.layers.iter();
        layers.flat_map(|layer| [layer.weights.as_slice(), layer.biases.as_slice()])
    }

    /// The network with these weights and biases.
    pub(crate) fn from_numbers<E>(
        words: usize,
        mut next: impl FnMut(usize) -> Result<Vec<f32>, E>,
    ) -> Result<Self, E> {
        let mut layer = |(inputs, outputs): (usize, usize)| {
            Ok(Layer {
                inputs,
                outputs,
                weights: next(inputs * outputs)?,
                biases: next(outputs)?,
            })
        };
        let [first, second, third] = sizes(words);
        Ok(Self {
            layers: [layer(first)?, layer(second)?, layer(third)?],
        })
    }

    /// Room for so many signals.
    pub(crate) fn workspace(&self, signals: usize) -> Workspace {
        let room = |neurons: usize| vec![0.0; signals * neurons];
        Workspace {
            activations: [room(HIDDEN), room(HIDDEN), room(self.size())],
            slopes: [room(HIDDEN), room(HIDDEN)],
        }
    }

    /// The word that each signal is taken for: that of the largest output, the first of equals.
    #[must_use]
    pub fn words(&self, signals: &[f32]) -> Vec<u32> {
        let asked = signals.len() / SAMPLES;
        // Fewer rows than products are made of: silent ones follow.
        let count = asked.max(FEWEST);
        let mut signals = std::borrow::Cow::Borrowed(signals);
        if asked < count {
            signals.to_mut().resize(count * SAMPLES, 0.0);
        }
        let mut workspace = self.workspace(count);
        self.outputs(&signals, count, &mut workspace);
        let outputs = &workspace.activations[2];
        let word = |signal: usize| {
            let mut best = 0;
            for word in 1..self.size() {
                if outputs[word * count + signal] > outputs[best * count + signal] {
                    best = word;
                }
            }
            best as u32
        };
        (0..asked).map(word).collect()
    }

    fn outputs(&self, signals: &[f32], count: usize, workspace: &mut Workspace) {
        let [first, second, third] = &mut workspace.activations;
        let [one, two, three] = &self.layers;
        // Signals stand one after the other, so each is a row.
        let signals = View {
            numbers: signals,
            rows: count,
            columns: SAMPLES,
            strides: (SAMPLES, 1),
        };
        one.forward(signals, &mut first[..count * HIDDEN], true);
        two.forward(
            View::rows(first, count, HIDDEN),
            &mut second[..count * HIDDEN],
            true,
        );
        let outputs = &mut third[..count * self.size()];
        three.forward(View::rows(second, count, HIDDEN), outputs, false);
    }

    /// A step of gradient descent on these signals; returns the sum of their losses.
    pub(crate) fn learn(
        &mut self,
        signals: &[f32],
        words: &[usize],
        rate: f32,
        workspace: &mut Workspace,
    ) -> f64 {
        let count = words.len();
        self.outputs(signals, count, workspace);
        let Workspace {
            activations: [first, second, third],
            slopes: [slope_one, slope_two],
        } = workspace;
        let [one, two, three] = &mut self.layers;
        let loss = loss(&mut third[..count * three.outputs], words);
        let slope_three = View::rows(third, count, three.outputs);
        three.backward(slope_three, second, &mut slope_two[..count * HIDDEN]);
        let slope_two = View::rows(slope_two, count, HIDDEN);
        two.backward(slope_two, first, &mut slope_one[..count * HIDDEN]);
        let slope_one = View::rows(slope_one, count, HIDDEN);
        let signals = View {
            numbers: signals,
            rows: SAMPLES,
            columns: count,
            strides: (1, SAMPLES),
        };
        let mut updates = one.updates(signals, slope_one);
        updates.extend(two.updates(View::rows(first, count, HIDDEN).transposed(), slope_two));
        updates.extend(three.updates(View::rows(second, count, HIDDEN).transposed(), slope_three));
        crew::each(&mut updates, &|update| update.apply(rate));
        loss
    }
}

fn sizes(words: usize) -> [(usize, usize); 3] {
    [(SAMPLES, HIDDEN), (HIDDEN, HIDDEN), (HIDDEN, words)]
}

/// Turns outputs into the slopes of the mean cross-entropy; returns the sum of the losses.
fn loss(outputs: &mut [f32], words: &[usize]) -> f64 {
    let count = words.len();
    let share = 1.0 / count as f32;
    let mut largest = vec![f32::NEG_INFINITY; count];
    for column in outputs.chunks(count) {
        for (largest, x) in largest.iter_mut().zip(column) {
            *largest = largest.max(*x);
        }
    }
    let mut sums = vec![0.0_f32; count];
    let correct: Vec<f32> = words
        .iter()
        .enumerate()
        .map(|(signal, word)| outputs[word * count + signal])
        .collect();
    for column in outputs.chunks_mut(count) {
        for ((x, largest), sum) in column.iter_mut().zip(&largest).zip(&mut sums) {
            *x = libm::expf(*x - largest);
            *sum += *x;
        }
    }
    for column in outputs.chunks_mut(count) {
        for (x, sum) in column.iter_mut().zip(&sums) {
            *x *= share / sum;
        }
    }
    let mut loss = 0.0;
    for (signal, &word) in words.iter().enumerate() {
        outputs[word * count + signal] -= share;
        loss += f64::from(libm::logf(sums[signal]) + largest[signal] - correct[signal]);
    }
    loss
}

/// Numbers as a matrix, wherever they stand.
#[derive(Clone, Copy)]
struct View<'a> {
    numbers: &'a [f32],
    rows: usize,
    columns: usize,
    /// From row to row, and from column to column.
    strides: (usize, usize),
}

impl<'a> View<'a> {
    /// Columns of so many rows, one after the other.
    fn rows(numbers: &'a [f32], rows: usize, columns: usize) -> Self {
        Self {
            numbers: &numbers[..rows * columns],
            rows,
            columns,
            strides: (1, rows),
        }
    }

    fn transposed(self) -> Self {
        Self {
            rows: self.columns,
            columns: self.rows,
            strides: (self.strides.1, self.strides.0),
            ..self
        }
    }

    fn matrix(self) -> MatrixView<'a, f32, Dyn, Dyn, Dyn, Dyn> {
        MatrixView::from_slice_with_strides_generic(
            self.numbers,
            Dyn(self.rows),
            Dyn(self.columns),
            Dyn(self.strides.0),
            Dyn(self.strides.1),
        )
    }
}

/// `product` = `own` × `product` + `scale` × `a` × `b`, where `product` has so many rows.
fn multiply(product: &mut [f32], rows: usize, own: f32, scale: f32, (a, b): (View<'_>, View<'_>)) {
    let columns = product.len() / rows;
    assert!(
        rows.min(columns).min(a.columns) >= FEWEST,
        "{rows} × {} × {columns}",
        a.columns
    );
    let mut product = MatrixViewMut::from_slice_generic(product, Dyn(rows), Dyn(columns));
    product.gemm(scale, &a.matrix(), &b.matrix(), own);
}

/// A block of a layer that learns.
struct Update<'a> {
    weights: &'a mut [f32],
    biases: &'a mut [f32],
    /// Inputs of all signals, one in each column.
    inputs: View<'a>,
    /// Slopes of the block's outputs, one signal in each row.
    slopes: View<'a>,
}

impl Update<'_> {
    fn apply(&mut self, rate: f32) {
        let rows = self.inputs.rows;
        multiply(self.weights, rows, 1.0, -rate, (self.inputs, self.slopes));
        let columns = self.slopes.numbers.chunks(self.slopes.rows);
        for (bias, slopes) in self.biases.iter_mut().zip(columns) {
            *bias -= rate * slopes.iter().sum::<f32>();
        }
    }
}

impl Layer {
    /// Outputs of all signals.
    fn forward(&self, inputs: View<'_>, outputs: &mut [f32], rectified: bool) {
        let count = inputs.rows;
        let weights = self.weights.chunks(BLOCK * self.inputs);
        let biases = self.biases.chunks(BLOCK);
        let outputs = outputs.chunks_mut(BLOCK * count);
        let mut blocks: Vec<_> = outputs.zip(weights).zip(biases).collect();
        crew::each(&mut blocks, &|((outputs, weights), biases)| {
            let weights = View::rows(weights, self.inputs, biases.len());
            multiply(outputs, count, 0.0, 1.0, (inputs, weights));
            for (column, bias) in outputs.chunks_mut(count).zip(*biases) {
                for x in column {
                    *x += bias;
                    if rectified {
                        *x = x.max(0.0);
                    }
                }
            }
        });
    }

    /// Slopes of the inputs, which are `activations` that were rectified, from those of the outputs.
    fn backward(&self, slopes: View<'_>, activations: &[f32], of_inputs: &mut [f32]) {
        let count = slopes.rows;
        let blocks = of_inputs.chunks_mut(BLOCK * count);
        let mut blocks: Vec<_> = blocks
            .zip(activations.chunks(BLOCK * count))
            .enumerate()
            .collect();
        crew::each(&mut blocks, &|(block, (of_inputs, activations))| {
            let first = *block * BLOCK;
            let weights = View {
                numbers: &self.weights[first..],
                rows: self.outputs,
                columns: of_inputs.len() / count,
                strides: (self.inputs, 1),
            };
            multiply(of_inputs, count, 0.0, 1.0, (slopes, weights));
            for (slope, activation) in of_inputs.iter_mut().zip(*activations) {
                if *activation <= 0.0 {
                    *slope = 0.0;
                }
            }
        });
    }

    /// What is to be learned, block by block, from inputs (a signal in each column) and slopes of outputs (one in each row).
    fn updates<'a>(&'a mut self, inputs: View<'a>, slopes: View<'a>) -> Vec<Update<'a>> {
        let count = slopes.rows;
        let weights = self.weights.chunks_mut(BLOCK * self.inputs);
        let blocks = weights.zip(self.biases.chunks_mut(BLOCK));
        let slopes = slopes.numbers.chunks(BLOCK * count);
        blocks
            .zip(slopes)
            .map(|((weights, biases), slopes)| Update {
                inputs,
                slopes: View::rows(slopes, count, biases.len()),
                weights,
                biases,
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Eight signals of eight words, of no meaning.
    fn some() -> (Vec<f32>, [usize; 8]) {
        let mut signals = vec![0.0; 8 * SAMPLES];
        random::symmetric(7, Purpose::ClassifierNoise, 0, 1.0, &mut signals);
        (signals, [0, 1, 1, 5, 2, 7, 3, 0])
    }

    fn mean_loss(network: &Network, signals: &[f32], words: &[usize]) -> f64 {
        let mut workspace = network.workspace(words.len());
        network.outputs(signals, words.len(), &mut workspace);
        loss(&mut workspace.activations[2], words) / words.len() as f64
    }

    #[test]
    fn a_step_goes_down_the_slope_of_the_loss() {
        let network = Network::new(1, 8);
        let (signals, words) = some();
        let rate = 1e-3;
        let mut after = network.clone();
        let mut workspace = network.workspace(8);
        after.learn(&signals, &words, rate, &mut workspace);
        let before = mean_loss(&network, &signals, &words);
        // Some weights and a bias of every layer: the slope by a central difference of the loss, in single precision, whose error
        // is 6e-8 × loss/h = 6e-5 at h = 1e-3, besides h² of curvature, and kinks of ReLU that the step may cross.
        let h = 1e-3_f32;
        let mut largest = 0.0_f64;
        for layer in 0..3 {
            let len = network.layers[layer].weights.len();
            for at in [0, len / 3, len - 1] {
                let moved = |by: f32| {
                    let mut moved = network.clone();
                    moved.layers[layer].weights[at] += by;
                    mean_loss(&moved, &signals, &words)
                };
                let slope = (moved(h) - moved(-h)) / f64::from(2.0 * h);
                let step = after.layers[layer].weights[at] - network.layers[layer].weights[at];
                let learned = f64::from(-step / rate);
                assert!(
                    (learned - slope).abs() < 1e-3,
                    "layer {layer}, {at}: {learned} {slope}"
                );
                largest = largest.max(slope.abs());
            }
            let moved = |by: f32| {
                let mut moved = network.clone();
                moved.layers[layer].biases[1] += by;
                mean_loss(&moved, &signals, &words)
            };
            let slope = (moved(h) - moved(-h)) / f64::from(2.0 * h);
            let learned = f64::from(-after.layers[layer].biases[1] / rate);
            assert!(
                (learned - slope).abs() < 1e-3,
                "bias of layer {layer}: {learned} {slope}"
            );
        }
        assert!(largest > 0.01, "slopes of {largest} test nothing");
        assert!(mean_loss(&after, &signals, &words) < before);
    }

    #[test]
    fn threads_change_no_bit() {
        let (signals, words) = some();
        let learned = || {
            let mut network = Network::new(1, 8);
            let mut workspace = network.workspace(8);
            for _ in 0..3 {
                network.learn(&signals, &words, 0.01, &mut workspace);
            }
            network
        };
        let alone = learned();
        let crew = crate::crew::Crew::new(3, Default::default);
        let (shared, _) = crew.work(|| crate::crew::helped(usize::MAX, learned));
        assert!(alone == shared, "weights differ");
    }

    #[test]
    fn signals_are_learned_by_heart_and_few_are_told_as_many() {
        let (signals, words) = some();
        let mut network = Network::new(3, 8);
        let mut workspace = network.workspace(8);
        for _ in 0..50 {
            network.learn(&signals, &words, 0.05, &mut workspace);
        }
        assert_eq!(network.words(&signals), words.map(|word| word as u32));
        assert_eq!(network.words(&signals[..3 * SAMPLES]), [0, 1, 1]);
    }
}
