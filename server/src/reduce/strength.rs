//! The fit of Eq. (4): how the ultimate strength of otherwise equal beams grows with friction.

use std::collections::BTreeMap;

use granary_api::table::SetRow;
use granary_core::beam::exponential_fit::{
    Estimate, ExponentialFit, PAPER_SCATTER, Shape, StrengthPoint, fit,
};
use granary_core::beam::results::FITS;
use serde_json::{Map, Value};

use super::groups;

/// The number that is fitted.
const STRENGTH: &str = "ultimate_strength";

/// Eq. (4) through the strengths of the rows that differ in `over` only, friction among it.
#[must_use]
pub fn ultimate_strength_fit(rows: &[SetRow], over: &[String]) -> Vec<SetRow> {
    let groups = groups(rows, over).into_iter();
    groups
        .map(|(parameters, members)| fitted(parameters, &members))
        .collect()
}

fn number(set: &SetRow, name: &str) -> Option<f64> {
    set.results.get(name).copied().flatten()
}

fn fitted(parameters: Map<String, Value>, members: &[&SetRow]) -> SetRow {
    let points: Vec<StrengthPoint> = members.iter().map(|set| point(set)).collect();
    let fit = fit(&points, scatter(members));
    let provisional = members.iter().any(|set| set.provisional);
    let dropped: Vec<&SetRow> = members
        .iter()
        .copied()
        .filter(|set| !set.provisional && number(set, STRENGTH).is_none())
        .collect();
    SetRow {
        set: 0,
        reduce: "ultimate_strength_fit".to_owned(),
        processing: None,
        shape: Some(shape_name(&fit.shape).to_owned()),
        setting: None,
        verdict: None,
        parameters,
        results: results(&fit, dropped.len()),
        n: fit.used as u64,
        of: members.len() as u64,
        provisional,
        missing_reason: reason(&fit, &dropped, members.len(), provisional),
        warning: None,
        confused: vec![],
    }
}

fn point(set: &SetRow) -> StrengthPoint {
    let friction = set.parameters.get("friction_coefficient");
    StrengthPoint {
        friction_coefficient: friction.and_then(Value::as_f64).unwrap_or(f64::NAN),
        strength: number(set, STRENGTH),
    }
}

/// How well strengths repeat \[Pa\]: the standard errors of means over packings, or the paper's own scatter.
fn scatter(members: &[&SetRow]) -> f64 {
    let mean_of = |values: Vec<f64>| {
        let count = values.len() as f64;
        (count > 0.0).then(|| values.iter().sum::<f64>() / count)
    };
    let errors = members
        .iter()
        .filter_map(|set| number(set, "ultimate_strength_sem"));
    let strengths = members.iter().filter_map(|set| number(set, STRENGTH));
    match mean_of(errors.map(|error| error * error).collect()) {
        Some(square) => square.sqrt(),
        None => PAPER_SCATTER * mean_of(strengths.collect()).unwrap_or_default(),
    }
}

fn shape_name(shape: &Shape) -> &'static str {
    match shape {
        Shape::Exponential(_) => "exponential",
        Shape::Step { .. } => "step",
        Shape::Straight { .. } => "straight",
        Shape::Constant { .. } => "constant",
        Shape::TooFewPoints => "too_few_points",
    }
}

/// Every number of a fit; `null` where the shape has no such parameter.
fn results(fit: &ExponentialFit, dropped: usize) -> BTreeMap<String, Option<f64>> {
    let names = FITS.iter().map(|row| (row.name.to_owned(), None));
    let mut results: BTreeMap<String, Option<f64>> = names.collect();
    let mut put = |name: &str, value: Option<f64>| {
        results.insert(name.to_owned(), value);
    };
    put("strengths_used", Some(fit.used as f64));
    put("strengths_dropped", Some(dropped as f64));
    if fit.used > 0 {
        let extrapolated = f64::from(u8::from(fit.extrapolated));
        put("strength_extrapolated", Some(extrapolated));
    }
    let mut estimate = |name: &str, estimate: Option<Estimate>| {
        put(name, estimate.map(|estimate| estimate.value));
        let error = estimate.and_then(|estimate| estimate.standard_error);
        put(&format!("{name}_error"), error);
    };
    match fit.shape {
        Shape::Exponential(found) => {
            estimate("strength_zero_friction", Some(found.zero_friction));
            estimate("strength_infinite_friction", Some(found.infinite_friction));
            estimate("strength_rate", Some(found.rate));
            put("strength_condition_number", found.condition_number);
            put("strength_residual", Some(found.residual_rms));
        }
        Shape::Step {
            zero_friction,
            infinite_friction,
            rate_at_least,
        } => {
            estimate("strength_zero_friction", zero_friction);
            estimate("strength_infinite_friction", Some(infinite_friction));
            put("strength_rate_at_least", Some(rate_at_least));
        }
        Shape::Straight {
            zero_friction,
            slope,
        } => {
            estimate("strength_zero_friction", Some(zero_friction));
            estimate("strength_slope", Some(slope));
        }
        Shape::Constant { strength } => estimate("strength_mean", Some(strength)),
        Shape::TooFewPoints => {}
    }
    results
}

