//! Mistakes of a request: all of them at once, each with its place, and what was perhaps meant.

use granary_api::problem::Mistake;
use granary_core::parameter::shown;
use serde_json::Value;

/// The most mistakes that one answer lists.
const MOST: usize = 100;

/// Mistakes found so far.
#[derive(Debug, Default)]
pub(crate) struct Mistakes {
    found: Vec<Mistake>,
    more: usize,
}

impl Mistakes {
    /// Adds a mistake at `pointer`.
    pub(crate) fn add(&mut self, pointer: &str, detail: impl Into<String>) {
        if self.found.len() < MOST {
            self.found.push(Mistake {
                pointer: pointer.to_owned(),
                detail: detail.into(),
            });
        } else {
            self.more += 1;
        }
    }

    /// The value at `pointer` if it is right, or the mistake that it is.
    pub(crate) fn keep<T>(&mut self, pointer: &str, result: Result<T, String>) -> Option<T> {
        result.map_err(|detail| self.add(pointer, detail)).ok()
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.found.is_empty()
    }

    /// Whether further mistakes are only counted.
    pub(crate) fn is_full(&self) -> bool {
        self.found.len() >= MOST
    }

    /// The mistakes, with a last line that counts those left out.
    pub(crate) fn into_list(mut self) -> Vec<Mistake> {
        if self.more > 0 {
            self.found.push(Mistake {
                pointer: String::new(),
                detail: format!("{} more mistakes are not listed", self.more),
            });
        }
        self.found
    }
}

/// `parent/key` as a JSON pointer (RFC 6901).
pub(crate) fn pointer(parent: &str, key: &str) -> String {
    let shortened: String = key.chars().take(80).collect();
    format!(
        "{parent}/{}",
        shortened.replace('~', "~0").replace('/', "~1")
    )
}

/// "`x` is not a …; did you mean y?" for a name that is not among `known`.
pub(crate) fn unknown<'a>(
    what: &str,
    name: &str,
    known: impl Iterator<Item = &'a str> + Clone,
) -> String {
    let name_shown = shown(&Value::from(name));
    match nearest(name, known.clone()) {
        Some(near) => format!("{name_shown} is not a {what}; did you mean {near}?"),
        None => format!("{name_shown} is not a {what}: {}", joined(known)),
    }
}

/// The known name that `name` was perhaps meant to be.
pub(crate) fn nearest<'a>(name: &str, known: impl Iterator<Item = &'a str>) -> Option<&'a str> {
    if name.len() > 80 {
        return None;
    }
    known
        .map(|candidate| (strsim::jaro_winkler(name, candidate), candidate))
        .filter(|(likeness, _)| *likeness > 0.8)
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, candidate)| candidate)
}

fn joined<'a>(known: impl Iterator<Item = &'a str>) -> String {
    known.collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pointers_escape_slashes_and_tildes() {
        assert_eq!(pointer("/fixed", "a/b~c"), "/fixed/a~1b~0c");
    }

    #[test]
    fn nearest_name_is_offered_and_a_strange_one_is_not() {
        let known = ["grains", "gamma0", "friction_coefficient"];
        assert_eq!(nearest("grians", known.into_iter()), Some("grains"));
        assert_eq!(nearest("xyzzy", known.into_iter()), None);
    }

    #[test]
    fn a_thousand_mistakes_are_cut_and_counted() {
        let mut mistakes = Mistakes::default();
        for _ in 0..1000 {
            mistakes.add("/x", "wrong");
        }
        let list = mistakes.into_list();
        assert_eq!(list.len(), MOST + 1);
        assert_eq!(list[MOST].detail, "900 more mistakes are not listed");
    }
}
