//! What presses on the vertices of a membrane: smooth rigid planes and rods.
//!
//! A vertex is a ball of radius r_v, and touches by Hertz's law with R_eff = r_v.

use crate::contact::hertz;
use crate::lanes::F64x1;
use crate::material::Material;
use crate::math::plain;

/// The ball that stands for a vertex.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct VertexBall {
    /// r_v \[m\].
    pub radius: f64,
    /// The membrane against something rigid.
    pub material: Material,
}

impl VertexBall {
    /// The tangent stiffness at an overlap \[N/m\]; zero if there is none.
    #[must_use]
    pub fn stiffness(&self, overlap: f64) -> f64 {
        1.5 * self.material.normal_stiffness * (self.radius * overlap.max(0.0)).sqrt()
    }

    /// The force at an overlap that grows at `rate` \[N\].
    fn push(&self, overlap: f64, rate: f64) -> f64 {
        let [overlap, rate, stiffness, damping, root] = [
            overlap,
            rate,
            self.material.normal_stiffness,
            self.material.normal_damping,
            (self.radius * overlap).sqrt(),
        ]
        .map(|x| F64x1([x]));
        hertz::normal_force(stiffness, damping, overlap, root, rate).0[0]
    }
}

/// A plane normal to an axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane {
    /// 0, 1, 2 for x, y, z.
    pub axis: usize,
    /// +1 if it pushes up its axis, −1 if down.
    pub inward: f64,
    /// Where it is \[m\].
    pub position: f64,
    /// How fast it moves up its axis \[m/s\].
    pub velocity: f64,
    /// The sum of its last pushes, against `inward` \[N\].
    pub force: f64,
}

impl Plane {
    /// How deep the ball of a vertex at `position` is in it; negative if it does not touch.
    #[must_use]
    pub fn overlap(&self, ball: &VertexBall, position: [f64; 3]) -> f64 {
        ball.radius - self.inward * (position[self.axis] - self.position)
    }

    /// Normal and tangent stiffness \[N/m\] of its contact with a vertex at `position`, if it touches.
    #[must_use]
    pub fn grasp(&self, ball: &VertexBall, position: [f64; 3]) -> Option<([f64; 3], f64)> {
        let overlap = self.overlap(ball, position);
        let mut normal = [0.0; 3];
        normal[self.axis] = self.inward;
        (overlap > 0.0).then(|| (normal, ball.stiffness(overlap)))
    }

    /// Pushes all vertices that it touches.
    pub fn press(
        &mut self,
        ball: &VertexBall,
        [positions, velocities]: [&[[f64; 3]]; 2],
        forces: &mut [[f64; 3]],
    ) {
        self.force = 0.0;
        for (v, &position) in positions.iter().enumerate() {
            let overlap = self.overlap(ball, position);
            if overlap > 0.0 {
                let rate = self.inward * (self.velocity - velocities[v][self.axis]);
                let push = ball.push(overlap, rate);
                forces[v][self.axis] += self.inward * push;
                self.force += push;
            }
        }
    }
}

/// A round rod along y.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rod {
    /// Where its axis is, in x and z \[m\].
    pub position: [f64; 2],
    /// How fast it moves up \[m/s\].
    pub velocity: f64,
    /// \[m\].
    pub radius: f64,
    /// The force of the membrane on it, upward \[N\].
    pub force: f64,
}

impl Rod {
    /// How deep the ball of a vertex at `position` is in it; negative if it does not touch.
    #[must_use]
    pub fn overlap(&self, ball: &VertexBall, [x, _, z]: [f64; 3]) -> f64 {
        let [dx, dz] = [x - self.position[0], z - self.position[1]];
        self.radius + ball.radius - (dx * dx + dz * dz).sqrt()
    }

    /// Normal and tangent stiffness \[N/m\] of its contact with a vertex at `position`, if it touches.
    #[must_use]
    pub fn grasp(&self, ball: &VertexBall, [x, y, z]: [f64; 3]) -> Option<([f64; 3], f64)> {
        let overlap = self.overlap(ball, [x, y, z]);
        let away = [x - self.position[0], 0.0, z - self.position[1]];
        let distance = plain::norm(away);
        (overlap > 0.0 && distance > 0.0)
            .then(|| (plain::scale(away, 1.0 / distance), ball.stiffness(overlap)))
    }

    /// Pushes all vertices that it touches.
    pub fn press(
        &mut self,
        ball: &VertexBall,
        [positions, velocities]: [&[[f64; 3]]; 2],
        forces: &mut [[f64; 3]],
    ) {
        self.force = 0.0;
        let reach = self.radius + ball.radius;
        for (v, &[x, _, z]) in positions.iter().enumerate() {
            let away = [x - self.position[0], 0.0, z - self.position[1]];
            let square = plain::dot(away, away);
            if square < reach * reach && square > 0.0 {
                let distance = square.sqrt();
                let normal = plain::scale(away, 1.0 / distance);
                let closing = plain::sub([0.0, 0.0, self.velocity], velocities[v]);
                let push = ball.push(reach - distance, plain::dot(closing, normal));
                forces[v] = plain::add(forces[v], plain::scale(normal, push));
                self.force -= push * normal[2];
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::material::Elastic;

    fn ball() -> VertexBall {
        let sheet = Elastic {
            youngs_modulus: 1e7,
            poisson_ratio: 1.0 / 3.0,
        };
        VertexBall {
            radius: 7e-4,
            material: Material::viscoelastic(sheet.against_rigid(), 7e-6),
        }
    }

    /// (4/3) E/(1 − ν²) √r ξ^(3/2).
    fn hertz(overlap: f64) -> f64 {
        4.0 / 3.0 * 1e7 / (1.0 - 1.0 / 9.0) * (7e-4 * overlap).sqrt() * overlap
    }

    #[test]
    fn plane_pushes_inward_by_hertzs_law() {
        let mut plane = Plane {
            axis: 2,
            inward: -1.0,
            position: 0.02,
            velocity: 0.0,
            force: 0.0,
        };
        let mut forces = [[0.0; 3]; 2];
        let places = [[0.0, 0.0, 0.0194], [0.0, 0.0, 0.0192]];
        plane.press(&ball(), [&places, &[[0.0; 3]; 2]], &mut forces);
        let f = hertz(1e-4);
        assert!((forces[0][2] + f).abs() < 1e-9 * f, "{forces:?}");
        assert!(plain::norm(forces[1]) < f64::MIN_POSITIVE);
        assert!((plane.force - f).abs() < 1e-9 * f);
    }

    #[test]
    fn rod_pushes_away_from_its_axis_and_is_pushed_back() {
        let mut rod = Rod {
            position: [0.1, 0.03],
            velocity: 0.0,
            radius: 0.01,
            force: 0.0,
        };
        let distance = 0.01 + 7e-4 - 1e-4;
        let places = [[0.1 + 0.6 * distance, 0.004, 0.03 - 0.8 * distance]];
        let mut forces = [[0.0; 3]];
        rod.press(&ball(), [&places, &[[0.0; 3]]], &mut forces);
        let f = hertz(1e-4);
        let expected = [0.6 * f, 0.0, -0.8 * f];
        assert!(
            plain::norm(plain::sub(forces[0], expected)) < 1e-9 * f,
            "{forces:?}"
        );
        assert!((rod.force - 0.8 * f).abs() < 1e-9 * f);
    }
}
