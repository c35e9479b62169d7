//! What a contact remembers slice by slice of its area: two numbers a slice, of which a step seldom needs any.

use crate::lanes::{Row, Scalar};

/// Two numbers for each slice and lane; those that were never set are zero.
pub trait Slices<S: Scalar> {
    /// The numbers of a slice.
    fn get(&self, lane: usize, slice: usize) -> [S; 2];

    /// Sets the numbers of a slice.
    fn set(&mut self, lane: usize, slice: usize, numbers: [S; 2]);

    /// Makes what lane `to` remembers a copy of what lane `from` does.
    fn copy_lane(&mut self, from: usize, to: usize);

    /// Bytes held elsewhere than in itself.
    fn bytes(&self) -> usize {
        0
    }
}

/// Of a law that knows no slices.
impl<S: Scalar> Slices<S> for () {
    #[inline(always)]
    fn get(&self, _lane: usize, _slice: usize) -> [S; 2] {
        [S::default(); 2]
    }

    #[inline(always)]
    fn set(&mut self, _lane: usize, _slice: usize, _numbers: [S; 2]) {}

    #[inline(always)]
    fn copy_lane(&mut self, _from: usize, _to: usize) {}
}

/// As many slices as any lane has needed so far.
#[derive(Clone, Debug, Default)]
pub struct Stack<R>(Vec<[R; 2]>);

impl<R: Row> Slices<R::Scalar> for Stack<R> {
    fn get(&self, lane: usize, slice: usize) -> [R::Scalar; 2] {
        match self.0.get(slice) {
            Some(rows) => rows.map(|row| row.lanes()[lane]),
            None => [R::Scalar::default(); 2],
        }
    }

    fn set(&mut self, lane: usize, slice: usize, numbers: [R::Scalar; 2]) {
        if slice >= self.0.len() {
            let all = (slice + 1).next_multiple_of(8);
            self.0.reserve_exact(all - self.0.len());
            self.0.resize(all, [R::default(); 2]);
        }
        for (row, number) in self.0[slice].iter_mut().zip(numbers) {
            row.lanes_mut()[lane] = number;
        }
    }

    fn copy_lane(&mut self, from: usize, to: usize) {
        for row in self.0.as_flattened_mut() {
            row.lanes_mut()[to] = row.lanes()[from];
        }
    }

    fn bytes(&self) -> usize {
        self.0.capacity() * std::mem::size_of::<[R; 2]>()
    }
}

/// Of eight contacts, one to a lane.
impl<S: Scalar, C: Slices<S>> Slices<S> for [C; 8] {
    fn get(&self, lane: usize, slice: usize) -> [S; 2] {
        self[lane].get(0, slice)
    }

    fn set(&mut self, lane: usize, slice: usize, numbers: [S; 2]) {
        self[lane].set(0, slice, numbers);
    }

    fn copy_lane(&mut self, _from: usize, _to: usize) {}
}
