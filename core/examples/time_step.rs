//! Times steps of a pack file: `time_step PACK.json [STEPS [WIDTH/PRECISION/LANES]]`.
#![expect(
    clippy::print_stdout,
    reason = "an example that prints what it measures"
)]

use granary_core::bench::{PackFile, Settings, bench};
use granary_core::lanes::VectorWidth;
use granary_core::memory::spec::{ForceLaw, Precision};

/// Time that this thread has spent on a processor.
fn cpu_seconds() -> f64 {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").expect("Linux");
    text.split(' ')
        .next()
        .and_then(|ns| ns.parse::<f64>().ok())
        .expect("nanoseconds first")
        * 1e-9
}

fn main() {
    let arguments: Vec<String> = std::env::args().collect();
    let pack: PackFile =
        serde_json::from_slice(&std::fs::read(&arguments[1]).expect("readable file"))
            .expect("a pack file");
    let steps: u64 = arguments
        .get(2)
        .map_or(300, |n| n.parse().expect("a number"));
    for width in VectorWidth::available() {
        for (precision, lanes) in [
            (Precision::F64, 1),
            (Precision::F64, 8),
            (Precision::F32, 8),
            (Precision::F32, 16),
        ] {
            let name = format!("{}/{precision:?}/{lanes}", width.name());
            if !name.contains(arguments.get(3).map_or("avx", String::as_str)) {
                continue;
            }
            let settings = Settings {
                lanes,
                precision,
                force_law: ForceLaw::H,
                time_step: 0.1,
                skin: 0.1,
                width,
            };
            let mut scene = bench(&pack, &settings).expect("compiled");
            let mut left = 0..50;
            scene.run(&mut || left.next().is_some());
            let start = cpu_seconds();
            let mut left = 0..steps;
            scene.run(&mut || left.next().is_some());
            let seconds = cpu_seconds() - start;
            let size = scene.size();
            let rate = (size.grains * lanes) as f64 * steps as f64 / seconds;
            let per_contact = seconds * 1e9 / (size.contacts * lanes) as f64 / steps as f64;
            println!(
                "{:9} {precision:?} x{lanes:<2} {rate:.3e} grain-steps/s {per_contact:6.2} ns/contact-lane {size:?}",
                width.name()
            );
        }
    }
}
