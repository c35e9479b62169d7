use granary_server::*;
use serde_json::json;
#[tokio::test]
async fn smoke() {
    let dir = tempfile::tempdir().unwrap();
    let store = Store::open(Config::new(dir.path()), "test").await.unwrap();
    let spec = json!({"model":"memory","name":"x","fixed":{"grains":100},"grid":[{"friction_coefficient":[0.0,1.0],"packing_seed":{"range":[1,3]},"waveform":{"suite":"six"}}]});
    let r = submit(&store, &spec, &Submission::default()).await.unwrap();
    println!("{}", serde_json::to_string_pretty(&r).unwrap());
    let r = submit(&store, &spec, &Submission::default()).await.unwrap();
    println!("{}", serde_json::to_string_pretty(&r).unwrap());
    let spec = json!({"model":"memory","name":"x","fixed":{"grains":100},"grid":[{"friction_coefficient":[0.0,1.0],"waveform":[{"suite":"binary_words","bits":15},{"suite":"binary_words","bits":14},{"suite":"binary_words","bits":10}]}]});
    let t = std::time::Instant::now();
    let r = submit(&store, &spec, &Submission::default()).await.unwrap();
    println!(
        "{} {:?}",
        serde_json::to_string_pretty(&r).unwrap(),
        t.elapsed()
    );
    println!(
        "{}",
        std::fs::read_to_string("/proc/self/status")
            .unwrap()
            .lines()
            .filter(|l| l.starts_with("Vm"))
            .collect::<Vec<_>>()
            .join("\n")
    );
    let t = std::time::Instant::now();
    println!(
        "{:?} {:?}",
        store.sweep_list(None, 10).await.unwrap(),
        t.elapsed()
    );
    let t = std::time::Instant::now();
    let req = granary_api::lease::LeaseRequest {
        worker: granary_api::id::WorkerId("w".into()),
        physics_version: 1,
        engine_version: "x".into(),
        memory_bytes: 1 << 40,
        wait_s: 0.0,
    };
    println!(
        "{:?} {:?}",
        store.lease_take(&req).await.unwrap(),
        t.elapsed()
    );
}
