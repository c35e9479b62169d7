//! Models: the two experiments as planner, tables and documents see them, so that none of these knows either.

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

use crate::beam;
use crate::beam::point::BeamPoint;
use crate::identity::StageId;
use crate::memory;
use crate::memory::spec::{MemoryPoint, RecallSpec};
use crate::memory::waveform::Waveform;
use crate::parameter::{Choices, Parameter, Preset, Quantity, Rule};
use crate::stage::{StageKind, StageSpec};
use crate::study::Judged;

/// An experiment.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Model {
    /// Gain and fidelity of a waveform stored in a pack.
    Memory,
    /// Stiffness and strength of a bent beam.
    Beam,
}

impl Model {
    /// Every model.
    pub const ALL: [Self; 2] = [Self::Memory, Self::Beam];

    /// The name in specs.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Memory => "memory",
            Self::Beam => "beam",
        }
    }

    /// The model called `name`.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|model| model.name() == name)
    }

    /// The model that stages of this kind belong to.
    #[must_use]
    pub fn of(kind: StageKind) -> Self {
        match kind {
            StageKind::Pack
            | StageKind::Train
            | StageKind::Encode
            | StageKind::Recall
            | StageKind::Classifier => Self::Memory,
            StageKind::Grow | StageKind::Jam | StageKind::Bend => Self::Beam,
        }
    }

    /// What it is, in one sentence.
    #[must_use]
    pub fn sentence(self) -> &'static str {
        match self {
            Self::Memory => {
                "A waveform of shear is stored in a pack of grains while it is compressed, and recalled when it is released."
            }
            Self::Beam => {
                "A beam of grains, jammed by the pressure on the membrane around them, is bent until it yields."
            }
        }
    }

    /// Every parameter.
    #[must_use]
    pub fn parameters(self) -> &'static [Parameter] {
        match self {
            Self::Memory => memory::parameters::PARAMETERS,
            Self::Beam => beam::parameters::PARAMETERS,
        }
    }

    /// The parameter called `name`.
    #[must_use]
    pub fn parameter(self, name: &str) -> Option<&'static Parameter> {
        self.parameters().iter().find(|row| row.name == name)
    }

    /// Named choices of parameters.
    #[must_use]
    pub fn presets(self) -> &'static [Preset] {
        match self {
            Self::Memory => memory::parameters::PRESETS,
            Self::Beam => beam::parameters::PRESETS,
        }
    }

    /// Pairs of parameters that say one thing: who writes the first takes back what a preset says of the second.
    #[must_use]
    pub fn taken_back(self) -> &'static [(&'static str, &'static str)] {
        match self {
            Self::Memory => &[],
            Self::Beam => beam::parameters::TAKEN_BACK,
        }
    }

    /// Rules between parameters.
    #[must_use]
    pub fn rules(self) -> &'static [Rule] {
        match self {
            Self::Memory => memory::parameters::RULES,
            Self::Beam => beam::rules::RULES,
        }
    }

    /// Every number of its tables.
    #[must_use]
    pub fn results(self) -> &'static [Quantity] {
        match self {
            Self::Memory => memory::results::RESULTS,
            Self::Beam => beam::results::RESULTS,
        }
    }

    /// The numerical settings from which the planner may choose.
    #[must_use]
    pub fn choices(self) -> &'static Choices {
        match self {
            Self::Memory => &memory::parameters::CHOICES,
            Self::Beam => &beam::parameters::CHOICES,
        }
    }

    /// The results of a set by which studies judge settings.
    #[must_use]
    pub fn judged(self) -> &'static [Judged] {
        match self {
            Self::Memory => memory::results::JUDGED,
            Self::Beam => beam::results::JUDGED,
        }
    }

    /// Results of a point that may be `null` with a word why, as `{name}_reason`.
    #[must_use]
    pub fn reasoned(self) -> &'static [&'static str] {
        match self {
            Self::Memory => &[],
            Self::Beam => beam::results::REASONED,
        }
    }

    /// The table's defaults with those of `preset` over them; `None` if there is no such preset.
    #[must_use]
    pub fn defaults(self, preset: &str) -> Option<Map<String, Value>> {
        match self {
            Self::Memory => MemoryPoint::defaults(preset),
            Self::Beam => BeamPoint::defaults(preset),
        }
    }

    /// Parameters that only the last stage of a point sees, and that points side by side in one ensemble may differ in.
    #[must_use]
    pub fn leaves(self) -> &'static [&'static str] {
        match self {
            Self::Memory => &["waveform", "gamma0"],
            Self::Beam => &[],
        }
    }

    /// A point from all its parameters, each already checked against the table.
    ///
    /// # Errors
    /// If a parameter is missing, unknown or of the wrong type, in serde's words.
    pub fn point(self, parameters: Map<String, Value>) -> Result<ModelPoint, String> {
        match self {
            Self::Memory => MemoryPoint::from_parameters(parameters).map(ModelPoint::Memory),
            Self::Beam => BeamPoint::from_parameters(parameters).map(ModelPoint::Beam),
        }
    }
}

/// All parameters of one point of any model.
#[derive(Clone, Debug, PartialEq)]
pub enum ModelPoint {
    /// See [`MemoryPoint`].
    Memory(MemoryPoint),
    /// See [`BeamPoint`].
    Beam(BeamPoint),
}

