//! What is measured of a beam while it is made and bent: contacts, energies, and the longest stable step.

use super::rig::{Beam, Friction};
use crate::contact::Components;
use crate::math::plain;
use crate::membrane::Hold;

/// A contact of two grains, at rest: without what its dashpots add.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct GrainContact {
    pub(super) i: usize,
    pub(super) j: usize,
    /// p \[m\].
    pub(super) overlap: f64,
    /// a = √(R_eff p) \[m\].
    pub(super) radius: f64,
    /// \[N\].
    pub(super) normal_force: f64,
    /// \[N\].
    pub(super) tangential_force: f64,
}

/// All contacts of grains with grains, by numbers.
pub(super) fn contacts<T: Friction>(beam: &Beam<T>) -> Vec<GrainContact> {
    let grains = &beam.grains;
    let (stiffness, slope) = (
        beam.laws.material.normal_stiffness,
        beam.laws.tangential.slope(),
    );
    let mut found = vec![];
    for (i, key, history) in beam.histories() {
        let j = key.j as usize;
        let branch = plain::sub(grains.pose(i, 0).position, grains.pose(j, 0).position);
        let (a, b) = (grains.radius(i), grains.radius(j));
        let overlap = a + b - plain::norm(branch);
        if overlap <= 0.0 {
            continue;
        }
        let radius = (a * b / (a + b) * overlap).sqrt();
        let parts = history.as_slice().iter().map(|part| part.0[0]);
        let spring = parts.map(|x| x * x).sum::<f64>().sqrt();
        found.push(GrainContact {
            i,
            j,
            overlap,
            radius,
            normal_force: stiffness * radius * overlap,
            tangential_force: slope * radius * spring,
        });
    }
    found
}

/// The longest stable step \[s\], by the sums of stiffness on each body.
#[derive(Clone, Copy, Debug)]
pub(super) struct CriticalTimeStep {
    /// 2/ω_max: were there no damping.
    pub(super) undamped: f64,
    /// Of grains, with the damping of their contacts: the stiffer they are, the more of it is due to that.
    pub(super) damped: f64,
}

/// Of a grain ω² = (2/m) Σ (k_n + 2 k_t)/3 + (2·(2/3)·2.5/m) Σ k_t, and with its contacts' damping c = (2/m) Σ c_n/3 its
/// step Δt is stable while ω² Δt² + 2 c Δt < 4 (`observable::critical_time_step`); the membrane's bound takes its springs and
/// its contacts with grains, planes and rods together.
pub(super) fn critical_time_step<T: Friction>(
    beam: &Beam<T>,
    contacts: &[GrainContact],
) -> CriticalTimeStep {
    let casing = &beam.surroundings;
    let mut of_grains = vec![[0.0; 3]; beam.grains.len()];
    // d(K a p)/dp = (3/2) K a.
    let along = 1.5 * beam.laws.material.normal_stiffness;
    let across = beam.laws.tangential.slope();
    let damping = beam.laws.material.normal_damping;
    for contact in contacts {
        for body in [contact.i, contact.j] {
            of_grains[body][0] += along * contact.radius;
            of_grains[body][1] += across * contact.radius;
            of_grains[body][2] += damping * contact.radius;
        }
    }
    let grip = &casing.grip;
    let mut holds = vec![];
    for touch in casing.touches(&beam.grains, beam.laws.width) {
        let i = touch.grain as usize;
        let radius = (beam.grains.radius(i) * touch.overlap.max(0.0)).sqrt();
        let along = 1.5 * grip.material.normal_stiffness * radius;
        let across = grip.tangential.stiffness() * radius;
        of_grains[i][0] += along;
        of_grains[i][1] += across;
        of_grains[i][2] += grip.material.normal_damping * radius;
        holds.extend(touch.shares.iter().map(|&(vertex, weight)| Hold {
            vertex,
            normal: touch.normal,
            along: weight * along,
            across: weight * across,
        }));
    }
    let press = &casing.press;
    for (vertex, &place) in (0..).zip(casing.membrane.mesh().positions()) {
        let planes = press
            .planes
            .iter()
            .map(|plane| plane.grasp(&press.ball, place));
        let rods = press.rods.iter().map(|rod| rod.grasp(&press.ball, place));
        holds.extend(planes.chain(rods).flatten().map(|(normal, along)| Hold {
            vertex,
            normal,
            along,
            across: 0.0,
        }));
    }
    let (mut fastest, mut damped) = (0.0f64, f64::INFINITY);
    for (&[along, across, damping], size) in of_grains.iter().zip(beam.grains.sizes()) {
        let twice = 2.0 * size.inverse_mass;
        let square = twice * ((along + 2.0 * across) / 3.0 + 5.0 / 3.0 * across);
        let damping = twice * damping / 3.0;
        fastest = fastest.max(square);
        // The root of ω² Δt² + 2 c Δt − 4 that keeps its digits.
        damped = damped.min(4.0 / (damping + (damping * damping + 4.0 * square).sqrt()));
    }
    let grains = 2.0 / fastest.sqrt();
    CriticalTimeStep {
        undamped: grains.min(casing.membrane.critical_time_step(&holds)),
        damped,
    }
}

