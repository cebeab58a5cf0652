//! Mean and covariance of the five states, and the two steps of the extended Kalman filter.

use super::transition::{Jacobian, Transition};
use crate::EstimatorError;
use crate::checks::in_range;
use crate::state_bytes::{Reader, RestoreError, Writer};

/// Mean of (α, ω, s, d, b).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Mean {
    /// −s·(φ − φ_eq), rad/s².
    pub(crate) alpha: f64,
    /// φ′, rad/s.
    pub(crate) rate: f64,
    /// Ω², 1/s².
    pub(crate) s: f64,
    /// 2·ζ·Ω, 1/s.
    pub(crate) d: f64,
    /// Bias of the gyro, rad/s.
    pub(crate) bias: f64,
}

impl Mean {
    pub(crate) fn entries(&self) -> [f64; 5] {
        [self.alpha, self.rate, self.s, self.d, self.bias]
    }
}

/// Covariance of (α, ω, s, d, b): the upper triangle, so that it cannot lose its symmetry.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Covariance5 {
    pub(crate) aa: f64,
    pub(crate) aw: f64,
    pub(crate) as_: f64,
    pub(crate) ad: f64,
    pub(crate) ab: f64,
    pub(crate) ww: f64,
    pub(crate) ws: f64,
    pub(crate) wd: f64,
    pub(crate) wb: f64,
    pub(crate) ss: f64,
    pub(crate) sd: f64,
    pub(crate) sb: f64,
    pub(crate) dd: f64,
    pub(crate) db: f64,
    pub(crate) bb: f64,
}

/// Mean and covariance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct State {
    pub(crate) mean: Mean,
    pub(crate) p: Covariance5,
}

/// Process noise densities.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Densities {
    /// White angular acceleration, rad²/s³.
    pub(crate) acceleration: f64,
    /// Random walk of the bias, rad²/s³.
    pub(crate) bias: f64,
}

/// What a measurement is to a state before it is taken in.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Expectation {
    /// Measured minus expected rate, rad/s.
    pub(crate) residual: f64,
    /// H·P·Hᵀ, rad²/s².
    pub(crate) spread: f64,
    /// P·Hᵀ.
    pub(super) columns: [f64; 5],
    /// Variance of the measurement's own noise, rad²/s².
    pub(super) r: f64,
}

impl State {
    /// The state with this mean and the upper triangle of this covariance.
    pub(crate) fn from_rows(mean: [f64; 5], rows: &[[f64; 5]; 5]) -> Self {
        let [alpha, rate, s, d, bias] = mean;
        let [a, w, s_row, d_row, b] = rows;
        let p = Covariance5::from_entries([
            a[0], a[1], a[2], a[3], a[4], w[1], w[2], w[3], w[4], s_row[2], s_row[3], s_row[4],
            d_row[3], d_row[4], b[4],
        ]);
        Self { mean: Mean { alpha, rate, s, d, bias }, p }
    }

    /// The state `span_s` later.
    #[inline(always)]
    pub(crate) fn predicted(&self, span_s: f64, q: Densities) -> Self {
        let Mean { alpha, rate, s, d, bias } = self.mean;
        let t = Transition::over(span_s, s, d);
        let (alpha_later, rate_later) = t.apply(alpha, rate);
        let mut p = self.p.carried(&t.jacobian(alpha, rate));
        p.aa += q.acceleration * t.noise.aa;
        p.aw += q.acceleration * t.noise.aw;
        p.ww += q.acceleration * t.noise.ww;
        p.bb += q.bias * span_s;
        Self { mean: Mean { alpha: alpha_later, rate: rate_later, s, d, bias }, p }
    }

    /// How a measured rate compares with the state, z = ω + b + noise of variance `r`.
    #[inline(always)]
    pub(super) fn expect(&self, rate_rad_s: f64, r: f64) -> Expectation {
        let p = &self.p;
        let columns = [p.aw + p.ab, p.ww + p.wb, p.ws + p.sb, p.wd + p.db, p.wb + p.bb];
        Expectation {
            residual: rate_rad_s - (self.mean.rate + self.mean.bias),
            spread: columns[1] + columns[4],
            columns,
            r,
        }
    }

