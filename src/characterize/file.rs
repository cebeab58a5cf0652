//! Rates from a CSV file, with what was lost between them.

use super::CharacterizeError;
use super::lines::{Lines, cells};
use super::unit::RateUnit;
use std::collections::BTreeSet;
use std::path::Path;
use struna_gyro::characterise::RateRecord;

/// Columns that are rates by their name, in the order in which they are looked for: those of
/// `struna run`, then what others call them.
const RATE_COLUMNS: [&str; 5] =
    ["measured_rate_rad_s", "rate_deg_s", "rate_rad_s", "rate_deg_h", "gyro_rate_deg_s"];
/// Columns that are times in s by their name.
const TIME_COLUMNS: [&str; 2] = ["time", "time_s"];
/// Share by which the median step of the time may differ from the sample rate given.
const RATE_SLACK: f64 = 0.05;

/// What to read of a file.
#[derive(Debug, Clone, Default)]
pub struct Columns {
    /// The rates; when not given, a column whose name says it is one.
    pub rate: Option<String>,
    /// Their unit; when not given, what the name of the column ends in.
    pub unit: Option<RateUnit>,
    /// Times in s; when not given, a column called `time`, if there is one.
    pub time: Option<String>,
    /// Numbers that grow by one from sample to sample.
    pub index: Option<String>,
    /// Samples per second; when not given, what the times say.
    pub sample_rate_hz: Option<f64>,
}

/// A file of rates.
#[derive(Debug, Clone, PartialEq)]
pub struct RateFile {
    /// What it holds.
    pub record: RateRecord,
    /// The column of rates.
    pub rate_column: String,
}

/// Reads the columns that are asked for. An empty cell or NaN in place of a rate is a lost sample.
///
/// Calls `progress` with thousandths of the file.
///
/// # Errors
/// [`CharacterizeError`] names file, line, column and value.
pub fn read(
    path: &Path,
    columns: &Columns,
    progress: &mut dyn FnMut(u64),
) -> Result<RateFile, CharacterizeError> {
    let mut lines = Lines::open(path)?;
    let layout = Layout::find(path, columns, &mut lines)?;
    if layout.time.is_none() && columns.sample_rate_hz.is_none() {
        return Err(CharacterizeError::NoSampleRate);
    }
    let mut samples = Samples::default();
    let mut row: u64 = 0;
    while lines.advance()? {
        samples.push(&layout, &lines)?;
        row += 1;
        if row.is_multiple_of(4096) {
            progress(lines.thousandths());
        }
    }
    if samples.rates_rad_s.is_empty() {
        return Err(lines.ends_without("rows of numbers"));
    }
    let record = samples.record(path, &layout, columns.sample_rate_hz)?;
    Ok(RateFile { record, rate_column: layout.names[layout.rate].clone() })
}

/// Where what is in a row.
struct Layout {
    names: Vec<String>,
    rate: usize,
    rad_s_per_unit: f64,
    time: Option<usize>,
    index: Option<usize>,
}

impl Layout {
    fn find(path: &Path, asked: &Columns, lines: &mut Lines) -> Result<Self, CharacterizeError> {
        if !lines.advance()? {
            return Err(lines.ends_without("a header"));
        }
        let names: Vec<String> = cells(lines.text()?).map(str::to_owned).collect();
        let mut seen = BTreeSet::new();
        if let Some(twice) = names.iter().find(|name| !name.is_empty() && !seen.insert(*name)) {
            let reason = format!("column '{twice}' is there twice; rename or remove one");
            return Err(lines.refuse(reason));
        }
        let present = || names.join(", ");
        let at = |column: &str| names.iter().position(|name| name == column);
        let find = |column: &String| {
            at(column).ok_or_else(|| CharacterizeError::NoColumn {
                path: path.to_owned(),
                column: column.clone(),
                present: present(),
            })
        };
        let rate = match &asked.rate {
            Some(column) => find(column)?,
            None => RATE_COLUMNS.into_iter().find_map(at).ok_or_else(|| {
                CharacterizeError::NoRateColumn { path: path.to_owned(), present: present() }
            })?,
        };
        let unit = asked.unit.or_else(|| RateUnit::of_column(&names[rate]));
        let unit = unit.ok_or_else(|| CharacterizeError::NoUnit { column: names[rate].clone() })?;
        let time = match &asked.time {
            Some(column) => Some(find(column)?),
            // An index says what was lost by itself, and better.
            None if asked.index.is_some() && asked.sample_rate_hz.is_some() => None,
            None => TIME_COLUMNS.into_iter().find_map(at),
        };
        let index = asked.index.as_ref().map(find).transpose()?;
        Ok(Self { rate, rad_s_per_unit: unit.rad_s(), time, index, names })
    }
}

