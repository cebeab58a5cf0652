//! Why an FMU could not be used.

use std::path::{Path, PathBuf};

/// Why an FMU could not be opened, instantiated or stepped.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ImportError {
    /// The file cannot be read.
    #[error("cannot read the FMU {}: {source}; check the path", path.display())]
    Read {
        /** The file. */
        path: PathBuf,
        /** The system's reason. */
        source: std::io::Error,
    },
    /// The file is no FMU.
    #[error("{} is not an FMU: {reason}; build one with `struna fmu build`", path.display())]
    NotAnFmu {
        /** The file. */
        path: PathBuf,
        /** What is wrong with it. */
        reason: String,
    },
    /// Neither FMI 2 nor FMI 3.
    #[error("{} is an FMU of version '{version}'; only FMI 2.0 and 3.0 are read", path.display())]
    Version {
        /** The file. */
        path: PathBuf,
        /** The version it declares. */
        version: String,
    },
    /// No co-simulation in it.
    #[error("{} holds no co-simulation model; export it for co-simulation", path.display())]
    NotCoSimulation {
        /** The file. */
        path: PathBuf,
    },
    /// No variable of that name and kind.
    #[error("FMU {model} has no {kind} variable '{name}'{}", nearest_hint(nearest.as_deref()))]
    NoVariable {
        /** Model name. */
        model: String,
        /** What kind was asked for. */
        kind: &'static str,
        /** The name asked for. */
        name: String,
        /** The closest name of that kind, if any is close. */
        nearest: Option<String>,
    },
    /// The shared library could not be loaded, or lacks a function.
    #[error(
        "cannot load the shared library of FMU {model}: {reason}; export the FMU again, for \
         co-simulation on this platform"
    )]
    Load {
        /** Model name. */
        model: String,
        /** The loader's reason. */
        reason: String,
    },
    /// The FMU would not be instantiated.
    #[error("FMU {model} refuses to be instantiated{}", said(messages))]
    Refused {
        /** Model name. */
        model: String,
        /** What the FMU logged. */
        messages: Vec<String>,
    },
    /// The FMU answered a call with an error.
    #[error("FMU {instance}: {call} ends with status {status}{}", said(messages))]
    Call {
        /** Instance name. */
        instance: String,
        /** The function called, FMI's own name without prefix. */
        call: &'static str,
        /** The status it returned. */
        status: &'static str,
        /** What the FMU logged. */
        messages: Vec<String>,
    },
    /// The FMU ended the step or the simulation early.
    #[error("FMU {instance} stopped by itself at {time_s} s")]
    StoppedEarly {
        /** Instance name. */
        instance: String,
        /** Last successful time, s. */
        time_s: f64,
    },
}

fn said(messages: &[String]) -> String {
    if messages.is_empty() { String::new() } else { format!("; it says: {}", messages.join("; ")) }
}

fn nearest_hint(nearest: Option<&str>) -> String {
    nearest.map(|name| format!("; did you mean '{name}'?")).unwrap_or_default()
}

pub(crate) fn not_an_fmu(path: &Path, reason: &impl std::fmt::Display) -> ImportError {
    ImportError::NotAnFmu { path: path.to_owned(), reason: reason.to_string() }
}
