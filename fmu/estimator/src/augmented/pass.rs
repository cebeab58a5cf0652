//! The tested filter's pass over a record, with its second thoughts, as a smoother needs it.

use super::filter::AugmentedFilter;
use super::state::{Covariance5, Mean, State};
use super::tested::TestedFilter;
use super::transition::Transition;
use crate::state_bytes::{Reader, RestoreError, Writer};

/// The state after a sample, and how it came there from the sample before.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Trace {
    state: State,
    /// Seconds since the sample before.
    pub(crate) span_s: f64,
    /// Variance of the rate that was added on the way because of a kick, rad²/s².
    kick_variance: f64,
}

/// One step of the model: what was believed before it, what was expected after it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Link {
    pub(crate) mean: [f64; 5],
    pub(crate) covariance: [[f64; 5]; 5],
    pub(crate) mean_later: [f64; 5],
    pub(crate) covariance_later: [[f64; 5]; 5],
    /// Derivative of the later mean by the earlier one.
    pub(crate) transition: [[f64; 5]; 5],
    /// What the step adds to the covariance.
    pub(crate) noise: [[f64; 5]; 5],
}

/// Within which the filter keeps the parameters, (least, largest).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Bounds {
    /// Of Ω², 1/s².
    pub(crate) s: (f64, f64),
    /// Of 2ζΩ, 1/s.
    pub(crate) d: (f64, f64),
}

impl Bounds {
    pub(crate) fn hold(&self, s: f64, d: f64) -> bool {
        let within = |x: f64, (low, high): (f64, f64)| low <= x && x <= high;
        within(s, self.s) && within(d, self.d)
    }
}

impl Trace {
    pub(crate) const SAVED_LEN: usize = State::SAVED_LEN + 16;

    pub(crate) fn mean(&self) -> [f64; 5] {
        self.state.mean.entries()
    }

    pub(crate) fn covariance(&self) -> [[f64; 5]; 5] {
        self.state.p.rows()
    }

    /// The same step with another state at its end. Of the covariance the upper triangle counts.
    pub(crate) fn with(&self, mean: [f64; 5], rows: &[[f64; 5]; 5]) -> Self {
        let [alpha, rate, s, d, bias] = mean;
        let [a, w, s_row, d_row, b] = rows;
        let p = Covariance5 {
            aa: a[0],
            aw: a[1],
            as_: a[2],
            ad: a[3],
            ab: a[4],
            ww: w[1],
            ws: w[2],
            wd: w[3],
            wb: w[4],
            ss: s_row[2],
            sd: s_row[3],
            sb: s_row[4],
            dd: d_row[3],
            db: d_row[4],
            bb: b[4],
        };
        Self { state: State { mean: Mean { alpha, rate, s, d, bias }, p }, ..*self }
    }

    /// Whether every number of the state is one, and no variance negative.
    pub(crate) fn is_sound(&self) -> bool {
        let p = &self.state.p;
        let least = [p.aa, p.ww, p.ss, p.dd, p.bb].into_iter().fold(f64::INFINITY, f64::min);
        self.state.judged().is_ok() && least >= 0.0
    }

    pub(crate) fn write(&self, out: &mut Writer<'_>) {
        self.state.write(out);
        out.f64(self.span_s);
        out.f64(self.kick_variance);
    }

    pub(crate) fn read(bytes: &mut Reader<'_>) -> Result<Self, RestoreError> {
        let state = State::read(bytes)?;
        let span_s = bytes.finite("span_s")?;
        let kick_variance = bytes.finite("kick variance")?;
        if span_s < 0.0 || kick_variance < 0.0 {
            return Err(RestoreError::Impossible);
        }
        Ok(Self { state, span_s, kick_variance })
    }
}

impl TestedFilter {
    /// Where the filter stands, `span_s` after the sample before.
    pub(crate) fn trace(&self, span_s: f64) -> Trace {
        Trace { state: self.filter.state, span_s, kick_variance: 0.0 }
    }

    /// The samples that the last alarm made the filter run again, oldest first, from the trace
    /// before the first of them.
    pub(crate) fn retrace(&self, from: &Trace, mut each: impl FnMut(Trace)) {
        // A re-run that fails was given up by the filter too, and then has no samples.
        let Ok(kick_variance) = self.inflation() else { return };
        let _ = self.rerun(from.state, |sample, state| {
            each(Trace { state: *state, span_s: sample.span_s, kick_variance });
        });
    }

    /// Measured minus expected rates of those samples, had nothing struck the body since `from`;
    /// none for samples over range.
    pub(crate) fn free_residuals(&self, from: &Trace, mut each: impl FnMut(Option<f64>)) {
        let mut state = from.state;
        let count = self.last_alarm().map_or(0, |alarm| alarm.rerun_samples);
        for sample in self.history.latest(u64::from(count)) {
            if let Ok(predicted) = self.filter.model.predicted(&state, sample.span_s) {
                state = predicted;
            }
            each(sample.rate_rad_s.map(|rate| self.filter.model.expected(&state, rate).residual));
        }
    }
}

impl AugmentedFilter {
    /// The same filter, standing where the trace ends.
    pub(crate) fn standing_at(&self, trace: &Trace) -> Self {
        Self { model: self.model, state: self.model.bounded(trace.state) }
    }

    pub(crate) fn bounds(&self) -> Bounds {
        Bounds { s: self.model.s_bounds, d: self.model.d_bounds }
    }

    /// The model's step from the end of one trace to before the measurement of the next.
    pub(crate) fn link(&self, from: &Trace, to: &Trace) -> Link {
        let q = self.model.densities();
        let State { mean, p } = from.state;
        let mut later = from.state.predicted(to.span_s, q);
        later.p.ww += to.kick_variance;
        let t = Transition::over(to.span_s, mean.s, mean.d);
        let j = t.jacobian(mean.alpha, mean.rate);
        let (aw, aa) = (q.acceleration * t.noise.aw, q.acceleration * t.noise.aa);
        let ww = q.acceleration * t.noise.ww + to.kick_variance;
        let none = [0.0; 5];
        Link {
            mean: mean.entries(),
            covariance: p.rows(),
            mean_later: later.mean.entries(),
            covariance_later: later.p.rows(),
            transition: [
                [j.aa, j.aw, j.a_by_s, j.a_by_d, 0.0],
                [j.wa, j.ww, j.w_by_s, j.w_by_d, 0.0],
                [0.0, 0.0, 1.0, 0.0, 0.0],
                [0.0, 0.0, 0.0, 1.0, 0.0],
                [0.0, 0.0, 0.0, 0.0, 1.0],
            ],
            noise: [
                [aa, aw, 0.0, 0.0, 0.0],
                [aw, ww, 0.0, 0.0, 0.0],
                none,
                none,
                [0.0, 0.0, 0.0, 0.0, q.bias * to.span_s],
            ],
        }
    }
}
