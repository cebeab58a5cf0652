//! A progress bar in simulated time, for people at a terminal.

use indicatif::{ProgressBar, ProgressStyle};
use struna_kernel::SimTime;

/// Shows how far a run has come; silent when standard error is no terminal.
#[derive(Debug)]
pub struct Progress {
    bar: ProgressBar,
}

impl Progress {
    /// A bar that is full at `end`.
    ///
    /// # Panics
    /// Never: the template is constant and tested.
    #[must_use]
    pub fn new(end: SimTime, name: &str) -> Self {
        let bar = ProgressBar::new(milliseconds(end));
        let style = ProgressStyle::with_template("{msg} {wide_bar} {percent:>3} % {eta:>4}")
            .expect("the template is constant");
        bar.set_style(style);
        bar.set_message(name.to_owned());
        Self { bar }
    }

    /// Moves to `time`.
    pub fn advance(&mut self, time: SimTime) {
        self.bar.set_position(milliseconds(time));
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
