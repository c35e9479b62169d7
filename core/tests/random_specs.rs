//! Any spec that is accepted gives finite numbers or a typed stop, within the memory that it was said to take.
//!
//! Source: `StageSpec::work`, which workers go by, and the ranges of `memory::parameters`.

use std::alloc::{GlobalAlloc, Layout, System};
use std::ops::ControlFlow;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use granary_core::model::Model;
use granary_core::stage::{Ensemble, STATE, StageFailure, StageSpec, run};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use serde_json::{Map, Value, json};

/// The system's allocator, which knows the most that was ever held at once.
struct Measuring;

/// Held by the test that measures: both count what all threads hold.
static ALONE: Mutex<()> = Mutex::new(());

static HELD: AtomicUsize = AtomicUsize::new(0);
static MOST: AtomicUsize = AtomicUsize::new(0);

#[expect(unsafe_code, reason = "an allocator cannot be written without")]
// SAFETY: every call is handed to the system's allocator unchanged.
unsafe impl GlobalAlloc for Measuring {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        let held = HELD.fetch_add(layout.size(), Ordering::Relaxed) + layout.size();
        MOST.fetch_max(held, Ordering::Relaxed);
        // SAFETY: the caller keeps the contract of `GlobalAlloc`.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        HELD.fetch_sub(layout.size(), Ordering::Relaxed);
        // SAFETY: the caller keeps the contract of `GlobalAlloc`.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Measuring = Measuring;

/// Runs all stages of a point; panics if one of them gives no number, no reason, or takes more memory than said.
fn try_point(changes: &Value) -> Result<(), TestCaseError> {
    let mut map: Map<String, Value> = Model::Memory.defaults("standard").expect("a preset");
    map.extend(changes.as_object().expect("by name").clone());
    let refused = Model::Memory
        .rules()
        .iter()
        .any(|rule| (rule.broken)(&map).is_some());
    let Ok(point) = Model::Memory.point(map) else {
        return Ok(());
    };
    if refused {
        return Ok(());
    }
    let stages: Vec<StageSpec> = point.stages();
    let mut input = vec![];
    for (n, spec) in stages.iter().enumerate() {
        let said = usize::try_from(spec.work(&stages[..n]).bytes).expect("a size");
        let before = HELD.load(Ordering::Relaxed);
        MOST.store(before, Ordering::Relaxed);
        let ensemble = Ensemble {
            specs: std::slice::from_ref(spec),
            input: &input,
            checkpoints: None,
        };
        let result = run(&ensemble, &mut |report| {
            // As a worker keeps it.
            drop((report.checkpoint)());
            ControlFlow::Continue(())
        })
        .remove(0);
        let most = MOST.load(Ordering::Relaxed) - before;
        let kind = spec.kind().name();
        eprintln!("{kind} said {said} took {most}");
        prop_assert!(
            most <= said,
            "{kind} took {most} bytes and said {said}: {changes}"
        );
        match result {
            Ok(outcome) => {
                for (name, value) in &outcome.results {
                    prop_assert!(value.is_none_or(f64::is_finite), "{name} is {value:?}");
                }
                input = outcome.artifacts.get(STATE).cloned().unwrap_or_default();
            }
            Err(StageFailure::Stopped {
                kind,
                detail,
                remedy,
                ..
            }) => {
                prop_assert!(!kind.is_empty() && !detail.is_empty() && !remedy.is_empty());
                return Ok(());
            }
            Err(other) => return Err(TestCaseError::fail(format!("{other}"))),
        }
    }
    Ok(())
}

/// From a decade to another.
fn decades(from: f64, to: f64) -> impl Strategy<Value = f64> {
    (from.log10()..to.log10()).prop_map(|power| 10f64.powf(power))
}

#[test]
fn larger_packs_keep_within_what_they_said() {
    let _alone = ALONE.lock();
    for changes in [
        json!({"overlap": 0.6}),
        json!({"overlap": 0.9, "precision": "f64", "skin": 0.5}),
        json!({"overlap": 0.97, "delta0": 0.2}),
        json!({"shape": "sphere", "skin": 0.3}),
        json!({"force_law": "M1", "overlap": 0.9}),
        json!({"force_law": "M2", "skin": 0.3}),
        json!({"force_law": "M2", "overlap": 0.9, "precision": "f64", "slices": 300}),
    ] {
        let mut map = json!({
            "grains": 500, "ramp": 400.0, "preparation_ramp": 400.0, "preparation_cycles": 1, "gas_time": 200.0,
            "rest_kinetic_energy": 1e-6, "waveform": "six/1", "time_step": 0.5, "preparation_time_step": 0.7,
        });
        let all = map.as_object_mut().expect("by name");
        all.extend(changes.as_object().expect("by name").clone());
        if let Err(error) = try_point(&map) {
            panic!("{error}");
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 48,
        rng_seed: RngSeed::Fixed(11),
        failure_persistence: None,
        ..ProptestConfig::default()
    })]

    #[test]
    fn any_accepted_point_is_computed_or_stopped_within_what_it_said(
        (grains, sphere, overlap, friction) in (1u32..150, any::<bool>(), 0.0..=1.0f64, decades(1e-6, 1e3)),
        (poisson, delta0, gamma0, pressure) in (-0.99..=0.5f64, decades(1e-4, 0.3), decades(1e-8, 0.5), decades(1e-6, 0.1)),
        (damping, tangential, wall, hold) in (decades(1e-3, 100.0), 0.0..=10.0f64, decades(1e-2, 100.0), 0.0..2.0f64),
        (time_step, preparation, skin, single) in (decades(0.05, 5.0), decades(0.2, 3.0), 0.0..=1.0f64, any::<bool>()),
        (drag, second, seed) in (0.0..=1.0f64, any::<bool>(), 0u64..1000),
        (law, slices, slice_overlap) in (prop_oneof!["H", "M1", "M2"], 5u32..200, decades(1e-2, 0.5)),
    ) {
        let _alone = ALONE.lock();
        try_point(&json!({
            "grains": grains, "shape": if sphere { "sphere" } else { "tetrahedron" }, "overlap": overlap,
            "friction_coefficient": friction, "poisson_ratio": poisson, "delta0": delta0, "gamma0": gamma0,
            "servo_pressure": pressure, "normal_damping": damping, "tangential_damping_ratio": tangential,
            "wall_stiffness": wall, "hold": hold, "time_step": time_step, "preparation_time_step": preparation,
            "skin": skin, "precision": if single { "f32" } else { "f64" }, "drag": drag, "second_cycle": second,
            "packing_seed": seed, "waveform": "six/1", "force_law": law, "slices": slices,
            "slice_overlap": slice_overlap,
            "ramp": 400.0, "preparation_ramp": 400.0, "preparation_cycles": 1, "gas_time": 200.0,
            "rest_kinetic_energy": 1e-7,
        }))?;
    }
}
