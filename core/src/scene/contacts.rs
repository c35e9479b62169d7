//! The contacts of a scene: candidates with their reference geometry, and what each remembers.
//!
//! One list serves all replicas.
//! It holds every pair of spheres that any replica could bring to touch before the next renewal.

use crate::contact::slices::Slices;
use crate::contact::{Components, TangentialLaw};
use crate::crew;
use crate::grains::Grains;
use crate::lanes::{Row, Scalar};
use crate::math::plain;
use crate::neighbor::{CellGrid, Key, Rows, Spheres};
use crate::wall::{WALLS, Walls, axis, inward};

use super::blocks::{self, Block, Tail};

/// A list is built so that fast grains need no other for about so many steps.
const AHEAD_STEPS: f64 = 500.0;

/// But for no farther than so much of a radius: where grains are packed, cages are not larger.
const AHEAD: f64 = 0.3;

/// How far beyond touching a list reaches at most, unless it is told to, in radii: where grains fly.
pub const FARTHEST_SKIN: f64 = 0.5;

/// A list that serves fewer steps is too short, one that serves more too long.
const FEW: u32 = 25;
const MANY: u32 = 60;

/// A pair of spheres that may touch; its grain `i` is the row that it stands in.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Candidate<S> {
    /// Twice the branch vector L0 from `j`'s sphere to `i`'s in the reference, and |L0|² − 4, or |L0|² where grains differ in size.
    pub(crate) reference: [S; 4],
    /// The row's grain.
    pub(crate) i: u32,
    /// The other grain.
    pub(crate) j: u32,
    /// Sphere of the row's grain.
    pub(crate) a: u8,
    /// Sphere of the other grain.
    pub(crate) b: u8,
}

impl<S> Candidate<S> {
    fn key(&self) -> Key {
        Key {
            j: self.j,
            a: self.a,
            b: self.b,
        }
    }
}

/// A sphere that may touch a wall.
#[derive(Clone, Copy, Debug)]
pub(crate) struct WallCandidate<S> {
    /// Distance of the sphere's center from the wall in the reference, minus R.
    pub(crate) gap: S,
    /// Which wall.
    pub(crate) wall: u8,
    /// Which sphere of the row's grain.
    pub(crate) a: u8,
}

/// The last list: row starts, candidates, whether they touched, histories and slices.
type OldRows<S, H, D> = (Vec<u32>, Vec<Candidate<S>>, Vec<bool>, Vec<H>, Vec<D>);

/// All candidates and histories.
#[derive(Clone)]
pub(crate) struct Contacts<R: Row, T: TangentialLaw> {
    pub(crate) starts: Vec<u32>,
    /// All rows, for the threads of a step.
    pub(super) blocks: Vec<Block>,
    /// The threads that they were cut for.
    cut_for: usize,
    /// The rows of all blocks that reach the next one.
    pub(super) tails: Vec<Tail>,
    pub(crate) candidates: Vec<Candidate<R::Scalar>>,
    /// Of every candidate, whether any replica touched in the last step, so that there is a history to forget.
    pub(crate) live: Vec<bool>,
    pub(crate) histories: Vec<T::History<R>>,
    /// What each candidate remembers besides.
    pub(crate) slices: Vec<T::Slices<R>>,
    pub(crate) wall_starts: Vec<u32>,
    pub(crate) wall_candidates: Vec<WallCandidate<R::Scalar>>,
    /// Last list's rows, while the next one takes over their histories.
    old: OldRows<R::Scalar, T::History<R>, T::Slices<R>>,
    grid: CellGrid,
    found: Rows,
    /// How fast each grain was when the list was built.
    speeds: Vec<f64>,
    built: Built,
    /// No grain or wall has moved farther than this since the list was built \[R\].
    pub(super) swept: f64,
    /// Steps since then.
    served: u32,
    /// How far beyond touching it reaches; no result depends on it.
    skin: f64,
    least_skin: f64,
    /// How often the list was built.
    pub(crate) renewals: u64,
}

/// Where everything was when the list was built, in the leading replica.
#[derive(Clone, Debug, Default)]
struct Built {
    centers: Vec<[f64; 3]>,
    offsets: Vec<([f64; 3], [f64; 4])>,
    walls: [f64; WALLS],
    /// The radius of each grain's spheres, how much farther than the leading replica's one of them was in any other, and how
    /// far it is let move beyond the skin.
    radii: Vec<f64>,
    wall_slack: f64,
}

/// Which replicas count: the leading one and all that still run.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Live<'a> {
    /// The first replica that runs.
    pub(crate) leader: usize,
    /// Whether each replica runs.
    pub(crate) running: &'a [bool],
}

