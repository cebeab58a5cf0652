//! The record to be smoothed, read from its CSV file.

use super::error::SmoothingError;
use std::path::Path;
use struna_estimator::RateSample;

/// Fewest rows that a step and a noise can be told from.
const ROWS_MIN: usize = 16;
const RATE: &str = "measured_rate_rad_s";

/// A record as it came, and its truth as far as it has any.
#[derive(Debug, Clone, PartialEq)]
pub struct MeasuredRecord {
    /// End of each averaging span, s.
    pub time_s: Vec<f64>,
    /// Mean rate over it, rad/s.
    pub rate_rad_s: Vec<f64>,
    /// Whether a sample in it was over range.
    pub over_range: Vec<bool>,
    /// Columns that start with `truth.`. Scored against, and otherwise unread.
    pub truth: Vec<(String, Vec<f64>)>,
}

/// Reads a record.
///
/// # Errors
/// [`SmoothingError`] names file, line and column.
pub fn read(path: &Path) -> Result<MeasuredRecord, SmoothingError> {
    let failed = |source: csv::Error| match source.position().map(csv::Position::line) {
        Some(line) => SmoothingError::bad_line(path, line, source.to_string()),
        None => SmoothingError::Read { path: path.to_owned(), source: source.into() },
    };
    let file = std::fs::File::open(path)
        .map_err(|source| SmoothingError::Read { path: path.to_owned(), source })?;
    let mut builder = csv::ReaderBuilder::new();
    let mut reader = builder.trim(csv::Trim::All).comment(Some(b'#')).from_reader(file);
    let header = reader.headers().map_err(failed)?.clone();
    let find = |column: &str| header.iter().position(|name| name == column);
    let needed = |column: &'static str| {
        find(column).ok_or_else(|| SmoothingError::NoColumn { path: path.to_owned(), column })
    };
    let (time, rate, over_range) = (needed("time")?, needed(RATE)?, find("over_range"));
    let is_truth = |(_, name): &(usize, &str)| name.starts_with("truth.");
    let truths: Vec<(usize, &str)> = header.iter().enumerate().filter(is_truth).collect();
    let mut record = MeasuredRecord::with_truth(truths.iter().map(|(_, name)| *name));
    for row in reader.records() {
        let row = row.map_err(failed)?;
        let cell = |at: usize| number(path, &row, at, header.get(at).unwrap_or_default());
        record.time_s.push(cell(time)?);
        record.rate_rad_s.push(cell(rate)?);
        record.over_range.push(over_range.map_or(Ok(0.0), cell)? > 0.5);
        for ((at, _), (_, values)) in truths.iter().zip(&mut record.truth) {
            // NaN is what a record holds where nothing was known.
            values.push(row.get(*at).and_then(|text| text.parse().ok()).unwrap_or(f64::NAN));
        }
    }
    let rows = record.time_s.len();
    if rows < ROWS_MIN {
        return Err(SmoothingError::TooShort { path: path.to_owned(), rows, need: ROWS_MIN });
    }
    Ok(record)
}

fn number(
    path: &Path,
    row: &csv::StringRecord,
    at: usize,
    column: &str,
) -> Result<f64, SmoothingError> {
    let text = row.get(at).unwrap_or_default();
    text.parse().ok().filter(|number: &f64| number.is_finite()).ok_or_else(|| {
        let line = row.position().map_or(0, csv::Position::line);
        let reason = format!("'{text}' in column '{column}' is no finite number");
        SmoothingError::bad_line(path, line, reason)
    })
}

