//! Gyros as TOML files: each parameter with its unit in the key and where its value comes from.
//!
//! A file has one table, `[gyro]`, in which each key is a plain number or word, or a table
//! `{ value = 0.07, provenance = "derived", note = "..." }`. Two gyros ship with the program; the
//! same reader takes a file of one's own, and the `[gyro]` section of a scenario on top of either.

mod keys;

use crate::datasheet::{Sided, walk_of_density};
use crate::{GyroParams, Law, Rounding, Sampling};
use keys::{DENSITY, NUMBERS, NumberKey, REQUIRED, SIDED, WALK, WORDS};
use std::fmt;
use struna_settings::{Result, Table, Value};

const SHIPPED: [(&str, &str); 2] = [
    ("vg910d", include_str!("../../presets/vg910d.toml")),
    ("adis16100", include_str!("../../presets/adis16100.toml")),
];

/// Names of the shipped presets.
pub const NAMES: [&str; SHIPPED.len()] = [SHIPPED[0].0, SHIPPED[1].0];

const NAME_CHARS_MAX: usize = 64;

/// A gyro, and where each of its values comes from.
#[derive(Debug, Clone, PartialEq)]
pub struct Preset {
    /// Its name.
    pub name: String,
    /// How it works.
    pub kind: Kind,
    /// Its parameters, in SI.
    pub params: GyroParams,
    /// What was written, in the order of the table of parameters. What was not is off.
    pub entries: Vec<Entry>,
}

/// One parameter as it was written.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Entry {
    /// The key, unit included.
    pub key: &'static str,
    /// The unit, or "-".
    pub unit: &'static str,
    /// The value.
    pub value: String,
    /// Where it comes from.
    pub provenance: Provenance,
    /// What else is said of it; empty when nothing is.
    pub note: String,
}

/// How a gyro works, which decides how its scale bends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Fibre-optic, open loop: what is left of a sine.
    FibreOptic,
    /// Micromechanical, vibrating: a cubic.
    Mems,
}

/// Where a value comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Provenance {
    /// Read in a source about this very model.
    Published,
    /// Calculated from published or measured values.
    Derived,
    /// Of the right order by analogy or hearsay; nobody has checked it for this model.
    Unverified,
    /// Chosen here.
    Invented,
    /// Measured on a real one.
    Measured,
    /// Written by the user, without saying where from.
    Given,
}

const PROVENANCES: [(&str, Provenance); 6] = [
    ("published", Provenance::Published),
    ("derived", Provenance::Derived),
    ("unverified", Provenance::Unverified),
    ("invented", Provenance::Invented),
    ("measured", Provenance::Measured),
    ("given", Provenance::Given),
];

impl fmt::Display for Provenance {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let word = PROVENANCES.iter().find(|(_, provenance)| provenance == self);
        f.pad(word.map_or("", |(word, _)| word))
    }
}

/// The VG-910D fibre-optic gyro as this bench assumes it; `presets/vg910d.toml` says what of that
/// is known.
#[must_use]
pub fn vg910d() -> GyroParams {
    shipped(0).params
}

/// The ADIS16100 micromechanical gyro as this bench assumes it; `presets/adis16100.toml` says what
/// of that is known.
#[must_use]
pub fn adis16100() -> GyroParams {
    shipped(1).params
}

/// The shipped preset called `name`.
#[must_use]
pub fn named(name: &str) -> Option<Preset> {
    let at = NAMES.iter().position(|shipped| *shipped == name)?;
    Some(shipped(at))
}

fn shipped(at: usize) -> Preset {
    read(SHIPPED[at].1).expect("shipped presets are tested")
}

/// Reads the text of a preset file.
///
/// # Errors
/// [`struna_settings::SettingsError`] names line, key, value and remedy.
pub fn read(text: &str) -> Result<Preset> {
    struna_settings::read(text, |root| {
        root.only(&["gyro"])?;
        let table = root.required("gyro")?.table()?;
        let known: Vec<_> = ["name"].into_iter().chain(parameter_keys()).collect();
        table.only(&known)?;
        let name = table.required("name")?;
        let text = name.text()?;
        if text.is_empty() || text.chars().count() > NAME_CHARS_MAX {
            return Err(name.out_of_range(format!("a name of up to {NAME_CHARS_MAX} characters")));
        }
        table.required("kind")?;
        let mut preset = blank(&table)?;
        text.clone_into(&mut preset.name);
        Ok(preset)
    })
}

/// A gyro of which everything is in `table`: what is not there is off. For the `[gyro]` of a
/// scenario without a preset. Other keys of the table are not looked at.
///
/// # Errors
/// [`struna_settings::SettingsError`] names line, key, value and remedy.
pub fn blank(table: &Table<'_>) -> Result<Preset> {
    for key in REQUIRED {
        table.required(key)?;
    }
    let params = GyroParams::exact(1.0, 1.0, 1.0, 1);
    let nameless = Preset { name: String::new(), kind: Kind::Mems, params, entries: Vec::new() };
    nameless.with(table)
}

/// Keys of all parameters.
pub fn parameter_keys() -> impl Iterator<Item = &'static str> {
    WORDS.into_iter().chain(NUMBERS.iter().map(|key| key.name))
}

