//! What a fit comes to.

use crate::swing::SwingBelief;

/// State and covariance of the swinging body at the end of the window of an accepted fit.
#[derive(Debug, Clone, PartialEq)]
pub struct AcceptedFit {
    /// Samples from the first one pushed to the last one of the window, missing ones included. The
    /// state is that at the last one.
    pub samples: u64,
    /// Mean and covariance at the end of the window, for [`SwingFilter`](crate::SwingFilter) to
    /// go on from. The covariance is symmetric to the bit.
    pub belief: SwingBelief,
    /// Cost per sample of the window; one when all is as assumed.
    pub cost_per_sample: f64,
    /// Largest mean of what is left over 8 to 1024 samples, standard deviations.
    pub leftover_mean: f64,
    /// Largest excess of the mean square of what is left in 5 s over R, standard deviations.
    pub leftover_square: f64,
    /// Largest angle of the body's axis from the vertical within the window, rad.
    pub amplitude_rad: f64,
    /// Distinct valleys of the cost that were left at the end, this one included.
    pub modes: usize,
    /// How many windows were given up before this one.
    pub restarts: u32,
    /// Whether the window needed the denser set of starts.
    pub dense: bool,
}

/// Why a window's fit was not taken.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Rejection {
    /// The misalignment is less than three standard deviations of its calibration: what leaks of
    /// the swing has no known size.
    #[error("misalignment {tilt_rad} rad is not known better than ±{tilt_sigma_rad} rad")]
    NotObservable {
        /** Believed misalignment, rad. */
        tilt_rad: f64,
        /** Its standard deviation per axis, rad. */
        tilt_sigma_rad: f64,
    },
    /// The record ended before the window did.
    #[error("a record of {have} samples is too short, {need} are needed")]
    TooShort {
        /** Samples there are. */
        have: u64,
        /** Samples that complete the next window. */
        need: u64,
    },
    /// More than a tenth of the window's samples are missing.
    #[error("{missing} samples of the window are missing")]
    TooManyMissing {
        /** How many. */
        missing: usize,
    },
    /// No start led to a motion that the body can have.
    #[error("no motion of the body fits")]
    NoMotion,
    /// The best fit leaves too much: a wrong valley, a kick, or a body unlike the believed one.
    #[error("a cost of {cost_per_sample} per sample is too high")]
    Cost {
        /** Cost per sample of the best fit. */
        cost_per_sample: f64,
    },
    /// What the best fit leaves is not noise.
    #[error("what is left has a mean of {mean} and a mean square of {square} sigmas")]
    Leftover {
        /** Largest mean over 8 to 1024 samples, standard deviations. */
        mean: f64,
        /** Largest excess of the mean square of 5 s, standard deviations. */
        square: f64,
    },
    /// Two motions with different twists fit about equally well.
    #[error("another motion, {apart_rad} rad apart in twist, fits as well to within {cost}")]
    Ambiguous {
        /** Difference of the twists at the end of the window, rad. */
        apart_rad: f64,
        /** Difference of the costs. */
        cost: f64,
    },
    /// More samples came than could be kept while the fit was given too little work.
    #[error("the fit was given too little work and ran out of memory for samples")]
    Starved,
}

/// How far a fit is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Progress {
    /// There is more to do with the samples there are.
    Working,
    /// Nothing can be done before more samples come.
    NeedsSamples,
    /// A fit is accepted, or there will never be one.
    Done,
}

/// What a fit has come to so far.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum FitOutcome<'a> {
    /// No fit is accepted yet.
    Pending {
        /// Why the last window was given up; none when none was.
        rejected: Option<Rejection>,
    },
    /// A fit passed all tests.
    Accepted(&'a AcceptedFit),
    /// There will be none, whatever comes.
    Refused(Rejection),
}
