//! B1 of the beam's checks: a beam of known stiffness.
//!
//! Grains on a cubic lattice that cannot slip are springs: k along each row and k_t across, at the overlaps that the pressure
//! makes. Their bending stiffness is the sum over rows, k d_x Σ z²; rows slide with G = k_t/2d, half of k_t since grains roll.
//!
//! Supports and rods are those of every beam; what they give way is left out by taking the deflection from the rows' grains.

use super::*;
use crate::beam::probe;

/// Grains along, across and upright.
const COUNTS: [usize; 3] = [50, 5, 5];

const RADIUS: f64 = 1.7e-3;

/// Hard grains that stick, in a membrane with little to say.
fn hard() -> BeamPoint {
    let [length, depth, height] = COUNTS.map(|n| n as f64 * 2.0 * RADIUS);
    point(json!({
        "length": length, "depth": depth, "height": height, "membrane_edge": 2.0 * RADIUS, "membrane_thickness": 1e-4,
        "radius_min": RADIUS, "radius_max": RADIUS, "youngs_modulus": 1e9, "vertex_radius": 7e-4,
        "protocol": "A", "friction_coefficient": 1e3, "support": "pinned_roller", "bending_damping": 100.0,
        // Contacts begin all at once, between two looks at the critical step.
        "rod_speed": 5e-3, "preparation_time_step_fraction": 0.1,
        "rest_window": 0.02, "rest_volume_rate": 1e-2, "rest_force_ratio": 1e-2, "rest_energy_ratio": 1e-4,
    }))
}

/// The grains where they belong, touching nothing yet.
fn lattice(grow: &GrowSpec, mesh: &Mesh) -> Snapshot<Past> {
    let places = (0..COUNTS.iter().product()).map(|n: usize| {
        let [_, ny, nz] = COUNTS;
        let index = [n / (ny * nz), n / nz % ny, n % nz];
        [0, 1, 2].map(|a| 2.0 * RADIUS * (index[a] as f64 - 0.5 * (COUNTS[a] as f64 - 1.0)))
    });
    let places: Vec<[f64; 3]> = places.collect();
    let still = crate::grains::Motion {
        velocity: [0.0; 3],
        spin: [0.0; 3],
    };
    Snapshot {
        header: Past {
            grow: grow.clone(),
            jam: None,
            warnings: vec![],
        },
        displacements: vec![[0.0; 3]; places.len()],
        motions: vec![still; places.len()],
        radii: vec![RADIUS; places.len()],
        reference: places,
        contacts: vec![],
        vertices: mesh.positions().to_vec(),
        velocities: vec![[0.0; 3]; mesh.positions().len()],
        held: vec![],
    }
}

/// Means over the contacts of one direction, away from the ends.
#[derive(Clone, Copy, Debug, Default)]
struct Row {
    /// Between neighbors \[m\].
    spacing: f64,
    /// k \[N/m\].
    along: f64,
    /// k_t \[N/m\].
    across: f64,
}

/// The rows along each axis in the middle half of the beam.
fn rows(run: &Run<Mindlin>) -> [Row; 3] {
    let place = |i: usize| run.beam.grains.pose(i, 0).position;
    let half = 0.5 * COUNTS[0] as f64 * RADIUS;
    let mut found = [(Row::default(), 0.0); 3];
    for contact in probe::contacts(&run.beam) {
        let branch = plain::sub(place(contact.j), place(contact.i));
        if place(contact.i)[0].abs() > half {
            continue;
        }
        let size = branch.map(f64::abs);
        let axis = (0..3)
            .max_by(|&a, &b| size[a].total_cmp(&size[b]))
            .expect("three");
        let (row, count) = &mut found[axis];
        row.spacing += size[axis];
        row.along += 1.5 * contact.normal_force / contact.overlap;
        row.across += run.beam.laws.tangential.slope() * contact.radius;
        *count += 1.0;
    }
    found.map(|(row, count)| Row {
        spacing: row.spacing / count,
        along: row.along / count,
        across: row.across / count,
    })
}

/// Mean height of the grains of a cross-section, by place between two of them.
fn height(run: &Run<Mindlin>, x: f64) -> f64 {
    let place = |i: usize| run.beam.grains.pose(i, 0).position;
    let section = COUNTS[1] * COUNTS[2];
    let mean = |s: usize, axis: usize| {
        (s * section..(s + 1) * section)
            .map(|i| place(i)[axis])
            .sum::<f64>()
            / section as f64
    };
    let right = (1..COUNTS[0] - 1)
        .find(|&s| mean(s, 0) >= x)
        .unwrap_or(COUNTS[0] - 1);
    let [a, b] = [right - 1, right].map(|s| [mean(s, 0), mean(s, 2)]);
    a[1] + (b[1] - a[1]) * (x - a[0]) / (b[0] - a[0])
}

