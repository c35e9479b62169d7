use super::*;
use crate::lanes::{F64x1, F64x8};
use crate::material::Elastic;

const SOLID: Elastic = Elastic {
    youngs_modulus: 1e8,
    poisson_ratio: 0.245,
};

fn law(model: TangentialStiffness, damping: f64) -> Mindlin {
    Mindlin::new(SOLID.against(SOLID), model, damping, 0.5)
}

fn contact(sliding_velocity: [f64; 3], normal_force: f64) -> Contact<F64x1> {
    let vector = |v: [f64; 3]| Vec3 {
        x: F64x1([v[0]]),
        y: F64x1([v[1]]),
        z: F64x1([v[2]]),
    };
    Contact {
        normal: vector([0.0, 0.0, 1.0]),
        sliding_velocity: vector(sliding_velocity),
        root_overlap: F64x1([1e-4]),
        reduced_mass: F64x1([4e-5]),
        normal_force: F64x1([normal_force]),
        time_step: F64x1([1e-5]),
        dither: F64x1([0.0]),
    }
}

fn force(law: Mindlin, contact: &Contact<F64x1>, history: &mut [F64x1; 3]) -> [f64; 3] {
    Mindlin::force(&law.constants(), contact, history, &mut ()).lane(0)
}

#[test]
fn stiffness_over_hertzs_is_what_each_model_says() {
    // BEAM §2: 1.147, 0.574 and 0.860 of the normal stiffness 2 E a at ν = 0.245.
    let normal = SOLID.against(SOLID).normal_slope();
    for (model, ratio) in [
        (TangentialStiffness::Paper, 1.147),
        (TangentialStiffness::Dimaio, 0.574),
        (TangentialStiffness::Mindlin, 0.860),
    ] {
        let found = law(model, 0.3).stiffness() / normal;
        assert!((found - ratio).abs() < 6e-4, "{model:?}: {found}");
    }
}

#[test]
fn sticking_force_is_spring_plus_dashpot() {
    let law = law(TangentialStiffness::Paper, 0.3);
    // (A3): k_t = 8 E/(2 (1 + ν) (2 − ν)) a, of which the spring takes two thirds.
    let k_t: f64 = 8.0 * 1e8 / (2.0 * 1.245 * 1.755) * 1e-4;
    let mut history = [F64x1([1e-6]), F64x1([0.0]), F64x1([0.0])];
    let [x, y, z] = force(law, &contact([1e-3, 0.0, 0.0], 10.0), &mut history);
    let expected = -2.0 / 3.0 * k_t * (1e-6 + 1e-8) - 0.3 * (4e-5 * k_t).sqrt() * 1e-3;
    assert!((x - expected).abs() < 1e-12 * expected.abs(), "{x}");
    assert!(y == 0.0 && z == 0.0);
    assert!((history[0].0[0] - 1.01e-6).abs() < 1e-20);
}

#[test]
fn sliding_force_is_on_the_limit_and_leaves_the_spring_there() {
    let law = law(TangentialStiffness::Mindlin, 0.3);
    let mut history = [F64x1([3e-5]), F64x1([-4e-5]), F64x1([0.0])];
    let [x, y, _] = force(law, &contact([0.3, -0.4, 0.0], 0.02), &mut history);
    assert!((x + 0.6 * 0.01).abs() < 1e-17 && (y - 0.8 * 0.01).abs() < 1e-17);
    let held = law.stiffness() * 1e-4 * history[0].0[0];
    assert!((held + x).abs() < 1e-17, "{held}");
}

#[test]
fn dashpot_never_pulls_beyond_the_limit() {
    // (A5) as printed would: a spring at rest, and a fast slip.
    let law = law(TangentialStiffness::Paper, 0.3);
    let mut history = [F64x1([0.0]); 3];
    let fast = contact([0.05, 0.0, 0.0], 0.02);
    let [x, y, z] = force(law, &fast, &mut history);
    assert!((x.hypot(y).hypot(z) - 0.01).abs() < 1e-16, "{x}");
}

#[test]
fn contact_without_normal_force_does_not_pull_and_forgets() {
    let law = law(TangentialStiffness::Paper, 0.3);
    for (spring, speed) in [(0.0, 0.0), (1e-6, 0.0), (0.0, 0.1), (1e-6, 0.1)] {
        let mut history = [F64x1([spring]), F64x1([0.0]), F64x1([0.0])];
        let pull = force(law, &contact([speed, 0.0, 0.0], 0.0), &mut history);
        assert!(pull.iter().all(|f| f.abs() < f64::MIN_POSITIVE), "{pull:?}");
        assert!(history[0].0[0].abs() < f64::MIN_POSITIVE);
    }
}

#[test]
fn contact_at_rest_does_not_pull_whatever_its_neighbors_in_the_vector_do() {
    // A lane at rest, one that slips, one whose overlap is below zero and not used.
    let law = law(TangentialStiffness::Paper, 0.3);
    let row = |numbers: [f64; 3]| {
        let [a, b, c] = numbers;
        F64x8([a, b, c, 0.0, 0.0, 0.0, 0.0, 0.0])
    };
    let zero = F64x8([0.0; 8]);
    let still = Vec3 {
        x: zero,
        y: zero,
        z: zero,
    };
    let contact = Contact {
        normal: Vec3 {
            z: F64x8([1.0; 8]),
            ..still
        },
        sliding_velocity: Vec3 {
            x: row([0.0, 0.3, 0.1]),
            ..still
        },
        root_overlap: row([1e-4, 1e-4, f64::NAN]),
        reduced_mass: F64x8([4e-5; 8]),
        normal_force: row([10.0, 0.02, 0.0]),
        time_step: F64x8([1e-5; 8]),
        dither: F64x8([0.0; 8]),
    };
    let mut history = [zero; 3];
    let pull = Mindlin::force(&law.constants(), &contact, &mut history, &mut ());
    for lane in [0, 3, 7] {
        assert!(pull.lane(lane).iter().all(|f| f.abs() < f64::MIN_POSITIVE));
        assert!(
            history
                .iter()
                .all(|part| part.0[lane].abs() < f64::MIN_POSITIVE)
        );
    }
    assert!((pull.lane(1)[0] + 0.01).abs() < 1e-17);
}

#[test]
fn friction_of_a_thousand_sticks_as_friction_of_ten_does() {
    let of = |friction| {
        let law = Mindlin::new(
            SOLID.against(SOLID),
            TangentialStiffness::Paper,
            0.3,
            friction,
        );
        let mut history = [F64x1([3e-5]), F64x1([-4e-5]), F64x1([0.0])];
        let pull = force(law, &contact([0.3, -0.4, 0.0], 10.0), &mut history);
        (pull, history.map(|part| part.0[0]))
    };
    let (ten, thousand) = (of(10.0), of(1e3));
    assert_eq!(ten, thousand);
    assert!(ten.0.iter().all(|f| f.is_finite()) && ten.0[0].abs() > 0.1);
}
