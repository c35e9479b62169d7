//! The contacts of some neighboring grains with the membrane: what one thread finds at a time.
//!
//! A part only reads membrane and grains; what it does to them is added afterwards, part after part, so that sums do not depend
//! on parts or threads. A thread that works alone has one part: with every other the code of all phases is fetched again.

use super::heirs::Heirs;
use super::patch::Sphere;
use super::push::{self, Pending};
use super::reach::{self, Reach};
use super::sheet::{self, Pair, Sheet};
use super::touch::{Ball, Finder};
use super::{Contact, Grip, Held};
use crate::contact::TangentialLaw;
use crate::crew;
use crate::grains::Grains;
use crate::lanes::{F64x1, F64x8, Lane};
use crate::math::plain;
use crate::membrane::Membrane;
use std::ops::Range;

/// Parts for each thread of a crew, so that those who are done early find some to take.
const PARTS: usize = 4;

/// What a part reads.
#[derive(Clone, Copy)]
pub(super) struct Around<'a> {
    pub(super) grip: &'a Grip,
    pub(super) membrane: &'a Membrane,
    pub(super) balls: &'a [sheet::Ball],
    /// All pairs that are near, by grains.
    pub(super) pairs: &'a [Pair],
}

/// Some neighboring grains.
#[derive(Clone, Debug, Default)]
pub(super) struct Part {
    /// Which of all pairs are theirs.
    pairs: Range<usize>,
    /// Their contacts of the last step, by grains.
    pub(super) held: Vec<Held>,
    reaches: Vec<Reach>,
    finder: Finder,
    heirs: Heirs,
    pending: Vec<Pending>,
    /// Force and torque of every contact on its grain.
    pushes: Vec<F64x8>,
}

/// Cuts `pairs` into parts anew, which take over the contacts of the old ones.
pub(super) fn renew(pairs: &[Pair], parts: &mut Vec<Part>) {
    let held: Vec<Held> = parts.iter().flat_map(|part| &part.held).copied().collect();
    share_out(pairs, &held, parts);
}

/// Cuts `pairs` into parts; each gets the contacts `held` of its grains and of those after them that are near nothing.
pub(super) fn share_out(pairs: &[Pair], mut held: &[Held], parts: &mut Vec<Part>) {
    let (mut from, mut count) = (0, 0);
    let most = if crew::size() > 1 {
        pairs.len() / (PARTS * crew::size())
    } else {
        pairs.len()
    };
    while count == 0 || from < pairs.len() {
        let end = cut(pairs, from, most);
        let own = match pairs.get(end) {
            Some(&[next, _]) => held.partition_point(|held| held.grain < next),
            None => held.len(),
        };
        let (own, rest) = held.split_at(own);
        if count == parts.len() {
            parts.push(Part::default());
        }
        let part = &mut parts[count];
        part.pairs = from..end;
        part.held.clear();
        part.held.extend_from_slice(own);
        part.finder.clear();
        part.pushes.clear();
        (from, held, count) = (end, rest, count + 1);
    }
    parts.truncate(count);
}

/// Where a part ends that starts at `from`: `count` pairs on, behind those of the grain there.
fn cut(pairs: &[Pair], from: usize, count: usize) -> usize {
    let Some(&[grain, _]) = pairs.get(from + count) else {
        return pairs.len();
    };
    let rest = &pairs[from + count..];
    from + count + rest.partition_point(|&[i, _]| i == grain)
}

impl Part {
    /// Finds the contacts and their forces.
    #[inline(always)]
    pub(super) fn act<W: Lane<Row = F64x8, Scalar = f64>>(
        &mut self,
        around: &Around<'_>,
        grains: &Grains<F64x1>,
        time_step: f64,
    ) {
        self.reach::<W>(around);
        self.finder.clear();
        for reaches in self.reaches.chunk_by(|a, b| a.pair[0] == b.pair[0]) {
            let ball = ball(around.balls, &self.held, reaches[0].pair[0]);
            let mesh = around.membrane.mesh();
            self.finder.add(mesh, around.sheet(), &ball, reaches);
        }
        self.carry_over(around, grains);
        self.push::<W>(around.grip, time_step);
    }

    /// Adds the feet at which grains and membrane push each other as both are now.
    #[inline(always)]
    pub(super) fn look<W: Lane<Row = F64x8, Scalar = f64>>(
        &mut self,
        around: &Around<'_>,
        found: &mut Vec<Contact>,
    ) {
        self.reach::<W>(around);
        for reaches in self.reaches.chunk_by(|a, b| a.pair[0] == b.pair[0]) {
            let ball = ball(around.balls, &self.held, reaches[0].pair[0]);
            self.finder.clear();
            let mesh = around.membrane.mesh();
            self.finder.add(mesh, around.sheet(), &ball, reaches);
            found.extend(self.finder.pushes().map(|push| Contact {
                grain: ball.grain,
                normal: push.normal,
                overlap: push.overlap,
                shares: push.shares,
            }));
        }
    }