    /// How the mean rate over the last `2·late_s` compares with the state: z = ω − late·ω′ + b, for
    /// a mean is the rate at the middle of its span. Of its slopes late·d and late·ω are left out.
    #[inline(always)]
    pub(super) fn expect_mean(&self, rate_rad_s: f64, r: f64, late_s: f64) -> Expectation {
        let (mean, p) = (&self.mean, &self.p);
        let Expectation { residual, columns: [a, w, s, d, b], .. } = self.expect(rate_rad_s, r);
        let columns = [
            a - late_s * p.aa,
            w - late_s * p.aw,
            s - late_s * p.as_,
            d - late_s * p.ad,
            b - late_s * p.ab,
        ];
        Expectation {
            residual: residual + late_s * (mean.alpha - mean.d * mean.rate),
            spread: columns[1] + columns[4] - late_s * columns[0],
            columns,
            r,
        }
    }

    /// Measurement update in Joseph form.
    ///
    /// P⁺ = (I − K·H)·P·(I − K·H)ᵀ + K·R·Kᵀ. With M = P − K·(P·Hᵀ)ᵀ that is
    /// M − (M·Hᵀ − R·K)·Kᵀ; the bracket is pure rounding, and subtracting it is what keeps R in
    /// the covariance when K·H is 1 to the last bit.
    ///
    /// # Source
    /// Bucy and Joseph, *Filtering for Stochastic Processes*, 1968.
    #[inline(always)]
    pub(crate) fn updated(&self, e: &Expectation, r: f64) -> Self {
        let inverse = 1.0 / (e.spread + r);
        let c = e.columns;
        let k = c.map(|column| column * inverse);
        // Each by itself: a call for all would keep the arrays in memory.
        let rounding = |i: usize| c[i] - k[i] * e.spread - r * k[i];
        let rest = [rounding(0), rounding(1), rounding(2), rounding(3), rounding(4)];
        let m = &self.mean;
        let mean = Mean {
            alpha: m.alpha + k[0] * e.residual,
            rate: m.rate + k[1] * e.residual,
            s: m.s + k[2] * e.residual,
            d: m.d + k[3] * e.residual,
            bias: m.bias + k[4] * e.residual,
        };
        let entry = |p: f64, i: usize, j: usize| p - k[i] * c[j] - rest[i] * k[j];
        let p = &self.p;
        let p = Covariance5 {
            aa: entry(p.aa, 0, 0),
            aw: entry(p.aw, 0, 1),
            as_: entry(p.as_, 0, 2),
            ad: entry(p.ad, 0, 3),
            ab: entry(p.ab, 0, 4),
            ww: entry(p.ww, 1, 1),
            ws: entry(p.ws, 1, 2),
            wd: entry(p.wd, 1, 3),
            wb: entry(p.wb, 1, 4),
            ss: entry(p.ss, 2, 2),
            sd: entry(p.sd, 2, 3),
            sb: entry(p.sb, 2, 4),
            dd: entry(p.dd, 3, 3),
            db: entry(p.db, 3, 4),
            bb: entry(p.bb, 4, 4),
        };
        Self { mean, p }
    }

    /// Itself, unless a number that [`predicted`](Self::predicted) changes has left the range of
    /// floating point.
    #[inline(always)]
    pub(crate) fn judged_as_predicted(self) -> Result<Self, EstimatorError> {
        let Mean { alpha, rate, .. } = self.mean;
        let p = &self.p;
        // The covariances of α and ω with s and d went into aa and ww, as products and sums.
        in_range(((alpha + rate) + (p.aa + p.aw)) + ((p.ww + p.ab) + (p.wb + p.bb)))?;
        Ok(self)
    }

    /// Itself, unless a number has left the range of floating point.
    #[inline(always)]
    pub(crate) fn judged(self) -> Result<Self, EstimatorError> {
        let Mean { alpha, rate, s, d, bias } = self.mean;
        // A sum is finite only if every term is.
        let sum = (alpha + rate) + (s + d) + bias + self.p.sum();
        in_range(sum)?;
        Ok(self)
    }
}

