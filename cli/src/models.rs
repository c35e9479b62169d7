//! `granary models`: what an experiment may be told.

use granary_api::model::Measured;
use granary_core::model::Model;
use serde_json::{Map, Value, json};

use crate::failure::Done;
use crate::output;
use crate::table::{Table, digits, parameter};

/// List the parameters of the experiments, with units, defaults and what they mean.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// The experiment.
    #[arg(default_value = "memory", value_parser = Model::ALL.map(Model::name))]
    model: String,
    /// Print a JSON Schema instead of a table.
    #[arg(long)]
    json: bool,
}

/// Prints the one table in `core` that also feeds validation, the form and the docs.
pub(crate) fn run(args: &Args) -> anyhow::Result<Done> {
    let model = Model::named(&args.model).expect("the command line takes no other");
    if args.json {
        output::json(&schema(model))?;
        return Ok(Done::Complete);
    }
    let mut table = Table::new([
        "parameter",
        "symbol",
        "unit",
        "default",
        "section",
        "what it is",
    ]);
    for row in model.parameters() {
        let default = row.default_value();
        let default = if default.is_null() {
            "derived".to_owned()
        } else {
            parameter(Some(&default))
        };
        table.push(vec![
            row.name.to_owned(),
            row.symbol.to_owned(),
            row.unit.to_owned(),
            default,
            row.section.name().to_owned(),
            row.sentence.to_owned(),
        ]);
    }
    output::bytes(table.render().as_bytes())?;
    for preset in model.presets() {
        output::line(&format!("preset {}: {}", preset.name, preset.sentence))?;
        let found = granary_server::presets::measured(model, preset.name);
        for measured in &found {
            output::line(&format!("  {}", told(measured, model)))?;
        }
        if found.is_empty() {
            output::line("  its error was not measured")?;
        }
    }
    Ok(Done::Complete)
}

/// What a study found of a preset, in a sentence.
fn told(measured: &Measured, model: Model) -> String {
    let get = |name: &str| measured.results.get(name).copied().flatten();
    let mut parts = vec![];
    for judged in model.judged() {
        let name = format!("{}_deviation", judged.name);
        let (scale, unit) = if judged.relative {
            (100.0, " %")
        } else {
            (1.0, "")
        };
        if let Some(mean) = get(&name) {
            let sign = if mean > 0.0 { "+" } else { "" };
            let bound = get(&format!("{name}_bound")).map_or_else(String::new, |bound| {
                format!(
                    " (of a further packing below {}{unit})",
                    digits(bound * scale, 2)
                )
            });
            parts.push(format!(
                "{} off by {sign}{}{unit}{bound}",
                judged.name,
                digits(mean * scale, 2)
            ));
        }
    }
    if let Some(cost) = get("relative_cost") {
        parts.push(format!("{} of the reference's time", digits(cost, 2)));
    }
    let by = measured.processing.as_deref();
    let by = by.map_or_else(String::new, |processing| format!(", by {processing}"));
    format!("measured on {}{by}: {}", measured.scene, parts.join(", "))
}

fn schema(model: Model) -> Value {
    let properties: Map<String, Value> = model
        .parameters()
        .iter()
        .map(|row| (row.name.to_owned(), row.schema()))
        .collect();
    json!({"title": model.name(), "type": "object", "properties": properties})
}
