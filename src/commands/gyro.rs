//! `struna gyro`.

use super::{Outcome, in_columns, print};
use crate::cli::Gyro;
use anyhow::Result;
use struna_gyro::preset::{self, Entry, Preset, Provenance};

pub(super) fn execute(command: &Gyro) -> Result<Outcome> {
    let shipped = |name: &str| preset::named(name).expect("the command line knows the names");
    match command {
        Gyro::List => {
            let head = ["name", "kind", "rate", "range", "parameters", "of them unverified"];
            let rows: Vec<_> = std::iter::once(head.map(str::to_owned))
                .chain(preset::NAMES.map(|name| summary(&shipped(name))))
                .collect();
            print(&in_columns(&rows))?;
        }
        Gyro::Show(args) => print(&shown(&shipped(&args.name)))?,
    }
    Ok(Outcome::Complete)
}

fn summary(preset: &Preset) -> [String; 6] {
    let of = |key: &str| {
        let entry = preset.entries.iter().find(|entry| entry.key == key);
        entry.map_or_else(String::new, |entry| match entry.unit {
            "-" => entry.value.clone(),
            unit => format!("{} {unit}", entry.value),
        })
    };
    let is_unverified = |entry: &&Entry| entry.provenance == Provenance::Unverified;
    [
        preset.name.clone(),
        of("kind"),
        of("sample_rate_hz"),
        format!("+-{}", of("rate_max_deg_s")),
        preset.entries.len().to_string(),
        preset.entries.iter().filter(is_unverified).count().to_string(),
    ]
}

fn shown(preset: &Preset) -> String {
    let head = ["parameter", "value", "unit", "provenance", "note"].map(str::to_owned);
    let cells = |entry: &Entry| {
        let provenance = entry.provenance.to_string();
        let (key, unit) = (entry.key.to_owned(), entry.unit.to_owned());
        [key, entry.value.clone(), unit, provenance, entry.note.clone()]
    };
    let rows: Vec<_> = std::iter::once(head).chain(preset.entries.iter().map(cells)).collect();
    format!("{}\n{}", preset.name, in_columns(&rows))
}
