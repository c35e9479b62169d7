use super::*;
use crate::lanes::F64x8;
use crate::membrane::shapes::{SHEET, strip, tube};
use crate::membrane::{Bending, Cuboid, Sheet};

const UNDAMPED: Sheet = Sheet {
    damping_ratio: 0.0,
    ..SHEET
};

/// Numbers between −1 and 1 that look like chance.
fn noise(count: usize) -> Vec<f64> {
    let number = |i: usize| 2.0 * (0.618_033_988_749_894_9 * (i * i) as f64).fract() - 1.0;
    (1..=count).map(number).collect()
}

/// K x, by central differences of the forces.
fn stiffness_times(membrane: &mut Membrane, x: &[f64], step: f64) -> Vec<f64> {
    let start = membrane.mesh().positions().to_vec();
    let mut forces = [1.0, -1.0].map(|sign| {
        let places = membrane.positions_mut().as_flattened_mut();
        for ((part, x), from) in places.iter_mut().zip(x).zip(start.as_flattened()) {
            *part = from + sign * step * x;
        }
        membrane.begin_step();
        membrane.add_internal_forces::<F64x8>();
        membrane.forces().as_flattened().to_vec()
    });
    membrane.positions_mut().copy_from_slice(&start);
    let [ahead, behind] = &mut forces;
    let differences = ahead
        .iter()
        .zip(behind)
        .map(|(a, b)| (*b - a) / (2.0 * step));
    differences.collect()
}

/// ω² of the fastest mode by power iteration on M⁻¹K: from below.
fn measured_square(membrane: &mut Membrane) -> f64 {
    let masses: Vec<f64> = membrane.masses().iter().flat_map(|&m| [m; 3]).collect();
    let mut x = noise(masses.len());
    let mut square = 0.0;
    for _ in 0..600 {
        let force = stiffness_times(membrane, &x, 1e-7);
        let weight: f64 = x.iter().zip(&masses).map(|(x, m)| m * x * x).sum();
        square = x.iter().zip(&force).map(|(x, f)| x * f).sum::<f64>() / weight;
        x = force.iter().zip(&masses).map(|(f, m)| f / m).collect();
        let largest = x.iter().copied().map(f64::abs).fold(0.0, f64::max);
        for part in &mut x {
            *part /= largest;
        }
    }
    square
}

/// M6.
#[test]
fn fastest_mode_of_a_free_lattice_is_the_bound() {
    let mut membrane = Membrane::new(tube(60, 40, 0.05), &UNDAMPED).unwrap();
    let k = 0.75f64.sqrt() * 3000.0;
    let m = membrane.masses().iter().copied().fold(0.0, f64::max);
    let bound = membrane.fastest_frequency(&[]).powi(2);
    let measured = measured_square(&mut membrane);
    println!(
        "M6: ω² m/6k measured {:.5}, bound {:.5}",
        measured * m / (6.0 * k),
        bound * m / (6.0 * k)
    );
    assert!((measured * m / (6.0 * k) - 1.0).abs() < 0.01);
    assert!((bound * m / (6.0 * k) - 1.0).abs() < 0.01);
    assert!(measured <= bound);
}

#[test]
fn critical_time_steps_of_the_paper_follow() {
    for (edge_length, microseconds) in [(2.35e-3, 27.0), (4.7e-3, 54.0), (8e-3, 92.0)] {
        let radius = 0.5 * edge_length / libm::sin(std::f64::consts::PI / 300.0);
        let membrane = Membrane::new(tube(300, 2, radius), &UNDAMPED).unwrap();
        let step = 1e6 * membrane.critical_time_step(&[]);
        assert!((step - microseconds).abs() < 0.6, "{step}");
    }
}

