//! `struna fmu`.

use super::{Outcome, print};
use crate::cli::Fmu;
use crate::fmu::{self, FmiVersion, ModelType};
use crate::output::create_folder;
use anyhow::Result;
use std::path::Path;
use struna_fmi_export::{Domain, Variable};

pub(super) fn execute(command: Fmu) -> Result<Outcome> {
    match command {
        Fmu::Build(args) => build(&args.out),
        Fmu::List => {
            print(&fmu::models().iter().map(listed).collect::<String>())?;
            Ok(Outcome::Complete)
        }
    }
}

/// Builds every FMU, and loads each once to see that an importer can.
fn build(out: &Path) -> Result<Outcome> {
    create_folder(out)?;
    for model in fmu::models() {
        for version in FmiVersion::ALL {
            let path = fmu::build(model.description().name(), version, out)?;
            struna_fmi_import::open(&path)?.instantiate("self-check")?;
            println!("{}", path.display());
        }
    }
    Ok(Outcome::Complete)
}

fn listed(model: &ModelType) -> String {
    let description = model.description();
    let head = ["variable", "kind", "causality", "unit", "start", "meaning"].map(str::to_owned);
    let rows: Vec<_> =
        std::iter::once(head).chain(description.variables().iter().map(columns)).collect();
    let width = |column: usize| rows.iter().map(|row| row[column].chars().count()).max();
    let widths: [usize; 6] = std::array::from_fn(|column| width(column).unwrap_or_default());
    let mut text = format!("{}  {}\n", description.name(), description.description());
    for row in &rows {
        let padded = row.iter().zip(widths).map(|(cell, width)| format!("  {cell:<width$}"));
        text += padded.collect::<String>().trim_end();
        text.push('\n');
    }
    text.push('\n');
    text
}

/// One variable in the words of its model description.
fn columns(variable: &Variable) -> [String; 6] {
    [
        variable.name().to_owned(),
        variable.domain().kind().to_string(),
        variable.causality().to_owned(),
        variable.unit().name().to_owned(),
        if variable.has_start() { start(variable.domain()) } else { "-".to_owned() },
        variable.description().to_owned(),
    ]
}

fn start(domain: Domain) -> String {
    match domain {
        Domain::Float64 { start, .. } => format!("{start:?}"),
        Domain::Int32 { start, .. } => start.to_string(),
        Domain::Boolean { start } => start.to_string(),
    }
}
