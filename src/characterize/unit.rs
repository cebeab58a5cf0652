//! Units: those a rate can be written in, and those of data sheets.

use std::str::FromStr;
use struna_gyro::characterise::Term;
use struna_kernel::RAD_PER_DEG;

const S_PER_H: f64 = 3600.0;
const SQRT_S_PER_SQRT_H: f64 = 60.0;

/// One °/h in rad/s.
pub(crate) const DEG_H: f64 = RAD_PER_DEG / S_PER_H;

/// What a column of rates is written in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RateUnit {
    /// deg/s.
    DegS,
    /// rad/s.
    RadS,
    /// deg/h.
    DegH,
}

/// Name, endings of column names that say it, and the unit.
const UNITS: [(&str, [&str; 3], RateUnit); 3] = [
    ("deg/s", ["_deg_s", "(deg/s)", "[deg/s]"], RateUnit::DegS),
    ("rad/s", ["_rad_s", "(rad/s)", "[rad/s]"], RateUnit::RadS),
    ("deg/h", ["_deg_h", "(deg/h)", "[deg/h]"], RateUnit::DegH),
];

impl RateUnit {
    /// The unit that the name of a column says.
    #[must_use]
    pub fn of_column(name: &str) -> Option<Self> {
        let says = |(_, endings, _): &&(_, [&str; 3], _)| endings.iter().any(|e| name.ends_with(e));
        UNITS.iter().find(says).map(|(.., unit)| *unit)
    }

    /// One of it in rad/s.
    #[must_use]
    pub fn rad_s(self) -> f64 {
        match self {
            Self::DegS => RAD_PER_DEG,
            Self::RadS => 1.0,
            Self::DegH => DEG_H,
        }
    }
}

/// A unit that nobody knows.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("'{unit}' is no unit of a rate; write deg/s, rad/s or deg/h")]
pub struct UnknownUnit {
    /// What was written.
    pub unit: String,
}

impl FromStr for RateUnit {
    type Err = UnknownUnit;

    fn from_str(text: &str) -> Result<Self, UnknownUnit> {
        let unit = UNITS.iter().find(|(name, ..)| *name == text).map(|(.., unit)| *unit);
        unit.ok_or_else(|| UnknownUnit { unit: text.to_owned() })
    }
}

/// Unit of a coefficient on data sheets, its key in files, and one of it in SI.
#[must_use]
pub fn of_term(term: Term) -> (&'static str, &'static str, f64) {
    match term {
        Term::Quantisation => ("arcsec", "quantisation_arcsec", RAD_PER_DEG / S_PER_H),
        Term::AngleRandomWalk => {
            ("deg/sqrt(h)", "angle_random_walk_deg_sqrt_h", RAD_PER_DEG / SQRT_S_PER_SQRT_H)
        }
        Term::BiasInstability => ("deg/h", "bias_instability_deg_h", DEG_H),
        Term::RateRandomWalk => {
            ("deg/h/sqrt(h)", "rate_random_walk_deg_h_sqrt_h", DEG_H / SQRT_S_PER_SQRT_H)
        }
        Term::RateRamp => ("deg/h/h", "rate_ramp_deg_h_h", DEG_H / S_PER_H),
    }
}

/// A coefficient in the unit of data sheets.
pub(crate) fn on_data_sheet(term: Term, value: f64) -> f64 {
    value / of_term(term).2
}

/// A number for people, to `digits` significant ones.
pub(crate) fn significant(value: f64, digits: i32) -> String {
    if value == 0.0 || !value.is_finite() {
        return value.to_string();
    }
    let after = usize::try_from(digits - 1).unwrap_or(0);
    let scientific = format!("{value:.after$e}");
    // Of the rounded number: 99.999 to three digits is 100.
    let exponent = scientific.rsplit_once('e').and_then(|(_, exponent)| exponent.parse().ok());
    let exponent: i32 = exponent.unwrap_or(0);
    if !(-4..6).contains(&exponent) {
        return scientific;
    }
    let after = usize::try_from(digits - 1 - exponent).unwrap_or(0);
    format!("{value:.after$}")
}

/// The same without trailing zeros, for what is exact as a rule.
pub(crate) fn plain(value: f64, digits: i32) -> String {
    let text = significant(value, digits);
    if !text.contains('.') || text.contains('e') {
        return text;
    }
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_are_read_by_name_and_by_column() {
        for (name, endings, unit) in UNITS {
            assert_eq!(name.parse(), Ok(unit));
            for ending in endings {
                assert_eq!(RateUnit::of_column(&format!("measured{ending}")), Some(unit));
            }
        }
        assert_eq!(RateUnit::of_column("rate"), None);
        let error = RateUnit::from_str("mdps").unwrap_err();
        assert_eq!(error.to_string(), "'mdps' is no unit of a rate; write deg/s, rad/s or deg/h");
    }

    #[test]
    fn coefficients_are_those_of_data_sheets() {
        // An hour of 1 deg/sqrt(h) adds up to 1 deg; so does 1 deg/h.
        let hour_s = 3600.0_f64;
        let walk = of_term(Term::AngleRandomWalk).2 * hour_s.sqrt();
        assert!((walk / RAD_PER_DEG - 1.0).abs() < 1e-15);
        let rate = of_term(Term::RateRandomWalk).2 * hour_s.sqrt();
        assert!((rate / DEG_H - 1.0).abs() < 1e-15);
        let ramp = of_term(Term::RateRamp).2 * hour_s;
        assert!((ramp / DEG_H - 1.0).abs() < 1e-15);
    }

    #[test]
    fn numbers_are_shown_with_significant_digits() {
        for (value, text) in [
            (0.084_123, "0.0841"),
            (12.3456, "12.3"),
            (99.999, "100"),
            (1234.56, "1235"),
            (1.234e-7, "1.23e-7"),
            (0.0, "0"),
            (-2.345_67, "-2.35"),
        ] {
            assert_eq!(significant(value, 3), text);
        }
        let plain = [(300.0, "300"), (95.0, "95"), (99.5, "99.5"), (0.0, "0"), (1e-9, "1.00e-9")];
        for (value, text) in plain {
            assert_eq!(super::plain(value, 3), text);
        }
    }
}