impl ModelPoint {
    /// The stages of this point, in the order in which they must run.
    #[must_use]
    pub fn stages(&self) -> Vec<StageSpec> {
        let mut stages = match self {
            Self::Memory(point) => {
                let pack = StageSpec::Pack(point.pack());
                let train = StageSpec::Train(point.train(pack.id()));
                vec![pack, train]
            }
            Self::Beam(point) => {
                let grow = StageSpec::Grow(point.grow());
                let jam = StageSpec::Jam(point.jam(grow.id()));
                vec![grow, jam]
            }
        };
        let (beginning, last) = self.ends(stages[1].id());
        stages.extend(beginning);
        stages.push(last);
        stages
    }

    /// The last stage of this point, after the stage named `before`, and, between the two, what it shares with other points.
    #[must_use]
    pub fn ends(&self, before: StageId) -> (Option<StageSpec>, StageSpec) {
        match self {
            Self::Memory(point) => {
                let beginning = point.encode(before).map(StageSpec::Encode);
                let recall = RecallSpec {
                    encode: beginning.as_ref().map(StageSpec::id),
                    ..point.recall(before)
                };
                (beginning, StageSpec::Recall(recall))
            }
            Self::Beam(point) => (None, StageSpec::Bend(point.bend(before))),
        }
    }

    /// This point without what its leaves say: its last stage is the one that the ensemble is named after.
    #[must_use]
    pub fn bare(&self) -> Self {
        match self {
            Self::Memory(point) => Self::Memory(MemoryPoint {
                waveform: Waveform::Zero,
                ..point.clone()
            }),
            Self::Beam(_) => self.clone(),
        }
    }

    /// Sets the leaf called `name` to a value that was checked against the table; other names change nothing.
    pub fn set_leaf(&mut self, name: &str, value: &Value) {
        let checked = "checked against the table";
        match (self, name) {
            (Self::Memory(point), "gamma0") => point.gamma0 = value.as_f64().expect(checked),
            (Self::Memory(point), "waveform") => {
                point.waveform = Waveform::parse(value).expect(checked);
            }
            _ => {}
        }
    }

    /// What is allowed but unwise, in full sentences.
    #[must_use]
    pub fn warnings(&self) -> Vec<String> {
        match self {
            Self::Memory(point) => point.warnings(),
            Self::Beam(point) => point.warnings(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn standard(model: Model) -> ModelPoint {
        let map = model.defaults("standard").expect("every model has it");
        model.point(map).expect("valid defaults")
    }

    #[test]
    fn each_stage_needs_the_one_before_it() {
        for model in Model::ALL {
            let stages = standard(model).stages();
            assert_eq!(stages[0].needs(), None);
            for pair in stages.windows(2) {
                assert_eq!(pair[1].needs(), Some(pair[0].id()));
                assert!(pair[1].kind() > pair[0].kind());
            }
        }
    }

    #[test]
    fn bare_point_names_the_ensemble_of_all_its_leaves() {
        for model in Model::ALL {
            let point = standard(model);
            let ensemble = point.bare().stages()[2].id();
            assert_eq!(point.stages()[2].ensemble_key(), ensemble);
        }
    }

    #[test]
    fn work_is_known_before_it_is_done() {
        for model in Model::ALL {
            let stages = standard(model).stages();
            for (k, stage) in stages.iter().enumerate() {
                let work = stage.work(&stages[..k]);
                assert!(work.steps > 10_000 && work.grain_steps > work.steps);
                assert!((1 << 20..300 << 20).contains(&work.bytes), "{work:?}");
            }
        }
    }

    #[test]
    fn what_would_take_too_much_memory_has_fewer_replicas() {
        let lanes = |grains: u32, force_law: &str, precision: &str| {
            let mut map = Model::Memory.defaults("standard").expect("a preset");
            map.insert("grains".to_owned(), grains.into());
            map.insert("force_law".to_owned(), force_law.into());
            map.insert("precision".to_owned(), precision.into());
            let stages = Model::Memory.point(map).expect("a point").stages();
            let (last, before) = stages.split_last().expect("three stages");
            assert!(
                last.work(before).bytes <= 10 << 30,
                "{force_law} {precision}"
            );
            (last.lanes(before), last.max_lanes())
        };
        assert_eq!(lanes(10_240, "H", "f32"), (16, 16));
        assert_eq!(lanes(1024, "M2", "f32"), (16, 16));
        assert_eq!(lanes(10_240, "M2", "f32"), (8, 16));
        assert_eq!(lanes(10_240, "M2", "f64"), (8, 8));
        assert_eq!(lanes(20_480, "M2", "f64"), (1, 8));
    }

    #[test]
    fn choices_are_allowed_and_rise_in_cost_to_the_reference() {
        for model in Model::ALL {
            let choices = model.choices();
            let all = choices.settings.iter().chain([&choices.reference]);
            let mut before = 0;
            for values in all {
                assert_eq!(values.len(), choices.names.len());
                let mut map = model.defaults("standard").expect("every model has it");
                for (name, value) in choices.table(values) {
                    let row = model.parameter(&name).expect("a parameter");
                    map.insert(name, row.check(&value).expect("allowed"));
                }
                let stages = model.point(map).expect("a point").stages();
                let steps = stages[2].work(&stages[..2]).steps;
                assert!(steps >= before, "{values:?}: {steps} after {before}");
                before = steps;
            }
        }
    }

    #[test]
    fn rules_leaves_and_pairs_name_parameters_and_studies_name_results() {
        for model in Model::ALL {
            for judged in model.judged() {
                let known = model.results().iter().any(|row| row.name == judged.name);
                assert!(known, "{}", judged.name);
            }
            let named = |name: &str| assert!(model.parameter(name).is_some(), "{name}");
            model.leaves().iter().for_each(|name| named(name));
            for rule in model.rules() {
                rule.parameters.iter().for_each(|name| named(name));
            }
        }
    }
}
