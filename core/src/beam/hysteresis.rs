//! What a cycle of loading and unloading loses: the share of the rods' work that they do not get back.

use super::curve::Sample;

/// 1 − W_back/W of the first cycle; `None` if the rods never turn back, or do no work.
///
/// W = Σ F Δs \[J\] over the samples on the way down, and W_back the same over those on the way up, s the way of the rods.
/// A sample's force is the mean over the way since the sample before, so each product is the work of that way, not a rule's estimate.
#[must_use]
pub fn unloading_loss(samples: &[Sample]) -> Option<f64> {
    let steps = samples
        .windows(2)
        .map(|pair| (pair[1].force, pair[1].rod_travel - pair[0].rod_travel));
    let mut steps = steps.peekable();
    let (mut work, mut back) = (0.0, 0.0);
    while let Some((force, way)) = steps.next_if(|(_, way)| *way >= 0.0) {
        work += force * way;
    }
    steps.peek()?;
    while let Some((force, way)) = steps.next_if(|(_, way)| *way <= 0.0) {
        back -= force * way;
    }
    (work > 0.0).then(|| 1.0 - back / work)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Samples at these ways, each with the mean of `force(way, down)` over the way since the one before.
    fn samples(ways: &[f64], force: impl Fn(f64, bool) -> f64) -> Vec<Sample> {
        let sample = |rod_travel, force| Sample {
            time: 0.0,
            rod_travel,
            force,
            deflection: 0.0,
        };
        let mean = |pair: &[f64]| {
            let middle = 0.5 * (pair[0] + pair[1]);
            sample(pair[1], force(middle, pair[1] > pair[0]))
        };
        let first = sample(ways[0], 0.0);
        std::iter::once(first)
            .chain(ways.windows(2).map(mean))
            .collect()
    }

    #[test]
    fn a_spring_gives_all_its_work_back() {
        let found = unloading_loss(&samples(&[0.0, 1.0, 2.0, 3.0, 1.5, 0.0], |way, _| way));
        assert!(found.expect("a cycle").abs() < 1e-15);
    }

    #[test]
    fn a_force_that_halves_when_the_rods_turn_loses_half() {
        let half = |way, down| if down { way } else { 0.5 * way };
        let one = samples(&[0.0, 1.0, 2.0, 1.0, 0.0], half);
        assert_eq!(unloading_loss(&one), Some(0.5));
        // Only the first cycle counts.
        let more = samples(&[0.0, 2.0, 0.0, 3.0, 0.0], |way, down| {
            if way > 1.0 { way } else { half(way, down) }
        });
        assert_eq!(unloading_loss(&more), Some(0.5));
    }

    #[test]
    fn without_a_cycle_or_without_work_nothing_is_lost() {
        assert_eq!(
            unloading_loss(&samples(&[0.0, 1.0, 2.0], |way, _| way)),
            None
        );
        assert_eq!(unloading_loss(&samples(&[0.0, 1.0, 0.0], |_, _| 0.0)), None);
        assert_eq!(unloading_loss(&[]), None);
    }
}
