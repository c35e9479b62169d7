//! One contact on a prescribed path: what each law's spring makes of it (Figs. 10 and 15 of the memory paper).
//!
//! A path is a list of overlaps p and slips σ, along one line; neither damping nor a Coulomb limit acts on it.
//! At every place the overlap is taken first, and the slip since the last place is made at that overlap, as a time step does.

use super::{Contact, TangentialLaw};
use crate::lanes::F64x1;
use crate::math::Vec3;

/// Where a contact is: how deep, and how far it has slipped since it closed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// p; at zero the contact is open and forgets.
    pub overlap: f64,
    /// σ.
    pub slip: f64,
}

/// The path of Fig. 10(a), in its units: pressed to p = ½, sheared to σ = 0.8, pressed to 1, sheared to 1, and parted.
///
/// `steps` of each leg.
#[must_use]
pub fn figure_10(steps: u32) -> Vec<Place> {
    let corners = [
        [0.0, 0.0],
        [0.5, 0.0],
        [0.5, 0.8],
        [1.0, 0.8],
        [1.0, 1.0],
        [0.0, 1.0],
    ];
    let legs = corners.windows(2).flat_map(|ends| {
        (1..=steps).map(move |n| {
            let share = f64::from(n) / f64::from(steps);
            let [overlap, slip] = [0, 1].map(|c| ends[0][c] + (ends[1][c] - ends[0][c]) * share);
            Place { overlap, slip }
        })
    });
    legs.collect()
}

/// Where a path goes from place to place: the overlap, and the slip made at it.
fn steps(path: &[Place]) -> impl Iterator<Item = (f64, f64)> {
    path.iter().scan(0.0, |slipped, place| {
        let slip = place.slip - *slipped;
        *slipped = place.slip;
        Some((place.overlap, slip))
    })
}

/// f_e of a law at every place of `path`, by the law's own code.
#[must_use]
pub fn response<T: TangentialLaw>(law: &T, path: &[Place]) -> Vec<f64> {
    let constants = law.constants::<F64x1>();
    let lane = |x: f64| F64x1([x]);
    let vector = |x: f64, z: f64| Vec3 {
        x: lane(x),
        y: lane(0.0),
        z: lane(z),
    };
    let forgotten = || {
        let history = <T::History<F64x1> as super::Components<F64x1>>::from_fn(|_| lane(0.0));
        (history, T::Slices::<F64x1>::default())
    };
    let mut memory = forgotten();
    let force = |(overlap, slip): (f64, f64)| {
        if overlap <= 0.0 {
            memory = forgotten();
            return 0.0;
        }
        let contact = Contact {
            normal: vector(0.0, 1.0),
            sliding_velocity: vector(slip, 0.0),
            root_overlap: lane(overlap.sqrt()),
            reduced_mass: lane(1.0),
            // Far more than any friction needs.
            normal_force: lane(1e100),
            time_step: lane(1.0),
            dither: lane(0.0),
        };
        -T::force(&constants, &contact, &mut memory.0, &mut memory.1).lane(0)[0]
    };
    steps(path).map(force).collect()
}

/// f_e of law M2 at every place of `path` in the limit of infinitely many slices: the integral of the density f(q), which is
/// constant between the values of q where the overlap has turned.
#[must_use]
pub fn exact(stiffness: f64, path: &[Place]) -> Vec<f64> {
    // Up to which q the density is how large, from the inside outwards.
    let mut rings: Vec<(f64, f64)> = vec![];
    let force = |(overlap, slip): (f64, f64)| {
        let q = overlap.max(0.0).sqrt();
        while rings.len() > 1 && rings[rings.len() - 2].0 >= q {
            rings.pop();
        }
        match rings.last_mut() {
            Some(outermost) if outermost.0 >= q => outermost.0 = q,
            _ => rings.push((q, 0.0)),
        }
        let mut inner = 0.0;
        let mut force = 0.0;
        for (outer, density) in &mut rings {
            *density += stiffness * slip;
            force += *density * (*outer - inner);
            inner = *outer;
        }
        force
    };
    steps(path).map(force).collect()
}

/// Law M2 as App. D.2 prints it: `slices` is Q and `largest_overlap` p_max.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Printed {
    /// k_M.
    pub stiffness: f64,
    /// Q.
    pub slices: usize,
    /// p_max.
    pub largest_overlap: f64,
    /// Whether the term in h of step 4a is in it.
    pub with_h: bool,
}

