//! Mean and covariance of fourteen states, and what two filters do with them.

use crate::augmented::history::Snapshot;
use crate::checks::in_range;
use crate::state_bytes::{Reader, RestoreError, Writer};
use crate::swing::motion::{
    MOTION_STATES, MOTION_TANGENTS, MotionParameters, MotionState, SwingMotion, Tangents,
};
use crate::{EstimatorError, SwingConfig};

/// States of the filters: six of the motion, its five parameters, and three of the gyros.
pub const SWING_STATES: usize = MOTION_TANGENTS + 3;

/// Place of the first state of the gyros.
pub(crate) const GYRO: usize = MOTION_TANGENTS;
/// Place of the rates among the states.
pub(crate) const RATES: usize = 3;
/// Place of the twist among the states.
pub(crate) const TWIST: usize = 2;

/// Numbers in a triangle of the covariance.
const TRIANGLE: usize = SWING_STATES * (SWING_STATES + 1) / 2;

/// Mean and covariance. The covariance is a full square, for the sake of its rows, and symmetric
/// to the last bit: whatever is computed is computed once and written twice.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Gaussian {
    pub(crate) mean: [f64; SWING_STATES],
    pub(crate) p: [[f64; SWING_STATES]; SWING_STATES],
}

/// A measurement's derivative by the states: zero but for the rates and the gyros' own.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Row {
    /// By the three rates.
    pub(crate) by_omega: [f64; 3],
    /// By the three states of the gyros.
    pub(crate) by_gyro: [f64; 3],
}

/// What a measurement is to a state before it is taken in.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Expectation {
    /// Measured minus expected rate, rad/s.
    pub(crate) residual: f64,
    /// H·P·Hᵀ, rad²/s².
    pub(crate) spread: f64,
    /// P·Hᵀ.
    columns: [f64; SWING_STATES],
}

/// Process noise: densities of random walks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Walks {
    /// Of the swing's rates, root density per radian of amplitude, s^(−3/2).
    swing_s_m3_2: f64,
    /// Of the rate about the body's axis, rad²/s³.
    rate_rad2_s3: f64,
    /// Of the states of the gyros, their unit squared per second.
    gyro_s: [f64; 3],
}

/// Least amplitude of the swing that the process noise reckons with: 0.1°, rad.
const AMPLITUDE_MIN_RAD: f64 = 0.1 * core::f64::consts::PI / 180.0;

impl Walks {
    pub(crate) fn new(config: &SwingConfig, gyro_s: [f64; 3]) -> Self {
        Self {
            swing_s_m3_2: config.swing_walk_s_m3_2,
            rate_rad2_s3: config.rate_walk_rad2_s3,
            gyro_s,
        }
    }

    /// Density of the walk of the swing's rates at an amplitude.
    #[inline(always)]
    fn swing_rad2_s3(&self, amplitude_rad: f64) -> f64 {
        let root = self.swing_s_m3_2 * amplitude_rad.max(AMPLITUDE_MIN_RAD);
        root * root
    }
}

impl Gaussian {
    /// Independent states.
    pub(crate) fn diagonal(mean: [f64; SWING_STATES], sigmas: [f64; SWING_STATES]) -> Self {
        let mut p = [[0.0; SWING_STATES]; SWING_STATES];
        for (i, sigma) in sigmas.into_iter().enumerate() {
            p[i][i] = sigma * sigma;
        }
        Self { mean, p }
    }

    #[inline(always)]
    pub(crate) fn motion(&self) -> MotionState {
        let [x, y, twist, p, q, r, ..] = self.mean;
        MotionState::from_entries([x, y, twist, p, q, r])
    }

    #[inline(always)]
    pub(crate) fn parameters(&self) -> MotionParameters {
        let [_, _, _, _, _, _, s, d, a, b, air, ..] = self.mean;
        MotionParameters::from_entries([s, d, a, b, air])
    }

    /// The state `span_s` later: steps of the motion, each followed by its noise.
    #[inline(always)]
    pub(crate) fn predicted(
        &self,
        motion: &SwingMotion,
        walks: &Walks,
        span_s: f64,
    ) -> Result<Self, EstimatorError> {
        let steps = motion.steps_within_limit(span_s)?;
        if span_s == 0.0 {
            return Ok(*self);
        }
        let step_s = span_s / f64::from(steps);
        let mut state = self.stepped(motion, walks, step_s)?;
        for _ in 1..steps {
            state = state.stepped(motion, walks, step_s)?;
        }
        Ok(state)
    }

    #[inline(always)]
    fn stepped(
        &self,
        motion: &SwingMotion,
        walks: &Walks,
        step_s: f64,
    ) -> Result<Self, EstimatorError> {
        let now = self.motion();
        let mut tangents = Tangents::START;
        let later = motion.step_with_tangents(&now, &self.parameters(), step_s, &mut tangents)?;
        let mut state = Self { mean: self.mean, p: carried(&self.p, &tangents) };
        state.mean[..MOTION_STATES].copy_from_slice(&later.entries());
        let swing = walks.swing_rad2_s3(motion.amplitude_rad(&now)) * step_s;
        state.p[RATES][RATES] += swing;
        state.p[RATES + 1][RATES + 1] += swing;
        state.p[RATES + 2][RATES + 2] += walks.rate_rad2_s3 * step_s;
        for (i, walk_s) in (GYRO..).zip(walks.gyro_s) {
            state.p[i][i] += walk_s * step_s;
        }
        state.judged()
    }