/// Why numbers are missing, or, once nothing is still to come, why strengths are.
fn reason(
    fit: &ExponentialFit,
    dropped: &[&SetRow],
    members: usize,
    provisional: bool,
) -> Option<String> {
    let shape = match fit.shape {
        Shape::Exponential(_) => None,
        Shape::Step { .. } => {
            Some("all strengths above no friction are one, which bounds the rate from below only")
        }
        Shape::Straight { .. } => {
            Some("the strengths lie on a straight line, without a sign of where they end")
        }
        Shape::Constant { .. } => {
            Some("the strengths are one within their scatter, which leaves the rate open")
        }
        Shape::TooFewPoints => {
            Some("fewer than four strengths, or than three frictions: nothing is fitted")
        }
    };
    if provisional {
        return shape.map(super::so_far);
    }
    let why = dropped.iter().find_map(|set| set.missing_reason.as_deref());
    let missing = (!dropped.is_empty()).then(|| {
        format!(
            "{} of {members} members have no strength: {}",
            dropped.len(),
            why.unwrap_or("no reason is known")
        )
    });
    match (shape, missing) {
        (Some(shape), Some(missing)) => Some(format!("{shape}; {missing}")),
        (shape, missing) => shape.map(str::to_owned).or(missing),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    /// The row of a beam, or of a mean over packings, with friction μ and strength Y_b.
    fn row(friction: f64, strength: Option<f64>) -> SetRow {
        let parameters = json!({"youngs_modulus": 1e8, "friction_coefficient": friction});
        SetRow {
            set: 0,
            reduce: "mean_sem".to_owned(),
            processing: None,
            shape: None,
            setting: None,
            verdict: None,
            parameters: parameters.as_object().expect("a table").clone(),
            results: BTreeMap::from([(STRENGTH.to_owned(), strength)]),
            n: 1,
            of: 1,
            provisional: false,
            missing_reason: strength
                .is_none()
                .then(|| "ultimate_strength: not_prominent".to_owned()),
            warning: None,
            confused: vec![],
        }
    }

    fn fit_of(rows: &[SetRow]) -> SetRow {
        let mut fits = ultimate_strength_fit(rows, &["friction_coefficient".to_owned()]);
        assert_eq!(fits.len(), 1);
        fits.remove(0)
    }

    /// Table I of the paper, 100 MPa by protocol A: Y⁰ = 20.63 kPa, Y^∞ = 96.15 kPa, a = 6.67.
    fn table_row() -> Vec<SetRow> {
        let strength = |friction: f64| (20.63e3 - 96.15e3) * (-6.67 * friction).exp() + 96.15e3;
        let frictions = [0.0, 0.1, 0.2, 0.3, 0.6, 0.9, 1.2];
        frictions
            .map(|friction| row(friction, Some(strength(friction))))
            .to_vec()
    }

    #[test]
    fn exact_curve_gives_its_parameters_back() {
        let fit = fit_of(&table_row());
        assert_eq!(
            (fit.n, fit.of, fit.shape.as_deref()),
            (7, 7, Some("exponential"))
        );
        assert_eq!(
            fit.parameters,
            *json!({"youngs_modulus": 1e8}).as_object().expect("a table")
        );
        for (name, expected) in [
            ("strength_zero_friction", 20.63e3),
            ("strength_infinite_friction", 96.15e3),
            ("strength_rate", 6.67),
        ] {
            let found = number(&fit, name).expect("determined");
            assert!((found / expected - 1.0).abs() < 1e-6, "{name}: {found}");
        }
        assert_eq!(number(&fit, "strengths_dropped"), Some(0.0));
        assert_eq!(fit.missing_reason, None);
    }

    #[test]
    fn beam_without_a_strength_is_left_out_counted_and_explained() {
        let mut rows = table_row();
        rows[2] = row(0.2, None);
        let fit = fit_of(&rows);
        assert_eq!((fit.n, fit.of), (6, 7));
        assert_eq!(number(&fit, "strengths_dropped"), Some(1.0));
        let reason = fit.missing_reason.as_deref();
        assert_eq!(
            reason,
            Some("1 of 7 members have no strength: ultimate_strength: not_prominent")
        );
    }

    #[test]
    fn half_done_fit_is_provisional_and_drops_nobody() {
        let mut rows = table_row();
        for open in &mut rows[3..] {
            open.provisional = true;
            open.results.insert(STRENGTH.to_owned(), None);
        }
        let fit = fit_of(&rows);
        assert!(fit.provisional);
        assert_eq!((fit.n, number(&fit, "strengths_dropped")), (3, Some(0.0)));
        assert_eq!(fit.shape.as_deref(), Some("too_few_points"));
        assert!(
            fit.missing_reason
                .expect("a reason")
                .starts_with("so far: ")
        );
    }

    #[test]
    fn equal_strengths_are_a_constant_within_the_errors_of_their_means() {
        let constant = [0.3, 0.6, 0.9, 1.2].map(|friction| {
            let mut row = row(friction, Some(36e3 + 1e3 * friction));
            row.results
                .insert("ultimate_strength_sem".to_owned(), Some(1e3));
            row
        });
        let fit = fit_of(&constant);
        assert_eq!(fit.shape.as_deref(), Some("constant"));
        assert!((number(&fit, "strength_mean").expect("a mean") - 36.75e3).abs() < 1e-6);
        assert_eq!(number(&fit, "strength_rate"), None);
        assert_eq!(number(&fit, "strength_extrapolated"), Some(1.0));
    }
}
