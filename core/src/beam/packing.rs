//! Where the grains are before they grow: radii drawn evenly, places tried at random until nothing overlaps.

use std::f64::consts::PI;

use super::spec::GrowSpec;
use crate::guard::Stop;
use crate::math::plain;
use crate::random::{Purpose, uniform3};

/// Places tried for one grain before it is given up; at the usual 0.21 of the volume one of 10 to 20 is free.
const MOST_TRIES: u64 = 100_000;

/// Grains before they grow.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Packing {
    /// Centers \[m\], about the mold's middle.
    pub(super) places: Vec<[f64; 3]>,
    /// \[m\].
    pub(super) radii: Vec<f64>,
    /// What all radii are multiplied by in the end, so that the volume fraction is the one asked for.
    pub(super) growth: f64,
}

/// Draws and places the grains of `spec`, numbered by place along the beam.
pub(super) fn packing(spec: &GrowSpec) -> Result<Packing, Stop> {
    let (radii, growth) = radii(spec);
    let mut places = Places::new(spec, &radii);
    for (i, &radius) in radii.iter().enumerate() {
        if !places.put(spec, radius) {
            return Err(Stop {
                kind: "no_place",
                detail: format!(
                    "grain {i} of {} found no place in {MOST_TRIES} tries",
                    radii.len()
                ),
                remedy: "use a smaller initial_volume_fraction or a larger growth_factor"
                    .to_owned(),
            });
        }
    }
    let order = along_the_beam(&places.centers, 3.0 * spec.radius_max);
    Ok(Packing {
        places: order.iter().map(|&i| places.centers[i]).collect(),
        radii: order.iter().map(|&i| radii[i]).collect(),
        growth,
    })
}

/// Radii before growth, drawn until their grown volumes are those of φ_init, and the factor that makes them just that.
fn radii(spec: &GrowSpec) -> (Vec<f64>, f64) {
    let mold = spec.length * spec.height * spec.depth;
    let wanted = spec.initial_volume_fraction * mold;
    let (low, high) = (
        spec.radius_min / spec.growth_factor,
        spec.radius_max / spec.growth_factor,
    );
    let grown = |radius: f64| {
        let radius = spec.growth_factor * radius;
        4.0 / 3.0 * PI * radius * radius * radius
    };
    let (mut radii, mut volume) = (vec![], 0.0);
    while volume < wanted {
        let [share, ..] = uniform3(spec.packing_seed, Purpose::GrainRadius, radii.len() as u64);
        let radius = low + share * (high - low);
        volume += grown(radius);
        radii.push(radius);
    }
    let excess = if volume > 0.0 { wanted / volume } else { 1.0 };
    (radii, spec.growth_factor * libm::cbrt(excess))
}

/// The order of centers along x in slabs of `width`, within a slab along z in layers, then along y.
fn along_the_beam(centers: &[[f64; 3]], width: f64) -> Vec<usize> {
    let cell = |x: f64| (x / width).floor() as i64;
    let mut order: Vec<usize> = (0..centers.len()).collect();
    order.sort_by(|&a, &b| {
        let ([ax, ay, az], [bx, by, bz]) = (centers[a], centers[b]);
        (cell(ax), cell(az))
            .cmp(&(cell(bx), cell(bz)))
            .then(ay.total_cmp(&by))
            .then(a.cmp(&b))
    });
    order
}

/// Grains placed so far, in cells as wide as the largest.
struct Places {
    centers: Vec<[f64; 3]>,
    radii: Vec<f64>,
    cells: Vec<Vec<u32>>,
    count: [usize; 3],
    width: [f64; 3],
    half: [f64; 3],
    tries: u64,
}

/// How many cells of at least `width` there are along each side: not many more in all than `grains`, however far apart they are.
fn cells(sides: [f64; 3], width: f64, grains: usize) -> [usize; 3] {
    if grains == 0 {
        return [1; 3];
    }
    let most = 4 * grains;
    let mut width = width;
    loop {
        let count = sides.map(|side| ((side / width) as usize).max(1));
        let all = count
            .iter()
            .try_fold(1, |all: usize, &n| all.checked_mul(n));
        if all.is_some_and(|all| all <= most) {
            return count;
        }
        width *= 1.26;
    }
}

