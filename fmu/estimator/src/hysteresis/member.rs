//! A filter's seat in the bank: its gate, its rescue after a kick, and its likelihood.

use super::filter::DahlFilter;
use crate::augmented::windows::{GATE, GATED_VARIANCE};
use crate::state_bytes::{Reader, RestoreError, Writer};
use crate::{AugmentedFilter, Belief, EstimatorError, Innovation, RateEstimator};

/// Samples in a row beyond the gate and on one side of it that are a kick and no outliers.
const KICK_RUN: i32 = 3;

/// What the bank asks of a filter besides the common contract.
pub(super) trait Member: RateEstimator {
    /// How a measured rate compares with the belief, if a gain can be formed of that.
    fn judge(&self, rate_rad_s: f64) -> Result<Innovation, EstimatorError>;
    /// Takes a rate in with `variance_factor` times R, once the own rate has become more uncertain
    /// by `kick_variance`: all of it, or nothing.
    fn absorb(
        &mut self,
        rate_rad_s: f64,
        variance_factor: f64,
        kick_variance: f64,
    ) -> Result<(), EstimatorError>;
    /// Own part of a saved bank.
    fn write(&self, out: &mut Writer<'_>);
    /// Reads it back.
    fn read(&mut self, bytes: &mut Reader<'_>) -> Result<(), RestoreError>;
}

/// Both kinds of filter have these as methods of their own.
macro_rules! member {
    ($filter:ty) => {
        impl Member for $filter {
            #[inline]
            fn judge(&self, rate_rad_s: f64) -> Result<Innovation, EstimatorError> {
                Self::judge(self, rate_rad_s)
            }

            #[inline]
            fn absorb(
                &mut self,
                rate_rad_s: f64,
                variance_factor: f64,
                kick_variance: f64,
            ) -> Result<(), EstimatorError> {
                Self::absorb(self, rate_rad_s, variance_factor, kick_variance)
            }

            fn write(&self, out: &mut Writer<'_>) {
                Self::write(self, out);
            }

            fn read(&mut self, bytes: &mut Reader<'_>) -> Result<(), RestoreError> {
                Self::read(self, bytes)
            }
        }
    };
}

member!(AugmentedFilter);
member!(DahlFilter);

/// A member with what the bank keeps of it.
#[derive(Debug, Clone)]
pub(super) struct Seat<F> {
    pub(super) filter: F,
    /// False once the filter has refused a call that another took.
    pub(super) is_taken: bool,
    /// Logarithm of the likelihood, up to a constant common to all members.
    pub(super) log_likelihood: f64,
    /// Samples in a row beyond the gate; negative below it.
    gated_run: i32,
}

/// What a measurement was to a member.
#[derive(Debug, Clone, Copy)]
pub(super) struct Taken {
    pub(super) innovation: Innovation,
    pub(super) gated: bool,
    pub(super) struck: bool,
}

impl<F: Member> Seat<F> {
    pub(super) fn new(filter: F) -> Self {
        Self { filter, is_taken: true, log_likelihood: 0.0, gated_run: 0 }
    }

    /// Takes a measurement in.
    ///
    /// Beyond the gate it counts with a millionth of its weight, and towards the likelihood as one
    /// at the gate. Three such in a row and on one side are a kick: the rate becomes as uncertain
    /// as the kick is large, and the third is believed.
    #[inline]
    pub(super) fn update(&mut self, rate_rad_s: f64) -> Result<Taken, EstimatorError> {
        let innovation = self.filter.judge(rate_rad_s)?;
        let residual2 = innovation.residual_rad_s * innovation.residual_rad_s;
        let nis = innovation.nis();
        let gated = nis > GATE * GATE;
        let side = if innovation.residual_rad_s > 0.0 { 1 } else { -1 };
        let run = match gated {
            false => 0,
            true if self.gated_run * side > 0 => self.gated_run + side,
            true => side,
        };
        let struck = run.abs() >= KICK_RUN;
        match (gated, struck) {
            (false, _) => self.filter.absorb(rate_rad_s, 1.0, 0.0)?,
            (true, false) => self.filter.absorb(rate_rad_s, GATED_VARIANCE, 0.0)?,
            (true, true) => self.filter.absorb(rate_rad_s, 1.0, 4.0 * residual2)?,
        }
        self.gated_run = if struck { 0 } else { run };
        let surprise = libm::log(innovation.variance_rad2_s2) + nis.min(GATE * GATE);
        self.log_likelihood -= 0.5 * surprise;
        Ok(Taken { innovation, gated, struck })
    }

    pub(super) fn belief(&self) -> Option<Belief> {
        self.is_taken.then(|| self.filter.belief())
    }

    pub(super) fn saved_len(&self) -> usize {
        8 + 8 + 4 + self.filter.saved_len()
    }

    pub(super) fn write(&self, out: &mut Writer<'_>) {
        out.u64(u64::from(self.is_taken));
        out.f64(self.log_likelihood);
        out.u32(self.gated_run.cast_unsigned());
        self.filter.write(out);
    }

    pub(super) fn read(&mut self, bytes: &mut Reader<'_>) -> Result<(), RestoreError> {
        self.is_taken = bytes.u64() != 0;
        self.log_likelihood = bytes.finite("log likelihood")?;
        self.gated_run = bytes.u32().cast_signed();
        if self.gated_run.checked_abs().is_none_or(|run| run >= KICK_RUN) {
            return Err(RestoreError::Impossible);
        }
        self.filter.read(bytes)
    }
}
