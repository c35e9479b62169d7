use super::*;
use crate::beam::noise;

/// σ = S (1 − e^{−ε/e}) + q (ε − t)², the last only for ε > t: a beam that saturates and is pulled taut.
#[derive(Clone, Copy, Debug)]
struct Beam {
    plateau: f64,
    strain: f64,
    quadratic: f64,
    taut: f64,
}

/// Saturates early, taut late: at Y_b the curve is nearly flat.
const FLAT: Beam = Beam {
    plateau: 90e3,
    strain: 0.012,
    quadratic: 6e7,
    taut: 0.045,
};

/// The two branches overlap everywhere: at Y_b the slope is still 0.3 of the first.
const GENTLE: Beam = Beam {
    plateau: 80e3,
    strain: 0.015,
    quadratic: 1.48e7,
    taut: 0.0,
};

impl Beam {
    fn stress(self, strain: f64) -> f64 {
        let taut = (strain - self.taut).max(0.0);
        -self.plateau * libm::expm1(-strain / self.strain) + self.quadratic * taut * taut
    }

    /// Where S/e² e^{−ε/e} = 2q, or where the beam comes taut if that is later.
    fn turn(self) -> Point {
        let bend = self.plateau / (self.strain * self.strain);
        let strain = (self.strain * libm::log(bend / (2.0 * self.quadratic))).max(self.taut);
        Point {
            strain,
            stress: self.stress(strain),
        }
    }

    /// Samples up to `end`, with noise of a part of Y_b.
    fn curve(self, end: f64, noise: f64, seed: u64) -> Curve {
        curve(
            end,
            |strain| self.stress(strain),
            noise * self.turn().stress,
            seed,
        )
    }
}

/// Samples of `stress` every 5·10⁻⁵ up to `end`, with noise of a standard deviation \[Pa\].
fn curve(end: f64, stress: impl Fn(f64) -> f64, deviation: f64, seed: u64) -> Curve {
    let count = (end / 5e-5).round() as u64;
    let point = |k| {
        let strain = 5e-5 * k as f64;
        let stress = stress(strain) + deviation * noise::gaussian(seed, k);
        Point { strain, stress }
    };
    (0..=count).map(point).collect()
}

fn reason(curve: &Curve) -> Reason {
    ultimate_strength(curve).expect_err("no strength").reason
}

/// σ where the slope is least with one width, prominent or not.
fn stress_at(curve: &Curve, width: f64) -> f64 {
    least_slope(&resample(&rising(curve.points())), width)
        .expect("a minimum")
        .at
        .stress
}

#[test]
fn strength_is_the_stress_where_the_curve_turns() {
    for beam in [FLAT, GENTLE] {
        let found = ultimate_strength(&beam.curve(0.08, 0.0, 0)).expect("it turns");
        let turn = beam.turn();
        assert!((found.ultimate_strength / turn.stress - 1.0).abs() < 0.01);
        assert!((found.strain - turn.strain).abs() < 4e-3);
        assert!(found.spread < 0.01 * turn.stress);
        // Smoothing rounds the kink of the flat beam and so raises its least slope, by 0.03 of the first at most.
        let slope = (beam.stress(turn.strain + 1e-6) - turn.stress) / 1e-6;
        let first = beam.plateau / beam.strain;
        assert!((found.least_slope - slope).abs() < 0.03 * first);
    }
}

#[test]
fn noise_up_to_2_percent_moves_the_strength_by_less_than_3_percent() {
    for noise in [0.005, 0.01, 0.02] {
        for seed in 0..20 {
            let found = ultimate_strength(&FLAT.curve(0.08, noise, seed)).expect("it turns");
            assert!((found.ultimate_strength / FLAT.turn().stress - 1.0).abs() < 0.03);
        }
    }
}

