//! The parameter table: what an experiment may be told, in one place.
//!
//! A table feeds validation, defaults, the JSON Schema of `/models`, the form and the docs.

use serde::Serialize;
use serde_json::{Map, Value, json};

use crate::identity::canonical_number;

mod row;

/// The section of a sweep in which a parameter may be fixed; axes name every parameter flat.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Section {
    /// `[fixed]`: the physics.
    Fixed,
    /// `[numerics]`: how the experiment itself is integrated.
    Numerics,
    /// `[preparation]`: how packs are made.
    Preparation,
}

impl Section {
    /// The name of the section in a spec.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Fixed => "fixed",
            Self::Numerics => "numerics",
            Self::Preparation => "preparation",
        }
    }
}

/// One end of a range of real numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Bound {
    /// The end belongs to the range.
    Closed(f64),
    /// The end does not belong to the range.
    Open(f64),
}

/// The values that a parameter may take.
#[derive(Clone, Copy, Debug)]
pub enum Domain {
    /// Real numbers between two bounds; never NaN or infinite.
    Real(Bound, Bound),
    /// Whole numbers from the first to the second, both included.
    Integer(i64, i64),
    /// One of a few words.
    Choice(&'static [&'static str]),
    /// `true` or `false`.
    Flag,
    /// Something with a notation of its own, read by an experiment's function into its canonical form.
    Notation(fn(&Value) -> Result<Value, String>),
}

/// What a parameter is when nobody says.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DefaultValue {
    /// A real number.
    Real(f64),
    /// A whole number.
    Integer(i64),
    /// A word.
    Text(&'static str),
    /// A truth value.
    Flag(bool),
    /// Computed from the other parameters; the sentence says how.
    Derived,
}

/// One row of the table.
#[derive(Clone, Copy, Debug)]
pub struct Parameter {
    /// The name in specs, axes and results.
    pub name: &'static str,
    /// The symbol in the paper and on the page.
    pub symbol: &'static str,
    /// The unit, empty for pure numbers.
    pub unit: &'static str,
    /// Where it may be fixed.
    pub section: Section,
    /// The values it may take.
    pub domain: Domain,
    /// Its value under the preset `standard`.
    pub default: DefaultValue,
    /// What it is, in one sentence.
    pub sentence: &'static str,
}

/// A rule between parameters that are each allowed.
#[derive(Clone, Copy, Debug)]
pub struct Rule {
    /// Those that it is about; the first is the one to change.
    pub parameters: &'static [&'static str],
    /// What is wrong with a point that breaks it, all its parameters given; `None` if it is kept.
    pub broken: fn(&Map<String, Value>) -> Option<String>,
}

/// A named choice of parameters; what the spec writes wins over it.
#[derive(Clone, Copy, Debug)]
pub struct Preset {
    /// The name in specs.
    pub name: &'static str,
    /// The parameters that it sets, all others keep their default.
    pub values: &'static [(&'static str, DefaultValue)],
    /// What it is for, in one sentence.
    pub sentence: &'static str,
}

/// Numerical settings of an experiment from which its planner may choose.
#[derive(Clone, Copy, Debug)]
pub struct Choices {
    /// The parameters that each of them sets.
    pub names: &'static [&'static str],
    /// Their values, setting by setting, the cheapest first.
    pub settings: &'static [&'static [DefaultValue]],
    /// The values of the reference that settings are held against, dearer than all of them.
    pub reference: &'static [DefaultValue],
}

impl Choices {
    /// One of the settings, or the reference, as a table.
    #[must_use]
    pub fn table(&self, values: &[DefaultValue]) -> Map<String, Value> {
        let pairs = self.names.iter().zip(values);
        pairs
            .map(|(name, value)| ((*name).to_owned(), value.value()))
            .collect()
    }
}

/// The defaults of `table` with those of the preset called `name` over them; `None` if there is no such preset.
pub(crate) fn defaults(
    table: &[Parameter],
    presets: &[Preset],
    name: &str,
) -> Option<Map<String, Value>> {
    let preset = presets.iter().find(|preset| preset.name == name)?;
    let rows = table.iter().map(|row| {
        let own = preset.values.iter().find(|(name, _)| *name == row.name);
        let default = own.map_or(row.default, |(_, value)| *value);
        (row.name.to_owned(), default.value())
    });
    Some(rows.collect())
}

impl DefaultValue {
    /// The value as JSON; `null` if it is derived.
    fn value(self) -> Value {
        match self {
            Self::Real(value) => json!(value),
            Self::Integer(value) => json!(value),
            Self::Text(value) => json!(value),
            Self::Flag(value) => json!(value),
            Self::Derived => Value::Null,
        }
    }
}

impl Parameter {
    /// The default as JSON; `null` if it is derived.
    #[must_use]
    pub fn default_value(&self) -> Value {
        self.default.value()
    }

    /// `value` in canonical form if it is allowed; otherwise the rule it breaks.
    pub fn check(&self, value: &Value) -> Result<Value, String> {
        if self.default == DefaultValue::Derived && value.is_null() {
            return Ok(Value::Null);
        }
        match self.domain {
            Domain::Real(low, high) => check_real(value, low, high),
            Domain::Integer(low, high) => check_integer(value, low, high),
            Domain::Choice(words) => check_choice(value, words),
            Domain::Flag => match value {
                Value::Bool(_) => Ok(value.clone()),
                _ => Err(format!("{} is not true or false", shown(value))),
            },
            Domain::Notation(read) => read(value),
        }
    }

