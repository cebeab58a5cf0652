//! Log lines to the importer, in either version's callback.

use crate::status::{ERROR, FATAL, Status};
use crate::{fmi2::types::fmi2CallbackLogger, fmi3::types::fmi3LogMessageCallback};
use std::ffi::{CStr, CString, c_char, c_void};

/// What a log line is about. Declared in both model descriptions.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum LogCategory {
    /// A call was refused and changed nothing.
    Error,
    /// The instance is lost.
    Fatal,
}

impl LogCategory {
    pub(crate) const ALL: [Self; 2] = [Self::Error, Self::Fatal];

    pub(crate) const fn name(self) -> &'static CStr {
        match self {
            Self::Error => c"logStatusError",
            Self::Fatal => c"logStatusFatal",
        }
    }

    pub(crate) const fn description(self) -> &'static str {
        match self {
            Self::Error => "Calls that were refused and changed nothing.",
            Self::Fatal => "Faults that ended the instance.",
        }
    }

    const fn status(self) -> Status {
        match self {
            Self::Error => ERROR,
            Self::Fatal => FATAL,
        }
    }
}

/// The importer's log callback and the environment pointer that it wants back unchanged.
#[derive(Debug, Clone, Copy)]
pub(crate) enum LogCallback {
    Fmi2(fmi2CallbackLogger, *mut c_void),
    Fmi3(fmi3LogMessageCallback, *mut c_void),
}

/// Where an instance writes its log lines, and which of them the importer wants.
#[derive(Debug)]
pub(crate) struct Log {
    instance_name: CString,
    callback: LogCallback,
    wanted: [bool; LogCategory::ALL.len()],
}

impl Log {
    pub(crate) fn new(instance_name: CString, callback: LogCallback, logging_on: bool) -> Self {
        Self { instance_name, callback, wanted: [logging_on; LogCategory::ALL.len()] }
    }

    /// Switches the given categories on and all others off.
    pub(crate) fn want_only(&mut self, categories: &[LogCategory]) {
        self.wanted = LogCategory::ALL.map(|category| categories.contains(&category));
    }

    /// Writes `function: message`, if the importer wants lines of this category.
    pub(crate) fn write(&self, category: LogCategory, function: &str, message: &str) {
        if !self.wanted[category as usize] {
            return;
        }
        let line = format!("{function}: {message}").replace('\0', "\u{fffd}");
        let Ok(line) = CString::new(line) else { return };
        self.send(category.status(), category.name().as_ptr(), line.as_ptr());
    }

    fn send(&self, status: Status, category: *const c_char, line: *const c_char) {
        match self.callback {
            LogCallback::Fmi2(Some(logger), environment) => {
                let name = self.instance_name.as_ptr();
                // SAFETY: the importer promised a callable logger at instantiation. All texts are
                // terminated and outlive the call. "%s" keeps a '%' in the message from being read
                // as a conversion.
                unsafe { logger(environment, name, status, category, c"%s".as_ptr(), line) }
            }
            LogCallback::Fmi3(Some(logger), environment) => {
                // SAFETY: as above; this callback takes the finished message.
                unsafe { logger(environment, status, category, line) }
            }
            LogCallback::Fmi2(None, _) | LogCallback::Fmi3(None, _) => {}
        }
    }
}