impl Places {
    fn new(spec: &GrowSpec, radii: &[f64]) -> Self {
        let largest = radii.iter().fold(0.0, |most: f64, &r| most.max(r));
        let sides = [spec.length, spec.depth, spec.height];
        let count = cells(sides, 2.0 * largest, radii.len());
        Self {
            centers: vec![],
            radii: vec![],
            cells: vec![vec![]; count.iter().product()],
            width: [0, 1, 2].map(|k| sides[k] / count[k] as f64),
            half: sides.map(|side| 0.5 * side),
            count,
            tries: 0,
        }
    }

    /// Puts a grain where it touches nothing; `false` if no place is found.
    fn put(&mut self, spec: &GrowSpec, radius: f64) -> bool {
        for _ in 0..MOST_TRIES {
            let shares = uniform3(spec.packing_seed, Purpose::GrainPlace, self.tries);
            self.tries += 1;
            let center = [0, 1, 2].map(|k| (2.0 * shares[k] - 1.0) * (self.half[k] - radius));
            if self.is_free(center, radius) {
                let [x, y, z] = self.cell(center);
                let cell = (z * self.count[1] + y) * self.count[0] + x;
                self.cells[cell].push(self.centers.len() as u32);
                self.centers.push(center);
                self.radii.push(radius);
                return true;
            }
        }
        false
    }

    fn cell(&self, center: [f64; 3]) -> [usize; 3] {
        [0, 1, 2].map(|k: usize| {
            (((center[k] + self.half[k]) / self.width[k]) as usize).min(self.count[k] - 1)
        })
    }

    fn is_free(&self, center: [f64; 3], radius: f64) -> bool {
        let at = self.cell(center);
        let around = |k: usize| at[k].saturating_sub(1)..=(at[k] + 1).min(self.count[k] - 1);
        around(2).all(|z| {
            around(1).all(|y| {
                around(0).all(|x| {
                    let cell = (z * self.count[1] + y) * self.count[0] + x;
                    self.cells[cell].iter().all(|&j| {
                        let reach = radius + self.radii[j as usize];
                        let apart = plain::sub(center, self.centers[j as usize]);
                        plain::dot(apart, apart) > reach * reach
                    })
                })
            })
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::beam::point::BeamPoint;

    fn spec() -> GrowSpec {
        let map = BeamPoint::defaults("smoke").expect("a preset");
        BeamPoint::from_parameters(map)
            .expect("valid defaults")
            .grow()
    }

    #[test]
    fn grown_grains_have_the_volume_fraction_and_none_touches_another_or_the_mold() {
        let spec = spec();
        let packing = packing(&spec).expect("room enough");
        let grown = |r: &f64| {
            4.0 / 3.0 * PI * (packing.growth * r) * (packing.growth * r) * (packing.growth * r)
        };
        let volume: f64 = packing.radii.iter().map(grown).sum();
        let mold = spec.length * spec.height * spec.depth;
        assert!((volume / mold - spec.initial_volume_fraction).abs() < 1e-12);
        let half = [spec.length, spec.depth, spec.height].map(|side| 0.5 * side);
        for (i, (&a, ra)) in packing.places.iter().zip(&packing.radii).enumerate() {
            assert!([0, 1, 2].iter().all(|&k| a[k].abs() + ra <= half[k]));
            for (&b, rb) in packing.places[..i].iter().zip(&packing.radii) {
                assert!(plain::norm(plain::sub(a, b)) > ra + rb);
            }
        }
    }

    /// Without grains the cells were as narrow as nothing, and there were 10⁹ of them.
    #[test]
    fn there_are_not_many_more_cells_than_grains() {
        let sides = [0.4, 0.08, 0.04];
        assert_eq!(cells(sides, 0.0, 0), [1; 3]);
        assert_eq!(cells(sides, 1e-6, 1).iter().product::<usize>(), 4);
        // As wide as the grains where these fill the mold.
        assert_eq!(cells(sides, 0.0035, 11_744), [114, 22, 11]);
    }

    #[test]
    fn no_grains_are_an_empty_beam_and_too_many_find_no_place() {
        let empty = GrowSpec {
            initial_volume_fraction: 0.0,
            ..spec()
        };
        assert_eq!(packing(&empty).expect("nothing to place").radii.len(), 0);
        let crowded = GrowSpec {
            growth_factor: 1.0,
            initial_volume_fraction: 0.5,
            ..spec()
        };
        assert_eq!(packing(&crowded).expect_err("no room").kind, "no_place");
    }
}
