//! What FMUs log, kept until an error wants it.
//!
//! The `fmi` crate hands an FMU's messages to the process-wide `log` facade, without saying which
//! instance spoke. Calls into an FMU are synchronous, so whatever was logged on this thread during
//! a failing call belongs to that call.

use std::cell::RefCell;
use std::collections::VecDeque;

const KEPT: usize = 8;

thread_local! {
    static RECENT: RefCell<VecDeque<String>> = const { RefCell::new(VecDeque::new()) };
}

struct Collector;

impl log::Log for Collector {
    fn enabled(&self, metadata: &log::Metadata<'_>) -> bool {
        metadata.level() <= log::Level::Warn
    }

    fn log(&self, record: &log::Record<'_>) {
        if !self.enabled(record.metadata()) {
            return;
        }
        RECENT.with_borrow_mut(|recent| {
            if recent.len() == KEPT {
                recent.pop_front();
            }
            recent.push_back(record.args().to_string());
        });
    }

    fn flush(&self) {}
}

/// Collects warnings and errors that FMUs log, so that errors can quote them.
///
/// Takes the process's `log` facade; a program that has its own logger keeps it and simply gets
/// errors without quotes. Call once at the start of `main`.
pub fn capture_fmu_messages() {
    if log::set_logger(&Collector).is_ok() {
        log::set_max_level(log::LevelFilter::Warn);
    }
}

/// Takes what was logged on this thread since the last call.
pub(crate) fn take() -> Vec<String> {
    RECENT.with_borrow_mut(|recent| recent.drain(..).collect())
}