impl Live<'_> {
    fn lanes(&self) -> impl Iterator<Item = usize> + '_ {
        self.running
            .iter()
            .enumerate()
            .filter_map(|(k, &running)| running.then_some(k))
    }
}

impl<R: Row, T: TangentialLaw> Contacts<R, T> {
    pub(crate) fn new(skin: f64) -> Self {
        Self {
            starts: vec![],
            blocks: vec![],
            cut_for: 0,
            tails: vec![],
            candidates: vec![],
            live: vec![],
            histories: vec![],
            slices: vec![],
            wall_starts: vec![],
            wall_candidates: vec![],
            old: (vec![], vec![], vec![], vec![], vec![]),
            grid: CellGrid::default(),
            found: Rows::default(),
            speeds: vec![],
            built: Built::default(),
            swept: f64::INFINITY,
            served: 0,
            skin,
            least_skin: skin,
            renewals: 0,
        }
    }

    /// How far beyond touching the list reaches.
    pub(super) fn skin(&self) -> f64 {
        self.skin
    }

    /// Takes note that nothing moved farther than `distance`, and renews the list if some pair might be missed; whether it did.
    ///
    /// `moved_around` says how far the surroundings have moved since the list was built.
    pub(crate) fn follow(
        &mut self,
        (distance, moved_around): (f64, &dyn Fn() -> f64),
        grains: &Grains<R>,
        walls: &Walls<R>,
        (reach, time_step): (f64, f64),
        live: Live<'_>,
    ) -> bool {
        self.swept += distance;
        self.served += 1;
        // Not `>`: a distance that is not a number must renew too.
        if self.swept <= 0.5 * self.skin {
            return false;
        }
        if self.swept.is_finite() {
            let within = self.measure(grains, walls, reach, live);
            self.swept = within.max(moved_around());
            // A list that is almost used up is renewed now rather than measured again at every step.
            if self.swept <= 0.4 * self.skin {
                return false;
            }
        }
        self.adapt(grains);
        self.renew(grains, walls, (reach, time_step), live);
        true
    }

    /// Lets the next list reach farther if this one served few steps, and less far if many: building one takes as long as a
    /// dozen steps, and a step longer with a longer list.
    ///
    /// In ensembles, where a step costs more and memory counts, it stays as short as it is.
    fn adapt(&mut self, grains: &Grains<R>) {
        if R::K > 1 {
            return;
        }
        let by = match self.served {
            ..FEW => 1.15,
            MANY.. => 0.9,
            _ => 1.0,
        };
        let farthest = self.least_skin.max(FARTHEST_SKIN * grains.radius(0));
        self.skin = (self.skin * by).clamp(self.least_skin, farthest);
    }

    /// How far beyond its slack any sphere or wall of any running replica has moved since the list was built.
    fn measure(&self, grains: &Grains<R>, walls: &Walls<R>, reach: f64, live: Live<'_>) -> f64 {
        let mut most = 0.0f64;
        for i in 0..grains.len() {
            for k in live.lanes() {
                let moved = moved(self.built.offsets[i], grains.offset(i, k), reach);
                most = most.max(moved + (grains.radius(i) - self.built.radii[i]));
            }
        }
        for w in 0..WALLS {
            for k in live.lanes() {
                most = most.max(
                    (walls.position(w, k) - self.built.walls[w]).abs() - self.built.wall_slack,
                );
            }
        }
        most
    }

    /// Builds the list anew from where the replicas are, carrying the histories over.
    pub(crate) fn renew(
        &mut self,
        grains: &Grains<R>,
        walls: &Walls<R>,
        (reach, time_step): (f64, f64),
        live: Live<'_>,
    ) {
        self.note_where_everything_is(grains, walls, reach, live);
        self.reach_ahead(grains, (reach, time_step), live);
        let spheres = Spheres {
            centers: &self.built.centers,
            per_grain: grains.spheres(),
            reach,
            radii: &self.built.radii,
            skin: self.skin,
        };
        self.grid.search(&spheres, &mut self.found);
        self.take_over(grains);
        self.find_wall_candidates(grains, walls);
        self.swept = 0.0;
        self.served = 0;
        self.renewals += 1;
    }

    fn note_where_everything_is(
        &mut self,
        grains: &Grains<R>,
        walls: &Walls<R>,
        reach: f64,
        live: Live<'_>,
    ) {
        let built = &mut self.built;
        built.centers.clear();
        built.offsets.clear();
        built.radii.clear();
        for i in 0..grains.len() {
            let lead = grains.offset(i, live.leader);
            built
                .centers
                .extend((0..grains.spheres()).map(|a| grains.center(i, a, live.leader)));
            built.offsets.push(lead);
            let farther = |most: f64, k| most.max(moved(lead, grains.offset(i, k), reach));
            built
                .radii
                .push(grains.radius(i) + live.lanes().fold(0.0, farther));
        }
        built.wall_slack = 0.0;
        for w in 0..WALLS {
            built.walls[w] = walls.position(w, live.leader);
            for k in live.lanes() {
                built.wall_slack = built
                    .wall_slack
                    .max((walls.position(w, k) - built.walls[w]).abs());
            }
        }
    }

