//! The figures and tables of the beam paper, each as a sweep of its own.
//!
//! H. Götz, T. Pöschel and O. D'Angelo, Phys. Rev. Research 6, 013061 (2024).

use super::data::Data;
use super::drawing::Drawing;
use super::{beams, curves, grains, inside};

/// What a figure is drawn from, beyond the rows of its sweep.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Needs {
    /// Nothing.
    Results,
    /// The records of its bendings, and the inside of its beams where that was analyzed.
    Records,
    /// These, and the snapshots of single grains.
    Grains,
}

/// How a figure comes to paper.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Shown {
    /// As a picture and files of its numbers.
    Picture(fn(&Data) -> Drawing),
    /// As a table of its sets beside the published one.
    Table,
}

/// A figure or table.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Figure {
    /// What the command line calls it.
    pub(crate) name: &'static str,
    /// What it shows, in a few words.
    pub(crate) shows: &'static str,
    pub(crate) needs: Needs,
    pub(crate) shown: Shown,
    template: &'static str,
}

/// The preset of the specs as they are stored, and their one packing.
const PRESET: &str = "preset = \"draft\"";
const PACKING: &str = "packing_seed = 1\n";

impl Figure {
    /// The spec, with another preset and so many packings.
    pub(crate) fn spec(&self, preset: &str, packings: u64) -> String {
        let text = self
            .template
            .replace(PRESET, &format!("preset = \"{preset}\""));
        match packings {
            1 => text,
            _ => text.replace(
                PACKING,
                &format!("packing_seed = {{ range = [1, {packings}] }}\n"),
            ),
        }
    }

    /// The figure called `name`.
    pub(crate) fn named(name: &str) -> Option<&'static Self> {
        ALL.iter().find(|figure| figure.name == name)
    }
}

macro_rules! figure {
    ($name:literal, $shows:literal, $needs:ident, $shown:expr) => {
        Figure {
            name: $name,
            shows: $shows,
            needs: Needs::$needs,
            shown: $shown,
            template: include_str!(concat!("../../../examples/figures/", $name, ".toml")),
        }
    };
}

use Shown::{Picture, Table};

/// All, in the order of the paper; Figures 1, 2 and 17 are sketches.
pub(crate) const ALL: &[Figure] = &[
    figure!(
        "fig3",
        "z over φ_init and over Δp, for five μ_init",
        Results,
        Picture(beams::coordination)
    ),
    figure!(
        "fig4",
        "g(r) for several φ_init and Δp",
        Records,
        Picture(inside::pair_correlation)
    ),
    figure!(
        "fig5",
        "σ over ε, and of a beam bent to ε = 0.002 and back",
        Records,
        Picture(curves::stress_strain)
    ),
    figure!(
        "fig6",
        "E_b and Y_b over μ_p and E_p, protocol A",
        Results,
        Picture(beams::maps)
    ),
    figure!(
        "fig7",
        "E_b and Y_b over μ_p and E_p, protocol B",
        Results,
        Picture(beams::maps)
    ),
    figure!(
        "fig8",
        "E_b and Y_b over μ_p, both protocols, with the fits of Eq. (4)",
        Results,
        Picture(beams::over_friction)
    ),
    figure!(
        "fig9",
        "⟨F⟩, ⟨F_n⟩, ⟨F_t⟩ and the Coulomb fraction over σ",
        Records,
        Picture(curves::forces)
    ),
    figure!(
        "fig10",
        "displacement relative to the middle, early and late",
        Records,
        Picture(inside::displacement)
    ),
    figure!(
        "fig11",
        "D_min in the beam, early and late",
        Grains,
        Picture(grains::non_affine)
    ),
    figure!(
        "fig12",
        "autocorrelation of D_min by stress",
        Records,
        Picture(inside::autocorrelation)
    ),
    figure!(
        "fig13",
        "D_min over Δφ of single grains",
        Grains,
        Picture(grains::non_affine_over_change)
    ),
    figure!(
        "fig14",
        "D_min over height by stress",
        Records,
        Picture(inside::height)
    ),
    figure!(
        "fig15",
        "D_min over height at 175–200 kPa, for four μ_p",
        Records,
        Picture(inside::height_and_friction)
    ),
    figure!(
        "fig16",
        "⟨D_min⟩ and φ over σ, both protocols",
        Records,
        Picture(inside::over_stress_of_all)
    ),
    figure!(
        "table1",
        "the fits of Eq. (4) to Y_b(μ_p), beside the published ones",
        Results,
        Table
    ),
];
