//! What stops a run, or is said of it, in scenes of one or two grains in a mold that stands still.

use std::ops::ControlFlow;

use super::*;
use crate::beam::point::BeamPoint;
use crate::beam::rig::Rig;
use crate::beam::spec::GrowSpec;
use crate::beam::state::Snapshot;
use crate::contact::frictionless::Frictionless;
use crate::contact::mindlin::Mindlin;
use crate::grains::{Motion, Size};
use crate::lanes::VectorWidth;
use crate::math::plain;
use crate::random::{Purpose, uniform3};

/// Half the height of the mold \[m\].
const HALF: f64 = 6e-3;

fn spec() -> GrowSpec {
    let map = BeamPoint::defaults("smoke").expect("a preset");
    GrowSpec {
        length: 0.06,
        height: 2.0 * HALF,
        depth: 0.024,
        membrane_edge: 3e-3,
        radius_min: 1.6e-3,
        radius_max: 1.8e-3,
        youngs_modulus: 2e7,
        background_damping: 0.0,
        ..BeamPoint::from_parameters(map)
            .expect("valid defaults")
            .grow()
    }
}

/// Grains by place, radius and velocity \[m, m/s\].
type Placed = ([f64; 3], f64, [f64; 3]);

fn beam<T: Friction>(spec: &GrowSpec, grains: &[Placed]) -> Beam<T> {
    let rig = Rig {
        grow: spec,
        jam: None,
        friction_coefficient: 0.5,
        damping: spec.background_damping,
        width: VectorWidth::widest(),
    };
    let vertices = rig.membrane().expect("a mold").mesh().positions().to_vec();
    let all: Vec<u32> = (0..vertices.len() as u32).collect();
    let motion = |grain: &Placed| Motion {
        velocity: grain.2,
        spin: [0.0; 3],
    };
    let snapshot = Snapshot {
        header: (),
        reference: grains.iter().map(|grain| grain.0).collect(),
        displacements: vec![[0.0; 3]; grains.len()],
        motions: grains.iter().map(motion).collect(),
        radii: grains.iter().map(|grain| grain.1).collect(),
        contacts: vec![],
        velocities: vec![[0.0; 3]; vertices.len()],
        vertices,
        held: vec![],
    };
    let mut beam = rig.restored::<T, _>(&snapshot).expect("a sound state");
    beam.surroundings.membrane.hold(&all, [true; 3]);
    beam
}

fn run_at(fraction: f64, beam: Beam<Frictionless>) -> Run<Frictionless> {
    Run::new(
        beam,
        Course::BEGINNING,
        (fraction, f64::MAX),
        spec().overlap,
    )
}

fn run(grains: &[Placed]) -> Run<Frictionless> {
    run_at(0.4, beam(&spec(), grains))
}

const REST: [f64; 3] = [0.0; 3];

/// Takes steps; why the run stopped, in its word and its sentence, and when.
fn steps(run: &mut Run<Frictionless>, count: u64) -> Result<(), (String, String, u64)> {
    let mut go_on = |_: &crate::outcome::Report<'_>| ControlFlow::Continue(());
    let mut progress = Progress {
        watch: &mut go_on,
        steps: count,
    };
    for _ in 0..count {
        match run.advance(&mut progress, &|_| vec![]) {
            Ok(()) => {}
            Err(StageFailure::Stopped {
                kind, step, detail, ..
            }) => return Err((kind, detail, step)),
            Err(other) => panic!("{other}"),
        }
    }
    Ok(())
}

fn stop(run: &mut Run<Frictionless>, count: u64) -> (String, String, u64) {
    steps(run, count).expect_err("it goes on")
}

fn names(text: &str, a: usize, b: usize) -> bool {
    let pair = |a, b| text.contains(&format!("grains {a} and {b} "));
    pair(a, b) || pair(b, a)
}

