//! `struna smooth`.

use super::Outcome;
use crate::cli::Smooth;
use crate::output::{create_folder, write_whole};
use crate::score::Score;
use crate::smooth::{figure, file, look_back, start_belief, text};
use anyhow::Result;

pub(super) fn execute(args: &Smooth) -> Result<Outcome> {
    let measured = file::read(&args.record)?;
    let belief = start_belief(args, &measured)?;
    let hindsight = look_back(args, &belief.config, &measured)?;
    let record = text::record(&measured, &hindsight);
    let score = (!measured.truth.is_empty()).then(|| Score::of(&record));
    let file = args.record.display().to_string();
    let title = format!("{file}: {} in hindsight", hindsight.method);
    // Everything that can fail is made before anything is written.
    let svg = figure::svg(&record, &hindsight, &title)?;
    let report = text::Report {
        file,
        measured: &measured,
        belief: &belief,
        hindsight: &hindsight,
        score: score.as_ref(),
    }
    .to_string();
    create_folder(&args.out)?;
    write_whole(&args.out.join("smoothed.csv"), |out| record.write_csv(out))?;
    write_whole(&args.out.join("figure.svg"), |out| out.write_all(svg.as_bytes()))?;
    write_whole(&args.out.join("report.txt"), |out| out.write_all(report.as_bytes()))?;
    let folder = args.out.display();
    super::print(&format!(
        "{report}\nwritten to {folder}: smoothed.csv, figure.svg, report.txt\n"
    ))?;
    Ok(Outcome::Complete)
}
