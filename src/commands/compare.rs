//! `struna compare`.

use super::Outcome;
use crate::cli::Compare;
use crate::compare::{Difference, compare};
use crate::progress::Progress;
use anyhow::{Context, Result, bail};

const NO_ANGLE: &str = "no angle is in both files; leave --tolerance-rad away";

pub(super) fn execute(args: &Compare) -> Result<Outcome> {
    let mut progress = Progress::of_length(1000, "compare");
    let comparison = compare(&args.a, &args.b, &mut |share| progress.reach(share))?;
    progress.finish();
    // Whether there is anything to judge is known before anything is printed.
    let widest = match args.tolerance_rad {
        Some(_) => Some(comparison.widest_angle().context(NO_ANGLE)?),
        None => None,
    };
    println!("{comparison}");
    match args.tolerance_rad.zip(widest) {
        Some((tolerance_rad, widest)) => judge(widest, tolerance_rad),
        None => Ok(Outcome::Complete),
    }
}

fn judge(widest: &Difference, tolerance_rad: f64) -> Result<Outcome> {
    let largest_rad = widest.largest.unwrap_or(0.0);
    if largest_rad > tolerance_rad {
        bail!(
            "{} differs by {largest_rad:e} rad at {} s, more than the tolerated {tolerance_rad:e} \
             rad",
            widest.name,
            widest.at_s
        );
    }
    Ok(Outcome::Complete)
}
