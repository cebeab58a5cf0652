//! Requirements, and what so many runs say of them.

use super::row::{Column, EPOCHS, Row};
use super::statistics::{ERROR_RATE, Measured, mean, mean_count, mean_square, median, rms, share};
use std::fmt;

/// What is measured over the runs of a cell. A run that stopped is infinitely wrong.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Statistic {
    /// Root mean square over runs of a column of errors.
    Rms(Column),
    /// The same over the root mean square of another column.
    RmsOver(Column, Column),
    /// The same over that of another estimator of the case, run by run on equal measurements.
    RmsAgainst(Column, &'static str),
    /// Median of a column.
    Median(Column),
    /// Mean of a column.
    Mean(Column),
    /// Mean NEES at that of ten epochs which is farthest from the number of states, with an
    /// interval for all ten together.
    Nees,
    /// Share of runs in which a column exceeds a number.
    ShareAbove(Column, f64),
    /// Share of runs that have a number in a column.
    ShareWith(Column),
    /// Share of runs at whose end the estimator says this of itself.
    ShareSaying(&'static str),
    /// Mean count of a column in a run.
    Count(Column),
    /// Length of the refinement, among the filters whose names begin so, at which the mean of a
    /// column is least. The interval spans the lengths that cannot be told from it.
    BestRefinement(&'static str, Column),
}

/// One requirement on one cell.
#[derive(Debug, Clone, PartialEq)]
pub struct Requirement {
    /// Case.
    pub case: String,
    /// Estimator; of [`Statistic::BestRefinement`], any of the family.
    pub estimator: String,
    /// What is measured.
    pub statistic: Statistic,
    /// Least value that is right.
    pub at_least: f64,
    /// Largest value that is right.
    pub at_most: f64,
    /// It must hold *because* the estimator is not up to the case: a campaign in which it fails
    /// does not measure what it should.
    pub negative_control: bool,
}

/// What is to be said of a requirement.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// The whole interval is right.
    Met,
    /// The whole interval is wrong.
    NotMet,
    /// Some of it is right.
    Undecided,
}

/// A requirement with its verdict.
#[derive(Debug, Clone, PartialEq)]
pub struct Judgement {
    /// Suite.
    pub suite: &'static str,
    /// What was required.
    pub requirement: Requirement,
    /// What was measured; none without a run.
    pub measured: Option<Measured>,
    /// What follows.
    pub verdict: Verdict,
}

impl Requirement {
    /// That a statistic of a cell lies in a range.
    #[must_use]
    pub fn new(
        (case, estimator): (&str, &str),
        statistic: Statistic,
        range: std::ops::RangeInclusive<f64>,
    ) -> Self {
        Self {
            case: case.to_owned(),
            estimator: estimator.to_owned(),
            statistic,
            at_least: *range.start(),
            at_most: *range.end(),
            negative_control: false,
        }
    }

    /// The same as a negative control.
    #[must_use]
    pub fn as_control(self) -> Self {
        Self { negative_control: true, ..self }
    }

    /// Judges by `rows` of one suite.
    #[must_use]
    pub fn judge(&self, suite: &'static str, rows: &[&Row]) -> Judgement {
        let measured = self.measure(rows);
        let verdict = measured.map_or(Verdict::Undecided, |measured| self.verdict(&measured));
        Judgement { suite, requirement: self.clone(), measured, verdict }
    }

    /// What an interval says.
    #[must_use]
    pub fn verdict(&self, measured: &Measured) -> Verdict {
        if measured.low >= self.at_least && measured.high <= self.at_most {
            Verdict::Met
        } else if measured.high < self.at_least || measured.low > self.at_most {
            Verdict::NotMet
        } else {
            Verdict::Undecided
        }
    }

    fn measure(&self, rows: &[&Row]) -> Option<Measured> {
        let case: Vec<&Row> = rows.iter().copied().filter(|row| row.case == self.case).collect();
        let of = |estimator: &str| -> Vec<&Row> {
            case.iter().copied().filter(|row| row.estimator == estimator).collect()
        };
        let cell = of(&self.estimator);
        match self.statistic {
            Statistic::Rms(column) => rms(&errors(&cell, column)),
            Statistic::RmsOver(column, bound) => {
                let bound = rms(&present(&cell, bound))?.value;
                Some(rms(&errors(&cell, column))?.over(bound))
            }
            Statistic::RmsAgainst(column, other) => {
                ratio(&errors(&cell, column), &errors(&of(other), column))
            }
            Statistic::Median(column) => median(&errors(&cell, column)),
            Statistic::Mean(column) => mean(&errors(&cell, column)),
            Statistic::Nees => nees(&cell),
            Statistic::ShareAbove(column, limit) => {
                let above = errors(&cell, column).iter().filter(|value| **value > limit).count();
                share(above, cell.len())
            }
            Statistic::ShareWith(column) => {
                let with = cell.iter().filter(|row| row.get(column).is_some()).count();
                share(with, cell.len())
            }
            Statistic::ShareSaying(word) => {
                let saying = cell.iter().filter(|row| row.status == word).count();
                share(saying, cell.len())
            }
            Statistic::Count(column) => {
                mean_count(cell.iter().filter_map(|row| row.get(column)).sum(), cell.len())
            }
            Statistic::BestRefinement(family, column) => best_refinement(&case, family, column),
        }
    }
}

/// The numbers of a column; infinite for a run that stopped, left out where it does not apply.
#[must_use]
pub fn errors(rows: &[&Row], column: Column) -> Vec<f64> {
    let of = |row: &&Row| row.get(column).or((!row.is_complete()).then_some(f64::INFINITY));
    rows.iter().filter_map(of).collect()
}

/// The numbers that there are in a column.
#[must_use]
pub fn present(rows: &[&Row], column: Column) -> Vec<f64> {
    rows.iter().filter_map(|row| row.get(column)).collect()
}

/// Ratio of two root mean squares over the same runs. Both have nearly the same scatter, and the
/// ratio hardly any when one follows the other; so its interval is that of the differences.
fn ratio(mine: &[f64], other: &[f64]) -> Option<Measured> {
    if mine.len() != other.len() {
        return None;
    }
    let n = mine.len() as f64;
    let mean_of = |values: &[f64]| values.iter().map(|v| v * v).sum::<f64>() / n;
    let squared = mean_of(mine) / mean_of(other);
    if !squared.is_finite() {
        return rms(mine).map(|m| Measured { low: 0.0, ..m });
    }
    // Delta method: var(a/b) from the residuals a - (a/b)·b of single runs.
    let residuals: Vec<f64> =
        mine.iter().zip(other).map(|(a, b)| a * a - squared * b * b).collect();
    let found = mean(&residuals)?.over(mean_of(other));
    let half = 0.5 * (found.high - found.low);
    let root = |square: f64| square.max(0.0).sqrt();
    Some(Measured {
        value: root(squared),
        low: root(squared - half),
        high: root(squared + half),
        runs: mine.len(),
    })
}

fn nees(rows: &[&Row]) -> Option<Measured> {
    let states = rows.iter().find_map(|row| row.get(Column::NeesStates))?;
    if let Some(stopped) = rows.iter().position(|row| !row.is_complete()) {
        let infinite = f64::INFINITY;
        return Some(Measured { value: infinite, low: infinite, high: infinite, runs: stopped });
    }
    let epoch = |at: usize| {
        let of = rows.iter().map(|row| row.epochs[at].nees).filter(|nees| !nees.is_nan());
        mean_square(&of.collect::<Vec<_>>(), states, ERROR_RATE / EPOCHS as f64)
    };
    let epochs: Vec<Measured> = (0..EPOCHS).filter_map(epoch).collect();
    let far = |epoch: &Measured| (epoch.value / states).ln().abs();
    let worst = epochs.iter().max_by(|a, b| far(a).total_cmp(&far(b)))?;
    let low = epochs.iter().map(|epoch| epoch.low).fold(f64::INFINITY, f64::min);
    let high = epochs.iter().map(|epoch| epoch.high).fold(0.0, f64::max);
    Some(Measured { low, high, ..*worst })
}

fn best_refinement(rows: &[&Row], family: &str, column: Column) -> Option<Measured> {
    let mut lengths: Vec<f64> = rows
        .iter()
        .filter(|row| row.estimator.starts_with(family))
        .filter_map(|row| row.get(Column::RefinementSamples))
        .collect();
    lengths.sort_by(f64::total_cmp);
    lengths.dedup();
    let of = |length: &f64| {
        let cell: Vec<&Row> = rows
            .iter()
            .copied()
            .filter(|row| row.estimator.starts_with(family))
            .filter(|row| row.get(Column::RefinementSamples) == Some(*length))
            .collect();
        mean(&errors(&cell, column))
    };
    let found: Vec<(f64, Measured)> =
        lengths.iter().filter_map(|length| Some((*length, of(length)?))).collect();
    let (value, least) = found.iter().min_by(|a, b| a.1.value.total_cmp(&b.1.value))?;
    let alike = || found.iter().filter(|(_, measured)| measured.low <= least.high);
    let low = alike().map(|(length, _)| *length).fold(f64::INFINITY, f64::min);
    let high = alike().map(|(length, _)| *length).fold(0.0, f64::max);
    Some(Measured { value: *value, low, high, runs: least.runs })
}

impl Verdict {
    /// In tables.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Met => "met",
            Self::NotMet => "NOT MET",
            Self::Undecided => "not decided",
        }
    }
}

