//! A progress bar for people at a terminal.

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::time::Duration;
use struna_kernel::SimTime;

/// What is done sooner than this shows no bar.
const SHOWN_AFTER: Duration = Duration::from_secs(1);

/// Shows how far a command has come, once it has taken a second; silent when standard error is no
/// terminal.
#[derive(Debug)]
pub struct Progress {
    bar: ProgressBar,
    shown: bool,
}

impl Progress {
    /// A bar in simulated time that is full at `end`.
    #[must_use]
    pub fn new(end: SimTime, name: &str) -> Self {
        Self::of_length(milliseconds(end), name)
    }

    /// A bar that is full at `length`.
    ///
    /// # Panics
    /// Never: the template is constant and tested.
    #[must_use]
    pub fn of_length(length: u64, name: &str) -> Self {
        let bar = ProgressBar::with_draw_target(Some(length), ProgressDrawTarget::hidden());
        let style = ProgressStyle::with_template("{msg} {wide_bar} {percent:>3} % {eta:>4}")
            .expect("the template is constant");
        bar.set_style(style);
        bar.set_message(name.to_owned());
        Self { bar, shown: false }
    }

    /// Moves to `time`.
    pub fn advance(&mut self, time: SimTime) {
        self.reach(milliseconds(time));
    }

    /// Moves to `position`.
    pub fn reach(&mut self, position: u64) {
        self.bar.set_position(position);
        if !self.shown && self.bar.elapsed() >= SHOWN_AFTER {
            self.bar.set_draw_target(ProgressDrawTarget::stderr());
            self.shown = true;
        }
    }

    /// Removes the bar.
    pub fn finish(self) {
        self.bar.finish_and_clear();
    }
}

fn milliseconds(time: SimTime) -> u64 {
    u64::try_from(time.as_ns() / 1_000_000).unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_bar_can_be_made_and_moved() {
        let mut progress = Progress::new(SimTime::from_ns(2_000_000_000), "x");
        progress.advance(SimTime::from_ns(1_000_000_000));
        assert_eq!(progress.bar.position(), 1000);
        assert_eq!(progress.bar.length(), Some(2000));
    }
}