impl MeasuredRecord {
    fn with_truth<'a>(names: impl Iterator<Item = &'a str>) -> Self {
        Self {
            time_s: Vec::new(),
            rate_rad_s: Vec::new(),
            over_range: Vec::new(),
            truth: names.map(|name| (name.to_owned(), Vec::new())).collect(),
        }
    }

    /// The usual time from row to row, s: the median.
    #[must_use]
    pub fn step_s(&self) -> f64 {
        let mut steps: Vec<f64> = self.time_s.windows(2).map(|pair| pair[1] - pair[0]).collect();
        steps.sort_by(f64::total_cmp);
        steps.get(steps.len() / 2).copied().unwrap_or(0.0).max(0.0)
    }

    /// Time over which each rate is the mean, s: the step, or less where rows are closer.
    pub fn spans_s(&self) -> impl Iterator<Item = f64> {
        let step_s = self.step_s();
        let before = std::iter::once(f64::NEG_INFINITY).chain(self.time_s.iter().copied());
        self.time_s.iter().zip(before).map(move |(time_s, before)| step_s.min(time_s - before))
    }

    /// When the record begins, s: a step before its first row.
    #[must_use]
    pub fn start_s(&self) -> f64 {
        self.time_s.first().map_or(0.0, |first_s| first_s - self.step_s())
    }

    /// The rates, each at the middle of its span: there a mean is the rate itself, up to the span
    /// squared.
    #[must_use]
    pub fn samples(&self) -> Vec<RateSample> {
        let rows = self.time_s.iter().zip(&self.rate_rad_s).zip(&self.over_range);
        rows.zip(self.spans_s())
            .map(|(((time_s, rate_rad_s), over_range), span_s)| RateSample {
                time_s: time_s - 0.5 * span_s,
                rate_rad_s: *rate_rad_s,
                over_range: *over_range,
            })
            .collect()
    }

    /// Noise of one rate, 1 sigma in rad/s, from second differences: a motion that is smooth over
    /// three rows leaves none, and the median of their sizes does not mind kicks and outliers.
    #[must_use]
    pub fn noise_rad_s(&self) -> f64 {
        let second = |w: &[f64]| (w[2] - 2.0 * w[1] + w[0]).abs();
        let mut sizes: Vec<f64> = self.rate_rad_s.windows(3).map(second).collect();
        sizes.sort_by(f64::total_cmp);
        let median = sizes.get(sizes.len() / 2).copied().unwrap_or(0.0);
        // The median of a normal number's size is 0.6745 sigma, and 1 + 4 + 1 variances add up.
        median / (0.674_489_750_196_081_7 * 6.0_f64.sqrt())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use struna_kernel::{Channel, RandomStream, Seed};

    fn record(time_s: Vec<f64>, rate_rad_s: Vec<f64>) -> MeasuredRecord {
        let over_range = vec![false; time_s.len()];
        MeasuredRecord { time_s, rate_rad_s, over_range, truth: Vec::new() }
    }

    #[test]
    fn rates_lie_in_the_middle_of_their_spans() {
        // A row is missing after 0.03, and one is early.
        let record = record(vec![0.01, 0.02, 0.03, 0.05, 0.056, 0.066], vec![0.0; 6]);
        assert!((record.step_s() - 0.01).abs() < 1e-12);
        assert!(record.start_s().abs() < 1e-12);
        let middles = [0.005, 0.015, 0.025, 0.045, 0.053, 0.061];
        for (sample, middle) in record.samples().iter().zip(middles) {
            assert!((sample.time_s - middle).abs() < 1e-12, "{} {middle}", sample.time_s);
        }
    }

    #[test]
    fn noise_is_told_from_the_rates_themselves() {
        let mut stream = RandomStream::new(Seed(5), Channel::GyroAngleRandomWalk, 0);
        let rate = |k: u32| {
            let kick = if k > 7_000 { 1.0 } else { 0.0 };
            let outlier = if k.is_multiple_of(100) { 3.0 } else { 0.0 };
            (0.001 * f64::from(k)).sin() + kick + outlier
        };
        let noisy = (0..20_000).map(|k| rate(k) + 0.02 * stream.standard_normal()).collect();
        let record = record((0..20_000).map(f64::from).collect(), noisy);
        // 20 000 sizes know their median to 0.8 %; outliers spoil 3 % of them.
        assert!((record.noise_rad_s() / 0.02 - 1.0).abs() < 0.06, "{}", record.noise_rad_s());
    }
}
