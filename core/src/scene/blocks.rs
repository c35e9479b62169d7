//! Blocks of rows: what each thread of a job takes.
//!
//! How many blocks there are changes no sum. Rows reach beyond the end of their block, but no farther than into the next:
//! what they add there is summed apart. A grain of the next block that they reach is *shared*: what its own block adds to it
//! is kept, in order, and added behind what the block before has summed, as one thread would have done.

use std::ops::Range;

use crate::crew::{self, LEAST_ROWS};

/// Neighboring rows, and their candidates.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Block {
    /// Its place among the blocks.
    pub(super) number: usize,
    pub(super) rows: Range<usize>,
    pub(super) candidates: Range<usize>,
    /// Where the rows end that the block before reaches.
    pub(super) shared_end: usize,
    /// Where the rows end that this one reaches.
    pub(super) reached_end: usize,
    /// Those of its rows that reach the next block, among all such.
    pub(super) tails: Range<usize>,
}

/// Where the candidates of a row start that reach the next block: a row's candidates are sorted by what they reach.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Tail {
    pub(super) row: u32,
    pub(super) start: u32,
}

/// What goes with some neighboring blocks and can be divided between two threads where one of them ends.
pub(super) trait Divide: Send + Sized {
    /// What goes with the first `counts`, and what goes with the others.
    fn divide(self, counts: &Counts) -> (Self, Self);
}

/// How many there are of what goes with blocks.
#[derive(Clone, Copy, Debug)]
pub(super) struct Counts {
    pub(super) blocks: usize,
    pub(super) rows: usize,
    pub(super) candidates: usize,
}

impl<A: Divide, B: Divide> Divide for (A, B) {
    fn divide(self, counts: &Counts) -> (Self, Self) {
        let ((a, other_a), (b, other_b)) = (self.0.divide(counts), self.1.divide(counts));
        ((a, b), (other_a, other_b))
    }
}

/// One for each block.
impl<T: Send> Divide for &mut [T] {
    fn divide(self, counts: &Counts) -> (Self, Self) {
        self.split_at_mut(counts.blocks)
    }
}

/// Does `work` on every block and what goes with it, side by side where the job has more threads.
pub(super) fn each<T: Divide>(blocks: &[Block], with: T, work: &(impl Fn(&Block, T) + Sync)) {
    match blocks {
        [] => {}
        [block] => work(block, with),
        [from, ..] => {
            let (first, second) = blocks.split_at(blocks.len() / 2);
            let counts = Counts {
                blocks: first.len(),
                rows: second[0].rows.start - from.rows.start,
                candidates: second[0].candidates.start - from.candidates.start,
            };
            let (with_first, with_second) = with.divide(&counts);
            crew::both(
                || each(first, with_first, work),
                || each(second, with_second, work),
            );
        }
    }
}

/// Cuts rows, given where their candidates start, into one block for each of so many threads.
///
/// `farthest` is the largest row that a range of candidates reaches.
pub(super) fn cut(
    threads: usize,
    starts: &[u32],
    farthest: impl Fn(Range<usize>) -> usize,
    blocks: &mut Vec<Block>,
) {
    let rows = starts.len().saturating_sub(1);
    let most = threads.min(rows / LEAST_ROWS);
    let mut cut = |count| cut_into(count, starts, &farthest, blocks);
    if (2..=most).rev().any(&mut cut) {
        return;
    }
    blocks.clear();
    blocks.push(Block {
        number: 0,
        rows: 0..rows,
        candidates: 0..starts.last().map_or(0, |&end| end as usize),
        shared_end: 0,
        reached_end: rows,
        tails: 0..0,
    });
}

/// Notes which rows of each block reach the next, given the row that each candidate reaches.
pub(super) fn note_tails(
    blocks: &mut [Block],
    starts: &[u32],
    reached: impl Fn(usize) -> usize,
    tails: &mut Vec<Tail>,
) {
    tails.clear();
    for block in blocks {
        let before = tails.len();
        for row in block.rows.clone() {
            let mut start = starts[row + 1];
            while start > starts[row] && reached(start as usize - 1) >= block.rows.end {
                start -= 1;
            }
            if start < starts[row + 1] {
                let row = row as u32;
                tails.push(Tail { row, start });
            }
        }
        block.tails = before..tails.len();
    }
}

