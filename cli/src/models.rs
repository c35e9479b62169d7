//! `granary models`: what an experiment may be told.

use granary_core::memory::parameters::{PARAMETERS, PRESETS};
use serde_json::{Map, Value, json};

use crate::failure::Done;
use crate::output;
use crate::table::{Table, parameter};

/// List the parameters of the experiments, with units, defaults and what they mean.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// The experiment.
    #[arg(default_value = "memory", value_parser = ["memory"])]
    model: String,
    /// Print a JSON Schema instead of a table.
    #[arg(long)]
    json: bool,
}

/// Prints the one table in `core` that also feeds validation, the form and the docs.
pub(crate) fn run(args: &Args) -> anyhow::Result<Done> {
    if args.json {
        output::json(&schema(&args.model))?;
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
    for row in PARAMETERS {
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
    for preset in PRESETS {
        output::line(&format!("preset {}: {}", preset.name, preset.sentence))?;
    }
    Ok(Done::Complete)
}

fn schema(model: &str) -> Value {
    let properties: Map<String, Value> = PARAMETERS
        .iter()
        .map(|row| (row.name.to_owned(), row.schema()))
        .collect();
    json!({"title": model, "type": "object", "properties": properties})
}