fn energy(run: &Run<Frictionless>) -> f64 {
    let contacts = probe::contacts(&run.beam);
    probe::energies(&run.beam, &contacts).iter().sum()
}

/// A light grain squeezed between bottom and top, smooth, elastic where `relaxation_time` is zero, its Δt_crit = 2/√(2k/m), where k = (3/2) K √(R p), and
/// what its contacts store at rest, 2 (2/5) f p.
fn squeezed(relaxation_time: f64) -> (Beam<Frictionless>, f64, f64) {
    let spec = GrowSpec {
        relaxation_time,
        ..spec()
    };
    let (radius, overlap) = (1.02 * HALF, 0.02 * HALF);
    let mut beam = beam::<Frictionless>(&spec, &[([1e-4, 2e-4, 0.0], radius, REST)]);
    beam.surroundings.grip.tangential = Mindlin::default();
    // So light that it, and not a vertex, sets the step.
    let size = Size::sphere(radius, 0.2);
    beam.resize([size].into_iter());
    let stiffness =
        1.5 * beam.surroundings.grip.material.normal_stiffness * (radius * overlap).sqrt();
    let stored = 0.8 * stiffness / 1.5 * overlap * overlap;
    let rate = 2.0 * stiffness * size.inverse_mass;
    // It swings by a twentieth of its overlap.
    let velocity = [0.0, 0.0, 0.05 * overlap * rate.sqrt()];
    let spin = [0.0; 3];
    beam.grains.set_motion(0, 0, Motion { velocity, spin });
    (beam, 2.0 / rate.sqrt(), stored)
}

/// A run of the squeezed grain with one step, `fraction` of its true critical one, and what its contacts store at rest.
///
/// The estimate, √(3/2) times as long, allows all that is below 1.16.
fn squeezed_run(fraction: f64) -> (Run<Frictionless>, f64) {
    let (mut beam, critical, stored) = squeezed(0.0);
    // The contacts with the membrane are known after a step.
    beam.laws.time_step = 1e-3 * critical;
    beam.step();
    let estimate = probe::critical_time_step(&beam, &[]).undamped;
    assert!((estimate / critical - 1.5f64.sqrt()).abs() < 1e-3);
    let mut run = run_at(0.95, beam);
    run.longest_step = fraction * critical;
    (run, stored)
}

#[test]
fn energy_is_kept_for_a_hundred_thousand_steps_just_below_the_critical_one() {
    let (mut run, stored) = squeezed_run(0.9);
    // Velocities are of half steps: only over many swings is the energy of a mode that turns by 2.2 a step even.
    let (mut first, mut last) = (0.0, 0.0);
    for step in 0..100_000 {
        steps(&mut run, 1).expect("stable");
        match step / 10_000 {
            0 => first += energy(&run) - stored,
            9 => last += energy(&run) - stored,
            _ => {}
        }
    }
    assert!((last / first - 1.0).abs() < 0.01, "{first} {last}");
}

#[test]
fn step_beyond_the_critical_one_that_the_estimate_allows_is_unstable() {
    let (mut run, _) = squeezed_run(1.1);
    let (kind, detail, step) = stop(&mut run, 10_000);
    assert_eq!(kind, "unstable", "{detail} at {step}");
}

#[test]
fn damping_limits_the_step_where_contacts_are_stiff() {
    // Damped over as long as the undamped critical step: c = A ω², as all of the stiffness is along the normals.
    let relaxation_time = squeezed(0.0).1;
    let (mut beam, critical, _) = squeezed(relaxation_time);
    beam.laws.time_step = 1e-3 * critical;
    beam.step();
    let found = probe::critical_time_step(&beam, &[]);
    let square = 4.0 / (found.undamped * found.undamped);
    let jury = square * found.damped * (found.damped + 2.0 * relaxation_time);
    assert!((jury / 4.0 - 1.0).abs() < 1e-9, "{jury}");
    for (fraction, step) in [(0.95, 0.8 * found.damped), (0.1, 0.1 * found.undamped)] {
        let mut run = run_at(fraction, beam.clone());
        run.look().expect("sound");
        let taken = run.beam.laws.time_step;
        assert!((taken / step - 1.0).abs() < 1e-12, "{taken} for {step}");
    }
}