/// Kinetic and elastic energy of grains and membrane \[J\].
pub(super) fn energies<T: Friction>(beam: &Beam<T>, contacts: &[GrainContact]) -> [f64; 2] {
    let grains = &beam.grains;
    let moving = |(i, size): (usize, &crate::grains::Size)| {
        let motion = grains.motion(i, 0);
        0.5 * (plain::dot(motion.velocity, motion.velocity) / size.inverse_mass
            + plain::dot(motion.spin, motion.spin) / size.inverse_inertia)
    };
    let kinetic: f64 = grains.sizes().iter().enumerate().map(moving).sum();
    let slope = beam.laws.tangential.slope();
    // ∫ K a p dp = (2/5) f p; f_t²/(2 κ a).
    let stored = |c: &GrainContact| {
        let across = if slope > 0.0 {
            0.5 * c.tangential_force * c.tangential_force / (slope * c.radius)
        } else {
            0.0
        };
        0.4 * c.normal_force * c.overlap + across
    };
    let elastic: f64 = contacts.iter().map(stored).sum();
    let casing = &beam.surroundings;
    let against = casing
        .held()
        .map(|held| 0.4 * held.normal_force * held.overlap);
    let membrane = &casing.membrane;
    [
        kinetic + membrane.kinetic_energy(),
        elastic + against.sum::<f64>() + membrane.elastic_energy(),
    ]
}

/// Mean force between grains \[N\]; zero if none touch.
pub(super) fn mean_force(contacts: &[GrainContact]) -> f64 {
    let force = |c: &GrainContact| libm::hypot(c.normal_force, c.tangential_force);
    contacts.iter().map(force).fold(0.0, |sum, f| sum + f) / contacts.len().max(1) as f64
}

/// Mean net force on a grain \[N\], from its velocities before the last step.
pub(super) fn mean_net_force<T: Friction>(beam: &Beam<T>, before: &[[f64; 3]]) -> f64 {
    let net = |(i, size): (usize, &crate::grains::Size)| {
        let change = plain::sub(beam.grains.motion(i, 0).velocity, before[i]);
        plain::norm(change) / (size.inverse_mass * beam.laws.time_step)
    };
    let sum: f64 = beam.grains.sizes().iter().enumerate().map(net).sum();
    sum / before.len().max(1) as f64
}

/// Σ 4π R³/3 \[m³\].
pub(super) fn grain_volume<T: Friction>(beam: &Beam<T>) -> f64 {
    let volume = |r: f64| 4.0 / 3.0 * std::f64::consts::PI * r * r * r;
    beam.grains
        .sizes()
        .iter()
        .map(|size| volume(size.radius))
        .fold(0.0, |sum, volume| sum + volume)
}