/// The columns, as they were read.
#[derive(Default)]
struct Samples {
    rates_rad_s: Vec<f64>,
    times_s: Vec<f64>,
    indices: Vec<f64>,
}

impl Samples {
    fn push(&mut self, layout: &Layout, lines: &Lines) -> Result<(), CharacterizeError> {
        let text = lines.text()?;
        let (mut found, mut rate, mut time, mut index) = (0, "", "", "");
        for (at, cell) in cells(text).enumerate() {
            found += 1;
            for (place, wanted) in [
                (&mut rate, Some(layout.rate)),
                (&mut time, layout.time),
                (&mut index, layout.index),
            ] {
                if wanted == Some(at) {
                    *place = cell;
                }
            }
        }
        let due = layout.names.len();
        if found != due {
            return Err(lines.refuse(format!(
                "{found} values where the header names {due} columns; repair or remove the line"
            )));
        }
        let rate =
            if rate.is_empty() { f64::NAN } else { number(lines, layout, layout.rate, rate)? };
        self.rates_rad_s.push(rate * layout.rad_s_per_unit);
        if let Some(at) = layout.time {
            let time_s = number(lines, layout, at, time)?;
            ascending(lines, layout, at, &mut self.times_s, time_s)?;
        }
        if let Some(at) = layout.index {
            let value = number(lines, layout, at, index)?;
            if value.fract() != 0.0 {
                let name = &layout.names[at];
                return Err(lines.refuse(format!("{value} in column '{name}' is no whole number")));
            }
            ascending(lines, layout, at, &mut self.indices, value)?;
        }
        Ok(())
    }

    /// The record: what index or time say was lost is lost.
    fn record(
        self,
        path: &Path,
        layout: &Layout,
        given_hz: Option<f64>,
    ) -> Result<RateRecord, CharacterizeError> {
        let measured_hz = median_rate_hz(&self.times_s);
        if let (Some(given_hz), Some(measured_hz)) = (given_hz, measured_hz)
            && !((1.0 - RATE_SLACK)..=(1.0 + RATE_SLACK)).contains(&(measured_hz / given_hz))
        {
            let column = layout.time.map(|at| layout.names[at].clone()).unwrap_or_default();
            return Err(CharacterizeError::RatesDiffer { column, measured_hz, given_hz });
        }
        let rate_hz = given_hz.or(measured_hz).ok_or(CharacterizeError::NoSampleRate)?;
        let mut record = RateRecord::new(rate_hz).map_err(CharacterizeError::unusable(path))?;
        for (k, rate_rad_s) in self.rates_rad_s.iter().enumerate() {
            if k > 0 {
                record.lose(self.lost_before(k, rate_hz));
            }
            record.push(*rate_rad_s);
        }
        Ok(record)
    }

    fn lost_before(&self, k: usize, rate_hz: f64) -> u64 {
        let steps = match (self.indices.get(k), self.times_s.get(k)) {
            (Some(index), _) => index - self.indices[k - 1],
            (None, Some(time_s)) => ((time_s - self.times_s[k - 1]) * rate_hz).round(),
            (None, None) => 1.0,
        };
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "not negative; casts of floats saturate"
        )]
        let lost = (steps - 1.0).max(0.0) as u64;
        lost
    }
}

