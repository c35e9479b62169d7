//! What LAMMPS reads: the pack, its rigid bodies, and a script that steps them under the laws of our own bench.
//!
//! Between two grains LAMMPS computes f_n = K √R_e p^(3/2) + G m_e √(R_e p) ṗ, never below zero, with R_e = R/2 and m_e = m/2;
//! at a wall R_e = R and m_e = m. K and G are chosen such that this is Eq. (3) with our k_n, γ_n, k_w and γ_w.
//! Its friction is law H but for the damping, which goes as √p where ours is constant: the two agree at the overlap where
//! Mindlin's stiffness k_M √p is k_H.

use std::fmt::Write;
use std::path::Path;

use anyhow::Context;
use granary_core::bench::{POISSON_RATIO, PackFile, Settings, friction, material};
use granary_core::grains::Pose;
use granary_core::math::plain;
use granary_core::shape::Body;

/// The script's name in the directory where LAMMPS runs.
pub(super) const SCRIPT: &str = "in.bench";
const DATA: &str = "pack.data";
const BODIES: &str = "pack.bodies";

const AXES: [&str; 3] = ["x", "y", "z"];

/// How far the box in which LAMMPS looks for atoms reaches beyond the walls \[R\].
const MARGIN: f64 = 0.2;
/// How far LAMMPS looks for the atoms of a rigid body \[R\]: two spheres of one grain are at most 2 R apart.
const BODY_CUTOFF: f64 = 4.2;

/// The files of one run.
pub(super) struct Input {
    script: String,
    data: String,
    /// Only where grains have more than one sphere.
    bodies: Option<String>,
}

impl Input {
    /// The input that takes the steps of `runs`, one run after the other.
    pub(super) fn new(
        pack: &PackFile,
        settings: &Settings,
        body: &Body,
        poses: &[Pose],
        runs: [u64; 2],
    ) -> Self {
        let rigid = body.arms.len() > 1;
        let [warm_up, timed] = runs;
        Self {
            script: script(pack, settings, body) + &format!("run {warm_up}\nrun {timed}\n"),
            data: data(pack, body, poses),
            bodies: rigid.then(|| bodies(pack, body, poses)),
        }
    }

    /// Writes the files into `directory`.
    ///
    /// # Errors
    /// If one of them cannot be written.
    pub(super) fn write(&self, directory: &Path) -> anyhow::Result<()> {
        let files = [
            (SCRIPT, Some(&self.script)),
            (DATA, Some(&self.data)),
            (BODIES, self.bodies.as_ref()),
        ];
        for (name, text) in files {
            let Some(text) = text else { continue };
            let place = directory.join(name);
            std::fs::write(&place, text)
                .with_context(|| format!("cannot write {}", place.display()))?;
        }
        Ok(())
    }
}

/// k and γ of a normal law, and R_e and m_e of who touches, all in SI units.
struct Hertz {
    stiffness: f64,
    damping: f64,
    radius: f64,
    mass: f64,
}

impl Hertz {
    /// The law in LAMMPS' words, with K and G.
    fn words(&self) -> String {
        let stiffness = self.stiffness / self.radius.sqrt();
        let damping = self.damping / (self.mass * self.radius.sqrt());
        format!("hertz {stiffness:e} {damping:e}")
    }
}

/// The laws of two grains, and of a grain at a wall.
fn laws(pack: &PackFile, body: &Body) -> [String; 2] {
    let (radius, mass, units) = (pack.radius, mass(pack, body), pack.units());
    let (material, friction) = (material(), friction(&units));
    // The unit of k_n, E R^½ [N m^(−3/2)].
    let unit = units.pressure * radius.sqrt();
    let pair = Hertz {
        stiffness: material.normal_stiffness * unit,
        damping: material.normal_damping * unit * units.time,
        radius: radius / 2.0,
        mass: mass / 2.0,
    };
    let wall = Hertz {
        stiffness: material.wall_stiffness * unit,
        damping: material.wall_damping * unit * units.time,
        radius,
        mass,
    };
    // LAMMPS wants γ_t/γ_n, which is k_M/k_n = 3 (1 − ν)/(2 − ν) times the ratio of γ_H/k_H to γ_n/k_n.
    let mindlin = 3.0 * (1.0 - POISSON_RATIO) / (2.0 - POISSON_RATIO);
    let relaxation = friction.damping / friction.stiffness;
    let damping = mindlin * relaxation * material.normal_stiffness / material.normal_damping;
    let friction = format!(
        "tangential linear_history {:e} {damping:e} {:e}",
        friction.stiffness * units.pressure * radius,
        friction.friction_coefficient
    );
    [
        format!("{} {friction} limit_damping", pair.words()),
        format!(
            "{} tangential linear_nohistory 0 0 limit_damping",
            wall.words()
        ),
    ]
}