#[test]
fn growing_and_colliding_grains_explain_their_energy() {
    // Two grains on their way to each other, and growing by a tenth in a thousand steps.
    let grains = [
        ([-2e-3, 0.0, 0.0], 1.6e-3, [0.5, 0.0, 0.0]),
        ([2e-3, 1e-4, 0.0], 1.6e-3, REST),
    ];
    let mut run = run(&grains);
    steps(&mut run, 1).expect("sound");
    let time = 1000.0 * run.beam.laws.time_step;
    run.growth_rate = 0.1 / time;
    for step in 1..=1000 {
        steps(&mut run, 1).expect("sound");
        let radius = 1.6e-3 * (1.0 + 1e-4 * f64::from(step));
        let size = Size::sphere(radius, 2000.0);
        run.beam.resize([size; 2].into_iter());
    }
    run.growth_rate = 0.0;
    steps(&mut run, 10_000).expect("sound");
}

#[test]
fn what_is_not_a_number_is_found_within_a_hundred_steps_and_named() {
    let grains = [
        ([-0.01, 0.0, 0.0], 1.7e-3, REST),
        ([0.01, 0.0, 0.0], 1.7e-3, REST),
    ];
    for broken in [f64::NAN, f64::INFINITY] {
        let motion = Motion {
            velocity: [0.0, broken, 0.0],
            spin: [0.0; 3],
        };
        let mut of_grain = run(&grains);
        steps(&mut of_grain, 250).expect("sound");
        of_grain.beam.grains.set_motion(1, 0, motion);
        let (kind, detail, step) = stop(&mut of_grain, 100);
        assert_eq!((kind.as_str(), step), ("non_finite", 300));
        assert!(detail.contains("grain 1 "), "{detail}");

        let mut of_vertex = run(&grains);
        steps(&mut of_vertex, 250).expect("sound");
        of_vertex.beam.surroundings.membrane.velocities_mut()[7][2] = broken;
        let (kind, detail, step) = stop(&mut of_vertex, 100);
        assert_eq!((kind.as_str(), step), ("non_finite", 300));
        // Springs have passed it on to other vertices.
        assert!(detail.contains("vertex "), "{detail}");
    }
}

#[test]
fn what_stops_a_run_is_never_saved() {
    let mut run = run(&[([0.0; 3], 1.7e-3, REST)]);
    let mut saved = vec![];
    let mut ask = |report: &crate::outcome::Report<'_>| {
        saved.push(report.step);
        ControlFlow::Continue(())
    };
    let mut progress = Progress {
        watch: &mut ask,
        steps: 1000,
    };
    for step in 0..=300 {
        if step == 250 {
            run.beam.surroundings.membrane.velocities_mut()[0] = [f64::NAN; 3];
        }
        let _ = run.advance(&mut progress, &|_| vec![]);
    }
    assert_eq!(saved, [0, 100, 200]);
}

#[test]
fn grains_at_one_place_are_named() {
    let place = [1e-3, 2e-3, 3e-4];
    let grains = [
        ([-0.01, 0.0, 0.0], 1.7e-3, REST),
        (place, 1.6e-3, REST),
        (place, 1.8e-3, REST),
    ];
    let (kind, detail, step) = stop(&mut run(&grains), 1);
    assert_eq!((kind.as_str(), step), ("coincident_centres", 0));
    assert!(names(&detail, 1, 2), "{detail}");
}

