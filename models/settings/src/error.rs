//! Why a file was refused.

use std::path::{Path, PathBuf};

/// Why a settings file was refused: where, which key, what it held, and what to do about it.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{}line {line}, column {column}: `{key}` = {value}: {fault}", prefix(file.as_deref()))]
pub struct SettingsError {
    /// The file, once known.
    pub file: Option<PathBuf>,
    /// Line of the value, from 1.
    pub line: usize,
    /// Column of the value, in characters from 1.
    pub column: usize,
    /// Path of the key, such as `frame.field[1].bits`.
    pub key: String,
    /// The text at fault, cut short when it is long.
    pub value: String,
    /// What is wrong and the remedy.
    pub fault: Fault,
}

impl SettingsError {
    /// The same refusal, saying which file it is about.
    #[must_use]
    pub fn in_file(mut self, file: &Path) -> Self {
        self.file = Some(file.to_owned());
        self
    }
}

/// What is wrong with one key of a file. Each message ends in the remedy.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Fault {
    /// The file is too long for what it is meant to be.
    #[error("the file has {found} bytes; at most {limit} are read")]
    TooLong {
        /** Bytes in the file. */
        found: usize,
        /** Bytes allowed. */
        limit: usize,
    },
    /// Not TOML at all.
    #[error("not TOML ({message}); correct the syntax here")]
    Syntax {
        /** What the TOML parser said. */
        message: String,
    },
    /// A key that means nothing here: a typing error would otherwise pass in silence.
    #[error("no such key; {}use one of: {known}", did_you_mean(nearest.as_deref()))]
    UnknownKey {
        /** The known key that looks most alike, if any does. */
        nearest: Option<String>,
        /** Keys that are understood here. */
        known: String,
    },
    /// A key that has no default is absent.
    #[error("this key is missing; add it")]
    Missing,
    /// The value is of another type.
    #[error("found {found}; write {expected}")]
    WrongType {
        /** Type in the file. */
        found: &'static str,
        /** Type wanted. */
        expected: &'static str,
    },
    /// The value is of the right type but cannot be used.
    #[error("not usable; write {expected}")]
    OutOfRange {
        /** What would be accepted. */
        expected: String,
    },
    /// A word that is not supported.
    #[error("not supported; {}write one of: {supported}", did_you_mean(nearest.as_deref()))]
    UnknownWord {
        /** The supported word that looks most alike, if any does. */
        nearest: Option<String>,
        /** Words that are. */
        supported: String,
    },
    /// The value contradicts another, or the world.
    #[error("{reason}")]
    Refused {
        /** Why, and the remedy. */
        reason: String,
    },
}

fn prefix(file: Option<&Path>) -> String {
    file.map(|file| format!("{}, ", file.display())).unwrap_or_default()
}

fn did_you_mean(nearest: Option<&str>) -> String {
    nearest.map(|word| format!("did you mean `{word}`? ")).unwrap_or_default()
}