impl Printed {
    /// f_e at every place of `path`, by the numbered steps 1 to 4a, slice by slice.
    #[must_use]
    pub fn response(&self, path: &[Place]) -> Vec<f64> {
        let width = self.largest_overlap.sqrt() / (self.slices - 1) as f64;
        let mut densities = vec![0.0; self.slices];
        let force = |(overlap, slip): (f64, f64)| {
            if overlap <= 0.0 {
                densities.fill(0.0);
                return 0.0;
            }
            let reached = overlap.sqrt() / width;
            let outermost = (reached as usize).min(self.slices - 2);
            let h = 1.0 + outermost as f64 - reached;
            densities[outermost + 1..].fill(0.0);
            for density in &mut densities[..=outermost] {
                *density += self.stiffness * slip;
            }
            let cut = if self.with_h { h } else { 0.0 };
            let sum: f64 = densities.iter().sum();
            width * (sum - 0.5 * densities[0] - cut * densities[outermost])
        };
        steps(path).map(force).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::hooke::Hooke;
    use crate::contact::mindlin_rescale::MindlinRescale;
    use crate::contact::mindlin_sliced::MindlinSliced;
    use crate::random::{Purpose, uniform3};

    const STEPS: u32 = 400;
    const STIFFNESS: f64 = 1.0;

    fn sliced(slices: u32) -> Vec<f64> {
        let law = MindlinSliced {
            stiffness: STIFFNESS,
            damping: 0.0,
            friction_coefficient: 1.0,
            slices,
            largest_overlap: 1.5,
        };
        response(&law, &figure_10(STEPS))
    }

    fn rescaled() -> Vec<f64> {
        let law = MindlinRescale {
            stiffness: STIFFNESS,
            damping: 0.0,
            friction_coefficient: 1.0,
        };
        response(&law, &figure_10(STEPS))
    }

    fn largest_difference(a: &[f64], b: &[f64]) -> f64 {
        let each = a.iter().zip(b).map(|(a, b)| (a - b).abs());
        each.fold(0.0, f64::max)
    }

    /// The index of the last place of each leg.
    fn end_of_leg(leg: u32) -> usize {
        (leg * STEPS - 1) as usize
    }

    #[test]
    fn figure_10_by_hand() {
        // Sheared by 0.8 at √½ and by 0.2 at 1, in units of k_M; nothing changes while the overlap grows.
        let (root, all) = (0.5f64.sqrt(), 0.8 * 0.5f64.sqrt() + 0.2);
        let (path, m1, m2) = (
            figure_10(STEPS),
            rescaled(),
            exact(STIFFNESS, &figure_10(STEPS)),
        );
        let hooke = Hooke {
            stiffness: 0.7,
            damping: 0.0,
            friction_coefficient: 1.0,
        };
        let h = response(&hooke, &path);
        for force in [&m1, &m2] {
            assert!((force[end_of_leg(2)] - 0.8 * root).abs() < 1e-12);
            assert!((force[end_of_leg(3)] - 0.8 * root).abs() < 1e-12);
            assert!((force[end_of_leg(4)] - all).abs() < 1e-12);
        }
        for n in end_of_leg(4)..end_of_leg(5) {
            let q = path[n].overlap.sqrt();
            // M1 falls as √p. M2 loses only the last shear between √½ and 1, then both.
            let inner = if q > root { 0.8 * root + 0.2 * q } else { q };
            assert!((m1[n] - all * q).abs() < 1e-12, "{q}: {}", m1[n]);
            assert!((m2[n] - inner).abs() < 1e-12, "{q}: {}", m2[n]);
            assert!((h[n] - 0.7).abs() < 1e-12);
        }
    }

    #[test]
    fn slices_converge_to_the_integral() {
        // Within the slice that p = ½ lies in, the density is taken for even: the force is off by no more than the change of
        // density there, 0.8 k_M, times a quarter of the slice, dq = √1.5/(Q − 1).
        let exact = exact(STIFFNESS, &figure_10(STEPS));
        let mut last = f64::INFINITY;
        for slices in [5, 20, 100, 1_000, 10_000] {
            let off = largest_difference(&sliced(slices), &exact);
            let bound = 0.8 * 0.25 * 1.5f64.sqrt() / f64::from(slices - 1);
            assert!(off < bound + 1e-12, "{slices}: {off} {bound}");
            assert!(off < last, "{slices}: {off} after {last}");
            last = off;
        }
    }

    #[test]
    fn printed_quadrature_is_half_a_slice_short() {
        let path = figure_10(STEPS);
        let exact = exact(STIFFNESS, &path);
        for (slices, with_h) in [(20, true), (20, false), (100, true), (100, false)] {
            let printed = Printed {
                stiffness: STIFFNESS,
                slices,
                largest_overlap: 1.5,
                with_h,
            };
            let width = 1.5f64.sqrt() / (slices - 1) as f64;
            let force = printed.response(&path);
            // After the first shear: 0.8 k_M (x_p − ½) dq with the term in h, and (j_p + ½) dq without.
            let reached = 0.5f64.sqrt() / width;
            let weight = if with_h {
                reached
            } else {
                reached.floor() + 1.0
            } - 0.5;
            let expected = 0.8 * weight * width;
            assert!((force[end_of_leg(2)] - expected).abs() < 1e-12);
            // The density jumps by 1 at most from slice to slice, so no force is off by more than one and a half.
            assert!(largest_difference(&force, &exact) < 1.5 * width);
        }
    }

    #[test]
    fn no_closed_path_gains_energy() {
        // Each slip is made at one overlap, where the spring is linear: its work is the slip times the mean of the forces
        // before and after. A spring k_M √p σ without more would give back more than it took: sheared shallow, parted deep.
        let sliced = MindlinSliced {
            stiffness: STIFFNESS,
            damping: 0.0,
            friction_coefficient: 1.0,
            slices: 30,
            largest_overlap: 1.5,
        };
        let rescaled = MindlinRescale {
            stiffness: STIFFNESS,
            damping: 0.0,
            friction_coefficient: 1.0,
        };
        for seed in 0..200 {
            let mut path = vec![];
            let mut slip = 0.0;
            for n in 0..60 {
                let [p, s, _] = uniform3(seed, Purpose::GasVelocity, n);
                let overlap = 1.4 * p + 0.01;
                path.push(Place { overlap, slip });
                // The last slip closes the path.
                slip = if n == 59 { 0.0 } else { 0.6 * s - 0.3 };
                path.push(Place { overlap, slip });
            }
            for force in [
                response(&sliced, &path),
                response(&rescaled, &path),
                exact(STIFFNESS, &path),
            ] {
                let work: f64 = (1..path.len())
                    .map(|n| 0.5 * (force[n - 1] + force[n]) * (path[n].slip - path[n - 1].slip))
                    .sum();
                assert!(work > -1e-12, "{seed}: {work}");
            }
        }
    }

    #[test]
    fn what_was_sheared_deeper_is_forgotten_on_return() {
        // The paper's note 5: after a return from p2 to p1 the force is that of a path that never exceeded p1.
        let there_and_back = |beyond: f64| {
            let mut path = vec![Place {
                overlap: 0.3,
                slip: 0.0,
            }];
            for n in 1..=200 {
                let share = f64::from(n) / 200.0;
                path.push(Place {
                    overlap: 0.3 + beyond * share,
                    slip: 0.4 * share,
                });
            }
            for n in 1..=200 {
                let share = f64::from(n) / 200.0;
                path.push(Place {
                    overlap: 0.3 + beyond * (1.0 - share),
                    slip: 0.4 + 0.1 * share,
                });
            }
            path
        };
        let (shallow, deep) = (there_and_back(0.0), there_and_back(0.7));
        let last = |path: &[Place]| exact(STIFFNESS, path).pop().expect("a force");
        assert!((last(&deep) - last(&shallow)).abs() < 1e-12);
        // By slices, but for the one that p1 lies in.
        let law = MindlinSliced {
            stiffness: STIFFNESS,
            damping: 0.0,
            friction_coefficient: 1.0,
            slices: 100,
            largest_overlap: 1.5,
        };
        let off = |path: &[Place]| response(&law, path).pop().expect("a force") - last(path);
        let width = 1.5f64.sqrt() / 99.0;
        assert!(off(&shallow).abs() < 1e-12 && off(&deep).abs() < 0.5 * width);
        assert!(off(&deep).abs() > 1e-6, "slices are not the integral");
    }
}
