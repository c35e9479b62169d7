//! Results: points and sets, in the shapes that scripts rely on.

use granary_api::id::SweepId;
use granary_api::lease::LeaseGrant;
use serde_json::{Value, json};

use crate::harness::{Fresh, GAIN_E_DELTA0, fresh, spec, sweep_of};

async fn done() -> (Fresh, SweepId) {
    let fresh = fresh().await;
    let sweep = sweep_of(&fresh.submit(&spec()).await);
    fresh.work().await;
    (fresh, sweep)
}

async fn table(fresh: &Fresh, sweep: SweepId, what: &str) -> Value {
    let answer = fresh.get(&format!("/api/v1/sweeps/{sweep}/{what}")).await;
    assert_eq!(answer.status, 200, "{}", answer.text());
    answer.json()
}

#[tokio::test]
async fn point_and_set_have_the_promised_shapes() {
    let (fresh, sweep) = done().await;
    let mut points = table(&fresh, sweep, "points?limit=1").await;
    for hash in ["job", "result_hash"] {
        // They change with the version of the physics.
        let text = points["items"][0][hash].as_str().expect("a hash");
        assert!(text.starts_with("b3:") && text.len() == 67);
        points["items"][0][hash] = json!("b3:…");
    }
    insta::assert_json_snapshot!("point", points);
    let sets = table(&fresh, sweep, "sets").await;
    let rows = sets["items"].as_array().expect("rows");
    insta::assert_json_snapshot!("sets", [rounded(&rows[0]), rounded(&rows[4])]);
}

/// A set with its numbers to nine digits: sums of rounded terms differ in the last ones between machines.
fn rounded(set: &Value) -> Value {
    let mut set = set.clone();
    for number in set["results"]
        .as_object_mut()
        .expect("results")
        .values_mut()
    {
        let text = number.as_f64().map(|number| format!("{number:.9e}"));
        *number = json!(text.and_then(|text| text.parse::<f64>().ok()));
    }
    set
}

#[tokio::test]
async fn gain_is_recovered_and_its_mean_has_no_error_when_all_packings_agree() {
    let (fresh, sweep) = done().await;
    let sets = table(&fresh, sweep, "sets").await;
    // Four sets of a packing and a friction, two means over packings.
    assert_eq!(sets["total"], 6);
    for set in sets["items"].as_array().expect("rows") {
        let gain = set["results"]["gain_e_delta0"].as_f64().expect("a gain");
        assert!((gain / GAIN_E_DELTA0 - 1.0).abs() < 1e-9, "{gain}");
        assert!((set["results"]["fidelity"].as_f64().expect("a fidelity") - 1.0).abs() < 1e-6);
        assert_eq!(set["provisional"], false);
        if set["reduce"] == "mean_sem" {
            assert!(
                set["results"]["gain_e_delta0_sem"]
                    .as_f64()
                    .expect("two members")
                    < 1e-6
            );
        }
    }
}

#[tokio::test]
async fn half_done_sweep_shows_provisional_sets() {
    let fresh = fresh().await;
    let sweep = sweep_of(&fresh.submit(&spec()).await);
    while let Some(grant) = fresh.take().await {
        fresh.complete(grant.lease, &grant.jobs).await;
        if grant.jobs.len() > 1 {
            break;
        }
    }
    let sets = table(&fresh, sweep, "sets").await;
    let rows = sets["items"].as_array().expect("rows");
    let of = |reduce: &str| {
        rows.iter()
            .filter(|row| row["reduce"] == reduce)
            .collect::<Vec<_>>()
    };
    let scores = of("gain_fidelity");
    assert_eq!(
        scores
            .iter()
            .filter(|row| row["n"] == 3 && row["provisional"] == false)
            .count(),
        1
    );
    assert_eq!(
        scores
            .iter()
            .filter(|row| row["n"] == 0 && row["results"]["gain"].is_null())
            .count(),
        3
    );
    assert!(of("mean_sem").iter().all(|row| row["provisional"] == true));
    assert!(
        rows.iter()
            .all(|row| row["results"]["gain"].is_f64() || row["missing_reason"].is_string())
    );
}

