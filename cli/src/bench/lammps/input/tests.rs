use granary_core::lanes::VectorWidth;
use granary_core::memory::spec::{ForceLaw, Precision};

use super::*;

/// Two grains of R = 0.5 mm, 0.95 mm apart along z; the second, if it can be, turned by 90° about x.
fn input(kind: &str) -> Input {
    let places = [[1e-3, 1e-3, 1e-3], [1e-3, 1e-3, 1.95e-3]];
    let half = std::f64::consts::FRAC_1_SQRT_2;
    let pack = PackFile {
        kind: kind.to_owned(),
        radius: 0.5e-3,
        density: 1200.0,
        r#box: [[0.0, 2e-3], [0.0, 2e-3], [0.0, 3e-3]],
        overlap: 0.6,
        positions: places.to_vec(),
        com: places.to_vec(),
        quat: vec![[0.0, 0.0, 0.0, 1.0], [half, 0.0, 0.0, half]],
    };
    let settings = Settings {
        lanes: 1,
        precision: Precision::F64,
        force_law: ForceLaw::H,
        time_step: 0.1,
        skin: 0.05,
        width: VectorWidth::PORTABLE,
    };
    let body = pack.body().expect("is known");
    Input::new(&pack, &settings, &body, &pack.poses(), [200, 700])
}

/// The numbers of the lines after `heading`.
fn numbers(text: &str, heading: &str) -> Vec<Vec<f64>> {
    let lines = text.lines().skip_while(|line| *line != heading).skip(1);
    let lines = lines.filter(|line| !line.is_empty());
    let words = |line: &str| {
        line.split_whitespace()
            .map(|word| word.parse().expect("is a number"))
            .collect()
    };
    lines.map(words).collect()
}

fn is_near(found: &[f64], expected: &[f64], relative: f64) {
    assert_eq!(found.len(), expected.len(), "{found:?}");
    for (a, b) in found.iter().zip(expected) {
        assert!(
            (a - b).abs() <= relative * b.abs(),
            "{found:?} {expected:?}"
        );
    }
}

#[test]
fn two_spheres_are_two_atoms_in_meters() {
    let input = input("spheres");
    assert!(input.data.contains("\n2 atoms\n1 atom types\n"));
    assert!(
        input.data.contains("\n-1e-4 3.1e-3 zlo zhi\n"),
        "{}",
        input.data
    );
    let atoms = numbers(&input.data, "Atoms # sphere");
    assert_eq!(atoms.len(), 2);
    is_near(
        &atoms[0],
        &[1.0, 1.0, 1e-3, 1200.0, 1e-3, 1e-3, 1e-3],
        1e-12,
    );
    is_near(
        &atoms[1],
        &[2.0, 1.0, 1e-3, 1200.0, 1e-3, 1e-3, 1.95e-3],
        1e-12,
    );
    assert!(input.bodies.is_none());
    assert!(input.script.contains("\nfix motion all nve/sphere\n"));
    assert!(input.script.ends_with("\nrun 200\nrun 700\n"));
}

#[test]
fn two_tetrahedra_are_eight_atoms_in_two_bodies() {
    let input = input("tetra");
    assert!(input.data.contains("\n8 atoms\n"));
    let atoms = numbers(&input.data, "Atoms # hybrid");
    let owners: Vec<f64> = atoms.iter().map(|atom| atom[7]).collect();
    is_near(&owners, &[1.0, 1.0, 1.0, 1.0, 2.0, 2.0, 2.0, 2.0], 0.0);
    // 𝒪 = 0.6: each center is 0.4 R/√2 from the middle along every axis. The turn takes (1, −1, −1) to (1, 1, −1).
    let arm = 0.2e-3 * std::f64::consts::FRAC_1_SQRT_2;
    let up = 1e-3 + arm;
    is_near(&atoms[0], &[1.0, 1.0, up, up, up, 1e-3, 1200.0, 1.0], 1e-12);
    let turned = [6.0, 1.0, up, up, 1.95e-3 - arm, 1e-3, 1200.0, 2.0];
    is_near(&atoms[5], &turned, 1e-12);
    // Mass and inertia of the union: 9.648 ρ R³ and 6.932 ρ R⁵, by 200³ voxels, which are good to 1e-3.
    let bodies = numbers(input.bodies.as_deref().expect("are there"), "2");
    assert_eq!(bodies.len(), 2);
    let inertia = 6.932 * 1200.0 * 0.5e-3f64.powi(5);
    let mut second = vec![2.0, 9.648 * 1200.0 * 0.125e-9, 1e-3, 1e-3, 1.95e-3];
    second.extend([inertia; 3]);
    second.extend([0.0; 12]);
    is_near(&bodies[1], &second, 1.5e-4);
    assert!(input.script.contains("exclude molecule/intra all\n"));
}

#[test]
fn laws_are_hertz_and_hooke_of_silicone_rubber() {
    // k_n = 1.3871464e5 N m^(−3/2) and γ_n = 0.23 t_c k_n with t_c = 5.4772256e-6 s: K = k_n/√(R/2), G = γ_n/(m/2 √(R/2)).
    let mass = 1200.0 * 4.0 / 3.0 * std::f64::consts::PI * 0.125e-9;
    let stiffness = 1.387_146_405_302_618_5e5 / 0.25e-3f64.sqrt();
    let damping = 0.23 * 5.477_225_575_051_662e-6 * stiffness / (0.5 * mass);
    let script = input("spheres").script;
    let law = |start: &str| -> Vec<f64> {
        let line = script.lines().find(|line| line.starts_with(start));
        let words = line.expect("is there").split_whitespace();
        words.filter_map(|word| word.parse().ok()).collect()
    };
    // Friction: 670 N/m, 0.3 · 3 (1 − ν)/(2 − ν), μ = 1.
    let friction = [670.0, 0.3 * 3.0 * 0.51 / 1.51, 1.0];
    let pair = [&[stiffness, damping], &friction[..]].concat();
    is_near(&law("pair_coeff"), &pair, 1e-12);
    // A wall pushes √2 as hard at the same overlap: f = K √R p^(3/2) with the pair's K, and half its G since m_e is twice as large.
    let wall = [stiffness, 0.5 * damping, 0.0, 0.0, 0.0, 3e-3];
    is_near(&law("fix wall_z"), &wall, 1e-12);
    is_near(&law("neighbor"), &[0.025e-3], 1e-12);
    is_near(&law("timestep"), &[5.477_225_575_051_662e-7], 1e-12);
}
