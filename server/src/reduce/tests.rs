//! Half-done, finished and failed members, and what a row says of them.

use super::*;
use serde_json::json;

fn member(seed: u64, waveform: &str, dots: Option<Dots>) -> Member {
    let parameters = json!({"packing_seed": seed, "waveform": waveform});
    Member {
        parameters: parameters.as_object().expect("an object").clone(),
        open: dots.is_none(),
        dots,
        done: dots.is_some(),
        failure: None,
        scale: [1e7, 0.05, 1e-3],
    }
}

/// Dots of a signal that is `gain_e_delta0 γ0` times its J.
fn recalled(gain_e_delta0: f64) -> Dots {
    let p = gain_e_delta0 * 1e-3;
    Dots {
        j_p: p,
        j_j: 1.0,
        p_p: p * p,
        lost: 0.0,
        scatter: 0.0,
    }
}

fn scores(members: &[Member]) -> Vec<SetRow> {
    let mut scorer = Scorer::new(&["waveform".to_owned()], Processing::Sub0, false);
    for member in members {
        scorer.add(member);
    }
    scorer.finish()
}

#[test]
fn half_done_set_is_provisional_with_the_members_it_has() {
    let sets = scores(&[
        member(1, "six/1", Some(recalled(1.5e5))),
        member(1, "six/2", None),
    ]);
    assert_eq!(
        (sets.len(), sets[0].n, sets[0].of, sets[0].provisional),
        (1, 1, 2, true)
    );
    let gain = sets[0].results["gain_e_delta0"].expect("one member is done");
    assert!((gain - 1.5e5).abs() < 1e-6);
}

#[test]
fn mean_over_packings_has_the_standard_error_of_two_and_none_of_one() {
    let sets = scores(&[
        member(1, "six/1", Some(recalled(1.0e5))),
        member(2, "six/1", Some(recalled(3.0e5))),
    ]);
    let over = ["packing_seed".to_owned()];
    let means = mean_sem(&sets, &over);
    assert_eq!((means.len(), means[0].n, means[0].of), (1, 2, 2));
    // Two values 1 and 3: mean 2, SEM = √(2/1/2) = 1.
    assert!((means[0].results["gain_e_delta0"].expect("two") - 2.0e5).abs() < 1e-6);
    assert!((means[0].results["gain_e_delta0_sem"].expect("two") - 1.0e5).abs() < 1e-6);
    let one = mean_sem(&sets[..1], &over);
    assert_eq!(one[0].results["gain_sem"], None);
    let reason = one[0].missing_reason.as_deref();
    assert_eq!(reason, Some("one member has no standard error of the mean"));
}

#[test]
fn nothing_done_is_null_with_a_reason() {
    let sets = scores(&[member(1, "six/1", None)]);
    assert_eq!(sets[0].results["gain"], None);
    assert_eq!(
        sets[0].missing_reason.as_deref(),
        Some("no member is done yet")
    );
}

/// The mean over the packings of these members, one packing each.
fn mean_of(members: &[Member]) -> SetRow {
    let mut means = mean_sem(&scores(members), &["packing_seed".to_owned()]);
    assert_eq!(means.len(), 1);
    means.remove(0)
}

#[test]
fn half_done_mean_says_nothing_of_the_members_that_it_waits_for() {
    let done = |seed| member(seed, "six/1", Some(recalled(1e5)));
    let open = |seed| member(seed, "six/1", None);
    let reason = |members: &[Member]| {
        let row = mean_of(members);
        assert!(row.provisional);
        row.missing_reason
    };
    // Once "no member is done yet" stood beside the mean of two members.
    assert_eq!(reason(&[done(1), done(2), open(3)]), None);
    let one = "so far: one member has no standard error of the mean";
    assert_eq!(reason(&[open(1), done(2), open(3)]).as_deref(), Some(one));
    let none = "no member has a number yet";
    assert_eq!(reason(&[open(1), open(2)]).as_deref(), Some(none));
}

#[test]
fn finished_row_says_why_members_are_missing() {
    let done = |seed| member(seed, "six/1", Some(recalled(1e5)));
    let failed = |seed| Member {
        open: false,
        ..member(seed, "six/1", None)
    };
    let two = mean_of(&[done(1), failed(2), done(3)]);
    assert_eq!((two.n, two.of, two.provisional), (2, 3, false));
    let reason = "1 of 3 members have no number: no member has an outcome";
    assert_eq!(two.missing_reason.as_deref(), Some(reason));
    let set = scores(&[
        done(1),
        Member {
            open: false,
            ..member(1, "six/2", None)
        },
    ]);
    let reason = set[0].missing_reason.as_deref();
    assert_eq!(
        reason,
        Some("1 of 2 members are missing: failed or cancelled")
    );
}

#[test]
fn set_that_waits_for_its_zero_waveform_says_so() {
    let waiting = Member {
        dots: None,
        open: true,
        ..member(1, "six/1", Some(recalled(1e5)))
    };
    let sets = scores(&[waiting, member(1, "six/2", None)]);
    let reason = sets[0].missing_reason.as_deref().expect("a reason");
    assert!(reason.contains("not done yet"), "{reason}");
    assert!(reason.contains("zero waveform"), "{reason}");
}

#[test]
fn noise_is_told_of_a_set_and_of_the_means_over_it() {
    let quiet = recalled(1e5);
    // What scatters is two tenths of the signal.
    let noisy = Dots {
        scatter: 0.04 * quiet.p_p,
        ..quiet
    };
    let sets = scores(&[
        member(1, "six/1", Some(quiet)),
        member(2, "six/1", Some(noisy)),
    ]);
    assert_eq!(sets[0].warning, None);
    let told = sets[1].warning.as_deref().expect("a warning");
    assert!(
        told.starts_with("noisy: ") && told.contains("0.20"),
        "{told}"
    );
    assert!(sets[1].results["gain"].is_some());
    let mean = &mean_sem(&sets, &["packing_seed".to_owned()])[0];
    let told = mean.warning.as_deref().expect("a warning");
    assert!(told.starts_with("1 of 2 members: noisy"), "{told}");
}