/// Words of three bits in two packings, and a classifier that is trained in a second.
fn words(trainings: u64) -> Value {
    json!({
        "name": "words", "model": "memory", "fixed": {"grains": 100},
        "grid": [{"packing_seed": [1, 2], "waveform": {"suite": "binary_words", "bits": 3}}],
        "reduce": [
            {"kind": "gain_fidelity", "processing": ["SUB2-BL"]},
            {"kind": "recognition", "trainings": trainings,
             "classifier": {"shifts": 3, "amplitudes": 1, "noises": 10, "epochs": 8}},
            {"kind": "mean_sem"},
        ],
    })
}

#[tokio::test]
async fn recalled_words_are_recognized_and_their_scores_stand_beside() {
    let fresh = fresh().await;
    let sweep = sweep_of(&fresh.submit(&words(2)).await);
    let rows = |sets: &Value, reduce: &str| -> Vec<Value> {
        let rows = sets["items"].as_array().expect("rows").iter();
        rows.filter(|row| row["reduce"] == reduce)
            .cloned()
            .collect()
    };
    let sets = table(&fresh, sweep, "sets").await;
    for row in rows(&sets, "recognition") {
        assert_eq!(row["missing_reason"], "no member is done yet");
        assert_eq!((&row["provisional"], &row["of"]), (&json!(true), &json!(8)));
    }
    fresh.work().await;
    let sets = table(&fresh, sweep, "sets").await;
    let recognized = rows(&sets, "recognition");
    assert_eq!(
        (recognized.len(), rows(&sets, "gain_fidelity").len()),
        (2, 2)
    );
    for row in &recognized {
        // What comes back has exactly the stored shape.
        assert_eq!(row["results"]["recognition_accuracy"], 1.0, "{row}");
        assert_eq!(row["results"]["recognition_accuracy_sem"], 0.0);
        assert!(
            row["results"]["validation_accuracy"].as_f64() > Some(0.95),
            "{row}"
        );
        assert_eq!(
            (&row["processing"], &row["n"]),
            (&json!("SUB2-BL"), &json!(8))
        );
        assert_eq!(
            (&row["confused"], &row["provisional"]),
            (&Value::Null, &json!(false))
        );
    }
    let means = rows(&sets, "mean_sem");
    assert_eq!(
        means.len(),
        2,
        "of scores, and of what was recognized: {means:?}"
    );
    assert!(means[0]["results"]["fidelity"].is_f64());
    assert_eq!(means[1]["results"]["recognition_accuracy"], 1.0);
    assert_eq!(means[1]["results"]["recognition_accuracy_sem"], 0.0);
    // Another sweep of these words asks the same networks.
    let again = fresh.submit(&words(1)).await;
    assert_eq!(again.jobs.new, 0);
}

#[tokio::test]
async fn words_of_each_length_are_sets_of_their_own() {
    let fresh = fresh().await;
    let mut spec = words(1);
    spec["grid"] =
        json!([{"waveform": [{"suite": "binary_words", "bits": 3}, "binary_words/4/5"]}]);
    spec["reduce"].as_array_mut().expect("a chain").pop();
    let sweep = sweep_of(&fresh.submit(&spec).await);
    fresh.work().await;
    let sets = table(&fresh, sweep, "sets?sort=-bits").await;
    let told: Vec<(&Value, &Value, &Value)> = sets["items"]
        .as_array()
        .expect("rows")
        .iter()
        .map(|row| (&row["reduce"], &row["parameters"]["bits"], &row["n"]))
        .collect();
    let (scored, recognized) = (json!("gain_fidelity"), json!("recognition"));
    let (three, four, eight, one) = (json!(3), json!(4), json!(8), json!(1));
    assert_eq!(
        told,
        [
            (&scored, &four, &one),
            (&recognized, &four, &one),
            (&scored, &three, &eight),
            (&recognized, &three, &eight),
        ]
    );
    assert_eq!(table(&fresh, sweep, "sets?where=bits=4").await["total"], 2);
}

#[tokio::test]
async fn every_processing_makes_sets_of_its_own() {
    let fresh = fresh().await;
    let mut spec = spec();
    spec["reduce"] = json!([{"kind": "gain_fidelity", "processing": ["SUB0", "SUB2", "SUB2-BL"]}]);
    let sweep = sweep_of(&fresh.submit(&spec).await);
    fresh.work().await;
    let sets = table(
        &fresh,
        sweep,
        "sets?where=processing=SUB2&where=packing_seed=1",
    )
    .await;
    assert_eq!(sets["total"], 2);
    assert_eq!(table(&fresh, sweep, "sets").await["total"], 12);
}