#[test]
fn deep_overlaps_are_warned_about_and_stopped_at_four_and_eight_tenths() {
    let pair = |depth: f64| {
        let (radius, far) = (1.6e-3, 0.5 * (3.4e-3 - depth * 1.6e-3));
        run(&[
            ([-far, 0.0, 0.0], radius, REST),
            ([far, 0.0, 0.0], 1.8e-3, REST),
        ])
    };
    for (depth, warnings) in [(0.39, 0), (0.41, 1), (0.79, 1)] {
        let mut run = pair(depth);
        steps(&mut run, 1).expect("allowed");
        let found = run.warnings("now");
        assert_eq!(found.len(), warnings, "{depth}: {found:?}");
        for text in &found {
            assert!(
                text.starts_with("deep_overlap") && names(text, 0, 1),
                "{text}"
            );
        }
    }
    let (kind, detail, step) = stop(&mut pair(0.81), 1);
    assert_eq!((kind.as_str(), step), ("overlap_limit", 0));
    assert!(names(&detail, 0, 1) && detail.contains("0.81"), "{detail}");
}

#[test]
fn grain_faster_than_a_tenth_of_its_radius_a_step_is_stopped() {
    for (share, stops) in [(0.09, false), (0.11, true)] {
        let mut slow = run(&[([-0.025, 0.0, 0.0], 1.7e-3, REST)]);
        steps(&mut slow, 1).expect("at rest");
        let speed = share * 1.7e-3 / slow.beam.laws.time_step;
        let mut fast = run(&[([-0.025, 0.0, 0.0], 1.7e-3, [speed, 0.0, 0.0])]);
        let found = steps(&mut fast, 201);
        assert_eq!(found.is_err(), stops, "{found:?}");
        if let Err((kind, detail, _)) = found {
            assert_eq!(kind, "escaped_particle");
            assert!(detail.contains("grain 0 "), "{detail}");
        }
    }
}

#[test]
fn grain_beside_an_arch_is_outside_though_within_its_bounds() {
    let arch = |[x, y, z]: [f64; 3]| [x, y, z + 20.0 * x * x];
    let inside = arch([0.024, 0.0, 0.0]);
    for (x, escaped) in [(0.0, true), (0.024, false)] {
        let mut run = run(&[(inside, 1.7e-3, REST), ([x, 5e-3, 0.0117], 1.7e-3, REST)]);
        for place in run.beam.surroundings.membrane.positions_mut() {
            *place = arch(*place);
        }
        run.beam.renew_contacts();
        let [low, high] = run.beam.surroundings.membrane.mesh().bounds();
        assert!(low[2] < 0.0117 && 0.0117 < high[2]);
        let found = steps(&mut run, 1);
        assert_eq!(found.is_err(), escaped, "{found:?}");
        if let Err((kind, detail, step)) = found {
            assert_eq!((kind.as_str(), step), ("escaped_particle", 0));
            assert!(detail.contains("grain 1 "), "{detail}");
        }
    }
}

#[test]
fn grain_that_crosses_the_sheet_by_less_than_its_radius_comes_back() {
    let spec = GrowSpec {
        relaxation_time: 0.0,
        ..spec()
    };
    let radius = 1.7e-3;
    let mut beam = beam::<Frictionless>(&spec, &[([0.0, 0.0, -HALF + radius], radius, REST)]);
    // m v²/2 = (2/5) K √R p^(5/2) at p = 1.3 R.
    let deepest = 1.3 * radius;
    let stored = 0.4
        * beam.surroundings.grip.material.normal_stiffness
        * radius.sqrt()
        * deepest
        * deepest
        * deepest.sqrt();
    let speed = (2.0 * stored * beam.grains.sizes()[0].inverse_mass).sqrt();
    let motion = Motion {
        velocity: [0.0, 0.0, -speed],
        spin: [0.0; 3],
    };
    beam.grains.set_motion(0, 0, motion);
    let mut run = run_at(0.4, beam);
    run.longest_step = deepest / speed / 1000.0;
    let mut lowest = 0.0f64;
    // An impact takes 2.94 p/v.
    for _ in 0..3200 {
        // Each step as if it were one at which grains outside are looked for.
        steps(&mut run, 1).expect("it is pushed back");
        lowest = lowest.min(run.beam.grains.pose(0, 0).position[2]);
        let step = std::mem::take(&mut run.step);
        run.look().expect("it is pushed back");
        run.step = step;
    }
    assert!(lowest < -HALF - 0.25 * radius, "{lowest}");
    assert!(run.beam.grains.motion(0, 0).velocity[2] > 0.9 * speed);
}

