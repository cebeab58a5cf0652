//! Limits that parameters must keep, and what is said of one that does not.

use std::fmt;

/// A limit on a value. NaN and infinity keep none of them.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Bound {
    /// Any number, but neither infinite nor NaN.
    Finite,
    /// Strictly above.
    Above(f64),
    /// At least.
    AtLeast(f64),
    /// At most.
    AtMost(f64),
}

/// A parameter that cannot be used. The message ends in the reason, because a limit alone does not
/// teach.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error("{name} = {value} is refused: it must be {bound}, because {reason}")]
pub struct ParameterError {
    /// Which value, with its unit.
    pub name: &'static str,
    /// What it was.
    pub value: f64,
    /// What it must be.
    pub bound: Bound,
    /// Why.
    pub reason: &'static str,
}

impl Bound {
    /// Gives `value` back when it is finite and keeps the limit.
    ///
    /// ```
    /// use struna_kernel::Bound;
    ///
    /// let refused = Bound::Above(0.0).check("mass_kg", -1.0, "weight tensions the string");
    /// assert_eq!(
    ///     refused.unwrap_err().to_string(),
    ///     "mass_kg = -1 is refused: it must be finite and above 0, because weight tensions the \
    ///      string"
    /// );
    /// ```
    ///
    /// # Errors
    /// [`ParameterError`] otherwise, with the reason given.
    pub fn check(
        self,
        name: &'static str,
        value: f64,
        reason: &'static str,
    ) -> Result<f64, ParameterError> {
        if self.holds(value) {
            return Ok(value);
        }
        Err(ParameterError { name, value, bound: self, reason })
    }

    fn holds(self, value: f64) -> bool {
        value.is_finite()
            && match self {
                Self::Finite => true,
                Self::Above(limit) => value > limit,
                Self::AtLeast(limit) => value >= limit,
                Self::AtMost(limit) => value <= limit,
            }
    }
}

impl fmt::Display for Bound {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Finite => write!(f, "finite"),
            Self::Above(limit) => write!(f, "finite and above {limit}"),
            Self::AtLeast(limit) => write!(f, "finite and at least {limit}"),
            Self::AtMost(limit) => write!(f, "finite and at most {limit}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALL: [Bound; 4] =
        [Bound::Finite, Bound::Above(1.0), Bound::AtLeast(1.0), Bound::AtMost(1.0)];

    #[test]
    fn each_bound_judges_below_at_and_above_its_limit() {
        let kept = |value| ALL.map(|bound| bound.check("x", value, "").is_ok());
        assert_eq!(kept(0.0), [true, false, false, true]);
        assert_eq!(kept(1.0), [true, false, true, true]);
        assert_eq!(kept(2.0), [true, true, true, false]);
    }

    #[test]
    fn nan_and_infinity_keep_no_bound() {
        for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            assert!(ALL.iter().all(|bound| bound.check("x", value, "").is_err()), "{value}");
        }
    }

    #[test]
    fn a_bound_says_its_limit() {
        assert_eq!(
            ALL.map(|bound| bound.to_string()),
            ["finite", "finite and above 1", "finite and at least 1", "finite and at most 1"]
        );
    }
}
