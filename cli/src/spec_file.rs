//! Spec files: TOML or JSON in, one JSON value out, and the line of every value for messages.

use std::collections::BTreeMap;
use std::fmt;
use std::path::Path;

use anyhow::Context;
use granary_api::problem::Mistake;
use granary_core::memory::waveform::Sampled;
use serde_json::{Map, Number, Value, json};
use toml::Spanned;
use toml::de::{DeTable, DeValue};

use crate::failure::Failure;

/// The largest table of a waveform.
const MOST_TABLE_BYTES: u64 = 1 << 20;

/// Elements of an array beyond this one are found by the line of the array.
const MOST_LINES: usize = 1000;

/// A spec as it was read.
#[derive(Debug)]
pub(crate) struct SpecFile {
    /// The file, for messages.
    pub(crate) name: String,
    /// What it says, as `POST /sweeps` wants it.
    pub(crate) value: Value,
    /// The line of each JSON pointer, from 1; empty for JSON.
    lines: BTreeMap<String, usize>,
}

/// Every mistake of a spec, where it stands and which rule it breaks.
#[derive(Debug, PartialEq)]
pub(crate) struct BadSpec {
    file: String,
    mistakes: Vec<(Option<usize>, Mistake)>,
}

impl fmt::Display for BadSpec {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let count = self.mistakes.len();
        let plural = if count == 1 { "" } else { "s" };
        write!(f, "{} has {count} mistake{plural}", self.file)?;
        for (line, mistake) in &self.mistakes {
            write!(f, "\n  {}", self.file)?;
            if let Some(line) = line {
                write!(f, ":{line}")?;
            }
            let place = if mistake.pointer.is_empty() { "" } else { " " };
            write!(f, "{place}{}: {}", mistake.pointer, mistake.detail)?;
        }
        Ok(())
    }
}

impl SpecFile {
    /// Reads `path`: JSON if it ends in `.json`, TOML otherwise, standard input if it is `-`.
    ///
    /// # Errors
    /// If the file cannot be read, or is neither TOML nor JSON.
    pub(crate) fn read(path: &Path) -> anyhow::Result<Self> {
        let name = path.display().to_string();
        let text = if name == "-" {
            std::io::read_to_string(std::io::stdin())
        } else {
            std::fs::read_to_string(path)
        };
        let text = text.with_context(|| format!("cannot read the spec {name}"))?;
        let json = path.extension().is_some_and(|end| end == "json") || text.starts_with('{');
        let mut file = Self::parse(name, &text, json)?;
        let mut mistakes = vec![];
        let beside = path.parent().unwrap_or(Path::new(""));
        inline(&mut file.value, ("", false), beside, &mut mistakes);
        if mistakes.is_empty() {
            return Ok(file);
        }
        Err(file.bad(mistakes).into())
    }

    /// Reads `text`; every value that JSON cannot hold is a mistake.
    pub(crate) fn parse(name: String, text: &str, json: bool) -> Result<Self, Failure> {
        if json {
            return match serde_json::from_str(text) {
                Ok(value) => Ok(Self {
                    name,
                    value,
                    lines: BTreeMap::new(),
                }),
                Err(error) => Err(not_readable(name, error.line(), &error.to_string())),
            };
        }
        let table = match DeTable::parse(text) {
            Ok(table) => table,
            Err(error) => {
                let start = error.span().map_or(0, |span| span.start);
                return Err(not_readable(name, line_of(text, start), error.message()));
            }
        };
        let mut reader = TomlReader {
            line_starts: text.match_indices('\n').map(|(at, _)| at).collect(),
            lines: BTreeMap::new(),
            mistakes: vec![],
        };
        let value = reader.table(table.get_ref(), "");
        let mistakes = reader.mistakes;
        let file = Self {
            name,
            value,
            lines: reader.lines,
        };
        if mistakes.is_empty() {
            Ok(file)
        } else {
            Err(file.bad(mistakes))
        }
    }

    /// The failure that `mistakes` in this file are.
    pub(crate) fn bad(&self, mistakes: Vec<Mistake>) -> Failure {
        let place = |mistake: Mistake| (self.line(&mistake.pointer), mistake);
        Failure::BadSpec(BadSpec {
            file: self.name.clone(),
            mistakes: mistakes.into_iter().map(place).collect(),
        })
    }

    /// The line of `pointer`, or of the nearest thing around it.
    fn line(&self, pointer: &str) -> Option<usize> {
        let mut pointer = pointer;
        loop {
            if let Some(line) = self.lines.get(pointer) {
                return Some(*line);
            }
            pointer = &pointer[..pointer.rfind('/')?];
        }
    }
}

