//! `struna characterize`.

use super::Outcome;
use crate::characterize::file::{self, Columns};
use crate::characterize::{CharacterizeError, Characterized, Report, figure, preset};
use crate::cli::Characterize;
use crate::output::write_whole;
use crate::progress::Progress;
use anyhow::Result;
use std::path::Path;
use struna_gyro::characterise::{Options, TauGrid, characterise};

pub(super) fn execute(args: &Characterize) -> Result<Outcome> {
    let characterized = characterized(args)?;
    // Everything that can fail is made before anything is written.
    let json = serde_json::to_string_pretty(&Report::new(&characterized))? + "\n";
    let preset = preset::toml(&characterized);
    let svg = args.figure.as_ref().map(|_| figure::svg(&characterized)).transpose()?;
    let files = [
        (args.json.as_deref(), Some(json)),
        (args.figure.as_deref(), svg),
        (args.preset.as_deref(), Some(preset)),
    ];
    let mut written = Vec::new();
    for (path, text) in files {
        if let (Some(path), Some(text)) = (path, text) {
            write_whole(path, |out| out.write_all(text.as_bytes()))?;
            written.push(path.display().to_string());
        }
    }
    println!("{characterized}");
    if !written.is_empty() {
        println!("\nwritten: {}", written.join(", "));
    }
    Ok(Outcome::Complete)
}

fn characterized(args: &Characterize) -> Result<Characterized> {
    let columns = Columns {
        rate: args.rate_column.clone(),
        unit: args.unit.as_deref().map(str::parse).transpose().map_err(CharacterizeError::Unit)?,
        time: args.time_column.clone(),
        index: args.index_column.clone(),
        sample_rate_hz: args.sample_rate,
    };
    let options = Options {
        grid: if args.octaves { TauGrid::Octave } else { TauGrid::TenPerDecade },
        bandwidth_hz: args.bandwidth_hz,
        averaging: args.averaging,
        overbound: args.overbound,
        ..Options::default()
    };
    let mut progress = Progress::of_length(1000, "characterize");
    let file = file::read(&args.file, &columns, &mut |share| progress.reach(share))?;
    progress.finish();
    let found = characterise(&file.record, &options)
        .map_err(|source| CharacterizeError::Unusable { path: args.file.clone(), source })?;
    Ok(Characterized {
        name: args.name.clone().unwrap_or_else(|| stem(&args.file)),
        source: args.file.display().to_string(),
        rate_column: file.rate_column,
        record: file.record,
        options,
        found,
    })
}

/// The file's name without folder and ending.
fn stem(path: &Path) -> String {
    path.file_stem().map_or_else(|| "gyro".to_owned(), |stem| stem.to_string_lossy().into_owned())
}
