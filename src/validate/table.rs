//! Rows as CSV, verdicts as text.

use super::requirement::{Judgement, Verdict};
use super::row::{Column, EPOCHS, Outcome, Row};
use super::statistics::Measured;
use std::io::{self, Write};

/// Name of a column that is text.
pub const TEXTS: [&str; 7] = ["suite", "case", "estimator", "run", "seed", "outcome", "status"];

/// Names of the columns of the epochs: error, claim and NEES at each.
#[must_use]
pub fn epoch_names() -> Vec<String> {
    let of =
        |at: usize| ["error_deg", "sigma_deg", "nees"].map(|what| format!("epoch_{at:02}_{what}"));
    (1..=EPOCHS).flat_map(of).collect()
}

/// Numbers of a row in the order of [`Column::ALL`] and [`epoch_names`]; none where not a number.
pub fn numbers(row: &Row) -> impl Iterator<Item = Option<f64>> {
    let epochs = row.epochs.iter().flat_map(|epoch| [epoch.error_deg, epoch.sigma_deg, epoch.nees]);
    let epochs = epochs.map(|value| Some(value).filter(|value| !value.is_nan()));
    Column::ALL.iter().map(|column| row.get(*column)).chain(epochs)
}

/// How the run ended, in words.
#[must_use]
pub fn outcome(row: &Row) -> &str {
    match &row.outcome {
        Outcome::Complete => "complete",
        Outcome::Stopped(reason) => reason,
    }
}

/// Writes `rows` as CSV. Numbers are the shortest that read back to the same bits.
///
/// # Errors
/// Those of `out`.
pub fn write_csv(rows: &[Row], out: &mut dyn Write) -> io::Result<()> {
    let mut csv = csv::Writer::from_writer(out);
    let names = Column::ALL.iter().map(|column| column.name().to_owned());
    let texts = TEXTS.map(str::to_owned).into_iter();
    csv.write_record(texts.chain(names).chain(epoch_names()))?;
    for row in rows {
        let texts = [
            row.suite.to_owned(),
            row.case.clone(),
            row.estimator.clone(),
            row.run.to_string(),
            row.seed.to_string(),
            outcome(row).to_owned(),
            row.status.to_owned(),
        ];
        let cell = |value: Option<f64>| value.map_or_else(String::new, |value| value.to_string());
        csv.write_record(texts.into_iter().chain(numbers(row).map(cell)))?;
    }
    csv.flush()
}

/// A number for people: three digits.
#[must_use]
pub fn short(value: f64) -> String {
    match value.abs() {
        _ if value.is_infinite() => if value > 0.0 { "inf" } else { "-inf" }.to_owned(),
        0.0 => "0".to_owned(),
        size if !(1e-3..1e5).contains(&size) => format!("{value:.2e}"),
        size if size >= 99.95 => format!("{value:.0}"),
        size if size >= 9.995 => format!("{value:.1}"),
        size if size >= 0.9995 => format!("{value:.2}"),
        size if size >= 0.09995 => format!("{value:.3}"),
        _ => format!("{value:.4}"),
    }
}

/// A value with its interval.
#[must_use]
pub fn with_interval(measured: &Measured) -> String {
    let Measured { value, low, high, .. } = *measured;
    format!("{} [{}, {}]", short(value), short(low), short(high))
}

/// The range that is right.
#[must_use]
pub fn range(judgement: &Judgement) -> String {
    let required = &judgement.requirement;
    match (required.at_least, required.at_most) {
        (low, high) if high.is_infinite() => format!(">= {}", short(low)),
        (low, high) if low < 0.0 => format!("{} to {}", short(low), short(high)),
        (low, high) if low <= 0.0 => format!("<= {}", short(high)),
        (low, high) => format!("{} to {}", short(low), short(high)),
    }
}

/// The cells of a verdict's line: case, estimator, what, measured, required, verdict.
#[must_use]
pub fn cells(judgement: &Judgement) -> [String; 6] {
    let required = &judgement.requirement;
    let control = if required.negative_control { " (control)" } else { "" };
    [
        required.case.clone(),
        required.estimator.clone(),
        format!("{}{control}", required.statistic),
        judgement.measured.as_ref().map_or_else(|| "no run".to_owned(), with_interval),
        range(judgement),
        judgement.verdict.name().to_owned(),
    ]
}

/// How many verdicts are met, not met, not decided.
#[must_use]
pub fn counts(judgements: &[Judgement]) -> [usize; 3] {
    [Verdict::Met, Verdict::NotMet, Verdict::Undecided]
        .map(|verdict| judgements.iter().filter(|judged| judged.verdict == verdict).count())
}

/// What the counts come to, in a sentence.
#[must_use]
pub fn sentence(judgements: &[Judgement]) -> String {
    let [met, not_met, undecided] = counts(judgements);
    format!(
        "{} requirements: {met} met, {not_met} not met, {undecided} not decided by so many runs",
        judgements.len()
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_for_people_have_three_digits() {
        let cases = [
            (0.0, "0"),
            (1234.4, "1234"),
            (12.34, "12.3"),
            (1.234, "1.23"),
            (0.9999, "1.00"),
            (0.1234, "0.123"),
            (0.012_34, "0.0123"),
            (1.2e-5, "1.20e-5"),
            (f64::INFINITY, "inf"),
        ];
        for (value, expected) in cases {
            assert_eq!(short(value), expected);
        }
    }
}