    /// How a residual, measured minus expected, compares with what is believed.
    #[inline(always)]
    pub(crate) fn expect(&self, residual: f64, row: &Row) -> Expectation {
        let mut columns = [0.0; SWING_STATES];
        let p = &self.p;
        let [a, b, c] = row.by_omega;
        let [d, e, f] = row.by_gyro;
        for (j, column) in columns.iter_mut().enumerate() {
            let by_omega = a * p[RATES][j] + b * p[RATES + 1][j] + c * p[RATES + 2][j];
            let by_gyro = d * p[GYRO][j] + e * p[GYRO + 1][j] + f * p[GYRO + 2][j];
            *column = by_omega + by_gyro;
        }
        Expectation { residual, spread: row.times(&columns), columns }
    }

    /// Measurement update in Joseph form.
    ///
    /// P⁺ = (I − K·H)·P·(I − K·H)ᵀ + K·R·Kᵀ. With M = P − K·(P·Hᵀ)ᵀ that is
    /// M − (M·Hᵀ − R·K)·Kᵀ; the bracket is pure rounding, and subtracting it keeps R in the
    /// covariance when K·H is 1 to the last bit.
    ///
    /// # Source
    /// Bucy and Joseph, *Filtering for Stochastic Processes*, 1968.
    #[inline(always)]
    pub(crate) fn updated(&self, e: &Expectation, r: f64) -> Self {
        let inverse = 1.0 / (e.spread + r);
        let c = &e.columns;
        let k = c.map(|column| column * inverse);
        let rest: [f64; SWING_STATES] = core::array::from_fn(|i| c[i] - k[i] * e.spread - r * k[i]);
        let mut state = *self;
        for i in 0..SWING_STATES {
            state.mean[i] += k[i] * e.residual;
            for j in 0..SWING_STATES {
                // In this order: the rest may be smaller than the rounding of the product.
                state.p[i][j] = self.p[i][j] - k[i] * c[j] - rest[i] * k[j];
            }
        }
        state.mirror();
        state
    }

    /// Writes the lower triangle over the upper one, which differs from it by rounding.
    #[inline(always)]
    fn mirror(&mut self) {
        for i in 0..SWING_STATES {
            for j in 0..i {
                self.p[j][i] = self.p[i][j];
            }
        }
    }

    /// The same variance more in each of the three rates, rad²/s².
    pub(crate) fn inflate_rates(&mut self, variance: f64) {
        for i in RATES..RATES + 3 {
            self.p[i][i] += variance;
        }
    }

    /// Itself, unless a number has left the range of floating point or the body hangs at a right
    /// angle.
    #[inline(always)]
    pub(crate) fn judged(self) -> Result<Self, EstimatorError> {
        // A sum is finite only if every term is.
        let mut sums = self.mean;
        for row in &self.p {
            for (sum, entry) in sums.iter_mut().zip(row) {
                *sum += entry;
            }
        }
        in_range(sums.iter().sum())?;
        self.motion().e3().ok_or(EstimatorError::TiltTooLarge)?;
        Ok(self)
    }
}

impl Row {
    #[inline(always)]
    fn times(&self, v: &[f64; SWING_STATES]) -> f64 {
        let [a, b, c] = self.by_omega;
        let [d, e, f] = self.by_gyro;
        (a * v[RATES] + b * v[RATES + 1] + c * v[RATES + 2])
            + (d * v[GYRO] + e * v[GYRO + 1] + f * v[GYRO + 2])
    }
}

/// F·P·Fᵀ, the first six rows of F being the tangents, the others those of the identity.
#[inline(always)]
fn carried(
    p: &[[f64; SWING_STATES]; SWING_STATES],
    tangents: &Tangents,
) -> [[f64; SWING_STATES]; SWING_STATES] {
    // Column j of the tangents as a row, so that both products run along rows.
    let mut turned = [[0.0; MOTION_STATES]; MOTION_TANGENTS];
    for (i, row) in tangents.0.iter().enumerate() {
        for (j, entry) in row.iter().enumerate() {
            turned[j][i] = *entry;
        }
    }
    let mut carried = *p;
    for (i, row) in tangents.0.iter().enumerate() {
        let mut product = [0.0; SWING_STATES];
        for (share, p) in row.iter().zip(p) {
            for (sum, p) in product.iter_mut().zip(p) {
                *sum += share * p;
            }
        }
        let mut corner = [0.0; MOTION_STATES];
        for (share, turned) in product.iter().zip(&turned) {
            for (sum, by) in corner.iter_mut().zip(turned) {
                *sum += share * by;
            }
        }
        carried[i][..=i].copy_from_slice(&corner[..=i]);
        for j in 0..i {
            carried[j][i] = corner[j];
        }
        carried[i][MOTION_STATES..].copy_from_slice(&product[MOTION_STATES..]);
        for j in MOTION_STATES..SWING_STATES {
            carried[j][i] = product[j];
        }
    }
    carried
}

impl Snapshot for Gaussian {
    const SAVED_LEN: usize = 8 * (SWING_STATES + TRIANGLE);

    fn write(&self, out: &mut Writer<'_>) {
        self.mean.iter().for_each(|number| out.f64(*number));
        for (i, row) in self.p.iter().enumerate() {
            row[..=i].iter().for_each(|number| out.f64(*number));
        }
    }

    fn read(bytes: &mut Reader<'_>) -> Result<Self, RestoreError> {
        let zeros = [0.0; SWING_STATES];
        let mut state = Self::diagonal(zeros, zeros);
        for number in &mut state.mean {
            *number = bytes.finite("mean")?;
        }
        for (i, row) in state.p.iter_mut().enumerate() {
            for number in &mut row[..=i] {
                *number = bytes.finite("covariance")?;
            }
        }
        state.mirror();
        state.motion().e3().ok_or(RestoreError::Impossible)?;
        Ok(state)
    }
}