/// Moves a vertex in the middle of the top along x by `share` of the way to its neighbor.
fn pull_a_vertex(run: &mut Run<Frictionless>, share: f64) {
    let membrane = &mut run.beam.surroundings.membrane;
    let places = membrane.mesh().positions().to_vec();
    let distance = |v: usize| plain::norm(plain::sub(places[v], [0.0, 0.0, HALF]));
    let nearest = (0..places.len()).min_by(|&a, &b| distance(a).total_cmp(&distance(b)));
    let vertex = nearest.expect("vertices");
    let edges = membrane.mesh().edges().iter();
    let ends = edges.filter(|ends| ends.contains(&(vertex as u32)));
    let neighbors = ends.map(|ends| (ends[0] + ends[1]) as usize - vertex);
    let way = neighbors
        .map(|other| plain::sub(places[other], places[vertex]))
        .max_by(|a, b| a[0].total_cmp(&b[0]))
        .expect("a neighbor");
    membrane.positions_mut()[vertex] = plain::add(places[vertex], plain::scale(way, share));
}

#[test]
fn short_edges_are_warned_about_and_collapsed_or_flipped_triangles_stop_a_run() {
    for (share, warned) in [(0.69, false), (0.71, true)] {
        let mut run = run(&[]);
        pull_a_vertex(&mut run, share);
        steps(&mut run, 101).expect("a warning at most");
        let found = run.warnings("now");
        assert_eq!(
            found.iter().any(|text| text.starts_with("short_edges")),
            warned
        );
    }
    // Onto its neighbor: two triangles have no area left.
    let mut collapsed = run(&[]);
    pull_a_vertex(&mut collapsed, 1.0);
    let (kind, detail, step) = stop(&mut collapsed, 1);
    assert_eq!((kind.as_str(), step), ("membrane_collapse", 0));
    assert!(detail.contains("of its area at rest"), "{detail}");
    // Beyond it: they are turned over.
    let mut flipped = run(&[]);
    steps(&mut flipped, 50).expect("sound");
    pull_a_vertex(&mut flipped, 1.5);
    let (kind, detail, step) = stop(&mut flipped, 100);
    assert_eq!((kind.as_str(), step), ("membrane_collapse", 100));
    assert!(detail.contains("has turned by 180°"), "{detail}");
}

#[test]
fn folds_sharper_than_150_degrees_are_warned_about() {
    let mut run = run(&[]);
    steps(&mut run, 1).expect("sound");
    assert_eq!(run.warnings("now"), [""; 0]);
    // A triangle is folded by 160° about one of its sides, onto the one beside it.
    let membrane = &mut run.beam.surroundings.membrane;
    let corners = membrane.mesh().triangles()[0].map(|v| v as usize);
    let places = membrane.mesh().positions().to_vec();
    let (a, b) = (places[corners[0]], places[corners[1]]);
    let out = membrane.mesh().normals().next().expect("a triangle");
    let (side, to) = (plain::sub(b, a), plain::sub(places[corners[2]], a));
    let share = plain::dot(to, side) / plain::dot(side, side);
    let foot = plain::add(a, plain::scale(side, share));
    let arm = plain::sub(places[corners[2]], foot);
    let turn = 160f64.to_radians();
    let up = plain::scale(out, libm::sin(turn) * plain::norm(arm));
    let turned = plain::add(plain::scale(arm, libm::cos(turn)), up);
    membrane.positions_mut()[corners[2]] = plain::add(foot, turned);
    run.normals.clear();
    steps(&mut run, 100).expect("a warning at most");
    let found = run.warnings("now");
    assert!(
        found.iter().any(|text| text.starts_with("sharp_folds")),
        "{found:?}"
    );
}

