//! Long checks of the whole service: `make verify WHAT=crash`, `make verify WHAT=intake`, `make verify WHAT=service`.

mod intake;
mod service;

#[test]
fn crash_200_sweeps_under_kill_9() {
    granary_tests::crash(200);
}
