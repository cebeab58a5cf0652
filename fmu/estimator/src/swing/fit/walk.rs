//! The motion from given unknowns on, sample by sample, and the rate that the gyro would show.

use super::cholesky::Square;
use super::problem::{BIAS, G1, G2, Problem, R, UNKNOWNS, Unknowns, motion_of};
use crate::swing::{MOTION_STATES, MotionParameters, MotionState, Tangents};

/// The motion at one sample with its derivatives by the unknowns.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Walk {
    state: MotionState,
    parameters: MotionParameters,
    tangents: Tangents,
    bias_rad_s: f64,
    /// The gyro's input axis in body components.
    axis: [f64; 3],
}

impl Walk {
    /// At the first sample.
    pub(super) fn new(problem: &Problem, u: &Unknowns) -> Self {
        let x = problem.x(u);
        let (state, parameters) = motion_of(&x);
        let (g1, g2) = (x[G1], x[G2]);
        let axis = [g1, g2, libm::sqrt(1.0 - g1 * g1 - g2 * g2)];
        Self { state, parameters, tangents: Tangents::START, bias_rad_s: x[BIAS], axis }
    }

    /// From the start to the first sample; false when the model has no such motion.
    pub(super) fn enter(&mut self, problem: &Problem) -> bool {
        self.carry(problem, problem.first_s)
    }

    /// On to the next sample; false when the model has no such motion.
    pub(super) fn step(&mut self, problem: &Problem) -> bool {
        (0..problem.substeps).all(|_| self.carry(problem, problem.step_s))
    }

    fn carry(&mut self, problem: &Problem, span_s: f64) -> bool {
        let (state, parameters) = (&self.state, &self.parameters);
        let tangents = &mut self.tangents;
        let carried = if problem.rough {
            problem.motion.step_with_rough_tangents(state, parameters, span_s, tangents)
        } else {
            problem.motion.step_with_tangents(state, parameters, span_s, tangents)
        };
        self.state = carried.unwrap_or(self.state);
        carried.is_ok()
    }

    /// On to the next sample without derivatives: those kept are then of an earlier one.
    pub(super) fn step_plainly(&mut self, problem: &Problem) -> bool {
        for _ in 0..problem.substeps {
            match problem.motion.step(&self.state, &self.parameters, problem.step_s) {
                Ok(state) => self.state = state,
                Err(_) => return false,
            }
        }
        true
    }

    /// The rate that the gyro shows, rad/s.
    pub(super) fn rate_rad_s(&self) -> f64 {
        let ([g1, g2, g3], [p, q, r]) = (self.axis, self.state.omega_rad_s);
        g1 * p + g2 * q + g3 * r + self.bias_rad_s
    }

    /// Angle of the body's axis from the vertical, rad.
    pub(super) fn tilt_rad(&self) -> f64 {
        self.state.tilt_rad()
    }

    /// Derivatives of the rate over √R by the scaled unknowns.
    pub(super) fn row(&self, problem: &Problem) -> Unknowns {
        let ([g1, g2, g3], [p, q, r]) = (self.axis, self.state.omega_rad_s);
        let [.., by_p, by_q, by_r] = &self.tangents.0;
        let mut row = [0.0; UNKNOWNS];
        // The first unknowns are, in this order, what the tangents are taken by.
        for (entry, ((by_p, by_q), by_r)) in row.iter_mut().zip(by_p.iter().zip(by_q).zip(by_r)) {
            *entry = g1 * by_p + g2 * by_q + g3 * by_r;
        }
        row[BIAS] = 1.0;
        row[G1] = p - r * g1 / g3;
        row[G2] = q - r * g2 / g3;
        for (entry, sigma) in row.iter_mut().zip(&problem.sigma) {
            *entry *= sigma * problem.inverse_noise;
        }
        row
    }

    /// The unknowns as they are now: what moves has moved, what does not is as at the start.
    pub(super) fn unknowns_now(&self, x: &Unknowns) -> Unknowns {
        let mut now = *x;
        now[..=R].copy_from_slice(&self.state.entries());
        now
    }

    /// Derivatives of [`unknowns_now`](Self::unknowns_now) by the scaled unknowns.
    pub(super) fn derivatives_now(&self, problem: &Problem) -> Square<UNKNOWNS> {
        let mut derivatives = [[0.0; UNKNOWNS]; UNKNOWNS];
        for (i, row) in derivatives.iter_mut().enumerate() {
            if i < MOTION_STATES {
                let by = self.tangents.0[i].iter().zip(&problem.sigma);
                for (entry, (by, sigma)) in row.iter_mut().zip(by) {
                    *entry = by * sigma;
                }
            } else {
                row[i] = problem.sigma[i];
            }
        }
        derivatives
    }
}