/// Puts tables in place of `waveform = { file = "…" }`, whose paths are those beside the spec.
fn inline(
    value: &mut Value,
    (pointer, is_waveform): (&str, bool),
    beside: &Path,
    mistakes: &mut Vec<Mistake>,
) {
    match value {
        Value::Array(items) => {
            for (k, item) in items.iter_mut().enumerate() {
                inline(
                    item,
                    (&format!("{pointer}/{k}"), is_waveform),
                    beside,
                    mistakes,
                );
            }
        }
        Value::Object(table) if is_waveform => {
            let named = table.get("file").and_then(Value::as_str);
            let Some(path) = named.filter(|_| table.len() == 1) else {
                return;
            };
            match table_file(&beside.join(path)) {
                Ok(text) => *value = json!({"csv": text}),
                Err(detail) => mistakes.push(Mistake {
                    pointer: pointer.to_owned(),
                    detail: format!("{path}: {detail}"),
                }),
            }
        }
        Value::Object(table) => {
            for (name, item) in table {
                let inner = format!("{pointer}/{name}");
                inline(item, (&inner, name == "waveform"), beside, mistakes);
            }
        }
        _ => {}
    }
}

/// The text of a table of u and I, if it is one that the server would take.
fn table_file(path: &Path) -> Result<String, String> {
    let size = std::fs::metadata(path)
        .map_err(|error| error.to_string())?
        .len();
    if size > MOST_TABLE_BYTES {
        return Err(format!(
            "{size} bytes: there may be at most {MOST_TABLE_BYTES}"
        ));
    }
    let text = std::fs::read_to_string(path).map_err(|error| error.to_string())?;
    Sampled::from_csv(&text).map(|_| text)
}

fn not_readable(file: String, line: usize, message: &str) -> Failure {
    let mistake = Mistake {
        pointer: String::new(),
        detail: message.trim().replace('\n', ", "),
    };
    Failure::BadSpec(BadSpec {
        file,
        mistakes: vec![(Some(line), mistake)],
    })
}

/// The line, from 1, of the byte at `offset`.
fn line_of(text: &str, offset: usize) -> usize {
    let before = &text.as_bytes()[..offset.min(text.len())];
    1 + before.split(|byte| *byte == b'\n').skip(1).count()
}

/// Turns TOML into JSON and remembers where everything stood.
struct TomlReader {
    line_starts: Vec<usize>,
    lines: BTreeMap<String, usize>,
    mistakes: Vec<Mistake>,
}

impl TomlReader {
    fn note(&mut self, pointer: &str, offset: usize) {
        let line = 1 + self.line_starts.partition_point(|start| *start < offset);
        self.lines.insert(pointer.to_owned(), line);
    }

    fn table(&mut self, table: &DeTable<'_>, pointer: &str) -> Value {
        let mut map = Map::new();
        for (key, value) in table {
            let name = key.get_ref();
            let escaped = name.replace('~', "~0").replace('/', "~1");
            let inner = format!("{pointer}/{escaped}");
            self.note(&inner, key.span().start);
            map.insert(name.to_string(), self.value(value.get_ref(), &inner));
        }
        Value::Object(map)
    }

