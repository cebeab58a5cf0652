//! One line that changes, for a person watching a live run.

#![expect(clippy::print_stderr, reason = "where a running command talks to its person")]

use crate::hil::recorder::{Screen, Status};
use indicatif::{ProgressBar, ProgressStyle};
use std::fmt::Write;
use struna_kernel::{EstimateStatus, RAD_PER_DEG};

/// The state of a live run on one line of standard error; silent when that is no terminal.
#[derive(Debug)]
pub(super) struct StatusLine {
    bar: ProgressBar,
}

impl StatusLine {
    pub(super) fn new() -> Self {
        let bar = ProgressBar::new_spinner();
        let style =
            ProgressStyle::with_template("{spinner} {wide_msg}").expect("the template is constant");
        bar.set_style(style);
        Self { bar }
    }

    pub(super) fn finish(self) {
        self.bar.finish_and_clear();
    }
}

impl Screen for StatusLine {
    fn status(&mut self, status: &Status<'_>) {
        if self.bar.is_hidden() {
            return;
        }
        self.bar.set_message(line(status));
        self.bar.tick();
    }

    fn say(&mut self, text: &str) {
        self.bar.suspend(|| eprintln!("struna: {text}"));
    }
}

/// The status in words; what a narrow terminal cuts off is the least needed.
fn line(status: &Status<'_>) -> String {
    let mut line = format!("{:.1} s", status.time.as_s());
    // A `String` takes whatever is written.
    let mut add = |text: std::fmt::Arguments<'_>| {
        let _ = line.write_fmt(text);
    };
    if let Some(gone_s) = status.gone_s {
        add(format_args!("  port gone for {gone_s:.1} s, trying again"));
    }
    add(format_args!("  {} frames, {} lost", status.frames, status.lost));
    match status.skew {
        Some(skew) => add(format_args!("  {:+.1}+-{:.1} ppm", skew.ppm, skew.sigma_ppm)),
        None => add(format_args!("  skew: not yet")),
    }
    if let Some(rate_rad_s) = status.rate_rad_s {
        add(format_args!("  {:+.3} deg/s", rate_rad_s / RAD_PER_DEG));
    }
    for (name, estimate) in status.names.iter().zip(status.estimates) {
        add(format_args!("  {name} {:+.2}", estimate.angle_rad / RAD_PER_DEG));
        if estimate.angle_sigma_rad.is_finite() {
            add(format_args!("+-{:.2}", estimate.angle_sigma_rad / RAD_PER_DEG));
        }
        add(format_args!(" deg"));
        if estimate.status != EstimateStatus::Nominal {
            add(format_args!(", {}", estimate.status.words()));
        }
    }
    line
}

#[cfg(test)]
mod tests {
    use super::*;
    use struna_harness::clock::Skew;
    use struna_kernel::{AngleEstimate, RateOf, SimTime};

    #[test]
    fn the_line_tells_time_rate_angles_frames_and_skew() {
        let time = SimTime::from_ns(12_340_000_000);
        let estimate = |angle_sigma_rad, status| AngleEstimate {
            time,
            angle_rad: RAD_PER_DEG,
            rate_rad_s: 0.0,
            angle_sigma_rad,
            rate_sigma_rad_s: f64::NAN,
            nis: f64::NAN,
            status,
            rate_of: RateOf::BodyAxis,
        };
        let names = ["integration".to_owned(), "rotation".to_owned()];
        let status = Status {
            time,
            rate_rad_s: Some(-2.0 * RAD_PER_DEG),
            names: &names,
            estimates: &[
                estimate(f64::NAN, EstimateStatus::Nominal),
                estimate(0.5 * RAD_PER_DEG, EstimateStatus::Disturbed),
            ],
            frames: 3700,
            lost: 2,
            skew: Some(Skew { ppm: 50.04, sigma_ppm: 0.26 }),
            gone_s: None,
        };
        assert_eq!(
            line(&status),
            "12.3 s  3700 frames, 2 lost  +50.0+-0.3 ppm  -2.000 deg/s  integration +1.00 deg  \
             rotation +1.00+-0.50 deg, disturbed"
        );
        let gone = line(&Status { gone_s: Some(1.5), skew: None, ..status });
        assert!(gone.contains("port gone for 1.5 s") && gone.contains("skew: not yet"), "{gone}");
    }
}
