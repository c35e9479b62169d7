//! The figures and tables of the two papers, each as a sweep of its own that anyone can submit, and change one number of.
//!
//! H. Götz, T. Pöschel and O. D'Angelo, Phys. Rev. Research 6, 013061 (2024); E. Dwight and D. Candela, arXiv:2603.14595.

use granary_core::model::Model;
use serde_json::Value;

/// A figure or table.
#[derive(Clone, Copy, Debug)]
pub struct Figure {
    /// What commands and paths call it.
    pub name: &'static str,
    /// The experiment.
    pub model: Model,
    /// What it shows, in a few words.
    pub shows: &'static str,
    template: &'static str,
}

/// The preset of the specs as they are stored, their one packing, and how large packs are and words long.
const PRESET: &str = "preset = \"draft\"";
const PACKING: &str = "packing_seed = 1\n";
const SMALL: &str = "grains = 1024\n";
const FEW_WORDS: &str = "    { suite = \"binary_words\", bits = 5 },\n";
const SMALL_LADDER: &str = "grains = [103, 325, 1024]\n";

/// Packs as large as the paper's, and longer words.
const LARGE: &str = "grains = 10240\n";
const MORE_WORDS: &str =
    "    { suite = \"binary_words\", bits = 6 },\n    { suite = \"binary_words\", bits = 7 },\n";
const LARGE_LADDER: &str = "grains = [325, 1024, 3267, 10240]\n";

impl Figure {
    /// The spec as TOML, with another preset and so many packings; but for `draft`, packs are as large as the paper's.
    #[must_use]
    pub fn spec(&self, preset: &str, packings: u64) -> String {
        let mut text = self
            .template
            .replace(PRESET, &format!("preset = \"{preset}\""));
        if self.model == Model::Memory && preset != "draft" {
            text = text
                .replace(SMALL, LARGE)
                .replace(SMALL_LADDER, LARGE_LADDER);
            text = text.replace(FEW_WORDS, &[FEW_WORDS, MORE_WORDS].concat());
        }
        match packings {
            1 => text,
            _ => text.replace(
                PACKING,
                &format!("packing_seed = {{ range = [1, {packings}] }}\n"),
            ),
        }
    }

    /// The spec as `POST /sweeps` takes it.
    ///
    /// # Panics
    /// Never: every template is TOML, and a test reads them all.
    #[must_use]
    pub fn json(&self, preset: &str, packings: u64) -> Value {
        toml::from_str(&self.spec(preset, packings)).expect("a template is TOML")
    }

    /// The figure called `name`.
    #[must_use]
    pub fn named(name: &str) -> Option<&'static Self> {
        FIGURES.iter().find(|figure| figure.name == name)
    }

    /// Whether its model has a preset of this name.
    #[must_use]
    pub fn has_preset(&self, preset: &str) -> bool {
        self.model
            .presets()
            .iter()
            .any(|known| known.name == preset)
    }
}

macro_rules! figure {
    ($model:ident, $name:literal, $shows:literal) => {
        Figure {
            name: $name,
            model: Model::$model,
            shows: $shows,
            template: include_str!(concat!("../../examples/figures/", $name, ".toml")),
        }
    };
}

/// All, in the order of the papers, the beam's first; what is left out are sketches and single contacts.
pub const FIGURES: &[Figure] = &[
    figure!(Beam, "fig3", "z over φ_init and over Δp, for five μ_init"),
    figure!(Beam, "fig4", "g(r) for several φ_init and Δp"),
    figure!(
        Beam,
        "fig5",
        "σ over ε, and of a beam bent to ε = 0.002 and back"
    ),
    figure!(Beam, "fig6", "E_b and Y_b over μ_p and E_p, protocol A"),
    figure!(Beam, "fig7", "E_b and Y_b over μ_p and E_p, protocol B"),
    figure!(
        Beam,
        "fig8",
        "E_b and Y_b over μ_p, both protocols, with the fits of Eq. (4)"
    ),
    figure!(
        Beam,
        "fig9",
        "⟨F⟩, ⟨F_n⟩, ⟨F_t⟩ and the Coulomb fraction over σ"
    ),
    figure!(
        Beam,
        "fig10",
        "displacement relative to the middle, early and late"
    ),
    figure!(Beam, "fig11", "D_min in the beam, early and late"),
    figure!(Beam, "fig12", "autocorrelation of D_min by stress"),
    figure!(Beam, "fig13", "D_min over Δφ of single grains"),
    figure!(Beam, "fig14", "D_min over height by stress"),
    figure!(
        Beam,
        "fig15",
        "D_min over height at 175–200 kPa, for four μ_p"
    ),
    figure!(Beam, "fig16", "⟨D_min⟩ and φ over σ, both protocols"),
    figure!(
        Beam,
        "table1",
        "the fits of Eq. (4) to Y_b(μ_p), beside the published ones"
    ),
    figure!(
        Memory,
        "memory-4",
        "φ, Z and pressures while signal 5 is stored, kept and recalled"
    ),
    figure!(
        Memory,
        "memory-6",
        "the six recalled signals over what was stored"
    ),
    figure!(
        Memory,
        "memory-8",
        "𝓕 over friction, beside the published packs"
    ),
    figure!(
        Memory,
        "memory-9",
        "the six recalled signals under laws H, M1 and M2"
    ),
    figure!(Memory, "memory-11", "𝓕 over δ0, for three γ0"),
    figure!(
        Memory,
        "memory-11-inset",
        "𝓕 over the shape of grains, beside the published packs"
    ),
    figure!(Memory, "memory-12a", "𝒢 over δ0, for three γ0"),
    figure!(Memory, "memory-12b", "𝒢 over N, beside the published packs"),
    figure!(
        Memory,
        "memory-13",
        "recalled words of three bits and of ten over what was stored"
    ),
    figure!(
        Memory,
        "memory-14",
        "𝓕 by three processings, and recognition, over the number of words"
    ),
];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sweep::{Limits, Plan};

    #[test]
    fn spec_of_every_figure_is_valid_in_every_preset_and_packings_multiply_its_points() {
        for figure in FIGURES {
            for preset in figure.model.presets() {
                let points = [1, 3].map(|packings| {
                    let plan = Plan::read(&figure.json(preset.name, packings), Limits::default());
                    let plan =
                        plan.unwrap_or_else(|mistakes| panic!("{}: {mistakes:?}", figure.name));
                    assert_eq!(
                        (plan.preset.as_str(), plan.model),
                        (preset.name, figure.model)
                    );
                    plan.points
                });
                assert_eq!(points[1], 3 * points[0], "{}", figure.name);
            }
        }
    }

    #[test]
    fn packs_of_the_memory_paper_are_large_but_for_drafts() {
        for figure in FIGURES
            .iter()
            .filter(|figure| figure.model == Model::Memory)
        {
            let (draft, paper) = (figure.spec("draft", 1), figure.spec("paper", 1));
            assert!(
                !draft.contains("10240") && paper.contains("10240"),
                "{}",
                figure.name
            );
        }
    }
}
