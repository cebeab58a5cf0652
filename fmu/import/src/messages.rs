//! What FMUs log, kept until an error wants it.
//!
//! An FMU's messages go to the process-wide `log` facade, as the `fmi` crate sends those of
//! FMI 2.0, without saying which instance spoke. Calls into an FMU are synchronous, so whatever was
//! logged on this thread during a failing call belongs to that call.

use crate::status::{Status, level};
use std::borrow::Cow;
use std::cell::RefCell;
use std::collections::VecDeque;
use std::ffi::{CStr, c_char, c_void};

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

/// The log callback of FMI 3.0.
///
/// # Safety
/// The texts must be null or terminated.
#[expect(unsafe_code, reason = "called from C with C's texts")]
pub(crate) unsafe extern "C" fn fmi3_log_message(
    _environment: *mut c_void,
    status: Status,
    category: *const c_char,
    message: *const c_char,
) {
    let text = |text: *const c_char| {
        if text.is_null() {
            return Cow::Borrowed("");
        }
        // SAFETY: not null, so terminated by the caller's promise.
        unsafe { CStr::from_ptr(text) }.to_string_lossy()
    };
    let (category, message) = (text(category), text(message));
    log::log!(target: &category, level(status), "{message}");
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::ptr::{null, null_mut};

    #[test]
    #[expect(unsafe_code, reason = "a C function, called as an FMU would")]
    fn whatever_an_fmu_logs_is_kept_or_dropped_but_never_a_panic() {
        capture_fmu_messages();
        take();
        let (broken, plain) = (c"broken \xff text", c"50 %s");
        for (status, text) in
            [(0, plain.as_ptr()), (3, plain.as_ptr()), (99, broken.as_ptr()), (4, null())]
        {
            // SAFETY: the texts are null or terminated.
            unsafe { fmi3_log_message(null_mut(), status, null(), text) };
        }
        assert_eq!(take(), ["50 %s", "broken \u{fffd} text", ""]);
    }
}
