//! `struna fmu`.

use super::Outcome;
use crate::cli::Fmu;
use crate::fmu::{self, FmiVersion, ModelType};
use crate::output::create_folder;
use anyhow::Result;
use std::path::Path;

pub(super) fn execute(command: Fmu) -> Result<Outcome> {
    match command {
        Fmu::Build(args) => build(&args.out),
        Fmu::List => {
            fmu::models().iter().for_each(list);
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

fn list(model: &ModelType) {
    let description = model.description();
    println!("{}  {}", description.name(), description.description());
    for variable in description.variables() {
        println!(
            "  {:<10} {:<30} {:<8} {}",
            variable.causality(),
            variable.name(),
            variable.unit().name(),
            variable.description(),
        );
    }
    println!();
}