/// A finite number, or NaN for a rate.
fn number(lines: &Lines, layout: &Layout, at: usize, cell: &str) -> Result<f64, CharacterizeError> {
    let value = cell.parse().unwrap_or(f64::INFINITY);
    if value.is_infinite() || (value.is_nan() && at != layout.rate) {
        let name = &layout.names[at];
        return Err(lines.refuse(format!(
            "'{cell}' in column '{name}' is no finite number; repair or remove the line"
        )));
    }
    Ok(value)
}

fn ascending(
    lines: &Lines,
    layout: &Layout,
    at: usize,
    values: &mut Vec<f64>,
    value: f64,
) -> Result<(), CharacterizeError> {
    if let Some(before) = values.last().filter(|before| value <= **before) {
        let name = &layout.names[at];
        return Err(lines.refuse(format!(
            "{value} in column '{name}' is not above the {before} before it; sort or remove the \
             line"
        )));
    }
    values.push(value);
    Ok(())
}

/// Samples per second, by the median of the steps, which losses do not move.
fn median_rate_hz(times_s: &[f64]) -> Option<f64> {
    let mut steps: Vec<f64> = times_s.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let middle = steps.len().checked_sub(1)? / 2;
    let (_, median, _) = steps.select_nth_unstable_by(middle, f64::total_cmp);
    let median_s = *median;
    // A mean of the steps near the median: times are often rounded to a few digits.
    let near = |step: &&f64| (**step / median_s - 1.0).abs() < 0.5;
    let (sum, count) =
        steps.iter().filter(near).fold((0.0, 0.0), |(s, n), step| (s + step, n + 1.0));
    Some(count / sum)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read_text(text: &str, columns: &Columns) -> Result<RateFile, CharacterizeError> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("r.csv");
        std::fs::write(&path, text).unwrap();
        read(&path, columns, &mut |_| {})
    }

    fn stretches(text: &str, columns: &Columns) -> Vec<usize> {
        read_text(text, columns).unwrap().record.stretches().map(<[f64]>::len).collect()
    }

    #[test]
    fn times_tell_rate_and_losses() {
        let text = "time,rate_rad_s\n0,1\n0.01,2\n0.02,3\n0.05,4\n0.06,5\n0.0705,6\n";
        let file = read_text(text, &Columns::default()).unwrap();
        assert!((file.record.sample_rate_hz() - 100.0).abs() < 2.0);
        assert_eq!(file.record.lost(), 2);
        assert_eq!(stretches(text, &Columns::default()), [3, 3]);
        assert_eq!(file.record.rates_rad_s(), [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
    }

    #[test]
    fn an_index_tells_losses() {
        let columns = Columns {
            index: Some("n".to_owned()),
            sample_rate_hz: Some(300.0),
            ..Columns::default()
        };
        let text = "n,rate_deg_s\n7,1\n8,2\n9.0,3\n1000000000009,4\n";
        assert_eq!(stretches(text, &columns), [3, 1]);
        let file = read_text(text, &columns).unwrap();
        assert_eq!(file.record.lost(), 999_999_999_999);
        let fraction = read_text("n,rate_deg_s\n7,1\n8.5,2\n", &columns).unwrap_err();
        assert!(fraction.to_string().contains("line 3: 8.5 in column 'n'"), "{fraction}");
    }

    #[test]
    fn holes_in_the_rates_are_losses() {
        let columns = Columns { sample_rate_hz: Some(10.0), ..Columns::default() };
        let text = "rate_deg_s,x\n1,a\n,a\n2,a\nNaN,a\nnan,a\n3,a\n";
        assert_eq!(stretches(text, &columns), [1, 1, 1]);
    }

    #[test]
    fn rounded_times_give_the_mean_rate_of_a_jittering_clock() {
        let times: Vec<f64> =
            (0..1000).map(|k| (f64::from(k) / 300.0 * 1e3).round() / 1e3).collect();
        let rate_hz = median_rate_hz(&times).unwrap();
        assert!((rate_hz / 300.0 - 1.0).abs() < 1e-3, "{rate_hz}");
        assert_eq!(median_rate_hz(&[1.0]), None);
    }
}
