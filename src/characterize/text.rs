//! What was found, for a person.

use super::Characterized;
use super::unit::{DEG_H, of_term, on_data_sheet, plain, significant};
use std::fmt::{self, Display, Formatter};
use struna_gyro::characterise::{AllanPoint, LabStatistic, MISFIT_REFUSED, Reason, Term, Verdict};
use struna_kernel::RAD_PER_DEG;

/// Rows per decade of the printed table; the JSON file has all.
const ROWS_PER_DECADE: f64 = 3.0;
/// A misfit from which on the slopes are no good description.
const MISFIT_MAX: f64 = 3.0;
/// Averages whose variance is so many times that of white noise are not white, unless there are so
/// few of them that chance does as much.
const EXCESS_MIN: f64 = 1.5;
/// Standard errors of a variance that chance is given.
const CHANCE_SIGMAS: f64 = 4.0;

impl Display for Characterized {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        self.write_record(f)?;
        self.write_curve(f)?;
        self.write_coefficients(f)?;
        self.write_overbound(f)?;
        self.write_laboratory(f)
    }
}

impl Characterized {
    fn write_record(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let (record, name) = (&self.record, self.name.escape_debug());
        let rate_hz = plain(record.sample_rate_hz(), 6);
        let samples = record.rates_rad_s().len();
        writeln!(f, "{name}: {samples} samples at {rate_hz} Hz, {}", time(record.duration_s()))?;
        if record.lost() > 0 {
            let longest_s = record.longest_stretch() as f64 / record.sample_rate_hz();
            writeln!(
                f,
                "{} samples lost in {} gaps; no average reaches over one; the longest stretch is \
                 {}",
                record.lost(),
                record.stretches().len() - 1,
                time(longest_s)
            )?;
        }
        let mean = significant(record.mean_rad_s() / DEG_H, 4);
        writeln!(f, "mean rate {mean} deg/h, taken off: bias of this run and the Earth's share")
    }

    fn write_curve(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let confidence = plain(100.0 * self.options.confidence, 3);
        let interval = format!("{confidence} % interval");
        writeln!(f, "\n{:>10}  {:>12}  {interval:>25}", "tau, s", "ADEV, deg/h")?;
        let mut next = f64::NEG_INFINITY;
        for point in &self.found.points {
            let place = ROWS_PER_DECADE * point.tau_s.log10();
            if place < next - 1e-9 {
                continue;
            }
            next = place.max(next) + if next.is_finite() { 1.0 - (place - next) } else { 1.0 };
            write_point(f, point)?;
        }
        Ok(())
    }

    fn write_coefficients(&self, f: &mut Formatter<'_>) -> fmt::Result {
        writeln!(f)?;
        if let Some(reason) = self.common_refusal() {
            return writeln!(f, "no coefficient: {reason}");
        }
        for term in Term::ALL {
            let (unit, ..) = of_term(term);
            let number = |value| significant(on_data_sheet(term, value), 3);
            write!(f, "{}  {:<19}", term.symbol(), term.name())?;
            match self.found.verdict(term) {
                Verdict::Estimated { value, interval: [low, high] } => {
                    let (low, high) = (number(low), number(high));
                    writeln!(f, "{} {unit}, between {low} and {high}", number(value))?;
                }
                Verdict::AtMost { bound, reason } => {
                    writeln!(f, "at most {} {unit}; {reason}", number(bound))?;
                }
                Verdict::Refused { reason } => writeln!(f, "no answer: {reason}")?,
            }
        }
        self.write_warnings(f)
    }

    /// Why there is no answer for any term, when it is the same for all.
    fn common_refusal(&self) -> Option<Reason> {
        let [Verdict::Refused { reason }, rest @ ..] = &self.found.verdicts else { return None };
        let same = |other: &Verdict| *other == Verdict::Refused { reason: *reason };
        rest.iter().all(same).then_some(*reason)
    }

    fn write_warnings(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let misfit = self.found.misfit;
        if (MISFIT_MAX..MISFIT_REFUSED).contains(&misfit) {
            let misfit = significant(misfit, 2);
            writeln!(
                f,
                "caution: the curve misses the fit by {misfit} times what chance explains, so the \
                 intervals above are too narrow"
            )?;
        }
        Ok(())
    }

