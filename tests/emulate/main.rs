//! `struna emulate`: a scenario's gyro on a virtual port, read as hardware is read.

#![expect(clippy::unwrap_used, clippy::panic, reason = "a failed unwrap fails the test")]

mod command;
mod line_section;
mod stream;

/// A body that turns slowly on its string, a VG-910D on it.
pub(crate) const SCENARIO: &str = r#"
[run]
name = "turning"
duration_s = 1.0
seed = 5

[source]
kind = "model"

[body]
mass_kg = 1.0
com_depth_m = 0.1
inertia_kg_m2 = [0.0100, 0.0110, 0.0120]

[body.torsion]
period_s = 480.0

[body.start]
twist_deg = 360.0

[gyro]
preset = "vg910d"

[line]
frame = "struna/vg910d@1"
"#;

/// A frame of seven bytes for a gyro of 1400 Hz.
pub(crate) const FAST_FRAME: &str = include_str!("fast.toml");

/// `text` with the first of each `from` replaced by its `to`.
pub(crate) fn edited(text: &str, edits: &[(&str, &str)]) -> String {
    edits.iter().fold(text.to_owned(), |text, (from, to)| {
        assert!(text.contains(from), "the text to be edited has no {from:?}");
        text.replacen(from, to, 1)
    })
}

/// The scenario with a gyro of 1400 Hz that speaks [`FAST_FRAME`], in `fast.toml` beside it.
pub(crate) fn fast() -> String {
    let gyro = "preset = \"vg910d\"\nsample_rate_hz = 1400.0\nlsb_deg_s = 0.01";
    let frame = "frame = \"fast.toml\"";
    let edits = [("preset = \"vg910d\"", gyro), ("frame = \"struna/vg910d@1\"", frame)];
    edited(SCENARIO, &edits)
}

/// The scenario with the MEMS gyro and its frame.
pub(crate) fn mems() -> String {
    let edits = [("\"vg910d\"", "\"adis16100\""), ("struna/vg910d@1", "struna/adis16100@1")];
    edited(SCENARIO, &edits)
}
