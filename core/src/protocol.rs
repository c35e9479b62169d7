//! Protocols: reusable motions of the walls.

use serde::{Deserialize, Serialize};

use crate::scene::{Physics, Replicas, Scene};

/// The box of one replica, about the origin: extents along x and y \[R\].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Box2 {
    /// L_x.
    pub x: f64,
    /// L_y.
    pub y: f64,
}

/// c(u) = 1 − u (1 − √(1 − δ0)): the extent in x and y that compresses the volume by δ0 at u = 1.
#[must_use]
pub fn compression(u: f64, delta0: f64) -> f64 {
    1.0 - u * (1.0 - (1.0 - delta0).sqrt())
}

impl Box2 {
    /// The box compressed to `u` and sheared by `gamma`, half on each axis.
    #[must_use]
    pub fn strained(self, u: f64, delta0: f64, gamma: f64) -> Self {
        let c = compression(u, delta0);
        Self {
            x: self.x * c * (1.0 - 0.5 * gamma),
            y: self.y * c * (1.0 + 0.5 * gamma),
        }
    }
}

/// Moves the ±x and ±y walls of replica `k` to the box `to` within one step.
pub fn move_box<R: Replicas, P: Physics>(scene: &mut Scene<R, P>, k: usize, to: Box2) {
    let time_step = scene.laws.time_step;
    let rate = |now: f64, to: f64| (to - now) / (time_step * to);
    let affine = [
        rate(scene.walls.extent(0, k), to.x),
        rate(scene.walls.extent(1, k), to.y),
        0.0,
    ];
    scene.set_affine_rate(k, affine);
    for (wall, position) in [-0.5 * to.x, 0.5 * to.x, -0.5 * to.y, 0.5 * to.y]
        .into_iter()
        .enumerate()
    {
        scene.walls.advance(wall, k, position, time_step);
    }
}

/// Drives the +z wall of a lone run to a pressure.
///
/// The wall's speed is proportional to (p/p_z − 1) and clamped; it yields ten times slower than it advances.
/// The pressure is smoothed over 20 t_c (docs/choices.md §3).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Servo {
    /// p_z \[E\].
    pub target: f64,
    /// Fastest advance \[R/t_c\].
    pub speed: f64,
    /// The smoothed pressure \[E\].
    pub smoothed: f64,
}

impl Servo {
    /// The wall that moves: +z.
    const UP: usize = 5;

    /// A servo that has felt nothing yet.
    #[must_use]
    pub fn new(target: f64, speed: f64) -> Self {
        Self {
            target,
            speed,
            smoothed: 0.0,
        }
    }

    /// Moves the +z wall by one step.
    pub fn advance<R: Replicas, P: Physics>(&self, scene: &mut Scene<R, P>) {
        let drive = (self.smoothed / self.target - 1.0).clamp(-1.0, 1.0);
        let speed = self.speed * if drive > 0.0 { 0.1 * drive } else { drive };
        let time_step = scene.laws.time_step;
        let position = scene.walls.position(Self::UP, 0) + speed * time_step;
        scene.walls.advance(Self::UP, 0, position, time_step);
    }

    /// Takes in the pressure of the last step.
    pub fn feel<R: Replicas, P: Physics>(&mut self, scene: &Scene<R, P>) {
        let area = scene.walls.extent(0, 0) * scene.walls.extent(1, 0);
        let pressure = scene.walls.force[Self::UP][0] / area;
        self.smoothed += (pressure - self.smoothed) * (scene.laws.time_step / 20.0).min(1.0);
    }

    /// Whether the smoothed pressure is within `tolerance` of the target.
    #[must_use]
    pub fn is_settled(&self, tolerance: f64) -> bool {
        (self.smoothed / self.target - 1.0).abs() < tolerance
    }
}
