//! Frame layouts, by the name of a shipped one or by file.

use std::borrow::Cow;
use std::path::{Path, PathBuf};
use struna_settings::SettingsError;
use struna_wire::{FrameSpec, Lint};

/// Layouts that ship with the program: what they are called and their files.
pub const SHIPPED: [(&str, &str); 8] = [
    ("struna/vg910d@1", include_str!("../frames/vg910d.toml")),
    ("struna/vg910d-triad@1", include_str!("../frames/vg910d-triad.toml")),
    ("struna/vg910d-raw4@1", include_str!("../frames/vg910d-raw4.toml")),
    ("struna/vg910d-sum@1", include_str!("../frames/vg910d-sum.toml")),
    ("struna/adis16100@1", include_str!("../frames/adis16100.toml")),
    ("kvh/dsp3000-1k@1", include_str!("../frames/kvh-dsp3000-1k.toml")),
    ("kvh/dsp3000-ascii@1", include_str!("../frames/kvh-dsp3000-ascii.toml")),
    ("struna/fog-septet-xor@1", include_str!("../frames/fog-septet-xor.toml")),
];

/// Why there is no such layout.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FrameError {
    /// Neither a shipped name nor a frame file's.
    #[error("no frame is called {name}; name a .toml file or one of: {known}")]
    Unknown {
        /** What was asked for. */
        name: String,
        /** The shipped names. */
        known: String,
    },
    /// The file cannot be read.
    #[error("cannot read the frame file {}: {source}; check the path", path.display())]
    Read {
        /** The file. */
        path: PathBuf,
        /** The system's reason. */
        source: std::io::Error,
    },
    /// The file is refused.
    #[error(transparent)]
    Settings(#[from] Box<SettingsError>),
}

/// The text of the shipped layout called `name`.
#[must_use]
pub fn shipped(name: &str) -> Option<&'static str> {
    SHIPPED.iter().find(|(shipped, _)| *shipped == name).map(|(_, text)| *text)
}

/// The layout called `name`, or that of the file at this path.
///
/// # Errors
/// [`FrameError`] names file, line, key, value and remedy.
pub fn frame_named_or_file(name: &str) -> Result<FrameSpec, FrameError> {
    judged(name, unique)
}

/// The layout of a frame file, if bytes can be decoded by it in one way only. Nothing of the
/// program decodes by any other.
///
/// # Errors
/// As [`Lint::of`], without the file's name.
pub fn unique(text: &str) -> Result<FrameSpec, Box<SettingsError>> {
    Ok(Lint::of(text)?.spec)
}

/// What `judge` makes of the text of the layout called `name`, or of the file at this path. A
/// refusal names the file.
///
/// # Errors
/// [`FrameError`] names file, line, key, value and remedy.
pub fn judged<T>(
    name: &str,
    judge: impl FnOnce(&str) -> Result<T, Box<SettingsError>>,
) -> Result<T, FrameError> {
    let text = text_of(name)?;
    Ok(judge(&text).map_err(|error| Box::new(error.in_file(Path::new(name))))?)
}

fn text_of(name: &str) -> Result<Cow<'static, str>, FrameError> {
    if let Some(text) = shipped(name) {
        return Ok(Cow::Borrowed(text));
    }
    let path = Path::new(name);
    let is_file = path.extension().is_some_and(|extension| extension == "toml") || path.is_file();
    if !is_file {
        let known = SHIPPED.map(|(name, _)| name).join(", ");
        return Err(FrameError::Unknown { name: name.to_owned(), known });
    }
    match std::fs::read_to_string(path) {
        Ok(text) => Ok(Cow::Owned(text)),
        Err(source) => Err(FrameError::Read { path: path.to_owned(), source }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One bit says where a frame starts, and nothing else does.
    const WEAK: &str = r#"
[frame]
name = "weak"
kind = "fixed"
provenance = "unverified"
sync = "80"
sync_mask = "80"
len = 4
check = { kind = "none" }
[[frame.field]]
name = "rate"
at = 1
bits = 24
endian = "be"
coding = "twos"
unit = "deg/s"
[line]
baud = 115200
data = 8
parity = "none"
stop = 1
[timing]
rate_hz = 300.0
rate_tol = 0.03
"#;

    #[test]
    fn a_layout_that_noise_imitates_is_not_decoded_by() {
        assert!(FrameSpec::from_toml(WEAK).is_ok());
        let refusal = unique(WEAK).unwrap_err().to_string();
        assert!(refusal.contains("tell frames from noise"), "{refusal}");
    }

    #[test]
    fn every_shipped_layout_has_the_name_it_is_shipped_by() {
        for (name, _) in SHIPPED {
            assert_eq!(frame_named_or_file(name).unwrap().name(), name);
        }
    }
}
