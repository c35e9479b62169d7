//! probe
use granary_core::contact::hooke::Hooke;
use granary_core::grains::{Motion, Pose};
use granary_core::lanes::F64x8;
use granary_core::math::plain::{add, cross, dot, norm, scale, sub};
use granary_core::scene::Scene;
use granary_core::shape::{Shape, Sphere, Tetrahedron};

#[path = "fixture/free_grains.rs"]
#[allow(dead_code, reason = "every proof takes what it needs")]
mod free_grains;

use free_grains::{Free, HOOKE, body, energy, laws, random_orientation, random3, scene};

const LANES: usize = 8;

/// The fastest grain of the gas: 0.02 R/t_c along each axis (MEMORY §3).
const GAS_SPEED: f64 = 0.034_641;

#[derive(Debug, Default)]
struct Found {
    impacts: u64,
    touched: u64,
    unfinished: u64,
    grown: u64,
    worst: f64,
    worst_absolute: f64,
    worst_share: f64,
}

fn impacts<S: Shape>(time_step: f64, (speeds, spins): ((f64, f64), (f64, f64)), count: u64) -> Found {
    let mut found = Found::default();
    let reach = if S::SPHERES > 1 { body::<S>().reach() } else { 0.0 };
    let apart = 2.0 * (1.0 + reach);
    for batch in 0..count / LANES as u64 {
        let seed = 1000 + batch;
        let pose = |x: f64, n: u64| Pose { position: [x, 0.0, 0.0], orientation: random_orientation::<S>(seed, n) };
        let mut laws = laws::<S, Hooke>(HOOKE, time_step);
        laws.skin = 3.0;
        let mut scene: Scene<F64x8, Free<S, Hooke>> = scene(laws, vec![pose(0.0, 0), pose(apart, 1)]);
        let mut draws = vec![];
        let mut touching = [0; LANES];
        for k in 0..LANES {
            let draw = |n: u64| random3(seed, 10 + 10 * k as u64 + n);
            let unit = |n: u64| { let v = draw(n); scale(v, 1.0 / norm(v)) };
            let along = unit(0);
            let aside = cross(along, unit(1));
            let aside = scale(aside, 1.0 / norm(aside));
            let [a, b, c] = draw(2).map(|x| 0.5 * (x + 1.0));
            let offset = apart * a.sqrt();
            let speed = speeds.0 + (speeds.1 - speeds.0) * b;
            let place = add(scale(along, (apart * apart - offset * offset).sqrt()), scale(aside, offset));
            let turn = |n: u64| random_orientation::<S>(seed + 77_777, 10 + 10 * k as u64 + n);
            scene.grains.set_offset(0, k, [0.0; 3], turn(0));
            scene.grains.set_offset(1, k, sub(place, [apart, 0.0, 0.0]), turn(1));
            let [d, e, _] = draw(3).map(|x| 0.5 * (x + 1.0));
            let spin = |n: u64, share: f64| scale(unit(n), spins.0 + (spins.1 - spins.0) * share);
            let _ = c;
            scene.grains.set_motion(0, k, Motion { velocity: scale(along, 0.5 * speed), spin: spin(4, d) });
            scene.grains.set_motion(1, k, Motion { velocity: scale(along, -0.5 * speed), spin: spin(5, e) });
            let n = scale(place, -1.0 / norm(place));
            let rel = add(scale(along, speed), cross(add(spin(4, d), spin(5, e)), scale(n, -1.0)));
            let vn = dot(rel, n);
            draws.push((offset / apart, speed, norm(sub(rel, scale(n, vn))), vn));
        }
        scene.renew_contacts();
        let before: Vec<f64> = (0..LANES).map(|k| energy(&scene, k)).collect();
        let start: Vec<Motion> = (0..LANES).map(|k| scene.grains.motion(0, k)).collect();
        let starts: Vec<Motion> = (0..LANES).map(|k| scene.grains.motion(1, k)).collect();
        let mut done = [false; LANES];
        let most = (6000.0 / time_step) as u64;
        for step in 0..most {
            scene.step();
            for (k, t) in touching.iter_mut().enumerate() { let d = norm(sub(scene.grains.pose(1, k).position, scene.grains.pose(0, k).position)); *t += i32::from(d < 2.0); }
            if step % 16 == 15 {
                for (k, done) in done.iter_mut().enumerate() {
                    let x = sub(scene.grains.pose(1, k).position, scene.grains.pose(0, k).position);
                    let v = sub(scene.grains.motion(1, k).velocity, scene.grains.motion(0, k).velocity);
                    *done = norm(x) > apart && dot(x, v) > 0.0;
                }
                if done.iter().all(|&d| d) { break; }
            }
        }
        for k in 0..LANES {
            found.impacts += 1;
            found.unfinished += u64::from(!done[k]);
            found.touched += u64::from(scene.grains.motion(0, k) != start[k]);
            let growth = energy(&scene, k) - before[k];
            if growth > 1e-12 * before[k] {
                found.grown += 1;
                let aa = draws[k];
                println!("   k {k} b/D {:.6} w {:.5} spins {:?} {:?} growth {:e} of {:e}; contact-steps {}; v_t {:?} v_n {:.5} -> {:?} E after parts", aa.0, aa.1, start[k].spin, starts[k].spin, growth, before[k], touching[k], aa.2, aa.3, norm(sub(scene.grains.motion(1, k).velocity, scene.grains.motion(0, k).velocity)));
                found.worst = found.worst.max(growth / before[k]);
                found.worst_absolute = found.worst_absolute.max(growth);
                let translational = 0.25 * body::<S>().mass * 4.0 * norm(start[k].velocity).powi(2);
                found.worst_share = found.worst_share.max(growth / translational);
            }
        }
    }
    found
}

#[test]
fn probe() {
    let s = ((0.2 * GAS_SPEED, GAS_SPEED), (0.0, 0.0));
    for (dt, spin, n) in [(1.5, 0.02, 40000), (1.5, 0.05, 40000), (0.1, 1.0, 10000)] {
        let t = std::time::Instant::now();
        println!("sphere dt {dt} spin {spin}: {:?} {:?}", impacts::<Sphere>(dt, (s.0, (0.0, spin)), n), t.elapsed());
        let t = std::time::Instant::now();
        println!("tetra dt {dt} spin {spin}: {:?} {:?}", impacts::<Tetrahedron>(dt, (s.0, (0.0, spin)), n), t.elapsed());
    }
    println!("tetra dt 1.5 spin 1: {:?}", impacts::<Tetrahedron>(1.5, (s.0, (0.0, 1.0)), 40000));
}