    /// Lets those that are much faster than most, as grains that rattle in their cages, move farther before all must be renewed.
    fn reach_ahead(&mut self, grains: &Grains<R>, (reach, time_step): (f64, f64), live: Live<'_>) {
        let n = grains.len();
        let fastest = |i: usize| {
            let speeds = live.lanes().map(|k| {
                let motion = grains.motion(i, k);
                plain::norm(motion.velocity) + reach * plain::norm(motion.spin)
            });
            // A replica that has lost its numbers must not cost the others their contacts.
            let finite = speeds.filter(|speed| speed.is_finite());
            finite.fold(0.0, f64::max)
        };
        self.speeds.clear();
        self.speeds.extend((0..n).map(fastest));
        let usual = 2.0 * self.speeds.iter().sum::<f64>() / n.max(1) as f64;
        for (i, (radius, speed)) in self.built.radii.iter_mut().zip(&self.speeds).enumerate() {
            let ahead = AHEAD_STEPS * time_step * (speed - usual);
            *radius += ahead.clamp(0.0, AHEAD * grains.radius(i));
        }
    }

    /// Makes the found keys the list; walks old and new rows side by side to carry histories over.
    fn take_over(&mut self, grains: &Grains<R>) {
        std::mem::swap(&mut self.starts, &mut self.old.0);
        std::mem::swap(&mut self.candidates, &mut self.old.1);
        std::mem::swap(&mut self.live, &mut self.old.2);
        std::mem::swap(&mut self.histories, &mut self.old.3);
        std::mem::swap(&mut self.slices, &mut self.old.4);
        self.starts.clear();
        self.candidates.clear();
        self.live.clear();
        self.histories.clear();
        self.slices.clear();
        let all = self.found.keys.len();
        make_room(&mut self.candidates, all);
        make_room(&mut self.live, all);
        make_room(&mut self.histories, all);
        make_room(&mut self.slices, all);
        self.starts.extend_from_slice(&self.found.starts);
        let (old_starts, old_candidates, old_live, old_histories, old_slices) = &mut self.old;
        for i in 0..grains.len() {
            let (mut next, end) = match old_starts.get(i..i + 2) {
                Some(range) => (range[0] as usize, range[1] as usize),
                None => (0, 0),
            };
            for &key in self.found.row(i) {
                while next < end && old_candidates[next].key() < key {
                    next += 1;
                }
                let known = next < end && old_candidates[next].key() == key;
                let live = known && old_live[next];
                self.live.push(live);
                let (history, slices) = if live {
                    (old_histories[next], std::mem::take(&mut old_slices[next]))
                } else {
                    (T::History::from_fn(|_| R::default()), T::Slices::default())
                };
                self.histories.push(history);
                self.slices.push(slices);
                self.candidates.push(candidate(grains, i, key));
            }
        }
        self.cut_for = 0;
        self.share_out(crew::size());
    }

    /// Cuts all rows into blocks for so many threads, unless they are.
    pub(super) fn share_out(&mut self, threads: usize) {
        if self.cut_for == threads {
            return;
        }
        self.cut_for = threads;
        let candidates = &self.candidates;
        let farthest = |range: std::ops::Range<usize>| {
            let others = candidates[range].iter().map(|candidate| candidate.j);
            others.max().unwrap_or(0) as usize
        };
        blocks::cut(threads, &self.starts, farthest, &mut self.blocks);
        let reached = |c: usize| candidates[c].j as usize;
        blocks::note_tails(&mut self.blocks, &self.starts, reached, &mut self.tails);
    }

    fn find_wall_candidates(&mut self, grains: &Grains<R>, walls: &Walls<R>) {
        let reference = walls.reference();
        self.wall_starts.clear();
        self.wall_candidates.clear();
        self.wall_starts.push(0);
        for i in 0..grains.len() {
            for (wall, &stands) in reference.iter().enumerate() {
                for a in 0..grains.spheres() {
                    let center = self.built.centers[grains.spheres() * i + a][axis(wall)];
                    let distance = inward(wall) * (center - self.built.walls[wall]);
                    if distance < self.skin + self.built.radii[i] + self.built.wall_slack {
                        let at_reference = grains.reference()[i].position[axis(wall)]
                            + grains.arm(i, a)[axis(wall)];
                        let gap = inward(wall) * (at_reference - stands) - grains.radius(i);
                        let gap = R::Scalar::from_f64(gap);
                        self.wall_candidates.push(WallCandidate {
                            gap,
                            wall: wall as u8,
                            a: a as u8,
                        });
                    }
                }
            }
            self.wall_starts.push(self.wall_candidates.len() as u32);
        }
    }

