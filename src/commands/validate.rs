//! `struna validate`.

use super::{Outcome, in_columns, print};
use crate::cli::Validate;
use crate::output::{prepare_folder, write_whole};
use crate::progress::Progress;
use crate::validate::junit::write_junit;
use crate::validate::parquet::write_parquet;
use crate::validate::report::html;
use crate::validate::table::{self, write_csv};
use crate::validate::{Judgement, Plan, Results, Suite, Verdict, Watcher, judge, run};
use anyhow::{Context, Result};
use std::path::Path;
use std::sync::Mutex;
use struna_kernel::Seed;
use struna_line::StopFlag;

/// What the person at the terminal sees and does meanwhile.
struct Terminal {
    progress: Mutex<Progress>,
    stop: StopFlag,
}

impl Watcher for Terminal {
    fn progress(&self, done: usize, all: usize) {
        if let Ok(mut progress) = self.progress.lock() {
            progress.reach(1000 * done as u64 / (all as u64).max(1));
        }
    }

    fn is_stopped(&self) -> bool {
        self.stop.is_stopped()
    }
}

pub(super) fn execute(args: &Validate) -> Result<Outcome> {
    let stop = StopFlag::new();
    let on_interrupt = stop.clone();
    ctrlc::set_handler(move || on_interrupt.stop()).context("cannot listen for Ctrl-C")?;
    // Before the hours of work, not after them.
    prepare_folder(&args.out)?;
    let suites: Option<Vec<Suite>> = args.suite.names().into_iter().map(Suite::named).collect();
    let suites = suites.context("a suite of that name is not built in")?;
    let cores = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
    let plan = Plan {
        runs: args.runs,
        seed: Seed(args.seed),
        threads: args.threads.map_or(cores, usize::from),
    };
    let progress = Mutex::new(Progress::of_length(1000, "validate"));
    let terminal = Terminal { progress, stop };
    let results = run(&suites, &plan, &terminal);
    if let Ok(progress) = terminal.progress.into_inner() {
        progress.finish();
    }
    let judgements = judge(&suites, &results);
    write(&args.out, &suites, &plan, &results, &judgements)?;
    print(&text(&suites, &results, &judgements, &args.out))?;
    Ok(outcome(&results, &judgements))
}

fn outcome(results: &Results, judgements: &[Judgement]) -> Outcome {
    if results.is_partial() {
        Outcome::Interrupted
    } else if judgements.iter().any(|judged| judged.verdict == Verdict::NotMet) {
        Outcome::NotMet
    } else {
        Outcome::Complete
    }
}

fn write(
    out: &Path,
    suites: &[Suite],
    plan: &Plan,
    results: &Results,
    judgements: &[Judgement],
) -> Result<()> {
    let complete = !results.is_partial();
    write_whole(&out.join("rows.csv"), |file| write_csv(&results.rows, file))?;
    write_whole(&out.join("rows.parquet"), |file| write_parquet(&results.rows, complete, file))?;
    let page = html(suites, plan, results, judgements)?;
    write_whole(&out.join("report.html"), |file| file.write_all(page.as_bytes()))?;
    write_whole(&out.join("junit.xml"), |file| write_junit(suites, results, judgements, file))?;
    Ok(())
}

/// Verdicts suite by suite, and what they come to.
fn text(suites: &[Suite], results: &Results, judgements: &[Judgement], out: &Path) -> String {
    let mut text = String::new();
    for suite in suites {
        text += &format!("{}: {}\n", suite.name, suite.about);
        let of = judgements.iter().filter(|judged| judged.suite == suite.name);
        let heads = ["case", "estimator", "what", "measured [95 %]", "required", "verdict"];
        let rows: Vec<[String; 6]> =
            std::iter::once(heads.map(str::to_owned)).chain(of.map(table::cells)).collect();
        text += &in_columns(&rows);
        text.push('\n');
    }
    let stopped = results.rows.iter().filter(|row| !row.is_complete()).count();
    if stopped > 0 {
        text += &format!("{stopped} runs stopped before their end; rows.csv says why\n");
    }
    if results.is_partial() {
        let (done, all) = results.done;
        text += &format!("PARTIAL: {done} of {all} runs were done before Ctrl-C\n");
    }
    text += &format!("{}\nwritten to {}\n", table::sentence(judgements), out.display());
    text
}