/// What the rods of a beam do, step by step.
struct Press<'a> {
    run: Run<Mindlin>,
    /// The speed of the rods \[m/s\].
    speed: f64,
    /// Where the supports are along the beam.
    supports: [f64; 2],
    progress: Progress<'a>,
}

impl Press<'_> {
    /// Lowers the rods, waits for rest, and returns their force and how far the middle is below the supports.
    fn lower(&mut self, way: f64) -> [f64; 2] {
        let until = self.run.time + way / self.speed;
        while self.run.time < until + 0.1 {
            let moves = self.run.time < until;
            for rod in &mut self.run.beam.surroundings.press.rods {
                rod.velocity = if moves { -self.speed } else { 0.0 };
            }
            let stepped = self.run.advance(&mut self.progress, &|_| vec![]);
            stepped.expect("a stable step");
        }
        let rods = self.run.beam.surroundings.press.rods.iter();
        let [left, right] = self.supports;
        let ends = 0.5 * (height(&self.run, left) + height(&self.run, right));
        let sag = ends - height(&self.run, 0.5 * (left + right));
        [rods.map(|rod| rod.force).sum(), sag]
    }
}

/// Four-point bending of a beam that also shears: sag = 23 F L³/(1296 EI) + F L/(6 κ G A), κ = 5/6.
///
/// The membrane adds E_m t (h² d/2 + h³/6) to EI, 2 %. Within 5 %, as the check asks: contacts stiffen by a tenth where the beam
/// is pressed most and soften by as much where it is stretched.
#[test]
fn b1_lattice_of_springs_bends_as_its_rows_do() {
    let point = hard();
    let (grow, jam) = (point.grow(), point.jam(StageId::of_bytes(b"grown")));
    let spec = point.bend(StageId::of_bytes(b"jammed"));
    let rig = Rig {
        friction_coefficient: point.friction_coefficient,
        ..rig(&grow, &jam)
    };
    let built = rig.membrane().expect("a membrane");
    let grown = lattice(&grow, built.mesh()).to_bytes();
    let jammed = finished(|width, progress| jam::run(&jam, "jam", (&grown, None), width, progress));
    let state = Snapshot::<Past>::from_bytes(&jammed.artifacts[STATE]).expect("a beam");
    let mut bench = Bench {
        spec: &spec,
        past: &state.header,
        jam: &jam,
        stage: "bend",
        places: places(built.mesh(), grow.membrane_edge),
    };
    let mut go_on = |_: &crate::outcome::Report<'_>| ControlFlow::Continue(());
    let mut progress = Progress {
        watch: &mut go_on,
        steps: 0,
    };
    let run = mounted(&mut bench, (&rig, &state), &mut progress);
    let mesh = run.beam.surroundings.membrane.mesh();
    let [depth, height] = [1, 2].map(|axis| bench.extent(mesh, axis));
    let supports = bench
        .places
        .supports
        .each_ref()
        .map(|side| mean(mesh, side, 0));
    let span = supports[1] - supports[0];
    let [x, y, z] = rows(&run);
    let [_, ny, nz] = COUNTS.map(|n| n as f64);
    let of_rows = x.along * x.spacing * ny * z.spacing.powi(2) * nz * (nz * nz - 1.0) / 12.0;
    let sheet = grow.membrane_youngs_modulus * jam.membrane_thickness;
    let of_sheet = sheet * (height.powi(2) * depth / 2.0 + height.powi(3) / 6.0);
    let shear = 0.5 * x.across / x.spacing * ny * y.spacing * nz * z.spacing;
    let compliance = 23.0 * span.powi(3) / 1296.0 / (of_rows + of_sheet) + span / 5.0 / shear;
    println!("B1: EI {of_rows:.4e} of rows, {of_sheet:.4e} of the membrane, L {span:.4e}");
    let mut press = Press {
        run,
        speed: spec.rod_speed,
        supports,
        progress,
    };
    let found = [press.lower(2e-4), press.lower(2e-4), press.lower(2e-4)];
    for pair in found.windows(2) {
        let [force, sag] = [0, 1].map(|n| pair[1][n] - pair[0][n]);
        let ratio = force * compliance / sag;
        println!("B1: {force:.4e} N, {sag:.4e} m: {ratio:.4} of the sag expected of it");
        assert!((ratio - 1.0).abs() < 0.05, "{ratio}");
    }
}