impl fmt::Display for Statistic {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Rms(column) => write!(f, "RMS of {}", column.name()),
            Self::RmsOver(column, _) => write!(f, "{} over its bound", column.name()),
            Self::RmsAgainst(column, other) => write!(f, "{} over that of {other}", column.name()),
            Self::Median(column) => write!(f, "median of {}", column.name()),
            Self::Mean(column) => write!(f, "mean of {}", column.name()),
            Self::Nees => f.write_str("NEES, worst of ten epochs"),
            Self::ShareAbove(Column::EndSigmas, limit) => {
                write!(f, "share ending beyond {limit} sigma")
            }
            Self::ShareAbove(Column::WorstSigmas, limit) => {
                write!(f, "share ever beyond {limit} sigma")
            }
            Self::ShareAbove(column, limit) => write!(f, "share with {} > {limit}", column.name()),
            Self::ShareWith(Column::DelayS) => f.write_str("share of kicks found"),
            Self::ShareWith(column) => write!(f, "share with {}", column.name()),
            Self::ShareSaying(word) => write!(f, "share that says \"{word}\" at the end"),
            Self::Count(column) => write!(f, "{} a run", column.name()),
            Self::BestRefinement(family, column) => {
                write!(f, "N of {family} at the least {}", column.name())
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn requirement(at_least: f64, at_most: f64) -> Requirement {
        Requirement::new(("case", "filter"), Statistic::Nees, at_least..=at_most)
    }

    #[test]
    fn a_verdict_needs_the_whole_interval() {
        let required = requirement(0.8, 1.15);
        let of = |low, high| {
            required.verdict(&Measured { value: 0.5 * (low + high), low, high, runs: 1 })
        };
        assert_eq!(of(0.8, 1.15), Verdict::Met);
        assert_eq!(of(0.79, 1.0), Verdict::Undecided);
        assert_eq!(of(0.9, 1.2), Verdict::Undecided);
        assert_eq!(of(0.5, 2.0), Verdict::Undecided);
        assert_eq!(of(0.5, 0.79), Verdict::NotMet);
        assert_eq!(of(1.16, f64::INFINITY), Verdict::NotMet);
        assert_eq!(of(f64::INFINITY, f64::INFINITY), Verdict::NotMet);
    }

    #[test]
    fn a_ratio_of_errors_that_go_together_is_known_well() {
        let other: Vec<f64> = (1..=20).map(f64::from).collect();
        let mine: Vec<f64> = other.iter().map(|v| 0.9 * v).collect();
        let found = ratio(&mine, &other).unwrap();
        assert!((found.value - 0.9).abs() < 1e-12 && found.high - found.low < 1e-6, "{found:?}");
        let shuffled: Vec<f64> = mine.iter().rev().copied().collect();
        let found = ratio(&shuffled, &other).unwrap();
        assert!(found.high - found.low > 0.3, "{found:?}");
    }
}
