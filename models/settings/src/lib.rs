//! Reads TOML while keeping the place of every value, so that each refusal can name file, line,
//! key, value and remedy.
//!
//! serde would lose the place of a value as soon as a table is an enum, and a scenario with a
//! typing error would pass in silence. Here the caller walks the tables: [`Table::only`] refuses
//! unknown keys and names the nearest known one, the getters of [`Value`] refuse wrong types and
//! values out of range.
//!
//! ```
//! let text = "[run]\nduration_s = -5.0\n";
//! let error = struna_settings::read(text, |root| {
//!     root.only(&["run"])?;
//!     let run = root.required("run")?.table()?;
//!     run.required("duration_s")?.positive()
//! });
//! assert_eq!(
//!     error.unwrap_err().to_string(),
//!     "line 2, column 14: `run.duration_s` = -5.0: not usable; write a number greater than 0"
//! );
//! ```
//!
//! **Architecture Invariant:** knows nothing of what the files mean, and opens none.

mod error;
mod value;

pub use error::{Fault, SettingsError};
pub use value::{Table, Value, read};

/// What every reading function here returns.
pub type Result<T> = std::result::Result<T, Box<SettingsError>>;
