//! The averaging times at which a record is looked at.

/// How densely averaging times are laid, each a whole number of samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum TauGrid {
    /// Ten in each decade, as evenly on a logarithmic axis as whole samples can be.
    #[default]
    TenPerDecade,
    /// Powers of two.
    Octave,
    /// 1, 2 and 4 in each decade.
    Decade,
}

impl TauGrid {
    /// Averaging times of 1 to `most` samples, ascending.
    #[must_use]
    pub fn factors(self, most: usize) -> Vec<usize> {
        let mut factors: Vec<usize> = match self {
            Self::TenPerDecade => up_to(most, |k| 10.0_f64.powf(f64::from(k) / 10.0).round()),
            Self::Octave => up_to(most, |k| 2.0_f64.powi(k)),
            Self::Decade => up_to(most, |k| 2.0_f64.powi(k % 3) * 10.0_f64.powi(k / 3)),
        };
        factors.dedup();
        factors
    }
}

fn up_to(most: usize, factor: impl Fn(i32) -> f64) -> Vec<usize> {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "whole, at least one, and below `most`"
    )]
    let factors = (0..).map(factor).take_while(|f| *f <= most as f64).map(|f| f as usize);
    factors.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ten_per_decade_are_ten_where_whole_samples_allow_it() {
        let factors = TauGrid::TenPerDecade.factors(1000);
        assert_eq!(factors[..9], [1, 2, 3, 4, 5, 6, 8, 10, 13]);
        let decade = factors.iter().filter(|factor| (100..1000).contains(*factor));
        assert_eq!(decade.count(), 10);
        assert_eq!(factors.last(), Some(&1000));
    }

    #[test]
    fn octaves_and_decades_are_those_of_the_field() {
        assert_eq!(TauGrid::Octave.factors(20), [1, 2, 4, 8, 16]);
        assert_eq!(TauGrid::Decade.factors(450), [1, 2, 4, 10, 20, 40, 100, 200, 400]);
    }

    #[test]
    fn an_empty_record_has_no_averaging_times() {
        assert!(TauGrid::TenPerDecade.factors(0).is_empty());
        assert!(TauGrid::Octave.factors(0).is_empty());
    }
}
