//! Energy that no work explains: the sign of a time step that is too long.
//!
//! Contacts and springs keep energy or lose it, so E_kin + E_el cannot exceed what there was and the work done since, W.
//! Pressure does p (V − V'); planes, rods and growing grains have a power, which is sampled at every look.
//! Work that is taken out is left out, so W is too large rather than too small.
//!
//! The sum of stiffness on a grain only estimates its fastest mode: that of a grain between two others is √(3/2) times as fast.
//! A time step just below the critical one can thus be too long, and this is how it shows.

use serde::{Deserialize, Serialize};

use super::{LOOK_EVERY, Run};
use crate::beam::probe;
use crate::beam::rig::Friction;
use crate::outcome::StageFailure;
use crate::scene::casing::Press;

/// So many times as much energy is not an error of sampling.
const GROWTH: f64 = 10.0;

/// Steps within which energy must have grown so.
const WINDOW: u64 = 10_000;

/// Energy per grain that is not judged \[E* R³\]: instability saturates at 1e-5 (docs/choices.md §4), and ten times this is well below.
const QUIET: f64 = 1e-7;

/// What there was, and what has been done since.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Books {
    /// The least energy since the window began, and the work done since \[J\].
    explained: f64,
    /// V at the last look \[m³\].
    volume: f64,
    /// Δp at the last look \[Pa\].
    pressure: f64,
    /// Of planes, rods and growth at the last look \[W\].
    power: f64,
}

impl Books {
    /// Before the first look.
    pub(super) const BLANK: Self = Self {
        explained: f64::MAX,
        volume: 0.0,
        pressure: 0.0,
        power: 0.0,
    };
}

impl<T: Friction> Run<T> {
    /// Stops if there is ten times as much energy as work explains.
    pub(super) fn check_energy(&mut self) -> Result<(), StageFailure> {
        let casing = &self.beam.surroundings;
        let [kinetic, elastic] = probe::energies(&self.beam, &self.contacts);
        let outside = Outside::of(&casing.press, casing.membrane.mesh().positions());
        let energy = kinetic + elastic + outside.stored;
        let now = Books {
            explained: energy,
            volume: casing.membrane.mesh().volume(),
            pressure: casing.press.pressure,
            power: outside.power + self.power_of_growth(kinetic),
        };
        let before = self.books;
        let time = LOOK_EVERY as f64 * self.beam.laws.time_step;
        let pressed = 0.5 * (before.pressure + now.pressure) * (before.volume - now.volume);
        let driven = 0.5 * (before.power + now.power) * time;
        let explained = before.explained + pressed.max(0.0) + driven.max(0.0);
        self.books = now;
        if !self.step.is_multiple_of(WINDOW) {
            self.books.explained = explained.min(energy);
        }
        if energy <= GROWTH * (explained + self.quiet_energy()) {
            return Ok(());
        }
        let detail = format!(
            "kinetic and elastic energy are {energy:.1e} J, and work explains {explained:.1e} J of them"
        );
        Err(self.failed("unstable", detail, super::check::SLOWER))
    }

    /// What growing grains do: against one another and the membrane, and by the mass that moves with them.
    fn power_of_growth(&self, kinetic: f64) -> f64 {
        if self.growth_rate <= 0.0 {
            return 0.0;
        }
        let radius = |i: usize| self.beam.grains.radius(i);
        let contacts = self.contacts.iter();
        let between = contacts.map(|c| c.normal_force * (radius(c.i) + radius(c.j)));
        let held = self.beam.surroundings.held();
        let against = held.map(|h| h.normal_force * radius(h.grain as usize));
        self.growth_rate * (between.sum::<f64>() + against.sum::<f64>() + 3.0 * kinetic)
    }

    /// Energy that is not judged \[J\]: too little to be an instability's, or what anything has that was struck by what drives
    /// the beam and flies off twice as fast, 2 M v².
    fn quiet_energy(&self) -> f64 {
        let beam = &self.beam;
        let sizes = beam.grains.sizes();
        let modulus = 0.75 * beam.laws.material.normal_stiffness;
        let cubes: f64 = sizes.iter().map(|s| s.radius * s.radius * s.radius).sum();
        let grains: f64 = sizes.iter().map(|size| 1.0 / size.inverse_mass).sum();
        let mass = grains + beam.surroundings.membrane.masses().iter().sum::<f64>();
        let speed = self.driving_speed();
        QUIET * modulus * cubes + 2.0 * mass * speed * speed
    }

    /// The largest speed of planes, rods and growing surfaces \[m/s\].
    fn driving_speed(&self) -> f64 {
        let press = &self.beam.surroundings.press;
        let planes = press.planes.iter().map(|plane| plane.velocity.abs());
        let rods = press.rods.iter().map(|rod| rod.velocity.abs());
        let sizes = self.beam.grains.sizes().iter();
        let growing = sizes.map(|size| self.growth_rate * size.radius);
        planes.chain(rods).chain(growing).fold(0.0, f64::max)
    }
}

/// What planes and rods do to the vertices that they touch; by places alone, so that it is the same after an interruption.
struct Outside {
    /// \[J\].
    stored: f64,
    /// \[W\].
    power: f64,
}

impl Outside {
    fn of(press: &Press, places: &[[f64; 3]]) -> Self {
        let mut sum = Self {
            stored: 0.0,
            power: 0.0,
        };
        for &place in places {
            for plane in &press.planes {
                let overlap = plane.overlap(&press.ball, place);
                sum.add(press, overlap, plane.inward * plane.velocity);
            }
            for rod in &press.rods {
                let overlap = rod.overlap(&press.ball, place);
                let distance = rod.radius + press.ball.radius - overlap;
                let rise = (place[2] - rod.position[1]) / distance;
                sum.add(press, overlap, rise * rod.velocity);
            }
        }
        sum
    }

    /// Adds one contact whose outer side comes nearer at `speed`: f = K √(r p) p, and (2/5) f p is stored.
    fn add(&mut self, press: &Press, overlap: f64, speed: f64) {
        if overlap > 0.0 {
            let force = press.ball.stiffness(overlap) * overlap / 1.5;
            self.stored += 0.4 * force * overlap;
            self.power += force * speed;
        }
    }
}