/// Cuts `count` blocks of about as many candidates each; `false` if one reaches beyond the next.
fn cut_into(
    count: usize,
    starts: &[u32],
    farthest: impl Fn(Range<usize>) -> usize,
    blocks: &mut Vec<Block>,
) -> bool {
    blocks.clear();
    let all = starts.last().map_or(0, |&end| end as usize);
    let (mut first, mut shared_end) = (0, 0);
    for n in 1..=count {
        let end = if n == count {
            starts.len() - 1
        } else {
            starts.partition_point(|&start| (start as usize) < n * all / count)
        };
        if end <= first || end < shared_end {
            return false;
        }
        let candidates = starts[first] as usize..starts[end] as usize;
        let reached_end = (farthest(candidates.clone()) + 1).max(end);
        blocks.push(Block {
            number: n - 1,
            rows: first..end,
            candidates,
            shared_end,
            reached_end,
            tails: 0..0,
        });
        (first, shared_end) = (end, reached_end);
    }
    true
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rows of one candidate each, `reach` rows on.
    fn chain(rows: u32, reach: usize) -> (Vec<u32>, impl Fn(Range<usize>) -> usize) {
        let last = rows as usize - 1;
        ((0..=rows).collect(), move |candidates: Range<usize>| {
            (candidates.end - 1 + reach).min(last)
        })
    }

    #[test]
    fn blocks_cover_all_rows_and_share_what_the_one_before_reaches() {
        let (starts, farthest) = chain(1000, 7);
        let mut blocks = vec![];
        assert!(cut_into(3, &starts, farthest, &mut blocks));
        let rows: Vec<_> = blocks.iter().map(|block| block.rows.clone()).collect();
        assert_eq!(rows, [0..333, 333..666, 666..1000]);
        let shared: Vec<_> = blocks.iter().map(|block| block.shared_end).collect();
        assert_eq!(shared, [0, 340, 673]);
        assert_eq!(blocks[2].reached_end, 1000);
    }

    #[test]
    fn tails_are_the_candidates_that_reach_the_next_block() {
        // Rows of two candidates each, one and four rows on.
        let starts: Vec<u32> = (0..=1000).map(|row| 2 * row).collect();
        let reached = |c: usize| (c / 2 + if c.is_multiple_of(2) { 1 } else { 4 }).min(999);
        let farthest = |range: Range<usize>| range.map(reached).max().unwrap_or(0);
        let (mut blocks, mut tails) = (vec![], vec![]);
        assert!(cut_into(2, &starts, farthest, &mut blocks));
        note_tails(&mut blocks, &starts, reached, &mut tails);
        let found: Vec<_> = tails.iter().map(|tail| (tail.row, tail.start)).collect();
        assert_eq!(found, [(496, 993), (497, 995), (498, 997), (499, 998)]);
        assert_eq!((&blocks[0].tails, &blocks[1].tails), (&(0..4), &(4..4)));
    }

    #[test]
    fn no_block_reaches_beyond_the_next() {
        let (starts, farthest) = chain(1000, 400);
        assert!(!cut_into(3, &starts, &farthest, &mut vec![]));
        assert!(cut_into(2, &starts, &farthest, &mut vec![]));
    }

    #[test]
    fn what_runs_alone_is_one_block() {
        let (starts, farthest) = chain(1000, 7);
        let mut blocks = vec![];
        cut(1, &starts, farthest, &mut blocks);
        assert_eq!(blocks.len(), 1);
        for none in [&[][..], &[0]] {
            cut(4, none, |_| 0, &mut blocks);
            assert_eq!((&blocks[0].rows, &blocks[0].candidates), (&(0..0), &(0..0)));
        }
    }
}