impl Preset {
    /// The same gyro, with what `table` says of it in place of what was. Other keys of the table
    /// are not looked at.
    ///
    /// # Errors
    /// [`struna_settings::SettingsError`] names line, key, value and remedy.
    pub fn with(mut self, table: &Table<'_>) -> Result<Self> {
        for key in WORDS {
            if let Some(value) = table.optional(key) {
                let cell = Cell::of(&value)?;
                let text = self.set_word(key, &cell.value)?;
                self.note(key, "-", text, &cell);
            }
        }
        for key in &NUMBERS {
            if let Some(value) = table.optional(key.name) {
                let cell = Cell::of(&value)?;
                let number = self.set_number(key, &cell.value)?;
                self.note(key.name, key.unit, number, &cell);
            }
        }
        self.density(table)?;
        self.entries.sort_by_key(|entry| parameter_keys().position(|key| key == entry.key));
        self.params.validate().map_err(|error| table.because(error.to_string()))?;
        Ok(self)
    }

    fn set_number(&mut self, key: &NumberKey, value: &Value<'_>) -> Result<String> {
        let number = key.allowed.read(value)?;
        *(key.place)(&mut self.params) = number * key.si;
        Ok(number.to_string())
    }

    fn set_word(&mut self, key: &str, value: &Value<'_>) -> Result<String> {
        match key {
            "kind" => {
                self.kind = value.word(&[("fog", Kind::FibreOptic), ("mems", Kind::Mems)])?;
                self.bend_by_kind(false);
            }
            "sampling" => {
                let words = [("mean", Sampling::Mean), ("instantaneous", Sampling::Instantaneous)];
                self.params.sampling = value.word(&words)?;
            }
            "output" => {
                self.params.rounding =
                    value.word(&[("rate", Rounding::Rate), ("angle", Rounding::Angle)])?;
            }
            "fold_back" => {
                let fold_back = value.boolean()?;
                if fold_back && self.kind == Kind::Mems {
                    let reason = "only an open-loop fibre-optic gyro folds back; remove it, or \
                                  write kind = \"fog\"";
                    return Err(value.because(reason));
                }
                self.bend_by_kind(fold_back);
                return Ok(fold_back.to_string());
            }
            "noise_before_filter" => {
                self.params.response.noise_before_filter = value.boolean()?;
                return Ok(self.params.response.noise_before_filter.to_string());
            }
            SIDED => return Ok(value.integer_in(1..=2_i64)?.to_string()),
            _ => {
                let bits = value.integer_in(2..=32_u32)?;
                self.params.counts_max = i32::MAX >> (32 - bits);
                return Ok(bits.to_string());
            }
        }
        value.text().map(str::to_owned)
    }

    fn bend_by_kind(&mut self, fold_back: bool) {
        self.params.linearity.law = match self.kind {
            Kind::FibreOptic => Law::Sine { fold_back },
            Kind::Mems => Law::Cubic,
        };
    }

    /// Turns a density just read into the angle random walk, and keeps one entry of the two.
    fn density(&mut self, table: &Table<'_>) -> Result<()> {
        let (density, sided) = (table.optional(DENSITY), table.optional(SIDED));
        let Some(density) = density else {
            if let Some(sided) = sided {
                return Err(sided.because(format!("there is no `{DENSITY}` beside it; add it")));
            }
            if table.optional(WALK).is_some() {
                self.entries.retain(|entry| ![DENSITY, SIDED].contains(&entry.key));
            }
            return Ok(());
        };
        if table.optional(WALK).is_some() {
            let reason = format!("`{WALK}` says the same already; remove one of the two");
            return Err(density.because(reason));
        }
        let Some(sided) = sided else {
            let reason = format!(
                "one-sided, as data sheets mean it, or two-sided? Add {SIDED} = 1 or {SIDED} = 2"
            );
            return Err(density.because(reason));
        };
        let two = Cell::of(&sided)?.value.integer_in(1..=2_i64)? == 2;
        let sided = if two { Sided::Two } else { Sided::One };
        let walk = &mut self.params.angle_random_walk_rad_sqrt_s;
        *walk = walk_of_density(*walk, sided);
        self.entries.retain(|entry| entry.key != WALK);
        Ok(())
    }

    fn note(&mut self, key: &'static str, unit: &'static str, value: String, cell: &Cell<'_>) {
        self.entries.retain(|entry| entry.key != key);
        let (provenance, note) = (cell.provenance, cell.note.to_owned());
        self.entries.push(Entry { key, unit, value, provenance, note });
    }
}

/// A value with what is said of it.
struct Cell<'a> {
    value: Value<'a>,
    provenance: Provenance,
    note: &'a str,
}

impl<'a> Cell<'a> {
    fn of(value: &Value<'a>) -> Result<Self> {
        let Ok(table) = value.table() else {
            return Ok(Self { value: value.clone(), provenance: Provenance::Given, note: "" });
        };
        table.only(&["value", "provenance", "note"])?;
        Ok(Self {
            value: table.required("value")?,
            provenance: table.required("provenance")?.word(&PROVENANCES)?,
            note: table.optional("note").map_or(Ok(""), |note| note.text())?,
        })
    }
}

#[cfg(test)]
mod tests;