#[test]
fn contacts_of_grains_a_hundred_times_as_large_are_all_found_and_the_light_one_sets_the_step() {
    let draw = |k: u64| uniform3(5, Purpose::GrainPlace, k);
    let grains: Vec<Placed> = (0..300)
        .map(|k| {
            let [size, ..] = draw(2 * k);
            let radius = 1.6e-3 * libm::pow(100.0, -size);
            let place = draw(2 * k + 1).map(|share| 4e-3 * (2.0 * share - 1.0));
            (place, radius, REST)
        })
        .collect();
    let crowd = beam::<Frictionless>(&spec(), &grains);
    let mut found: Vec<[usize; 2]> = probe::contacts(&crowd)
        .iter()
        .map(|c| [c.i.min(c.j), c.i.max(c.j)])
        .collect();
    found.sort_unstable();
    let mut expected = vec![];
    for (i, a) in grains.iter().enumerate() {
        for (j, b) in grains.iter().enumerate().skip(i + 1) {
            if plain::norm(plain::sub(a.0, b.0)) < a.1 + b.1 {
                expected.push([i, j]);
            }
        }
    }
    assert!(expected.len() > 100, "{}", expected.len());
    assert_eq!(found, expected);

    let (large, small) = (1.6e-3, 1.6e-5);
    let overlap = 0.1 * small;
    let pair = beam::<Frictionless>(
        &spec(),
        &[
            (REST, large, REST),
            ([large + small - overlap, 0.0, 0.0], small, REST),
        ],
    );
    let contacts = probe::contacts(&pair);
    let masses = pair.grains.sizes();
    assert!((masses[1].inverse_mass / masses[0].inverse_mass / 1e6 - 1.0).abs() < 1e-12);
    // k = (3/2) K √(R_eff p), of which a third counts.
    let effective = large * small / (large + small);
    let along = 1.5 * pair.laws.material.normal_stiffness * (effective * overlap).sqrt();
    let expected = 2.0 / (2.0 * masses[1].inverse_mass * along / 3.0).sqrt();
    let step = probe::critical_time_step(&pair, &contacts).undamped;
    // The overlap is a difference of lengths a thousand times as large.
    assert!((step / expected - 1.0).abs() < 1e-9, "{step} {expected}");
}

#[test]
fn grains_that_just_do_not_touch_feel_nothing() {
    let (radius, reach) = (1.7e-3, 3.4e-3f64);
    // At their reach, and beyond it by one rounding and by 1e-18 m.
    for distance in [reach, reach.next_up(), reach + 1e-18] {
        let far = 0.5 * distance;
        let grains = [
            ([-far, 0.0, 0.0], radius, REST),
            ([far, 0.0, 0.0], radius, [0.0, 0.1, 0.0]),
        ];
        let mut pair = beam::<Mindlin>(&spec(), &grains);
        pair.laws.time_step = 1e-9;
        assert_eq!(probe::contacts(&pair), []);
        pair.step();
        let velocity = pair.grains.motion(0, 0).velocity;
        // A tie may be broken by rounding, 2e-16 of the reach: the force is below 1e-20 N, the grain's mass above 1e-5 kg.
        assert!(plain::norm(velocity) < 1e-23, "{velocity:?}");
        let springs = pair.histories().map(|(_, _, history)| history.as_slice());
        let longest = springs
            .flatten()
            .fold(0.0f64, |most, part| most.max(part.0[0].abs()));
        assert!(longest < 1e-9, "{longest}");
    }
}
