//! Rows of the tables, in the order in which they read best.

use super::{Bound, DefaultValue, Domain, Parameter, Quantity, Section};

impl Parameter {
    /// A real number between two bounds.
    pub(crate) const fn real(
        section: Section,
        (name, symbol, unit): (&'static str, &'static str, &'static str),
        (low, high): (Bound, Bound),
        default: f64,
        sentence: &'static str,
    ) -> Self {
        Self {
            name,
            symbol,
            unit,
            section,
            domain: Domain::Real(low, high),
            default: DefaultValue::Real(default),
            sentence,
        }
    }

    /// A real number between two bounds that is computed from other parameters where nobody says.
    pub(crate) const fn derived(
        section: Section,
        names: (&'static str, &'static str, &'static str),
        bounds: (Bound, Bound),
        sentence: &'static str,
    ) -> Self {
        Self {
            default: DefaultValue::Derived,
            ..Self::real(section, names, bounds, 0.0, sentence)
        }
    }

    /// A whole number without a unit.
    pub(crate) const fn integer(
        section: Section,
        (name, symbol): (&'static str, &'static str),
        (low, high): (i64, i64),
        default: i64,
        sentence: &'static str,
    ) -> Self {
        Self {
            name,
            symbol,
            unit: "",
            section,
            domain: Domain::Integer(low, high),
            default: DefaultValue::Integer(default),
            sentence,
        }
    }

    /// One of a few words.
    pub(crate) const fn choice(
        section: Section,
        (name, symbol): (&'static str, &'static str),
        words: &'static [&'static str],
        default: &'static str,
        sentence: &'static str,
    ) -> Self {
        Self {
            name,
            symbol,
            unit: "",
            section,
            domain: Domain::Choice(words),
            default: DefaultValue::Text(default),
            sentence,
        }
    }

    /// `true` or `false`.
    pub(crate) const fn flag(
        section: Section,
        (name, symbol): (&'static str, &'static str),
        default: bool,
        sentence: &'static str,
    ) -> Self {
        Self {
            name,
            symbol,
            unit: "",
            section,
            domain: Domain::Flag,
            default: DefaultValue::Flag(default),
            sentence,
        }
    }
}

impl Quantity {
    /// A row of a result table.
    pub(crate) const fn new(
        name: &'static str,
        (symbol, unit): (&'static str, &'static str),
        sentence: &'static str,
    ) -> Self {
        Self {
            name,
            symbol,
            unit,
            sentence,
        }
    }
}