    /// The row as a property of a JSON Schema, with our own `x-symbol`, `x-unit` and `x-section`.
    #[must_use]
    pub fn schema(&self) -> Value {
        let mut schema = match self.domain {
            Domain::Real(low, high) => {
                let mut schema = json!({"type": "number"});
                match low {
                    Bound::Closed(v) => schema["minimum"] = json!(v),
                    Bound::Open(v) => schema["exclusiveMinimum"] = json!(v),
                }
                match high {
                    Bound::Closed(v) => schema["maximum"] = json!(v),
                    Bound::Open(v) => schema["exclusiveMaximum"] = json!(v),
                }
                schema
            }
            Domain::Integer(low, high) => {
                json!({"type": "integer", "minimum": low, "maximum": high})
            }
            Domain::Choice(words) => json!({"type": "string", "enum": words}),
            Domain::Flag => json!({"type": "boolean"}),
            Domain::Notation(_) => json!({"type": ["string", "object"]}),
        };
        schema["default"] = self.default_value();
        schema["description"] = json!(self.sentence);
        schema["x-symbol"] = json!(self.symbol);
        schema["x-unit"] = json!(self.unit);
        schema["x-section"] = json!(self.section.name());
        schema
    }
}

/// One number that an experiment yields.
#[derive(Clone, Copy, Debug)]
pub struct Quantity {
    /// The name in results.
    pub name: &'static str,
    /// The symbol in the paper and on the page.
    pub symbol: &'static str,
    /// The unit, empty for pure numbers.
    pub unit: &'static str,
    /// What it is, in one sentence.
    pub sentence: &'static str,
}

impl Quantity {
    /// The row as a property of a JSON Schema, with our own `x-symbol` and `x-unit`.
    #[must_use]
    pub fn schema(&self) -> Value {
        json!({
            "type": ["number", "null"],
            "description": self.sentence,
            "x-symbol": self.symbol,
            "x-unit": self.unit,
        })
    }
}

fn check_real(value: &Value, low: Bound, high: Bound) -> Result<Value, String> {
    let Some(number) = value.as_f64().filter(|number| number.is_finite()) else {
        return Err(format!("{} is not a finite number", shown(value)));
    };
    let above = match low {
        Bound::Closed(bound) => number >= bound,
        Bound::Open(bound) => number > bound,
    };
    let below = match high {
        Bound::Closed(bound) => number <= bound,
        Bound::Open(bound) => number < bound,
    };
    if above && below {
        Ok(json!(canonical_number(number)))
    } else {
        Err(format!("{} is not in {}", shown(value), range(low, high)))
    }
}

fn check_integer(value: &Value, low: i64, high: i64) -> Result<Value, String> {
    // Axes made by `linspace` hold whole numbers as reals; both forms are the same number.
    let whole =
        |number: f64| (number.fract() == 0.0 && number.abs() < 9e15).then_some(number as i64);
    let Some(number) = value.as_i64().or_else(|| value.as_f64().and_then(whole)) else {
        return Err(format!("{} is not a whole number", shown(value)));
    };
    if (low..=high).contains(&number) {
        Ok(json!(number))
    } else {
        Err(format!(
            "{number} is not in {} … {}",
            grouped(low),
            grouped(high)
        ))
    }
}

fn check_choice(value: &Value, words: &[&str]) -> Result<Value, String> {
    match value.as_str() {
        Some(word) if words.contains(&word) => Ok(value.clone()),
        _ => Err(format!(
            "{} is not one of {}",
            shown(value),
            words.join(", ")
        )),
    }
}

/// A range as mathematicians write it: `(0, 0.3]`.
fn range(low: Bound, high: Bound) -> String {
    let left = match low {
        Bound::Closed(v) => format!("[{v}"),
        Bound::Open(v) => format!("({v}"),
    };
    let right = match high {
        Bound::Closed(v) => format!("{v}]"),
        Bound::Open(v) => format!("{v})"),
    };
    format!("{left}, {right}")
}

/// A whole number with a comma between thousands.
fn grouped(number: i64) -> String {
    let digits = number.unsigned_abs().to_string();
    let mut text = String::new();
    for (place, digit) in digits.chars().enumerate() {
        if place > 0 && (digits.len() - place).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    if number < 0 { format!("-{text}") } else { text }
}

/// `value` as JSON, cut to 80 characters so that an error never repeats a huge body.
#[must_use]
pub fn shown(value: &Value) -> String {
    let text = value.to_string();
    if text.chars().count() > 80 {
        text.chars().take(79).chain(['…']).collect()
    } else {
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const AMPLITUDE: Parameter = Parameter {
        name: "delta0",
        symbol: "δ0",
        unit: "",
        section: Section::Fixed,
        domain: Domain::Real(Bound::Open(0.0), Bound::Closed(0.3)),
        default: DefaultValue::Real(0.05),
        sentence: "",
    };

    #[test]
    fn open_and_closed_ends_are_kept_apart() {
        assert!(AMPLITUDE.check(&json!(0.0)).is_err());
        assert!(AMPLITUDE.check(&json!(0.3)).is_ok());
        assert_eq!(
            AMPLITUDE.check(&json!(0.31)),
            Err("0.31 is not in (0, 0.3]".to_owned())
        );
    }

    #[test]
    fn whole_reals_are_integers_and_others_are_not() {
        let count = Parameter {
            domain: Domain::Integer(1, 10_000_000),
            ..AMPLITUDE
        };
        assert_eq!(count.check(&json!(1024.0)), Ok(json!(1024)));
        assert_eq!(
            count.check(&json!(0)),
            Err("0 is not in 1 … 10,000,000".to_owned())
        );
        assert!(count.check(&json!(1.5)).is_err());
        assert!(count.check(&json!("12")).is_err());
    }

    #[test]
    fn long_values_are_cut_in_messages() {
        let text = "x".repeat(10_000);
        assert!(
            AMPLITUDE
                .check(&json!(text))
                .expect_err("not a number")
                .len()
                < 200
        );
    }
}
