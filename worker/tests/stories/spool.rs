//! Finished outcomes that outlive their worker.

use std::time::Duration;

use granary_worker::config::Config;

use crate::engines::{Gated, instant};
use crate::scripted_server::ScriptedServer;
use crate::{Worker, config, grant};

#[tokio::test]
async fn an_outcome_that_could_not_be_delivered_is_delivered_by_the_next_worker() {
    let directory = tempfile::tempdir().expect("temporary directory");
    let config = Config {
        spool: Some(directory.path().join("spool")),
        grace: Duration::from_millis(300),
        ..config()
    };
    let mut server = ScriptedServer::start().await;
    let gate = Gated::new();
    server.change(|script| script.grants.push_back(grant(2, None)));
    let worker = Worker::start(&server, gate.engine(), config.clone());
    server.until(|script| !script.beats.is_empty()).await;
    server.kill().await;
    gate.open();
    let place = config.spool.clone().expect("given");
    let spooled = || {
        let lease = std::fs::read_dir(&place).ok()?.next()?.ok()?;
        Some(lease.path().join("report.json").exists())
    };
    tokio::time::timeout(Duration::from_secs(20), async {
        while spooled() != Some(true) {
            tokio::task::yield_now().await;
        }
    })
    .await
    .expect("the report is spooled within 20 s");
    worker.stop().await.expect_err("nothing was delivered");

    server.change(|script| script.unwell = false);
    server.begin().await;
    let worker = Worker::start(&server, instant(), config);
    let script = server.until(|script| script.outcomes.len() == 2).await;
    assert_eq!(script.artifacts.len(), 2);
    worker.stop().await.expect("a clean end");
}