    /// Every pair in the list: grain `i`, and the pair.
    pub(crate) fn pairs(&self) -> impl Iterator<Item = (usize, Key)> + '_ {
        let rows = self.starts.windows(2).enumerate();
        rows.flat_map(|(i, range)| {
            self.candidates[range[0] as usize..range[1] as usize]
                .iter()
                .map(move |c| (i, c.key()))
        })
    }

    /// Every remembered contact of replica `k`: grain `i`, key and history.
    pub(crate) fn remembered(&self, k: usize) -> impl Iterator<Item = (u32, Key, Vec<f64>)> + '_ {
        let rows = self.starts.windows(2).enumerate();
        rows.flat_map(move |(i, range)| {
            (range[0] as usize..range[1] as usize)
                .filter(|&c| self.live[c])
                .map(move |c| (i as u32, self.candidates[c].key(), self.memory(c, k)))
        })
    }

    /// What candidate `c` remembers in replica `k`: its history, then its slices.
    fn memory(&self, c: usize, k: usize) -> Vec<f64> {
        let rows = self.histories[c].as_slice().iter();
        let mut memory: Vec<f64> = rows.map(|row| row.lanes()[k].to_f64()).collect();
        for slice in 0..T::slices(&memory) {
            let numbers = self.slices[c].get(k, slice);
            memory.extend(numbers.map(R::Scalar::to_f64));
        }
        memory
    }

    /// Gives replica `k` a remembered contact; `false` if the list does not hold the pair.
    pub(crate) fn remember(&mut self, k: usize, i: u32, key: Key, history: &[f64]) -> bool {
        let range = self.starts[i as usize] as usize..self.starts[i as usize + 1] as usize;
        let Ok(place) = self.candidates[range.clone()].binary_search_by_key(&key, Candidate::key)
        else {
            return false;
        };
        let c = range.start + place;
        self.live[c] = true;
        let rows = self.histories[c].as_mut_slice();
        let (history, slices) = history.split_at(rows.len().min(history.len()));
        for (row, &value) in rows.iter_mut().zip(history) {
            row.lanes_mut()[k] = R::Scalar::from_f64(value);
        }
        for (slice, &numbers) in slices.as_chunks().0.iter().enumerate() {
            let numbers: [f64; 2] = numbers;
            self.slices[c].set(k, slice, numbers.map(R::Scalar::from_f64));
        }
        true
    }

    /// Makes what replica `to` remembers a copy of what replica `from` does.
    pub(crate) fn copy_lane(&mut self, from: usize, to: usize) {
        for history in &mut self.histories {
            for row in history.as_mut_slice() {
                row.lanes_mut()[to] = row.lanes()[from];
            }
        }
        for slices in &mut self.slices {
            slices.copy_lane(from, to);
        }
    }
}

/// Room for `all`, and for a few more, so that lists that grow slowly do not ask again each time.
fn make_room<T>(list: &mut Vec<T>, all: usize) {
    if list.capacity() < all {
        list.reserve_exact(all + all / 16 - list.len());
    }
}

fn candidate<R: Row>(grains: &Grains<R>, i: usize, key: Key) -> Candidate<R::Scalar> {
    let center = |i: usize, a: u8| {
        plain::add(
            grains.reference()[i].position,
            grains.arm(i, usize::from(a)),
        )
    };
    let branch = plain::sub(center(i, key.a), center(key.j as usize, key.b));
    let [x, y, z] = branch.map(|part| 2.0 * part);
    let four = if grains.sizes.is_empty() { 4.0 } else { 0.0 };
    let excess = plain::dot(branch, branch) - four;
    Candidate {
        reference: [x, y, z, excess].map(R::Scalar::from_f64),
        i: i as u32,
        j: key.j,
        a: key.a,
        b: key.b,
    }
}

/// An upper bound of how far any point within `reach` of the middle moved between two offsets.
///
/// A turn between unit quaternions q and q' by α has |q − q'| = 2 sin(α/4), and moves a point by 2 r sin(α/2) ≤ 2 r |q − q'|.
fn moved(from: ([f64; 3], [f64; 4]), to: ([f64; 3], [f64; 4]), reach: f64) -> f64 {
    let turn: f64 = from
        .1
        .iter()
        .zip(to.1)
        .map(|(a, b)| (a - b) * (a - b))
        .sum();
    plain::norm(plain::sub(to.0, from.0)) + 2.0 * reach * turn.sqrt()
}