/// m \[kg\].
fn mass(pack: &PackFile, body: &Body) -> f64 {
    body.mass * pack.density * pack.radius.powi(3)
}

/// Everything but the `run` lines.
fn script(pack: &PackFile, settings: &Settings, body: &Body) -> String {
    let [pair, wall] = laws(pack, body);
    let skin = settings.skin * pack.radius;
    let time_step = settings.time_step * pack.units().time;
    let reach = BODY_CUTOFF * pack.radius;
    let (style, exclude, motion) = if body.arms.len() > 1 {
        (
            "hybrid sphere molecular",
            " exclude molecule/intra all",
            format!(
                "comm_modify cutoff {reach:e}\nfix motion all rigid/small molecule infile {BODIES}"
            ),
        )
    } else {
        ("sphere", "", "fix motion all nve/sphere".to_owned())
    };
    let mut text = format!(
        "units si
atom_style {style}
boundary f f f
comm_modify vel yes
newton off
read_data {DATA}
neighbor {skin:e} bin
neigh_modify every 1 delay 0 check yes{exclude}
pair_style granular
pair_coeff * * {pair}
timestep {time_step:e}
{motion}
"
    );
    for (axis, [low, high]) in AXES.into_iter().zip(pack.r#box) {
        let _ = writeln!(
            text,
            "fix wall_{axis} all wall/gran granular {wall} {axis}plane {low:e} {high:e}"
        );
    }
    text + "thermo_style custom step\n"
}

/// The box and the spheres: number, type, place, diameter and density; for a rigid body also its own number.
fn data(pack: &PackFile, body: &Body, poses: &[Pose]) -> String {
    let (radius, density, spheres) = (pack.radius, pack.density, body.arms.len());
    let rigid = spheres > 1;
    let mut text = format!("pack\n\n{} atoms\n1 atom types\n", poses.len() * spheres);
    for (axis, [low, high]) in AXES.into_iter().zip(pack.r#box) {
        let margin = MARGIN * radius;
        let (low, high) = (low - margin, high + margin);
        let _ = writeln!(text, "{low:e} {high:e} {axis}lo {axis}hi");
    }
    let style = if rigid { "hybrid" } else { "sphere" };
    let _ = writeln!(text, "\nAtoms # {style}\n");
    let diameter = 2.0 * radius;
    for (grain, pose) in poses.iter().enumerate() {
        for (sphere, &arm) in body.arms.iter().enumerate() {
            let atom = grain * spheres + sphere + 1;
            let place = plain::add(pose.position, plain::rotate(pose.orientation, arm));
            let [x, y, z] = place.map(|x| x * radius);
            let _ = if rigid {
                let number = grain + 1;
                writeln!(
                    text,
                    "{atom} 1 {x:e} {y:e} {z:e} {diameter:e} {density:e} {number}"
                )
            } else {
                writeln!(text, "{atom} 1 {diameter:e} {density:e} {x:e} {y:e} {z:e}")
            };
        }
    }
    text
}

/// Mass and inertia of every union, which LAMMPS would otherwise add up over overlapping spheres; all at rest.
///
/// A line is number, mass, center, six moments of inertia, velocity, angular momentum and three counts of box lengths.
fn bodies(pack: &PackFile, body: &Body, poses: &[Pose]) -> String {
    let mass = mass(pack, body);
    let inertia = body.inertia * pack.density * pack.radius.powi(5);
    let mut text = format!("{}\n", poses.len());
    for (grain, pose) in poses.iter().enumerate() {
        let [x, y, z] = pose.position.map(|x| x * pack.radius);
        let number = grain + 1;
        let _ = writeln!(
            text,
            "{number} {mass:e} {x:e} {y:e} {z:e} {inertia:e} {inertia:e} {inertia:e} 0 0 0  0 0 0  0 0 0  0 0 0"
        );
    }
    text
}

#[cfg(test)]
mod tests;
