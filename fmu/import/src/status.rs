//! Status codes, and what is made of a bad one.

use crate::{ImportError, messages};
use std::ffi::c_uint;

/// What a C function answers; the two versions of FMI share the numbers.
pub(crate) type Status = c_uint;

const OK: Status = 0;
const WARNING: Status = 1;
const DISCARD: Status = 2;

/// FMI's word for a status. Any number may come: an FMU is somebody else's program.
fn name(status: Status) -> &'static str {
    match status {
        OK => "OK",
        WARNING => "Warning",
        DISCARD => "Discard",
        3 => "Error",
        4 => "Fatal",
        5 => "Pending",
        _ => "unknown to the standard",
    }
}

/// How loud a log line of that status is.
pub(crate) fn level(status: Status) -> log::Level {
    match status {
        OK => log::Level::Info,
        WARNING | DISCARD => log::Level::Warn,
        _ => log::Level::Error,
    }
}

/// Judges what `call` of the instance called `instance` answered.
#[inline(always)]
pub(crate) fn check(instance: &str, call: &'static str, status: Status) -> Result<(), ImportError> {
    if status <= WARNING { Ok(()) } else { Err(refusal(instance, call, status)) }
}

#[cold]
fn refusal(instance: &str, call: &'static str, status: Status) -> ImportError {
    let (instance, messages) = (instance.to_owned(), messages::take());
    ImportError::Call { instance, call, status: name(status), messages }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_warning_is_no_error_and_any_number_has_a_name() {
        for status in [OK, WARNING] {
            check("probe", "DoStep", status).unwrap();
        }
        for (status, word) in [
            (2, "Discard"),
            (3, "Error"),
            (4, "Fatal"),
            (5, "Pending"),
            (6, "unknown"),
            (!0, "unk"),
        ] {
            let error = check("probe", "DoStep", status).unwrap_err().to_string();
            let said = format!("FMU probe: DoStep ends with status {word}");
            assert!(error.starts_with(&said), "{error}");
        }
    }
}