#[tokio::test]
async fn points_are_filtered_sorted_and_projected_over_all_rows() {
    let (fresh, sweep) = done().await;
    let some = table(&fresh, sweep, "points?where=friction_coefficient%3E=0.5&where=waveform=six/5&sort=-packing_seed&columns=waveform,encode_correlation").await;
    assert_eq!(some["total"], 2);
    let rows = some["items"].as_array().expect("rows");
    assert_eq!(rows[0]["parameters"], json!({"waveform": "six/5"}));
    assert_eq!(rows[0]["results"], json!({"encode_correlation": 0.9}));
    let none = table(&fresh, sweep, "points?where=grains!=100").await;
    assert_eq!(none["total"], 0);
    let done = table(
        &fresh,
        sweep,
        "points?where=state=done&where=encode_correlation%3C=0.9",
    )
    .await;
    assert_eq!(done["total"], 12);
}

#[tokio::test]
async fn pages_by_cursor_show_every_row_once_in_any_order() {
    let (fresh, sweep) = done().await;
    for sort in [
        "",
        "&sort=waveform",
        "&sort=-friction_coefficient",
        "&sort=encode_correlation",
    ] {
        for what in ["points", "sets"] {
            let (mut seen, mut cursor) = (vec![], String::new());
            loop {
                let page = table(&fresh, sweep, &format!("{what}?limit=5{sort}{cursor}")).await;
                let name = &what[..what.len() - 1];
                seen.extend(
                    page["items"]
                        .as_array()
                        .expect("rows")
                        .iter()
                        .map(|row| row[name].as_u64()),
                );
                match page["next"].as_str() {
                    Some(next) => {
                        cursor =
                            format!("&cursor={}", next.replace('"', "%22").replace('/', "%2F"));
                    }
                    None => break,
                }
            }
            let total = if what == "points" { 12 } else { 6 };
            seen.sort_unstable();
            assert_eq!(
                seen,
                (0..total).map(Some).collect::<Vec<_>>(),
                "{what} {sort}"
            );
        }
    }
}

#[tokio::test]
async fn wrong_questions_are_4xx() {
    let (fresh, sweep) = done().await;
    for (query, status) in [
        ("limit=0", 400),
        ("limit=99999999", 400),
        ("wher=a=1", 400),
        ("where=gain", 400),
        ("format=xml", 400),
        ("sort=encode_corelation", 422),
        ("columns=nothing", 422),
        ("cursor=nonsense", 422),
    ] {
        let answer = fresh
            .get(&format!("/api/v1/sweeps/{sweep}/points?{query}"))
            .await;
        assert_eq!(answer.status, status, "{query}: {}", answer.text());
        assert_eq!(answer.headers["content-type"], "application/problem+json");
    }
    let missing = granary_api::id::SweepId::new();
    assert_eq!(
        fresh
            .get(&format!("/api/v1/sweeps/{missing}/points"))
            .await
            .status,
        404
    );
    assert_eq!(
        fresh.get("/api/v1/sweeps/not-an-id/points").await.status,
        404
    );
}

#[tokio::test]
async fn csv_has_a_line_per_row_whatever_the_page_size() {
    let (fresh, sweep) = done().await;
    let all = fresh
        .get(&format!("/api/v1/sweeps/{sweep}/points?format=csv"))
        .await;
    assert_eq!(all.headers["content-type"], "text/csv; charset=utf-8");
    let text = all.text();
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(lines.len(), 13);
    assert_eq!(
        lines[0],
        "point,state,friction_coefficient,packing_seed,waveform,encode_correlation,hold_kinetic_energy,job,result_hash,failure"
    );
    assert!(
        lines[1].starts_with("0,done,0.4,1,six/1,0.9,3e-15,b3:"),
        "{}",
        lines[1]
    );
    let sets = fresh
        .get(&format!("/api/v1/sweeps/{sweep}/sets?format=csv"))
        .await;
    assert_eq!(sets.text().lines().count(), 7);
}

