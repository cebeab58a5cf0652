//! Numbers that may be several: the arithmetic that a step of the motion is written in.

use std::ops::{Add, Div, Mul, Sub};

/// A number for each of several bodies, or for one.
///
/// Every operation is the IEEE one in every lane, so a step written in it gives each body the same
/// bits at any width. Methods are inlined without condition: inside a function compiled for a
/// vector extension they then take on its instructions, where a call would lose them.
pub(super) trait Num:
    Copy + Send + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self>
{
    /// Bodies at once.
    const LANES: usize;

    /// The same number in every lane.
    fn splat(value: f64) -> Self;

    /// The number in one lane.
    fn lane(&self, lane: usize) -> f64;

    /// Replaces the number in one lane.
    fn set_lane(&mut self, lane: usize, value: f64);

    /// The smaller; `other` when one is NaN or both are zero, as the vector instructions have it.
    fn min(self, other: Self) -> Self;

    /// The larger; `other` when one is NaN or both are zero.
    fn max(self, other: Self) -> Self;

    /// `self·factor + term`, rounded twice. Fusing it would be an eighth faster and would part the
    /// bits of machines with and without the instruction.
    #[inline(always)]
    fn times_plus(self, factor: Self, term: Self) -> Self {
        self * factor + term
    }

    /// `term − self·factor`, rounded twice.
    #[inline(always)]
    fn times_from(self, factor: Self, term: Self) -> Self {
        term - self * factor
    }
}

impl Num for f64 {
    const LANES: usize = 1;

    #[inline(always)]
    fn splat(value: f64) -> Self {
        value
    }

    #[inline(always)]
    fn lane(&self, _lane: usize) -> f64 {
        *self
    }

    #[inline(always)]
    fn set_lane(&mut self, _lane: usize, value: f64) {
        *self = value;
    }

    #[inline(always)]
    fn min(self, other: Self) -> Self {
        if self < other { self } else { other }
    }

    #[inline(always)]
    fn max(self, other: Self) -> Self {
        if self > other { self } else { other }
    }
}

/// Four numbers in plain Rust. Any compiler turns their loops into the vector instructions that
/// every machine of its target has: two at a time on x86-64 and on 64-bit ARM.
#[derive(Debug, Clone, Copy)]
pub(super) struct Quad([f64; 4]);

macro_rules! lanewise {
    ($($operator:ident $method:ident),*) => {$(
        impl $operator for Quad {
            type Output = Self;

            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                let mut out = self;
                for i in 0..4 {
                    out.0[i] = $operator::$method(self.0[i], other.0[i]);
                }
                out
            }
        }
    )*};
}

lanewise!(Add add, Sub sub, Mul mul, Div div);

impl Num for Quad {
    const LANES: usize = 4;

    #[inline(always)]
    fn splat(value: f64) -> Self {
        Self([value; 4])
    }

    #[inline(always)]
    fn lane(&self, lane: usize) -> f64 {
        self.0[lane]
    }

    #[inline(always)]
    fn set_lane(&mut self, lane: usize, value: f64) {
        self.0[lane] = value;
    }

    #[inline(always)]
    fn min(self, other: Self) -> Self {
        let mut out = self;
        for i in 0..4 {
            out.0[i] = Num::min(self.0[i], other.0[i]);
        }
        out
    }

    #[inline(always)]
    fn max(self, other: Self) -> Self {
        let mut out = self;
        for i in 0..4 {
            out.0[i] = Num::max(self.0[i], other.0[i]);
        }
        out
    }
}