    fn array(&mut self, items: &[Spanned<DeValue<'_>>], pointer: &str) -> Value {
        let mut values = vec![];
        for (index, item) in items.iter().enumerate() {
            let inner = format!("{pointer}/{index}");
            if index < MOST_LINES {
                self.note(&inner, item.span().start);
            }
            values.push(self.value(item.get_ref(), &inner));
        }
        Value::Array(values)
    }

    fn value(&mut self, value: &DeValue<'_>, pointer: &str) -> Value {
        match value {
            DeValue::Table(table) => self.table(table, pointer),
            DeValue::Array(items) => self.array(items, pointer),
            DeValue::String(text) => Value::String(text.to_string()),
            DeValue::Boolean(flag) => Value::Bool(*flag),
            DeValue::Integer(digits) => {
                let number = i64::from_str_radix(digits.as_str(), digits.radix());
                let number = number.ok().map(Number::from);
                self.number(
                    number,
                    &digits.to_string(),
                    "a whole number below 2^63",
                    pointer,
                )
            }
            DeValue::Float(digits) => {
                let number = digits.as_str().parse().ok().and_then(Number::from_f64);
                self.number(number, digits.as_str(), "a finite number", pointer)
            }
            DeValue::Datetime(time) => {
                self.number(None, &time.to_string(), "a number or a text", pointer)
            }
        }
    }

    fn number(&mut self, number: Option<Number>, shown: &str, rule: &str, pointer: &str) -> Value {
        if let Some(number) = number {
            return Value::Number(number);
        }
        self.mistakes.push(Mistake {
            pointer: pointer.to_owned(),
            detail: format!("{shown} is not {rule}"),
        });
        Value::Null
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use granary_server::sweep::{Limits, Plan};

    const SPEC: &str = "name = \"x\"\n[fixed]\ngrains = 0\ndelta0 = 5e-2\n\n[[grid]]\nwaveform = { suite = \"six\" }\npacking_seed = [1,\n  2, 3]\n";

    fn parse(text: &str) -> Result<SpecFile, Failure> {
        SpecFile::parse("a.toml".to_owned(), text, false)
    }

    #[test]
    fn every_example_is_a_sweep_without_mistakes() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples");
        let mut points = std::collections::BTreeMap::new();
        for entry in std::fs::read_dir(folder).expect("a folder") {
            let path = entry.expect("an entry").path();
            // Those of figures have tests of their own.
            if path.is_dir() {
                continue;
            }
            let file = SpecFile::read(&path).expect("valid TOML");
            let plan = Plan::read(&file.value, Limits::default());
            let plan = plan.unwrap_or_else(|mistakes| panic!("{}: {mistakes:?}", path.display()));
            let name = path.file_stem().expect("a name").to_string_lossy();
            points.insert(name.into_owned(), plan.points);
        }
        assert_eq!(points["beam-smoke"], 1);
        // 11 points of each stiffness, and of two more packings at 100 MPa.
        assert_eq!(points["beam-table1-draft"], 4 * 11 + 2 * 11);
    }

    #[test]
    fn toml_becomes_the_json_of_the_same_schema() {
        let file = parse(SPEC).expect("valid TOML");
        let expected = json!({
            "name": "x",
            "fixed": {"grains": 0, "delta0": 0.05},
            "grid": [{"waveform": {"suite": "six"}, "packing_seed": [1, 2, 3]}],
        });
        assert_eq!(file.value, expected);
    }

    #[test]
    fn mistakes_are_shown_with_file_line_pointer_and_rule() {
        let file = parse(SPEC).expect("valid TOML");
        let mistake = |pointer: &str, detail: &str| Mistake {
            pointer: pointer.to_owned(),
            detail: detail.to_owned(),
        };
        let failure = file.bad(vec![
            mistake("/fixed/grains", "0 is not in 1 … 10,000,000"),
            mistake("/grid/0/packing_seed/2", "3 is too many"),
            mistake("/grid/0/waveform/bits", "missing"),
        ]);
        assert_eq!(
            failure.to_string(),
            "a.toml has 3 mistakes\n  a.toml:3 /fixed/grains: 0 is not in 1 … 10,000,000\n  \
             a.toml:9 /grid/0/packing_seed/2: 3 is too many\n  a.toml:7 /grid/0/waveform/bits: missing"
        );
    }

    #[test]
    fn numbers_that_json_cannot_hold_are_mistakes_all_at_once() {
        let failure = parse("[fixed]\ndelta0 = nan\ngamma0 = [1.0, -inf]\n").expect_err("nan");
        assert_eq!(
            failure.to_string(),
            "a.toml has 2 mistakes\n  a.toml:2 /fixed/delta0: nan is not a finite number\n  \
             a.toml:3 /fixed/gamma0/1: -inf is not a finite number"
        );
    }

    #[test]
    fn a_broken_file_names_its_line() {
        let failure = parse("name = \"x\"\ngrains = = 3\n").expect_err("no TOML");
        assert!(failure.to_string().contains("a.toml:2"), "{failure}");
        let failure = SpecFile::parse("a.json".to_owned(), "{\n\"name\": }", true);
        let failure = failure.expect_err("no JSON");
        assert!(failure.to_string().contains("a.json:2"), "{failure}");
    }

    #[test]
    fn tables_beside_a_spec_are_read_with_it_and_wrong_ones_are_named() {
        let place = tempfile::tempdir().expect("a directory");
        let write = |name: &str, text: &str| {
            std::fs::write(place.path().join(name), text).expect("a file");
        };
        write("ramp.csv", "u,I\n0,0\n1,1\n");
        write("bad.csv", "0,0\n0.5,2\n1,0\n");
        let spec = |waveform: &str| {
            write(
                "sweep.toml",
                &format!("model = \"memory\"\n[fixed]\nwaveform = {waveform}\n"),
            );
            SpecFile::read(&place.path().join("sweep.toml"))
        };
        let read = spec("[\"six/1\", { file = \"ramp.csv\" }]").expect("a spec");
        assert_eq!(read.value["fixed"]["waveform"][1]["csv"], "u,I\n0,0\n1,1\n");
        let told = |waveform: &str| spec(waveform).expect_err("a bad table").to_string();
        let bad = told("{ file = \"bad.csv\" }");
        assert!(
            bad.contains("sweep.toml:3") && bad.contains("bad.csv: line 2: I = 2"),
            "{bad}"
        );
        let gone = told("{ file = \"gone.csv\" }");
        assert!(gone.contains("gone.csv: No such file"), "{gone}");
    }
}
