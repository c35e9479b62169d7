//! The forces of grains and membrane on each other, eight contacts at a time.

use super::Held;
use super::touch::{Share, Touch};
use crate::contact::mindlin::Mindlin;
use crate::contact::{Contact, TangentialLaw, hertz};
use crate::grains::Grains;
use crate::lanes::{F64x1, F64x8, Lane};
use crate::material::Material;
use crate::math::{Vec3, plain};
use crate::membrane::Membrane;

/// One contact of the running step, until its force is known.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pending {
    /// The normal and the overlap; the lever from the grain's center and the grain's radius.
    geometry: F64x8,
    /// Velocity of the grain against the membrane at the contact point and 1/m_grain + 1/m_triangle; the spring.
    motion: F64x8,
    grain: u32,
    triangle: u32,
}

impl Pending {
    /// `touch` with its `shares` and its spring, of a grain and a triangle of `mass`.
    #[inline(always)]
    pub(super) fn new(
        touch: &Touch,
        shares: &[Share],
        (grains, membrane): (&Grains<F64x1>, &Membrane),
        [s_x, s_y, s_z]: [f64; 3],
        mass: f64,
    ) -> Self {
        let of_sheet = shares.iter().fold([0.0; 3], |sum, share| {
            let &[x, y, z, _] = membrane.vertices()[share.vertex as usize].halves()[1];
            plain::add(sum, plain::scale([x, y, z], share.weight))
        });
        let (motion, size) = (
            grains.motion(touch.grain as usize, 0),
            grains.sizes()[touch.grain as usize],
        );
        let surface = plain::add(motion.velocity, plain::cross(motion.spin, touch.lever));
        let [x, y, z] = plain::sub(surface, of_sheet);
        let ([n_x, n_y, n_z], [l_x, l_y, l_z]) = (touch.normal, touch.lever);
        let inverse_mass = size.inverse_mass + 1.0 / mass;
        Self {
            geometry: F64x8([n_x, n_y, n_z, touch.overlap, l_x, l_y, l_z, size.radius]),
            motion: F64x8([x, y, z, inverse_mass, s_x, s_y, s_z, 0.0]),
            grain: touch.grain,
            triangle: touch.triangle,
        }
    }
}

/// What eight contacts do.
pub(super) struct Acting {
    /// Force and torque on each grain, a spare number beside each.
    pub(super) pushes: [F64x8; 8],
    /// The spring after the step, f_n, |f_t| and the overlap.
    after: [F64x8; 8],
}

impl Acting {
    /// The contacts as the next step finds them.
    pub(super) fn held(&self, pending: &[Pending]) -> impl Iterator<Item = Held> {
        pending.iter().zip(&self.after).map(|(pending, after)| {
            let [x, y, z, normal_force, tangential_force, overlap, ..] = after.0;
            Held {
                grain: pending.grain,
                triangle: pending.triangle,
                spring: [x, y, z],
                normal_force,
                tangential_force,
                overlap,
            }
        })
    }
}

/// The forces of up to eight contacts, which push the grains.
#[inline(always)]
pub(super) fn forces<W: Lane<Row = F64x8, Scalar = f64>>(
    material: &Material,
    constants: &<Mindlin as TangentialLaw>::Constants<W>,
    time_step: f64,
    eight: &[Pending],
) -> Acting {
    let last = eight.len() - 1;
    let (mut geometry, mut motion) = ([W::constant(0.0); 8], [W::constant(0.0); 8]);
    for e in 0..W::K {
        let pending = &eight[e.min(last)];
        geometry[e] = W::load(&pending.geometry);
        motion[e] = W::load(&pending.motion);
    }
    let [n_x, n_y, n_z, overlap, l_x, l_y, l_z, radius] = W::transposed(geometry);
    let [v_x, v_y, v_z, inverse_mass, s_x, s_y, s_z, _] = W::transposed(motion);
    let vector = |x, y, z| Vec3 { x, y, z };
    let (normal, lever) = (vector(n_x, n_y, n_z), vector(l_x, l_y, l_z));
    let relative = vector(v_x, v_y, v_z);
    let root_overlap = (radius * overlap).sqrt();
    let overlap_rate = -relative.dot(normal);
    let normal_force = hertz::normal_force(
        W::constant(material.normal_stiffness),
        W::constant(material.normal_damping),
        overlap,
        root_overlap,
        overlap_rate,
    );
    let contact = Contact {
        normal,
        sliding_velocity: normal.scale_add(overlap_rate, relative),
        root_overlap,
        reduced_mass: W::constant(1.0) / inverse_mass,
        normal_force,
        time_step: W::constant(time_step),
        dither: W::constant(0.0),
    };
    let mut history = [s_x, s_y, s_z];
    let tangential = Mindlin::force(constants, &contact, &mut history, &mut ());
    let force = normal.scale_add(normal_force, tangential);
    let torque = lever.cross(force);
    let size = tangential.dot(tangential).sqrt();
    let zero = W::constant(0.0);
    let [x, y, z] = history;
    let pushes = W::transposed([
        force.x, force.y, force.z, zero, torque.x, torque.y, torque.z, zero,
    ]);
    let after = W::transposed([x, y, z, normal_force, size, overlap, zero, zero]);
    let mut acting = Acting {
        pushes: [F64x8::default(); 8],
        after: [F64x8::default(); 8],
    };
    for e in 0..W::K {
        pushes[e].store(&mut acting.pushes[e]);
        after[e].store(&mut acting.after[e]);
    }
    acting
}