#[test]
fn bound_holds_where_the_lattice_is_cut_stretched_or_bent() {
    let cuboid = Cuboid {
        length: 0.12,
        height: 0.02,
        depth: 0.024,
        edge_length: 4.7e-3,
    };
    // Stiff enough for folds to be faster than stretches.
    let bending = Some(Bending {
        stiffness: 0.1,
        damping: 0.0,
    });
    let sheets = [
        (cuboid.mesh().unwrap(), UNDAMPED, 1.0),
        (cuboid.mesh().unwrap(), UNDAMPED, 1.5),
        (strip(8, 6, 4.7e-3), UNDAMPED, 1.0),
        (
            strip(8, 6, 4.7e-3),
            Sheet {
                bending,
                ..UNDAMPED
            },
            1.0,
        ),
    ];
    for (mesh, sheet, stretch) in sheets {
        let mut membrane = Membrane::new(mesh, &sheet).unwrap();
        for place in membrane.positions_mut() {
            *place = plain::scale(*place, stretch);
        }
        let bound = membrane.fastest_frequency(&[]).powi(2);
        let measured = measured_square(&mut membrane);
        println!("measured/bound {:.3}", measured / bound);
        assert!(measured < bound * (1.0 + 1e-6) && measured > 0.4 * bound);
    }
}

/// The largest growth of the energy that leapfrog keeps, ½ Σ m v₋·v₊ + U, and its drift from the first step to the last.
fn energy_change(sheet: &Sheet, fraction: f64, steps: u32) -> (f64, f64) {
    let mut membrane = Membrane::new(tube(8, 4, 0.006), sheet).unwrap();
    let shake = noise(3 * membrane.masses().len());
    let velocities = membrane.velocities_mut().as_flattened_mut();
    velocities.copy_from_slice(&shake.iter().map(|x| 1e-5 * x).collect::<Vec<_>>());
    let time_step = fraction * membrane.critical_time_step(&[]);
    let (mut first, mut last, mut most) = (None, 0.0, 0.0f64);
    for _ in 0..steps {
        membrane.begin_step();
        membrane.add_internal_forces::<F64x8>();
        let stored = membrane.elastic_energy();
        let before = membrane.velocities().to_vec();
        membrane.advance(time_step);
        let after = membrane.velocities().iter().zip(membrane.masses());
        let moving = before.iter().zip(after);
        last = stored
            + moving
                .map(|(&u, (&v, m))| 0.5 * m * plain::dot(u, v))
                .sum::<f64>();
        let start = *first.get_or_insert(last);
        most = most.max(stored / start);
        if most > 10.0 {
            break;
        }
    }
    let start = first.unwrap_or(last);
    (most, (last / start - 1.0).abs())
}

#[test]
fn steps_below_the_critical_one_keep_the_energy_and_steps_above_do_not() {
    let (growth, drift) = energy_change(&UNDAMPED, 0.9, 100_000);
    println!("0.9 Δt_crit: energy drifts by {drift:.1e} in 1e5 steps");
    assert!(growth < 10.0 && drift < 0.01, "{growth} {drift}");
    let (growth, _) = energy_change(&UNDAMPED, 1.1, 10_000);
    assert!(growth > 10.0, "{growth}");
    // Damping shortens the step.
    let damped = Sheet {
        damping_ratio: 0.5,
        ..UNDAMPED
    };
    let (growth, _) = energy_change(&damped, 0.99, 10_000);
    assert!(growth < 10.0, "{growth}");
    let (growth, _) = energy_change(&damped, 1.1, 10_000);
    assert!(growth > 10.0, "{growth}");
}

#[test]
#[expect(clippy::float_cmp, reason = "nothing is rounded")]
fn largest_eigenvalue_of_known_tensors_is_found() {
    let mut tensor = [0.0; 6];
    assert_eq!(largest_eigenvalue(&tensor), 0.0);
    add_isotropic(&mut tensor, 2.0);
    assert_eq!(largest_eigenvalue(&tensor), 2.0);
    add_dyad(&mut tensor, [1.0, 2.0, 2.0], 1.0);
    assert!((largest_eigenvalue(&tensor) - 11.0).abs() < 1e-14);
    add_dyad(&mut tensor, [2.0, 1.0, -2.0], 3.0);
    assert!((largest_eigenvalue(&tensor) - 29.0).abs() < 1e-13);
}