#[test]
fn each_width_finds_the_strength_within_3_percent() {
    for seed in 0..20 {
        let curve = FLAT.curve(0.08, 0.02, seed);
        for width in [1e-3, 2e-3, 3e-3, 4e-3, 6e-3] {
            let error = stress_at(&curve, width) / FLAT.turn().stress - 1.0;
            assert!(error.abs() < 0.03, "{width} {error}");
        }
    }
}

#[test]
fn the_first_sign_change_would_be_far_too_low() {
    // Means over 20 seeds, where the least slope is right within 3 % (flat) or 17 % (gentle).
    for (beam, width, wrong) in [
        (FLAT, 1e-3, 0.1),
        (FLAT, 5e-4, 0.7),
        (GENTLE, 1e-3, 0.4),
        (GENTLE, 5e-4, 0.8),
    ] {
        let first = |seed| {
            let grid = resample(&rising(beam.curve(0.08, 0.02, seed).points()));
            let (stress, _, slope) = smoothed(&grid, &gaussian(width));
            let turns = |k: &usize| slope[*k] < slope[*k - 1] && slope[*k] < slope[*k + 1];
            stress[(1..slope.len() - 1).find(turns).expect("it turns")]
        };
        let mean = (0..20).map(first).sum::<f64>() / 20.0;
        assert!(mean / beam.turn().stress - 1.0 < -wrong);
    }
}

#[test]
fn a_gentle_turn_is_blurred_by_noise_but_never_far_off_unnoticed() {
    // Where the slope only falls to 0.3, noise moves its least a long way; all widths must still agree.
    for (noise, off) in [(0.005, 0.1), (0.02, 0.2)] {
        for seed in 0..20 {
            match ultimate_strength(&GENTLE.curve(0.08, noise, seed)) {
                Ok(found) => {
                    let error = found.ultimate_strength / GENTLE.turn().stress - 1.0;
                    assert!(error.abs() < off);
                    assert!(found.spread <= 0.1 * found.ultimate_strength);
                }
                Err(missing) => assert_eq!(missing.reason, Reason::WidthSensitive),
            }
        }
    }
}

#[test]
fn reversals_change_nothing() {
    // From ε = 0.02 back to 0.01 and up again along a stiffer path: the loop adds no point to the rising branch.
    let whole = FLAT.curve(0.08, 0.0, 0);
    let (before, after) = whole.points().split_at(401);
    let top = before[400];
    let path = |k: u32| 0.02 - 5e-5 * f64::from(if k <= 200 { k } else { 400 - k });
    let cycle = (0..400).map(|k| Point {
        strain: path(k),
        stress: top.stress - 2e7 * (top.strain - path(k)),
    });
    let points = before
        .iter()
        .copied()
        .chain(cycle)
        .chain(after.iter().copied());
    assert_eq!(
        ultimate_strength(&points.collect()),
        ultimate_strength(&whole)
    );
}

#[test]
fn a_straight_line_has_no_strength() {
    for deviation in [0.0, 2e3] {
        for seed in 0..20 {
            let line = curve(0.08, |strain| 5e6 * strain, deviation, seed);
            assert_eq!(reason(&line), Reason::NotProminent);
        }
    }
}

#[test]
fn a_beam_that_only_softens_or_only_stiffens_has_no_interior_minimum() {
    let softening = |strain: f64| -90e3 * libm::expm1(-strain / 0.03);
    let stiffening = |strain: f64| 1e6 * strain + 6e7 * strain * strain;
    assert_eq!(
        reason(&curve(0.08, softening, 0.0, 0)),
        Reason::NoInteriorMinimum
    );
    assert_eq!(
        reason(&curve(0.08, stiffening, 0.0, 0)),
        Reason::NoInteriorMinimum
    );
    // Noise never makes it up.
    for seed in 0..20 {
        assert!(ultimate_strength(&curve(0.08, softening, 1.8e3, seed)).is_err());
    }
}

