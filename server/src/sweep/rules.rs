//! Rules between parameters, checked at every combination of the values that they are about.

use std::collections::HashSet;

use granary_core::parameter::Rule;
use serde_json::{Map, Value};

use super::Axis;
use super::mistakes::{Mistakes, pointer};
use super::section::Sections;
use super::study::Setting;

/// Adds every rule that a point of the grids breaks, in any of the settings that a study compares; values that are
/// wrong by themselves are told first, and alone.
pub(crate) fn check(
    written: Option<&Value>,
    grids: &[Vec<Axis>],
    sections: &Sections,
    settings: Option<&[Setting]>,
    mistakes: &mut Mistakes,
) {
    if !mistakes.is_empty() {
        return;
    }
    let settings = settings.map_or(vec![None], |all| all.iter().map(Some).collect());
    let mut told = HashSet::new();
    for setting in settings {
        for (k, grid) in grids.iter().enumerate() {
            let grid = Grid {
                number: k,
                axes: grid,
                written: written.and_then(|grids| grids.get(k)),
                sections,
                setting,
            };
            for rule in sections.model.rules() {
                grid.check(rule, &mut |place, detail| {
                    if told.insert((place.clone(), detail.clone())) {
                        mistakes.add(&place, detail);
                    }
                    !mistakes.is_full()
                });
            }
        }
    }
}

/// One grid of a spec.
struct Grid<'a> {
    number: usize,
    axes: &'a [Axis],
    /// As it stands in the spec.
    written: Option<&'a Value>,
    sections: &'a Sections,
    setting: Option<&'a Setting>,
}

/// An axis and the place of its value at hand.
type Chosen<'a> = (&'a Axis, usize);

impl Grid<'_> {
    /// Tells `tell` the place and the detail of every combination that breaks `rule`, until it has heard enough.
    fn check(&self, rule: &Rule, tell: &mut dyn FnMut(String, String) -> bool) {
        let about = |name: &str| rule.parameters.contains(&name);
        let axes: Vec<&Axis> = self.axes.iter().filter(|axis| about(axis.name)).collect();
        let fixed = self.sections.fixed.iter().filter(|(name, _)| about(name));
        let mut point: Map<String, Value> = fixed
            .map(|(name, value)| (name.clone(), value.clone()))
            .collect();
        let changed = self
            .setting
            .iter()
            .flat_map(|setting| &setting.studied.values);
        for (name, value) in changed.filter(|(name, _)| about(name)) {
            point[name] = value.clone();
        }
        let combinations: usize = axes.iter().map(|axis| axis.values.len()).product();
        for number in 0..combinations {
            let mut rest = number;
            let mut chosen: Vec<Chosen<'_>> = Vec::with_capacity(axes.len());
            for axis in axes.iter().rev() {
                let index = rest % axis.values.len();
                rest /= axis.values.len();
                chosen.push((axis, index));
                point[axis.name] = axis.values[index].clone();
            }
            if let Some(detail) = (rule.broken)(&point)
                && !tell(self.place(rule, &chosen), detail)
            {
                return;
            }
        }
    }

    /// Where the spec names the first of the rule's parameters that it names at all.
    fn place(&self, rule: &Rule, chosen: &[Chosen<'_>]) -> String {
        let of_axis = |name: &str| {
            let (axis, index) = chosen.iter().find(|(axis, _)| axis.name == name)?;
            let at = pointer("/grid", &self.number.to_string());
            let at = pointer(&at, axis.name);
            // A value of a list has a place of its own, one of a linspace has the axis'.
            let listed = self.written.is_some_and(|grid| grid[axis.name].is_array());
            Some(if listed {
                pointer(&at, &index.to_string())
            } else {
                at
            })
        };
        let in_section = |name: &str| {
            let section = self.sections.written.get(name)?;
            Some(pointer(&pointer("", section), name))
        };
        let in_setting = |name: &str| {
            let setting = self.setting.filter(|setting| setting.names(name))?;
            Some(setting.place.clone())
        };
        let mut places = rule.parameters.iter();
        places
            .find_map(|name| {
                in_setting(name)
                    .or_else(|| of_axis(name))
                    .or_else(|| in_section(name))
            })
            .unwrap_or_default()
    }
}
