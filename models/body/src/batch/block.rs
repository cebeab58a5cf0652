//! A block of bodies that step together, one in each lane.

use super::lanes::Num;
use super::params::BatchBody;
use super::step::{
    Coefficients, FAST_STATES, SLIP_ELEMENTS_MAX, Slip, StepLength, lane, set_lane, splat, step,
};

/// A stretch of steps under one torque.
#[derive(Debug, Clone, Copy)]
pub(super) struct Segment<N> {
    /// Body torque, N·m.
    pub(super) torque: [N; 3],
    pub(super) steps: u64,
}

/// Bodies in structure of arrays: each field holds one number of every body.
#[derive(Debug, Clone, Copy)]
pub(super) struct Block<N> {
    body: Coefficients<N>,
    slip: Slip<N>,
    state: [N; FAST_STATES],
    /// Smallest γ₃ after any step: how near upside down each body has come.
    lowest: N,
    /// Smallest pull of the string times d at the start of any step, N·m.
    least_pull: N,
}

/// One body out of a block.
#[derive(Debug, Clone, Copy)]
pub(super) struct LaneState {
    pub(super) state: [f64; FAST_STATES],
    pub(super) elastic_rad: [f64; SLIP_ELEMENTS_MAX],
    pub(super) lowest: f64,
    pub(super) least_pull_n_m: f64,
}

impl<N: Num> Block<N> {
    /// A block of `bodies` at their starts, at most one for each lane. Lanes left over are copies
    /// of the last body, because a lane of zeros would divide by them.
    pub(super) fn new(bodies: &[(BatchBody, [f64; FAST_STATES])]) -> Option<Self> {
        let (first, _) = bodies.first()?;
        let zero = N::splat(0.0);
        let none = [zero; SLIP_ELEMENTS_MAX];
        let mut block = Self {
            body: Coefficients::splat(&Coefficients::of(&first.body)),
            slip: Slip { stiffness: none, yield_twist: none, elastic: none },
            state: [zero; FAST_STATES],
            lowest: N::splat(1.0),
            least_pull: N::splat(f64::MAX),
        };
        for lane in 0..N::LANES {
            let (body, state) = &bodies[lane.min(bodies.len() - 1)];
            block.place(lane, body, state);
        }
        Some(block)
    }

    fn place(&mut self, lane: usize, body: &BatchBody, state: &[f64; FAST_STATES]) {
        self.body.set_lane(lane, &Coefficients::of(&body.body));
        set_lane(&mut self.state, lane, state);
        let slip = &mut self.slip;
        set_lane(&mut slip.stiffness, lane, &body.thread.map(|e| e.stiffness_n_m_rad));
        set_lane(&mut slip.yield_twist, lane, &body.thread.map(|e| e.yield_rad));
        set_lane(&mut slip.elastic, lane, &body.thread.map(|e| e.elastic_start_rad));
    }

    pub(super) fn lane(&self, at: usize) -> LaneState {
        LaneState {
            state: lane(&self.state, at),
            elastic_rad: lane(&self.slip.elastic, at),
            lowest: self.lowest.lane(at),
            least_pull_n_m: self.least_pull.lane(at),
        }
    }

    /// Runs through `segments`, evaluating the first `elements` of the threads. An element that a
    /// body does not have has no stiffness and adds zero, so evaluating it changes no bit.
    #[inline(always)]
    pub(super) fn run(&mut self, length: &StepLength, segments: &[Segment<N>], elements: usize) {
        // Three copies of the code, since the loop over the elements must be unrolled.
        match elements {
            0 => self.run_with::<0>(length, segments),
            1 => self.run_with::<1>(length, segments),
            _ => self.run_with::<SLIP_ELEMENTS_MAX>(length, segments),
        }
    }

    #[inline(always)]
    fn run_with<const M: usize>(&mut self, length: &StepLength, segments: &[Segment<N>]) {
        let (body, mut slip, mut state) = (self.body, self.slip, self.state);
        let (mut lowest, mut least_pull) = (self.lowest, self.least_pull);
        for segment in segments {
            for _ in 0..segment.steps {
                let pull = step::<N, M>(&body, &mut slip, &mut state, &segment.torque, length);
                (lowest, least_pull) = (lowest.min(state[2]), least_pull.min(pull));
            }
        }
        (self.slip, self.state) = (slip, state);
        (self.lowest, self.least_pull) = (lowest, least_pull);
    }
}

impl<N: Num> Segment<N> {
    /// A segment without torque.
    pub(super) fn idle() -> Self {
        Self { torque: splat(&[0.0; 3]), steps: 0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Body, reference};
    use std::ops::{Add, Div, Mul, Sub};

    /// A number whose `a·b + c` is rounded once, as by a fused instruction.
    #[derive(Clone, Copy)]
    struct Fused(f64);

    macro_rules! pass_on {
        ($($operator:ident $method:ident),*) => {$(
            impl $operator for Fused {
                type Output = Self;

                fn $method(self, other: Self) -> Self {
                    Self($operator::$method(self.0, other.0))
                }
            }
        )*};
    }

    pass_on!(Add add, Sub sub, Mul mul, Div div);

    impl Num for Fused {
        const LANES: usize = 1;

        fn splat(value: f64) -> Self {
            Self(value)
        }

        fn lane(&self, _lane: usize) -> f64 {
            self.0
        }

        fn set_lane(&mut self, _lane: usize, value: f64) {
            self.0 = value;
        }

        fn min(self, other: Self) -> Self {
            Self(Num::min(self.0, other.0))
        }

        fn max(self, other: Self) -> Self {
            Self(Num::max(self.0, other.0))
        }

        fn times_plus(self, factor: Self, term: Self) -> Self {
            Self(self.0.mul_add(factor.0, term.0))
        }

        fn times_from(self, factor: Self, term: Self) -> Self {
            Self((-self.0).mul_add(factor.0, term.0))
        }
    }

    fn after_480_s<N: Num>() -> LaneState {
        let body = BatchBody::new(Body::new(&reference::PARAMS).unwrap(), reference::S3);
        let start = crate::FastEquations::start(&reference::S3).unwrap();
        let mut block = Block::<N>::new(&[(body, start)]).unwrap();
        let segment = Segment { steps: 480 * 1400, ..Segment::idle() };
        block.run(&StepLength::new(1.0 / 1400.0), &[segment], 0);
        block.lane(0)
    }

    #[test]
    fn b3_fused_products_part_from_plain_ones_by_rounding_only() {
        let (plain, fused) = (after_480_s::<f64>(), after_480_s::<Fused>());
        let bits = |end: &LaneState| end.state.map(f64::to_bits);
        assert_ne!(bits(&plain), bits(&fused), "the two must compute differently");
        for (i, (a, b)) in plain.state.iter().zip(&fused.state).enumerate() {
            // 670 000 steps of a few roundings at up to 35 rad walk some 1e-12 away.
            assert!((a - b).abs() < 1e-11, "state {i}: {:e}", a - b);
        }
        let worst = plain.state.iter().zip(&fused.state).map(|(a, b)| (a - b).abs());
        println!("FMA against non-FMA, 480 s: {:.2e}", worst.fold(0.0, f64::max));
    }
}
