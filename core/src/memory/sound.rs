//! Sound: how long what walls stir up in a pack swings, and how long it takes to die away.
//!
//! A ramp that is not slow against this leaves a pack shaking, differently for every waveform, which looks like a poor memory.
//! Both times are measured in the pack itself: a copy of it is struck with the longest wave that moving walls can make,
//! the full wave between them, and listened to for a few swings.
//! The copy has no drag: what a drag does to the wave follows, also where it keeps the wave from swinging at all.

use std::f64::consts::PI;

use serde::{Deserialize, Serialize};

use crate::force::BodyForce as _;
use crate::lanes::F64x1;
use crate::math::plain;
use crate::outcome::StageFailure;
use crate::scene::{Physics, Scene};
use crate::wall::WALLS;

/// How far the energy must fall before enough is heard: to e^−1.5 of what it was.
const FALL: f64 = 1.5;
/// Swings before the energy is looked at: at first all of it is motion.
const FIRST_SWINGS: usize = 2;
/// Steps between two looks.
const LOOK_EVERY: u64 = 4;
/// Looks between two questions whether to go on.
const ASK_EVERY: usize = 25;
/// The most steps.
const MOST_STEPS: u64 = 20_000;
/// Ramps shorter than this many decay times lose fidelity: 0.01 at 7, 0.3 at 4, 0.8 at 2, at 325 grains as at 1,024
/// (docs/accuracy.md).
const LEAST_DECAYS: f64 = 7.0;
/// The drag of the presets \[1/t_c\].
pub(super) const USUAL_DRAG: f64 = 0.1;
/// Fewer grains than this carry no wave.
const LEAST_GRAINS: usize = 64;
/// How fast a pack is struck \[R/t_c\]: a swing of 200 t_c then moves neighbors by 1e-4 R, a hundredth of their overlap,
/// and a pack at rest moves a hundred times more slowly.
const STRIKE: f64 = 1e-5;

/// The longest wave between the walls.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Sound {
    /// Time of a swing without drag \[t_c\].
    pub period: f64,
    /// Time in which the energy that it leaves in the pack falls to 1/e \[t_c\], scattered into other waves or not, drag included.
    pub decay_time: f64,
}

impl Sound {
    /// The same in a pack with a drag η \[1/t_c\].
    ///
    /// An oscillator of frequency ω whose amplitude falls at the rate a = (1/τ + η)/2; from a = ω on it no longer swings, but
    /// creeps back at the rate a − √(a² − ω²).
    fn with_drag(self, drag: f64) -> Self {
        let frequency = 2.0 * PI / self.period;
        let damping = 0.5 * (1.0 / self.decay_time + drag);
        let beyond = (damping * damping - frequency * frequency).max(0.0);
        let slowest = if beyond > 0.0 {
            frequency * frequency / (damping + beyond.sqrt())
        } else {
            damping
        };
        Self {
            decay_time: 0.5 / slowest,
            ..self
        }
    }

    /// Both times as results, of a pack that was heard or not.
    pub(crate) fn results(sound: Option<Self>) -> [(String, Option<f64>); 2] {
        [
            ("sound_period", sound.map(|sound| sound.period)),
            ("sound_decay_time", sound.map(|sound| sound.decay_time)),
        ]
        .map(|(name, value)| (name.to_owned(), value))
    }

    /// What a reader should know of a recall with this ramp \[t_c\], if it was too hasty for the pack.
    pub(crate) fn warning(&self, ramp: f64, drag: f64) -> Option<String> {
        let decays = ramp / self.decay_time;
        (decays < LEAST_DECAYS).then(|| {
            let least = LEAST_DECAYS * self.decay_time;
            let or = if drag < USUAL_DRAG {
                format!(", or a drag of {USUAL_DRAG}")
            } else {
                String::new()
            };
            format!(
                "fast_ramp: a ramp of {ramp} t_c is only {decays:.1} times as long as the energy of sound stays in this \
                 pack, {:.0} t_c: what one part of a waveform stirs up reaches the next, which looks like a poor memory; \
                 take a ramp of {least:.0} t_c or more{or}",
                self.decay_time
            )
        })
    }
}

