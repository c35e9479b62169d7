//! `granary models`: what an experiment may be told.

use granary_core::model::Model;
use serde_json::{Map, Value, json};

use crate::failure::Done;
use crate::output;
use crate::table::{Table, parameter};

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
    }
    Ok(Done::Complete)
}

fn schema(model: Model) -> Value {
    let properties: Map<String, Value> = model
        .parameters()
        .iter()
        .map(|row| (row.name.to_owned(), row.schema()))
        .collect();
    json!({"title": model.name(), "type": "object", "properties": properties})
}
