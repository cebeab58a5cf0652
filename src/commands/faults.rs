//! `struna faults`.

use super::Outcome;
use crate::cli::{EventCount, FaultSuite, Faults};
use crate::faults::{Stream, Suite, run, svg, write_csv};
use crate::output::write_whole;
use crate::progress::Progress;
use anyhow::Result;
use std::sync::Mutex;
use struna_kernel::Seed;

pub(super) fn execute(args: &Faults) -> Result<Outcome> {
    let streams = match args.suite {
        FaultSuite::Vg => vec![Stream::Vg],
        FaultSuite::Adis => vec![Stream::Adis],
        FaultSuite::Weak => vec![Stream::Weak],
        FaultSuite::All => Stream::ALL.to_vec(),
    };
    let make = match args.events {
        EventCount::Small => Suite::small,
        EventCount::Full => Suite::full,
    };
    let suite = make(streams, args.hours, Seed(args.seed));
    let threads = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
    let progress = Mutex::new(Progress::of_length(1000, "faults"));
    let matrix = run(&suite, threads, &|done, all| {
        if let Ok(mut progress) = progress.lock() {
            progress.reach(done * 1000 / all.max(1));
        }
    })?;
    if let Ok(progress) = progress.into_inner() {
        progress.finish();
    }
    println!("{matrix}");
    if let Some(file) = &args.csv {
        write_whole(file, |out| write_csv(&matrix, out))?;
        println!("written: {}", file.display());
    }
    if let Some(file) = &args.svg {
        let title = format!("Faults and detectors, seed {}", args.seed);
        write_whole(file, |out| out.write_all(svg(&matrix, &title).as_bytes()))?;
        println!("written: {}", file.display());
    }
    Ok(Outcome::Complete)
}
