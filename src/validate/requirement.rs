//! Requirements, and what so many runs say of them.

use super::refinement;
use super::row::{Column, EPOCHS, Row};
use super::statistics::{
    ERROR_RATE, Measured, honest_mean_square, largest, mean, mean_count, mean_square, median,
    ratio, rms, share,
};
use std::fmt;
use std::ops::RangeInclusive;

/// What is measured over the runs of a cell. A run that stopped is infinitely wrong.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Statistic {
    /// Root mean square over runs of a column of errors.
    Rms(Column),
    /// The same over the root mean square of another column.
    RmsOver(Column, Column),
    /// The same over that of another estimator of the case, run by run on equal measurements.
    RmsAgainst(Column, &'static str),
    /// Root mean square of a column less a published one, in standard errors of that. Zero as far
    /// as the published digits go.
    RmsOff(Column, Published),
    /// Median of a column.
    Median(Column),
    /// Largest value of a column over all runs: what is promised of every run.
    Largest(Column),
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
    /// Mean count of a column in an hour.
    CountAnHour(Column),
    /// Length of the refinement, among the filters whose names begin so, at which the mean square
    /// of a column is least.
    BestRefinement(&'static str, Column),
}

/// A root mean square as it was published.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Published {
    /// The value.
    pub value: f64,
    /// Half a unit of its last digit.
    pub rounding: f64,
    /// Runs that it comes from.
    pub runs: u32,
}

impl Published {
    /// How far `found` is off in standard errors of what was published: so many runs would have,
    /// with the scatter that is found here, as soon as there are runs enough to know it by.
    /// Differences within the rounding are none.
    fn off(&self, found: &Measured) -> Option<Measured> {
        if found.value.is_infinite() {
            return Some(*found);
        }
        let half = 0.5 * (found.high - found.low);
        let runs = found.runs;
        if runs < RUNS_OF_A_SCATTER {
            let (low, high) = (f64::NEG_INFINITY, f64::INFINITY);
            return Some(Measured { value: 0.0, low, high, runs });
        }
        let error = half / HALF_WIDTH * (runs as f64 / f64::from(self.runs)).sqrt();
        let off = |at: f64| {
            let beyond = (at - self.value).abs() - self.rounding;
            beyond.max(0.0).copysign(at - self.value) / error.max(1e-9 * self.value)
        };
        let [value, low, high] = [found.value, found.low, found.high].map(off);
        Some(Measured { value, low, high, runs })
    }
}

/// Runs that a scatter is known from to a sixth of itself, 1/√(2·19).
const RUNS_OF_A_SCATTER: usize = 20;

/// Half width of an interval of many runs, standard errors.
const HALF_WIDTH: f64 = 1.96;

/// Runs for whose NEES the band of honest claims is promised.
const RUNS_OF_NEES: usize = 200;

/// Where the mean NEES of 200 honest runs on so many states lies at ten epochs together. The mean
/// of more runs must lie there, too, with its whole interval.
#[must_use]
pub fn honest_nees(states: f64) -> RangeInclusive<f64> {
    let error_rate = ERROR_RATE / EPOCHS as f64;
    let (low, high) = honest_mean_square(states, RUNS_OF_NEES, error_rate).unwrap_or((0.0, 0.0));
    low..=high
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
        range: RangeInclusive<f64>,
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
                ratio(&errors(&cell, column), &present(&cell, bound))
            }
            Statistic::RmsAgainst(column, other) => {
                ratio(&errors(&cell, column), &errors(&of(other), column))
            }
            Statistic::RmsOff(column, published) => published.off(&rms(&errors(&cell, column))?),
            Statistic::Median(column) => median(&errors(&cell, column)),
            Statistic::Largest(column) => largest(&errors(&cell, column)),
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
            Statistic::CountAnHour(column) => {
                let counts = mean_count(present(&cell, column).iter().sum(), cell.len())?;
                let duration_s = mean(&present(&cell, Column::DurationS))?.value;
                Some(counts.over(duration_s / 3600.0))
            }
            Statistic::BestRefinement(family, column) => refinement::best(&case, family, column),
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
            Self::RmsOff(column, published) => {
                write!(f, "{} less {}, in its standard errors", column.name(), published.value)
            }
            Self::Median(column) => write!(f, "median of {}", column.name()),
            Self::Largest(Column::EndSigmas) => {
                f.write_str("most sigmas off at the end of any run")
            }
            Self::Largest(Column::WorstSigmas) => f.write_str("most sigmas ever off in any run"),
            Self::Largest(column) => write!(f, "largest {}", column.name()),
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
            Self::CountAnHour(column) => write!(f, "{} an hour", column.name()),
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
}
