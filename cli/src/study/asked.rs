//! What the command line adds to the `[study]` of a spec.

use anyhow::bail;
use serde_json::{Map, Value};

use super::Args;

/// Adds knobs, settings and reference to `spec`, which the planner then reads like any other.
pub(super) fn add(spec: &mut Value, args: &Args) -> anyhow::Result<()> {
    let Some(table) = spec.as_object_mut() else {
        // The planner says what is wrong with it.
        return Ok(());
    };
    let given = !args.knobs.is_empty() || !args.settings.is_empty() || args.reference.is_some();
    if !given && !table.contains_key("study") {
        bail!(
            "nothing to compare: the spec has no [study]\n  name a knob: --knob time_step=0.5,1,1.5"
        );
    }
    let study = table
        .entry("study")
        .or_insert_with(|| Value::Object(Map::new()));
    let Some(study) = study.as_object_mut() else {
        return Ok(());
    };
    for knob in &args.knobs {
        let Some((name, values)) = knob.split_once('=') else {
            bail!("--knob {knob} is not NAME=VALUE,VALUE");
        };
        let values = values.split(',').map(value).collect();
        study.insert(name.trim().to_owned(), Value::Array(values));
    }
    if let Some(reference) = &args.reference {
        let changes = changes("--reference", reference)?;
        study.insert("reference".to_owned(), Value::Object(changes));
    }
    if args.settings.is_empty() {
        return Ok(());
    }
    let listed = study
        .entry("setting")
        .or_insert_with(|| Value::Array(vec![]));
    if let Some(listed) = listed.as_array_mut() {
        for setting in &args.settings {
            listed.push(Value::Object(changes("--setting", setting)?));
        }
    }
    Ok(())
}

/// `a=1,b=word` as a table.
fn changes(option: &str, text: &str) -> anyhow::Result<Map<String, Value>> {
    let mut changes = Map::new();
    for part in text.split(',') {
        let Some((name, text)) = part.split_once('=') else {
            bail!("{option} {text} is not NAME=VALUE,NAME=VALUE");
        };
        changes.insert(name.trim().to_owned(), value(text));
    }
    Ok(changes)
}

/// A number or a truth value as such, anything else as a word.
fn value(text: &str) -> Value {
    let text = text.trim();
    let read = serde_json::from_str(text).ok();
    let scalar = read.filter(|value: &Value| value.is_number() || value.is_boolean());
    scalar.unwrap_or_else(|| Value::from(text))
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Parser;
    use serde_json::json;

    /// What the options `line` make of `spec`.
    fn added(mut spec: Value, line: &[&str]) -> anyhow::Result<Value> {
        #[derive(clap::Parser)]
        struct Line {
            #[command(flatten)]
            args: Args,
        }
        let line = ["study", "spec.toml"].iter().chain(line);
        let line = Line::try_parse_from(line).expect("a command line");
        add(&mut spec, &line.args)?;
        Ok(spec["study"].take())
    }

    #[test]
    fn options_become_a_study_and_add_to_one() {
        let line = ["--knob", "time_step=0.5,1", "--knob", "precision=f32,f64"];
        let study = added(json!({"model": "memory"}), &line).expect("a study");
        assert_eq!(
            study,
            json!({"time_step": [0.5, 1], "precision": ["f32", "f64"]})
        );
        let spec = json!({"study": {"ramp": [9000], "setting": [{"preset": "draft"}]}});
        let line = [
            "--setting",
            "ramp=4500,drag=0.01",
            "--reference",
            "time_step=0.2",
        ];
        let study = added(spec, &line).expect("a study");
        assert_eq!(
            study,
            json!({
                "ramp": [9000],
                "setting": [{"preset": "draft"}, {"ramp": 4500, "drag": 0.01}],
                "reference": {"time_step": 0.2},
            })
        );
    }

    #[test]
    fn options_without_a_value_and_specs_without_a_study_are_refused() {
        for line in [&["--knob", "time_step"][..], &["--setting", "ramp"], &[]] {
            assert!(added(json!({"model": "memory"}), line).is_err(), "{line:?}");
        }
    }
}
