//! What a reader asks of a table: filters, order, columns, page; pure.
//!
//! `where=friction_coefficient>=0.3` (repeated: and), `sort=-gain`, `columns=gain,fidelity`, `cursor`, `limit`.

use std::cmp::Ordering;

use serde_json::Value;

/// The most rows of one page.
pub const MOST_ROWS: u32 = 10_000;
/// Rows of a page if nobody says.
const USUAL_ROWS: u32 = 100;
/// The most filters of one request.
const MOST_FILTERS: usize = 20;

/// How a column is compared with a value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Comparison {
    /// `=`
    Equal,
    /// `!=`
    Unequal,
    /// `<`
    Less,
    /// `<=`
    AtMost,
    /// `>`
    Greater,
    /// `>=`
    AtLeast,
}

impl Comparison {
    /// Longer symbols first, so that `<=` is not read as `<`.
    const ALL: [(&'static str, &'static str, Self); 6] = [
        ("!=", "<>", Self::Unequal),
        ("<=", "<=", Self::AtMost),
        (">=", ">=", Self::AtLeast),
        ("=", "=", Self::Equal),
        ("<", "<", Self::Less),
        (">", ">", Self::Greater),
    ];

    /// The operator in SQL.
    pub(crate) fn sql(self) -> &'static str {
        Self::ALL
            .iter()
            .find(|(_, _, this)| *this == self)
            .map_or("=", |(_, sql, _)| sql)
    }

    fn holds(self, ordering: Ordering) -> bool {
        match self {
            Self::Equal => ordering.is_eq(),
            Self::Unequal => ordering.is_ne(),
            Self::Less => ordering.is_lt(),
            Self::AtMost => ordering.is_le(),
            Self::Greater => ordering.is_gt(),
            Self::AtLeast => ordering.is_ge(),
        }
    }
}

/// One `where`.
#[derive(Clone, Debug, PartialEq)]
pub struct Filter {
    /// What is compared.
    pub column: String,
    /// How.
    pub comparison: Comparison,
    /// With what: a number, a truth value or a text.
    pub value: Value,
}

impl Filter {
    /// Reads `column>=value`.
    fn parse(text: &str) -> Result<Self, String> {
        let wrong = || format!("where={text} is not COLUMN, one of = != < <= > >=, and a value");
        let at = text.find(['=', '!', '<', '>']).ok_or_else(wrong)?;
        let rest = &text[at..];
        let (symbol, _, comparison) = Comparison::ALL
            .into_iter()
            .find(|(symbol, _, _)| rest.starts_with(symbol))
            .ok_or_else(wrong)?;
        Ok(Self {
            column: column(&text[..at])?,
            comparison,
            value: scalar(rest[symbol.len()..].trim()),
        })
    }

    /// Whether `value` passes; `null` never does.
    #[must_use]
    pub fn passes(&self, value: &Value) -> bool {
        compare(value, &self.value).is_some_and(|ordering| self.comparison.holds(ordering))
    }
}

/// The order of rows.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Sort {
    /// By what.
    pub column: String,
    /// Largest first.
    pub descending: bool,
}

/// Everything that a reader asks of a table.
#[derive(Clone, Debug, PartialEq)]
pub struct TableQuery {
    /// All must pass.
    pub filters: Vec<Filter>,
    /// The table's own order if none.
    pub sort: Option<Sort>,
    /// Names of parameters and results to show; all if none.
    pub columns: Option<Vec<String>>,
    /// The `next` of the page before.
    pub cursor: Option<String>,
    /// Rows of a page.
    pub limit: u32,
}

impl Default for TableQuery {
    fn default() -> Self {
        Self {
            filters: vec![],
            sort: None,
            columns: None,
            cursor: None,
            limit: USUAL_ROWS,
        }
    }
}

