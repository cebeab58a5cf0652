//! Two vectors for one, so that neither waits for itself.

use super::lanes::Num;
use std::ops::{Add, Div, Mul, Sub};

/// Two vectors side by side. One alone leaves the machine waiting for its own results; two that do
/// not depend on each other fill the gaps.
#[derive(Debug, Clone, Copy)]
pub(super) struct Pair<N>(N, N);

macro_rules! pairwise {
    ($($operator:ident $method:ident),*) => {$(
        impl<N: Num> $operator for Pair<N> {
            type Output = Self;

            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self($operator::$method(self.0, other.0), $operator::$method(self.1, other.1))
            }
        }
    )*};
}

pairwise!(Add add, Sub sub, Mul mul, Div div);

impl<N: Num> Num for Pair<N> {
    const LANES: usize = 2 * N::LANES;

    #[inline(always)]
    fn splat(value: f64) -> Self {
        Self(N::splat(value), N::splat(value))
    }

    #[inline(always)]
    fn lane(&self, lane: usize) -> f64 {
        if lane < N::LANES { self.0.lane(lane) } else { self.1.lane(lane - N::LANES) }
    }

    #[inline(always)]
    fn set_lane(&mut self, lane: usize, value: f64) {
        if lane < N::LANES {
            self.0.set_lane(lane, value);
        } else {
            self.1.set_lane(lane - N::LANES, value);
        }
    }

    #[inline(always)]
    fn min(self, other: Self) -> Self {
        Self(self.0.min(other.0), self.1.min(other.1))
    }

    #[inline(always)]
    fn max(self, other: Self) -> Self {
        Self(self.0.max(other.0), self.1.max(other.1))
    }
}