/// Strikes a copy of `scene` and listens; none if no swing is heard, as in a pack of few grains.
///
/// # Errors
/// That of `ask`, which is asked now and then whether to go on.
pub(crate) fn measure<P: Physics>(
    scene: &Scene<F64x1, P>,
    ask: &mut dyn FnMut() -> Result<(), StageFailure>,
) -> Result<Option<Sound>, StageFailure> {
    if scene.grains.len() < LEAST_GRAINS {
        return Ok(None);
    }
    let mut struck = scene.clone();
    let drag = struck.laws.body_force.take_drag();
    struck.set_affine_rate(0, [0.0; 3]);
    for wall in 0..WALLS {
        // They have just moved.
        struck.walls.place(wall, 0, struck.walls.position(wall, 0));
    }
    let wave = Wave::of(&struck);
    wave.strike(&mut struck);
    let mut heard = vec![wave.heard(&struck)];
    let look = LOOK_EVERY as f64 * struck.laws.time_step;
    while (heard.len() as u64) * LOOK_EVERY < MOST_STEPS && !is_enough(&heard) {
        if heard.len().is_multiple_of(ASK_EVERY) {
            ask()?;
        }
        for _ in 0..LOOK_EVERY {
            struck.step();
        }
        heard.push(wave.heard(&struck));
    }
    Ok(listen(&heard, look).map(|sound| sound.with_drag(drag)))
}

/// One look at a struck pack.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Heard {
    /// How much of the wave is in the velocities.
    wave: f64,
    /// Mean square of the velocities, to which the kinetic energy is proportional.
    energy: f64,
}

/// The shape of the wave, grain by grain: a full wave along x, and its opposite along y, zero at the walls.
struct Wave(Vec<[f64; 2]>);

impl Wave {
    fn of<P: Physics>(scene: &Scene<F64x1, P>) -> Self {
        let number = |axis| 2.0 * PI / scene.walls.extent(axis, 0);
        let numbers = [number(0), number(1)];
        let of_grain = |i| {
            let place = scene.grains.pose(i, 0).position;
            [
                libm::sin(numbers[0] * place[0]),
                -libm::sin(numbers[1] * place[1]),
            ]
        };
        Self((0..scene.grains.len()).map(of_grain).collect())
    }

    fn strike<P: Physics>(&self, scene: &mut Scene<F64x1, P>) {
        for (i, &[x, y]) in self.0.iter().enumerate() {
            let mut motion = scene.grains.motion(i, 0);
            motion.velocity = [STRIKE * x, STRIKE * y, 0.0];
            motion.spin = [0.0; 3];
            scene.grains.set_motion(i, 0, motion);
        }
    }

    fn heard<P: Physics>(&self, scene: &Scene<F64x1, P>) -> Heard {
        let (mut wave, mut energy) = (0.0, 0.0);
        for (i, &[x, y]) in self.0.iter().enumerate() {
            let velocity = scene.grains.motion(i, 0).velocity;
            wave += x * velocity[0] + y * velocity[1];
            energy += plain::dot(velocity, velocity);
        }
        let n = self.0.len() as f64;
        Heard {
            wave: wave / n,
            energy: energy / n,
        }
    }
}

/// Time of a swing \[looks\], by the first five changes of the wave's sign, each between two looks by a straight line.
fn period(heard: &[Heard]) -> Option<f64> {
    let pairs = heard.windows(2).enumerate();
    let mut crossings = pairs
        .map(|(k, pair)| (k as f64, pair[0].wave, pair[1].wave))
        .filter(|(_, before, after)| before * after < 0.0)
        .map(|(k, before, after)| k + before / (before - after));
    let (first, last) = (crossings.next()?, crossings.nth(3)?);
    // Two changes a swing.
    Some(0.5 * (last - first))
}

/// The mean energy of each whole swing after the first ones.
fn energies(heard: &[Heard], period: f64) -> Vec<f64> {
    let swing = (period.round() as usize).max(1);
    let whole = heard.chunks_exact(swing).skip(FIRST_SWINGS);
    whole
        .map(|part| part.iter().map(|look| look.energy).sum::<f64>() / swing as f64)
        .collect()
}

fn is_enough(heard: &[Heard]) -> bool {
    let energies = period(heard).map(|period| energies(heard, period));
    match energies.as_deref() {
        Some([first, .., last]) => libm::log(first / last) >= FALL,
        _ => false,
    }
}