impl TableQuery {
    /// Reads the pairs of a query string; those in `others` are somebody else's.
    pub fn parse(pairs: &[(String, String)], others: &[&str]) -> Result<Self, String> {
        let mut query = Self::default();
        for (key, text) in pairs {
            match key.as_str() {
                "where" if query.filters.len() < MOST_FILTERS => {
                    query.filters.push(Filter::parse(text)?);
                }
                "where" => {
                    return Err(format!(
                        "where may be repeated {MOST_FILTERS} times at most"
                    ));
                }
                "sort" => {
                    let descending = text.starts_with('-');
                    query.sort = Some(Sort {
                        column: column(text.trim_start_matches('-'))?,
                        descending,
                    });
                }
                "columns" => {
                    query.columns = Some(text.split(',').map(column).collect::<Result<_, _>>()?);
                }
                "cursor" => query.cursor = Some(text.clone()),
                "limit" => {
                    let limit = text.parse().ok().filter(|n| (1..=MOST_ROWS).contains(n));
                    query.limit =
                        limit.ok_or_else(|| format!("limit={text} is not in 1 … {MOST_ROWS}"))?;
                }
                key if others.contains(&key) => {}
                key => {
                    return Err(format!(
                        "{key} is not one of where, sort, columns, cursor, limit"
                    ));
                }
            }
        }
        Ok(query)
    }

    /// Whether `name` is to be shown.
    #[must_use]
    pub fn shows(&self, name: &str) -> bool {
        self.columns
            .as_ref()
            .is_none_or(|columns| columns.iter().any(|column| column == name))
    }

    /// Every column that the query names.
    pub(crate) fn named(&self) -> impl Iterator<Item = &str> {
        let filters = self.filters.iter().map(|filter| &filter.column);
        let sort = self.sort.iter().map(|sort| &sort.column);
        filters
            .chain(sort)
            .chain(self.columns.iter().flatten())
            .map(String::as_str)
    }
}

/// A column's name: letters, digits and underscores, at most 64.
fn column(text: &str) -> Result<String, String> {
    let text = text.trim();
    let plain = |c: char| c.is_ascii_alphanumeric() || c == '_';
    if text.is_empty() || text.len() > 64 || !text.chars().all(plain) {
        let start: String = text.chars().take(80).collect();
        return Err(format!("`{start}` is not the name of a column"));
    }
    Ok(text.to_owned())
}

fn scalar(text: &str) -> Value {
    match text {
        "true" => Value::Bool(true),
        "false" => Value::Bool(false),
        _ => match text.parse::<f64>() {
            Ok(number) if number.is_finite() => Value::from(number),
            _ => Value::from(text),
        },
    }
}

/// How two values of a column stand to one another; `None` if one is `null` or they are of different types.
#[must_use]
pub fn compare(a: &Value, b: &Value) -> Option<Ordering> {
    match (a, b) {
        (Value::Number(a), Value::Number(b)) => a.as_f64()?.partial_cmp(&b.as_f64()?),
        (Value::String(a), Value::String(b)) => Some(a.cmp(b)),
        (Value::Bool(a), Value::Bool(b)) => Some(a.cmp(b)),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn pairs(text: &[(&str, &str)]) -> Vec<(String, String)> {
        text.iter()
            .map(|(k, v)| ((*k).to_owned(), (*v).to_owned()))
            .collect()
    }

    #[test]
    fn filters_read_every_comparison() {
        for (text, comparison) in [
            ("gain>=0.3", Comparison::AtLeast),
            ("gain<=0.3", Comparison::AtMost),
            ("gain!=0.3", Comparison::Unequal),
            ("gain=0.3", Comparison::Equal),
            ("gain<0.3", Comparison::Less),
            ("gain > 0.3", Comparison::Greater),
        ] {
            let filter = Filter::parse(text).expect(text);
            assert_eq!(
                (filter.comparison, filter.value),
                (comparison, json!(0.3)),
                "{text}"
            );
        }
    }

    #[test]
    fn null_passes_no_filter_and_text_is_no_number() {
        let filter = Filter::parse("gain!=0").expect("a filter");
        assert!(!filter.passes(&Value::Null));
        assert!(!filter.passes(&json!("six/1")));
        assert!(filter.passes(&json!(1)));
    }

    #[test]
    fn unknown_keys_wrong_limits_and_strange_columns_are_refused() {
        for wrong in [
            ("limit", "0"),
            ("limit", "1e9"),
            ("wher", "a=1"),
            ("where", "gain"),
            ("sort", "a;b"),
            ("columns", ""),
        ] {
            assert!(
                TableQuery::parse(&pairs(&[wrong]), &[]).is_err(),
                "{wrong:?}"
            );
        }
    }
}