#[test]
fn a_run_that_ends_before_the_turn_gives_a_lower_bound_only() {
    let curve = FLAT.curve(0.03, 0.0, 0);
    let missing = ultimate_strength(&curve).expect_err("it has not turned");
    assert_eq!(missing.reason, Reason::NoInteriorMinimum);
    assert_eq!(missing.lower_bound, Some(FLAT.stress(0.03)));
    assert!(FLAT.stress(0.03) < FLAT.turn().stress);
}

#[test]
fn a_run_shorter_than_what_the_widest_filter_discards_says_so() {
    for end in [0.0, 1e-4, 0.004, 0.01, 0.0235] {
        assert_eq!(reason(&FLAT.curve(end, 0.0, 0)), Reason::RunTooShort);
    }
    assert_eq!(
        ultimate_strength(&Curve::default()),
        Err(NoStrength {
            reason: Reason::RunTooShort,
            lower_bound: None
        })
    );
}

#[test]
fn a_turn_that_only_narrow_filters_see_is_width_sensitive() {
    // Taut from ε = 0.009: the widest filter discards all before 0.012.
    let early = Beam {
        strain: 0.002,
        taut: 0.009,
        quadratic: 2e8,
        ..FLAT
    };
    assert_eq!(reason(&early.curve(0.08, 0.0, 0)), Reason::WidthSensitive);
}

#[test]
fn widths_that_disagree_by_more_than_a_tenth_are_refused() {
    let minimum = |stress| {
        Ok(Minimum {
            width: 1e-3,
            at: Point {
                strain: 0.03,
                stress,
            },
            slope: 0.0,
            before: 1e6,
            after: 1e6,
        })
    };
    let verdict = |stresses: [f64; 4]| judge(&stresses.map(minimum));
    let agreed = verdict([95e3, 100e3, 109e3, 91e3]).expect("spread 9.2 %");
    assert_eq!((agreed.ultimate_strength, agreed.spread), (97.5e3, 9e3));
    let middle = verdict([89e3, 100e3, 100e3, 110e3]);
    assert_eq!(middle, Err(Reason::WidthSensitive));
}

#[test]
fn a_rise_within_the_noise_is_not_prominent() {
    let minimum = Minimum {
        width: 1e-3,
        at: Point {
            strain: 0.03,
            stress: 90e3,
        },
        slope: 0.0,
        before: 5e6,
        after: 0.4e6,
    };
    // Noise of 2 kPa every 10⁻⁴: σ' scatters by 0.141 MPa, so a rise of 0.4 MPa is less than three deviations.
    let density = 4e6 * 1e-4;
    assert!((slope_deviation(density, 1e-3) - 0.141e6).abs() < 1e3);
    assert_eq!(minimum.checked(density), Err(Reason::NotProminent));
    assert_eq!(minimum.checked(0.5 * density), Ok(minimum));
    // 5 % of 9 MPa is 0.45 MPa.
    let steep = Minimum {
        before: 9e6,
        ..minimum
    };
    assert_eq!(steep.checked(0.0), Err(Reason::NotProminent));
    // A stress that falls from the beginning is no beam's: its least slope is no fall from a stiffness.
    let falling = Minimum {
        slope: -2e6,
        before: -1e6,
        after: 0.0,
        ..minimum
    };
    assert_eq!(falling.checked(0.0), Err(Reason::NotProminent));
}

#[test]
fn smoothed_noise_scatters_as_the_formula_says() {
    let width = 1e-3;
    let kernel = gaussian(width);
    let stress: Vec<f64> = (0..20_000).map(|k| 2e3 * noise::gaussian(2, k)).collect();
    let strain: Vec<f64> = (0..20_000).map(|k| SPACING * f64::from(k)).collect();
    let slope = smooth(
        &central_differences(&smooth(&stress, &kernel), &strain),
        &kernel,
    );
    let mean_square = slope.iter().map(|slope| slope * slope).sum::<f64>() / 20_000.0;
    // About 500 independent values of variance 1: a root mean square within 4 %, and twice that.
    let expected = slope_deviation(4e6 * SPACING, width);
    assert!((mean_square.sqrt() / expected - 1.0).abs() < 0.08);
}
