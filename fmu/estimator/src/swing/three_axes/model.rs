//! All of the filter of three axes that does not evolve: how it predicts and updates.

use crate::augmented::windows::{GATE, GATED_VARIANCE};
use crate::checks::check_measurement;
use crate::swing::config::SwingConfig;
use crate::swing::filter::gaussian::{GYRO, Gaussian, RATES, Row, Walks};
use crate::swing::filter::model::{Bounds, belief, bounded, bounds, innovation, is_at_a_bound};
use crate::swing::motion::SwingMotion;
use crate::{Belief, EstimatorError, Innovation};

/// A belief with rates taken in.
#[derive(Debug, Clone, Copy)]
pub(super) struct Updated {
    pub(super) state: Gaussian,
    pub(super) innovations: [Innovation; 3],
    /// Axes whose innovation lies beyond the gate.
    pub(super) gated: [bool; 3],
}

/// When a rate that is far off hardly counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Gate {
    /// Beyond 5 of its deviations it hardly counts.
    Narrow,
    /// Beyond 50.
    Wide,
    /// It counts as any other: it may be the kick that is looked for.
    Open,
}

impl Gate {
    fn excludes(self, innovation: &Innovation) -> bool {
        match self {
            Self::Narrow => innovation.nis() > GATE * GATE,
            Self::Wide => innovation.nis() > 100.0 * GATE * GATE,
            Self::Open => false,
        }
    }
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Model {
    pub(super) motion: SwingMotion,
    r: f64,
    walks: Walks,
    bounds: Bounds,
    scale_factor_variance: f64,
}

impl Model {
    /// For a configuration that has been validated.
    pub(super) fn new(config: &SwingConfig) -> Self {
        Self {
            motion: SwingMotion::new(&config.body),
            r: config.measurement_variance_rad2_s2,
            walks: Walks::new(config, [config.bias_walk_rad2_s3; 3]),
            bounds: bounds(config, [f64::MAX; 3]),
            scale_factor_variance: config.scale_factor_sigma * config.scale_factor_sigma,
        }
    }

    pub(super) fn predicted(
        &self,
        from: &Gaussian,
        span_s: f64,
    ) -> Result<Gaussian, EstimatorError> {
        from.predicted(&self.motion, &self.walks, span_s)
    }

    /// The belief with three rates taken in, one after the other, each with `noise` times R.
    pub(super) fn updated(
        &self,
        from: &Gaussian,
        rates_rad_s: [f64; 3],
        noise: f64,
        gate: Gate,
    ) -> Result<Updated, EstimatorError> {
        for rate_rad_s in rates_rad_s {
            check_measurement(rate_rad_s)?;
        }
        let mut state = *from;
        let none = Innovation { residual_rad_s: 0.0, variance_rad2_s2: 1.0 };
        let (mut innovations, mut gated) = ([none; 3], [false; 3]);
        for (axis, rate_rad_s) in rates_rad_s.into_iter().enumerate() {
            let mut row = Row { by_omega: [0.0; 3], by_gyro: [0.0; 3] };
            (row.by_omega[axis], row.by_gyro[axis]) = (1.0, 1.0);
            let expected_rad_s = state.mean[RATES + axis] + state.mean[GYRO + axis];
            let expected = state.expect(rate_rad_s - expected_rad_s, &row);
            let r = noise * self.r;
            innovations[axis] = innovation(expected.residual, expected.spread + r)?;
            gated[axis] = gate.excludes(&innovations[axis]);
            state = state.updated(&expected, if gated[axis] { r * GATED_VARIANCE } else { r });
        }
        Ok(Updated { state: self.bounded(state).judged()?, innovations, gated })
    }

    pub(super) fn bounded(&self, state: Gaussian) -> Gaussian {
        bounded(state, &self.bounds)
    }

    pub(super) fn is_at_a_bound(&self, state: &Gaussian) -> bool {
        is_at_a_bound(state, &self.bounds)
    }

    pub(super) fn belief(&self, state: &Gaussian) -> Belief {
        belief(state, self.scale_factor_variance)
    }
}