impl Covariance5 {
    /// F·P·Fᵀ. Rows s, d and b of F are those of the identity, so six entries stay.
    #[inline(always)]
    fn carried(&self, f: &Jacobian) -> Self {
        let p = self;
        let alpha =
            |a: f64, w: f64, s: f64, d: f64| (f.aa * a + f.aw * w) + (f.a_by_s * s + f.a_by_d * d);
        let rate =
            |a: f64, w: f64, s: f64, d: f64| (f.wa * a + f.ww * w) + (f.w_by_s * s + f.w_by_d * d);
        let as_ = alpha(p.as_, p.ws, p.ss, p.sd);
        let ad = alpha(p.ad, p.wd, p.sd, p.dd);
        let ab = alpha(p.ab, p.wb, p.sb, p.db);
        let ws = rate(p.as_, p.ws, p.ss, p.sd);
        let wd = rate(p.ad, p.wd, p.sd, p.dd);
        let wb = rate(p.ab, p.wb, p.sb, p.db);
        // Rows of F·P in the columns of α and ω.
        let (row_aa, row_aw) = (alpha(p.aa, p.aw, p.as_, p.ad), alpha(p.aw, p.ww, p.ws, p.wd));
        let (row_wa, row_ww) = (rate(p.aa, p.aw, p.as_, p.ad), rate(p.aw, p.ww, p.ws, p.wd));
        Self {
            aa: alpha(row_aa, row_aw, as_, ad),
            aw: rate(row_aa, row_aw, as_, ad),
            as_,
            ad,
            ab,
            ww: rate(row_wa, row_ww, ws, wd),
            ws,
            wd,
            wb,
            ..*p
        }
    }

    #[inline(always)]
    fn sum(&self) -> f64 {
        let [a, b, c, d, e, f, g, h, i, j, k, l, m, n, o] = self.entries();
        ((a + b) + (c + d)) + ((e + f) + (g + h)) + ((i + j) + (k + l)) + ((m + n) + o)
    }

    #[inline(always)]
    pub(crate) fn entries(&self) -> [f64; 15] {
        let p = self;
        [p.aa, p.aw, p.as_, p.ad, p.ab, p.ww, p.ws, p.wd, p.wb, p.ss, p.sd, p.sb, p.dd, p.db, p.bb]
    }

    pub(crate) fn rows(&self) -> [[f64; 5]; 5] {
        let p = self;
        [
            [p.aa, p.aw, p.as_, p.ad, p.ab],
            [p.aw, p.ww, p.ws, p.wd, p.wb],
            [p.as_, p.ws, p.ss, p.sd, p.sb],
            [p.ad, p.wd, p.sd, p.dd, p.db],
            [p.ab, p.wb, p.sb, p.db, p.bb],
        ]
    }

    fn from_entries(e: [f64; 15]) -> Self {
        let [aa, aw, as_, ad, ab, ww, ws, wd, wb, ss, sd, sb, dd, db, bb] = e;
        Self { aa, aw, as_, ad, ab, ww, ws, wd, wb, ss, sd, sb, dd, db, bb }
    }
}

impl State {
    /// Twenty numbers.
    pub(crate) const SAVED_LEN: usize = 20 * 8;

    pub(crate) fn write(&self, out: &mut Writer<'_>) {
        for number in self.mean.entries().into_iter().chain(self.p.entries()) {
            out.f64(number);
        }
    }

    pub(crate) fn read(bytes: &mut Reader<'_>) -> Result<Self, RestoreError> {
        let mean = Mean {
            alpha: bytes.finite("alpha")?,
            rate: bytes.finite("rate")?,
            s: bytes.finite("s")?,
            d: bytes.finite("d")?,
            bias: bytes.finite("bias")?,
        };
        let mut entries = [0.0; 15];
        for entry in &mut entries {
            *entry = bytes.finite("covariance")?;
        }
        Ok(Self { mean, p: Covariance5::from_entries(entries) })
    }
}
