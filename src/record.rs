//! The record of a run: named columns over time. Score and figure read nothing else.

use std::io::{self, Write};
use struna_kernel::{AngleEstimate, RateOf, RateSample};

/// Columns of equal length; the first is `time`, s. Names carry units.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Record {
    columns: Vec<Column>,
}

/// One quantity over time.
#[derive(Debug, Clone, PartialEq)]
pub struct Column {
    /// Its name, unit suffix included.
    pub name: String,
    /// Its values, one for each row.
    pub values: Vec<f64>,
}

impl Record {
    /// A record with these columns and no rows.
    #[must_use]
    pub fn with_columns(names: impl IntoIterator<Item = String>) -> Self {
        let column = |name| Column { name, values: Vec::new() };
        Self { columns: names.into_iter().map(column).collect() }
    }

    /// Adds a row.
    ///
    /// # Panics
    /// When the row does not have one value for each column.
    pub fn push(&mut self, row: &[f64]) {
        assert_eq!(row.len(), self.columns.len(), "one value for each column");
        for (column, value) in self.columns.iter_mut().zip(row) {
            column.values.push(*value);
        }
    }

    /// How many rows there are.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.columns.first().map_or(0, |column| column.values.len())
    }

    /// The values of the column called `name`.
    #[must_use]
    pub fn column(&self, name: &str) -> Option<&[f64]> {
        let column = self.columns.iter().find(|column| column.name == name)?;
        Some(&column.values)
    }

    /// Names of the estimators in the record, in column order.
    pub fn estimators(&self) -> impl Iterator<Item = &str> {
        self.columns.iter().filter_map(|column| column.name.strip_suffix(".angle_rad"))
    }

    /// What the rate of the estimator called `name` is the rate of; none where the record says
    /// what this program does not know.
    ///
    /// A record without that column was judged by the rate about the body's axis, and is.
    #[must_use]
    pub fn rate_of(&self, name: &str) -> Option<RateOf> {
        let first = self.column(&format!("{name}.{RATE_OF}")).and_then(<[f64]>::first);
        let Some(number) = first else { return Some(RateOf::BodyAxis) };
        [RateOf::BodyAxis, RateOf::Twist]
            .into_iter()
            .find(|of| f64::from(of.code()).total_cmp(number).is_eq())
    }

    /// The true rate that an estimator's is judged by, and which one that is.
    ///
    /// A recording knows of no twist: there the body's rate stands for it, as the integral of that
    /// rate does for the angle.
    #[must_use]
    pub fn true_rate(&self, of: RateOf) -> Option<(RateOf, &[f64])> {
        let body_axis = || Some((RateOf::BodyAxis, self.column(TRUE_BODY_RATE)?));
        match (of, self.column(TRUE_TWIST_RATE)) {
            (RateOf::Twist, Some(twist)) => Some((RateOf::Twist, twist)),
            _ => body_axis(),
        }
    }

    /// Writes CSV in FMPy's layout: quoted names, `"time"` first, and numbers in the shortest form
    /// that reads back to the same bits.
    ///
    /// # Errors
    /// What `out` says.
    pub fn write_csv(&self, out: &mut dyn Write) -> io::Result<()> {
        write_csv_names(self.columns.iter().map(|column| column.name.as_str()), out)?;
        (0..self.rows()).try_for_each(|row| {
            write_csv_row(self.columns.iter().map(|column| column.values[row]), out)
        })
    }
}

/// True rate about the body's axis relative to the room.
pub const TRUE_BODY_RATE: &str = "truth.body_rate_rad_s";
/// True rate of the twist of the string.
pub const TRUE_TWIST_RATE: &str = "truth.twist_rate_rad_s";
/// What every record holds of a sample.
const MEASURED_SIGNALS: [&str; 4] = ["time", "measured_rate_rad_s", "over_range", "lost_before"];
/// And what it holds besides when the line carries three rates.
const CROSS_SIGNALS: [&str; 2] = ["measured_rate_x_rad_s", "measured_rate_y_rad_s"];

/// Names of the first columns of a record; `has_cross` when the line carries three rates.
#[must_use]
pub fn measured_signals(has_cross: bool) -> Vec<String> {
    let cross = CROSS_SIGNALS.iter().filter(|_| has_cross);
    MEASURED_SIGNALS.iter().chain(cross).map(|name| (*name).to_owned()).collect()
}

/// The values of these columns.
pub fn measured_values(of: &RateSample, has_cross: bool) -> impl Iterator<Item = f64> {
    let over_range = f64::from(u8::from(of.over_range));
    let main = [of.time.as_s(), of.rate_rad_s, over_range, of.lost_before as f64];
    let cross = has_cross.then(|| of.cross_rates_rad_s.unwrap_or([f64::NAN; 2]));
    main.into_iter().chain(cross.into_iter().flatten())
}

/// Names of the signals that each estimator has in a record.
pub const ESTIMATOR_SIGNALS: [&str; 7] =
    ["angle_rad", "rate_rad_s", "angle_sigma_rad", "rate_sigma_rad_s", "nis", "status", RATE_OF];
/// The signal that says which rate an estimator tells.
const RATE_OF: &str = "rate_of";

/// The values of these signals.
#[must_use]
pub fn estimator_values(of: &AngleEstimate) -> [f64; ESTIMATOR_SIGNALS.len()] {
    let AngleEstimate { angle_rad, rate_rad_s, angle_sigma_rad, rate_sigma_rad_s, nis, .. } = *of;
    let codes = [of.status.code(), of.rate_of.code()].map(f64::from);
    [angle_rad, rate_rad_s, angle_sigma_rad, rate_sigma_rad_s, nis, codes[0], codes[1]]
}

/// The first line of a record.
///
/// # Errors
/// What `out` says.
pub fn write_csv_names<'a>(
    names: impl IntoIterator<Item = &'a str>,
    out: &mut dyn Write,
) -> io::Result<()> {
    for (k, name) in names.into_iter().enumerate() {
        write!(out, "{}\"{name}\"", if k == 0 { "" } else { "," })?;
    }
    writeln!(out)
}

/// Any other line of a record.
///
/// # Errors
/// What `out` says.
pub fn write_csv_row(values: impl IntoIterator<Item = f64>, out: &mut dyn Write) -> io::Result<()> {
    for (k, value) in values.into_iter().enumerate() {
        write!(out, "{}{value:?}", if k == 0 { "" } else { "," })?;
    }
    writeln!(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn csv_numbers_read_back_to_the_same_bits() {
        let values = [0.1, 1.0 / 3.0, 1e-300, -0.0, 5e-324, 1.0];
        let mut record = Record::with_columns(["time".to_owned(), "a.angle_rad".to_owned()]);
        for value in values {
            record.push(&[0.0, value]);
        }
        let mut csv = Vec::new();
        record.write_csv(&mut csv).unwrap();
        let text = String::from_utf8(csv).unwrap();
        assert_eq!(text.lines().next(), Some("\"time\",\"a.angle_rad\""));
        for (line, value) in text.lines().skip(1).zip(values) {
            let read: f64 = line.split(',').nth(1).unwrap().parse().unwrap();
            assert_eq!(read.to_bits(), value.to_bits());
        }
        assert_eq!(record.estimators().collect::<Vec<_>>(), ["a"]);
    }
}
