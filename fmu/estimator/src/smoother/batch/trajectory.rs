//! The motion that a set of parameters stands for, and its derivatives by each of them.

use super::closed_form::{Pair, Response};
use super::normal::Normal;
use alloc::vec;
use alloc::vec::Vec;

/// Parameters that every record has: angle and rate at the start, s = Ω², d = 2ζΩ, bias. The
/// sizes of the kicks follow them.
pub(super) const FIXED: usize = 5;
pub(super) const S: usize = 2;
pub(super) const D: usize = 3;
pub(super) const BIAS: usize = 4;

/// A measured rate, as the fit sees it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Observation {
    /// Since the start belief, s.
    pub(super) time_s: f64,
    pub(super) rate_rad_s: f64,
    /// Neither over range nor beyond the gate.
    pub(super) used: bool,
    pub(super) over_range: bool,
}

/// Angle and rate, with their derivatives by the parameters.
#[derive(Debug, Clone)]
pub(super) struct Point {
    pub(super) angle: f64,
    pub(super) rate: f64,
    pub(super) angle_by: Vec<f64>,
    pub(super) rate_by: Vec<f64>,
}

/// Walks along the motion, kick by kick.
#[derive(Debug)]
struct Walk<'a> {
    parameters: &'a [f64],
    kicks_s: &'a [f64],
    /// Where the present piece of undisturbed motion begins.
    from: Point,
    from_s: f64,
    /// Kicks behind.
    kicks: usize,
}

impl Point {
    fn start(parameters: &[f64]) -> Self {
        let n = parameters.len();
        let mut point = Self {
            angle: parameters[0],
            rate: parameters[1],
            angle_by: vec![0.0; n],
            rate_by: vec![0.0; n],
        };
        (point.angle_by[0], point.rate_by[1]) = (1.0, 1.0);
        point
    }

    /// Carries `from` on, in the first `active` parameters.
    fn carry(&mut self, from: &Self, response: &Response, active: usize) {
        let at: Pair = (from.angle, from.rate);
        (self.angle, self.rate) = response.carried(at);
        for i in 0..active {
            let carried = response.carried((from.angle_by[i], from.rate_by[i]));
            (self.angle_by[i], self.rate_by[i]) = carried;
        }
        for (i, by) in [S, D].into_iter().zip(response.by_parameters(at)) {
            self.angle_by[i] += by.0;
            self.rate_by[i] += by.1;
        }
    }
}

impl<'a> Walk<'a> {
    fn new(parameters: &'a [f64], kicks_s: &'a [f64]) -> Self {
        Self { parameters, kicks_s, from: Point::start(parameters), from_s: 0.0, kicks: 0 }
    }

    fn response(&self, time_s: f64) -> Response {
        Response::after(time_s - self.from_s, self.parameters[S], self.parameters[D])
    }

    /// Parameters that matter so far.
    fn active(&self) -> usize {
        FIXED + self.kicks
    }

    /// Starts a new piece at each kick up to a time.
    fn pass_kicks(&mut self, until_s: f64, point: &mut Point) {
        while let Some(&kick_s) = self.kicks_s.get(self.kicks).filter(|&&kick| kick <= until_s) {
            point.carry(&self.from, &self.response(kick_s), self.active());
            let size = FIXED + self.kicks;
            point.rate += self.parameters[size];
            (point.angle_by[size], point.rate_by[size]) = (0.0, 1.0);
            core::mem::swap(&mut self.from, point);
            // What was swapped out holds no derivative of this kick yet; carry() writes it.
            (self.from_s, self.kicks) = (kick_s, self.kicks + 1);
        }
    }
}

/// Shows `each` the motion at every observation, in order, and how many parameters matter by then.
pub(super) fn walk(
    parameters: &[f64],
    kicks_s: &[f64],
    observations: &[Observation],
    mut each: impl FnMut(&Observation, &Point, usize),
) {
    let mut walk = Walk::new(parameters, kicks_s);
    let mut point = walk.from.clone();
    for observation in observations {
        walk.pass_kicks(observation.time_s, &mut point);
        point.carry(&walk.from, &walk.response(observation.time_s), walk.active());
        each(observation, &point, walk.active());
    }
}

/// Measured minus expected rate at every observation, used or not.
pub(super) fn residuals(
    parameters: &[f64],
    kicks_s: &[f64],
    observations: &[Observation],
) -> Vec<f64> {
    let (s, d) = (parameters[S], parameters[D]);
    let (mut from, mut from_s, mut kicks) = ((parameters[0], parameters[1]), 0.0, 0);
    let residual = |observation: &Observation| {
        while let Some(&kick_s) = kicks_s.get(kicks).filter(|&&kick| kick <= observation.time_s) {
            from = Response::after(kick_s - from_s, s, d).carried(from);
            from.1 += parameters[FIXED + kicks];
            (from_s, kicks) = (kick_s, kicks + 1);
        }
        let (_, rate) = Response::after(observation.time_s - from_s, s, d).carried(from);
        observation.rate_rad_s - rate - parameters[BIAS]
    };
    observations.iter().map(residual).collect()
}

/// Normal equations of the used observations, each of weight `weight`.
pub(super) fn linearised(
    parameters: &[f64],
    kicks_s: &[f64],
    observations: &[Observation],
    weight: f64,
) -> Normal {
    let mut normal = Normal::new(parameters.len());
    let mut row = vec![0.0; parameters.len()];
    walk(parameters, kicks_s, observations, |observation, point, active| {
        if observation.used {
            row[..active].copy_from_slice(&point.rate_by[..active]);
            row[BIAS] = 1.0;
            let residual = observation.rate_rad_s - point.rate - parameters[BIAS];
            normal.observe(&row[..active], residual, weight);
        }
    });
    normal
}