    fn write_overbound(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let Some(model) = &self.found.overbound else { return Ok(()) };
        let terms = [Term::AngleRandomWalk, Term::BiasInstability, Term::RateRandomWalk];
        let shown = terms.map(|term| {
            let value = significant(on_data_sheet(term, model.coefficient(term)), 3);
            format!("{} = {value} {}", term.symbol(), of_term(term).0)
        });
        writeln!(f, "\nnowhere below the upper end of the intervals: {}", shown.join(", "))
    }

    fn write_laboratory(&self, f: &mut Formatter<'_>) -> fmt::Result {
        write!(f, "\nthe laboratory's statistic of 2008, sigma = (max - min)/2, in deg/s")?;
        write!(f, "\n{:>8}  {:>8}  {:>11}  {:>6}", "average", "values", "(max-min)/2", "d(n)")?;
        write!(f, "  {:>10}  {:>10}  {:>13}", "over d(n)", "std. dev.", "printed s^2")?;
        for lab in self.found.laboratory.iter().flatten() {
            write_statistic(f, lab)?;
        }
        match self.found.laboratory[1] {
            Some(lab) if lab.averaging > 1 => write_averaging(f, &lab),
            Some(_) => Ok(()),
            None => write!(f, "\nthere are no two averages of {} samples", self.options.averaging),
        }
    }
}

fn write_point(f: &mut Formatter<'_>, point: &AllanPoint) -> fmt::Result {
    let [low, high] = point.interval_rad_s.map(|end| significant(end / DEG_H, 4));
    let remark = match (point.trusted, point.filtered) {
        (_, true) => "  filtered by the gyro's band",
        (false, _) => "  few averages, not used",
        _ => "",
    };
    let (tau, adev) = (significant(point.tau_s, 4), significant(point.adev_rad_s / DEG_H, 4));
    writeln!(f, "{tau:>10}  {adev:>12}  {low:>11} - {high:>11}{remark}")
}

fn write_statistic(f: &mut Formatter<'_>, lab: &LabStatistic) -> fmt::Result {
    let deg_s = |rad_s: f64| significant(rad_s / RAD_PER_DEG, 3);
    write!(
        f,
        "\n{:>8}  {:>8}  {:>11}  {:>6.2}  {:>10}  {:>10}  {:>13}",
        lab.averaging,
        lab.averages,
        deg_s(lab.half_range_rad_s),
        lab.bias_factor,
        deg_s(lab.debiased_sigma_rad_s()),
        deg_s(lab.sigma_rad_s),
        significant(lab.printed_variance() / RAD_PER_DEG.powi(2), 3),
    )
}

/// Whether averaging did what averaging white noise does.
fn write_averaging(f: &mut Formatter<'_>, lab: &LabStatistic) -> fmt::Result {
    let (m, excess) = (lab.averaging, lab.excess_over_white());
    let correlation = lab.lag1_correlation.map_or("unknown".to_owned(), |c| {
        // Rounded first: a minus before zero says nothing.
        format!("{:.2}", (100.0 * c).round() / 100.0 + 0.0)
    });
    let chance = CHANCE_SIGMAS * (2.0 / lab.averages as f64).sqrt();
    if excess > EXCESS_MIN.max(1.0 + chance) {
        write!(
            f,
            "\naveraging {m} samples does not divide sigma by sqrt({m}): the variance is {} times \
             that of white noise (correlation of neighbours {correlation})",
            significant(excess, 3)
        )
    } else {
        write!(
            f,
            "\naveraging {m} samples divides sigma by sqrt({m}) as it does for white noise: \
             variance {excess:.2} of that (correlation of neighbours {correlation})"
        )
    }
}

/// A duration as people say it.
pub(super) fn time(s: f64) -> String {
    match s {
        s if s < 120.0 => format!("{} s", significant(s, 3)),
        s if s < 7200.0 => format!("{} min", significant(s / 60.0, 3)),
        s => format!("{} h", significant(s / 3600.0, 3)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn durations_are_said_in_the_unit_that_fits() {
        assert_eq!(
            [60.0, 100.0, 600.0, 8640.0].map(time),
            ["60.0 s", "100 s", "10.0 min", "2.40 h"]
        );
    }
}