#[tokio::test]
async fn etag_holds_while_nothing_changes_and_breaks_when_something_does() {
    let fresh = fresh().await;
    let sweep = sweep_of(&fresh.submit(&spec()).await);
    for what in ["points", "sets"] {
        let path = format!("/api/v1/sweeps/{sweep}/{what}");
        let first = fresh.get(&path).await;
        let etag = first.headers["etag"].clone();
        let ask = || {
            let request = crate::harness::request(axum::http::Method::GET, &path)
                .header("if-none-match", &etag);
            fresh.send(request.body(axum::body::Body::empty()).expect("a request"))
        };
        assert_eq!(ask().await.status, 304);
        let grant = fresh.take().await.expect("work");
        fresh.complete(grant.lease, &grant.jobs).await;
        assert_eq!(ask().await.status, 200);
    }
}

#[tokio::test]
async fn running_point_shows_progress_and_its_workers_last_word() {
    let fresh = fresh().await;
    let sweep = sweep_of(&fresh.submit(&crate::harness::single("six/1")).await);
    for _ in 0..2 {
        let grant = fresh.take().await.expect("pack, train");
        fresh.complete(grant.lease, &grant.jobs).await;
    }
    let grant = fresh.take_as("node 3").await.expect("the recall");
    let at = |job| granary_api::lease::JobProgress {
        job,
        step: 250,
        steps: 1000,
        checkpoint: None,
    };
    let beat = granary_api::lease::Heartbeat {
        jobs: grant.jobs.iter().map(|job| at(job.job)).collect(),
    };
    fresh
        .store
        .lease_heartbeat(grant.lease, &beat)
        .await
        .expect("ours");
    let row = table(&fresh, sweep, "points").await["items"][0].clone();
    assert_eq!(
        (
            &row["state"],
            &row["progress"]["step"],
            &row["progress"]["worker"]
        ),
        (&json!("leased"), &json!(250), &json!("node 3"))
    );
    let summary = fresh.store.sweep_read(sweep).await.expect("the sweep");
    assert_eq!(summary.points.running, 1);
    assert!(summary.eta_s.expect("running") > 0.0);
}

/// Completes a lease whose ensemble took `wall_s` of its thread, though only a second of the processor.
async fn complete_in(fresh: &Fresh, grant: &LeaseGrant, wall_s: f64) {
    let mut completion = fresh.outcomes(&grant.jobs).await;
    for outcome in &mut completion.outcomes {
        outcome.provenance.wall_s = wall_s;
        outcome.provenance.lanes = grant.jobs.len() as u32;
    }
    let done = fresh.store.lease_complete(grant.lease, &completion).await;
    done.expect("the lease is ours");
}

#[tokio::test]
async fn time_left_follows_what_the_finished_jobs_took() {
    let fresh = fresh().await;
    let submitted = fresh.submit(&spec()).await;
    let eta = async || {
        let sweep = fresh.store.sweep_read(sweep_of(&submitted)).await;
        sweep.expect("the sweep").eta_s.expect("something runs")
    };
    let about = |x: f64, y: f64| (x / y - 1.0).abs() < 1e-9;
    // Two packs: seven times their predicted second, so everything else is expected to be as slow.
    let packs = [fresh.take().await, fresh.take().await].map(|grant| grant.expect("a pack"));
    for pack in &packs {
        complete_in(&fresh, pack, 7.0).await;
    }
    let train = fresh.take().await.expect("a train");
    let predicted = fresh.submit(&spec()).await.predicted.core_seconds;
    assert!(about(eta().await, 7.0 * predicted));
    complete_in(&fresh, &train, 7.0).await;
    let mut recalls = vec![];
    while let Some(grant) = fresh.take().await {
        match grant.jobs.len() {
            1 => complete_in(&fresh, &grant, 7.0).await,
            _ => recalls.push(grant),
        }
    }
    // Four ensembles of four; the first took 100 s for each of its jobs, and three threads share the other twelve.
    assert_eq!(recalls.len(), 4);
    complete_in(&fresh, &recalls[0], 400.0).await;
    assert!(about(eta().await, 12.0 * 100.0 / 3.0));
    // The rate is that of the latest jobs, not of the first.
    complete_in(&fresh, &recalls[1], 4.0).await;
    let left = eta().await;
    assert!((8.0 / 2.0..8.0 * 100.0 / 2.0).contains(&left), "{left}");
}