/// Period and decay of what was heard every `look`: the slope of the logarithm of each swing's energy, by least squares.
fn listen(heard: &[Heard], look: f64) -> Option<Sound> {
    let period = period(heard)?;
    let energies = energies(heard, period);
    if energies.len() < 3 {
        return None;
    }
    let n = energies.len() as f64;
    let middle = 0.5 * (n - 1.0);
    let (mut xy, mut xx) = (0.0, 0.0);
    for (k, energy) in energies.iter().enumerate() {
        let x = k as f64 - middle;
        xy += x * libm::log(*energy);
        xx += x * x;
    }
    let per_swing = -xy / xx;
    (per_swing > 0.0 && per_swing.is_finite()).then(|| Sound {
        period: period * look,
        decay_time: period.round().max(1.0) * look / per_swing,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A swing of this period and energy decay, heard every 1.5 t_c for `swings`, and half as much of an overtone.
    fn swing(period: f64, decay: f64, swings: f64) -> Vec<Heard> {
        let look = 1.5;
        let turn = |k: u32, period: f64| 2.0 * PI * f64::from(k) * look / period;
        let heard = |k| {
            let fall = libm::exp(-0.5 * f64::from(k) * look / decay);
            let wave = fall * libm::cos(turn(k, period));
            let other = 0.5 * fall * libm::cos(turn(k, 0.37 * period));
            Heard {
                wave: wave + 0.1 * other,
                energy: wave * wave + other * other,
            }
        };
        (0..(swings * period / look) as u32).map(heard).collect()
    }

    #[test]
    fn swing_of_known_period_and_decay_is_heard_as_it_is() {
        for (period, decay) in [(37.0, 500.0), (200.0, 400.0), (80.0, 5_000.0)] {
            let sound = listen(&swing(period, decay, 12.0), 1.5).expect("a swing");
            assert!((sound.period / period - 1.0).abs() < 0.02, "{sound:?}");
            assert!((sound.decay_time / decay - 1.0).abs() < 0.1, "{sound:?}");
        }
    }

    #[test]
    fn enough_is_heard_once_the_energy_has_fallen() {
        // The third swing is the first that counts; from there 1.5 decay times are 15 swings.
        assert!(!is_enough(&swing(40.0, 400.0, 14.0)));
        assert!(is_enough(&swing(40.0, 400.0, 20.0)));
    }

    #[test]
    fn what_does_not_swing_is_no_sound() {
        let creep = |k: i32| {
            let wave = libm::exp(-f64::from(k) / 50.0);
            Heard {
                wave,
                energy: wave * wave,
            }
        };
        assert_eq!(listen(&(0..500).map(creep).collect::<Vec<_>>(), 1.0), None);
        let silent = Heard {
            wave: 0.0,
            energy: 0.0,
        };
        assert_eq!(listen(&[silent; 100], 1.0), None);
    }

    #[test]
    fn ramps_of_fewer_than_seven_decay_times_are_warned_about() {
        let sound = Sound {
            period: 56.0,
            decay_time: 700.0,
        };
        assert_eq!(sound.warning(5_000.0, 0.0), None);
        let warning = sound.warning(2_800.0, 0.0).expect("too hasty");
        assert!(warning.starts_with("fast_ramp: "), "{warning}");
        assert!(
            warning.contains("4.0 times")
                && warning.ends_with("4900 t_c or more, or a drag of 0.1"),
            "{warning}"
        );
        let creeps = sound.with_drag(20.0).warning(2_800.0, 20.0);
        assert!(creeps.is_some_and(|warning| warning.ends_with("t_c or more")));
    }

    /// By stepping the oscillator, x'' = −ω² x − (1/τ + η) x', until what creeps no faster than the rest is left, and then for
    /// as long as its energy is said to take to fall to 1/e¹²: it does so within 2 a/ω/12, by which the energy of a swing goes up
    /// and down, where a/ω is at most 0.41 below.
    #[test]
    fn drag_takes_energy_as_fast_as_from_an_oscillator_whether_it_swings_or_creeps() {
        let quiet = Sound {
            period: 100.0,
            decay_time: 1_000.0,
        };
        for drag in [0.0, 0.01, 0.05, 0.2, 1.0] {
            let sound = quiet.with_drag(drag);
            let step = 0.01;
            let (mut x, mut v) = (1.0, 0.0);
            let mut energy_after = |time: f64| {
                for _ in 0..(time / step) as u64 {
                    let squared = (2.0 * PI / quiet.period).powi(2);
                    v -= step * (squared * x + (1.0 / quiet.decay_time + drag) * v);
                    x += step * v;
                }
                (2.0 * PI / quiet.period * x).powi(2) + v * v
            };
            let first = energy_after(4.0 * sound.decay_time);
            let second = energy_after(12.0 * sound.decay_time);
            let fall = libm::log(first / second);
            assert!((fall / 12.0 - 1.0).abs() < 0.07, "{drag}: {fall}");
        }
        assert_eq!(quiet.with_drag(0.0), quiet);
        // Twice the rate in half the time, as long as it swings.
        assert!((quiet.with_drag(0.001).decay_time - 500.0).abs() < 1e-9);
    }
}