    /// Finds which triangles every grain reaches.
    #[inline(always)]
    fn reach<W: Lane<Row = F64x8, Scalar = f64>>(&mut self, around: &Around<'_>) {
        let pairs = &around.pairs[self.pairs.clone()];
        reach::find::<W>(around.sheet(), pairs, &mut self.reaches);
    }

    /// Takes the springs of the last step over to the contacts of this one, and notes how these move.
    #[inline(always)]
    fn carry_over(&mut self, around: &Around<'_>, grains: &Grains<F64x1>) {
        let membrane = around.membrane;
        self.pending.clear();
        let mut held = self.held.as_slice();
        let mut shares = self.finder.shares.as_slice();
        let mut shares_from = 0;
        for touches in self.finder.touches.chunk_by(|a, b| a.grain == b.grain) {
            let of_grain = held_of(&mut held, touches[0].grain);
            self.heirs.find(membrane.mesh(), of_grain, touches);
            for (touch, &spring) in touches.iter().zip(&self.heirs.springs) {
                let own = shares
                    .split_off(..touch.shares_end - shares_from)
                    .unwrap_or_default();
                shares_from = touch.shares_end;
                let area = membrane.rest_areas()[touch.triangle as usize];
                let mass = around.grip.areal_density * area;
                let pending = Pending::new(touch, own, (grains, membrane), spring, mass);
                self.pending.push(pending);
            }
        }
    }

    /// Finds the forces of all contacts, eight at a time.
    #[inline(always)]
    fn push<W: Lane<Row = F64x8, Scalar = f64>>(&mut self, grip: &Grip, time_step: f64) {
        let constants = grip.tangential.constants::<W>();
        self.held.clear();
        self.pushes.clear();
        for eight in self.pending.chunks(W::K) {
            let acting = push::forces::<W>(&grip.material, &constants, time_step, eight);
            self.held.extend(acting.held(eight));
            self.pushes.extend(&acting.pushes[..eight.len()]);
        }
    }

    /// Force and torque of every contact, and its grain.
    #[inline(always)]
    pub(super) fn pushes(&self) -> impl Iterator<Item = (u32, &F64x8)> {
        let touches = self.finder.touches.iter();
        touches.map(|touch| touch.grain).zip(&self.pushes)
    }

    /// Adds the opposite of all forces to the vertices.
    pub(super) fn share(&self, forces: &mut [[f64; 3]]) {
        let mut shares_from = 0;
        for (touch, push) in self.finder.touches.iter().zip(&self.pushes) {
            let [x, y, z, ..] = push.0;
            for share in &self.finder.shares[shares_from..touch.shares_end] {
                let force = &mut forces[share.vertex as usize];
                *force = plain::sub(*force, plain::scale([x, y, z], share.weight));
            }
            shares_from = touch.shares_end;
        }
    }

    /// Adds what contacts do beside their force at one point, to grains and vertices; `stiffness` is k.
    pub(super) fn add_surpluses(&mut self, stiffness: f64, forces: &mut [[f64; 3]]) {
        let mut pulls_from = 0;
        for surplus in &self.finder.surpluses {
            let [x, y, z] = plain::scale(surplus.force, stiffness);
            let [f_x, f_y, f_z, ..] = &mut self.pushes[surplus.touch].0;
            (*f_x, *f_y, *f_z) = (*f_x + x, *f_y + y, *f_z + z);
            for pull in &self.finder.pulls[pulls_from..surplus.pulls_end] {
                let force = &mut forces[pull.vertex as usize];
                *force = plain::sub(*force, plain::scale(pull.force, stiffness));
            }
            pulls_from = surplus.pulls_end;
        }
    }
}

impl<'a> Around<'a> {
    #[inline(always)]
    fn sheet(&self) -> Sheet<'a> {
        Sheet {
            faces: self.membrane.faces(),
            balls: self.balls,
        }
    }
}

/// A grain, and the contacts `held` from the last step.
#[inline(always)]
fn ball<'a>(balls: &[sheet::Ball], held: &'a [Held], grain: u32) -> Ball<'a> {
    let [x, y, z, radius] = balls[grain as usize];
    let sphere = Sphere {
        center: [x, y, z],
        radius,
    };
    Ball {
        grain,
        sphere,
        held,
    }
}

/// The contacts of `grain` in the last step; `held` goes on behind them.
#[inline(always)]
fn held_of<'a>(held: &mut &'a [Held], grain: u32) -> &'a [Held] {
    let before = held.iter().take_while(|h| h.grain < grain).count();
    let own = held[before..]
        .iter()
        .take_while(|h| h.grain == grain)
        .count();
    let (_, from) = held.split_at(before);
    let (own, after) = from.split_at(own);
    *held = after;
    own
}
