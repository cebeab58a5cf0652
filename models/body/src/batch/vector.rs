//! The vector extensions of x86-64, and the choice among them at run time.
//!
//! The only unsafe code of this crate: instructions that a machine may not have.

#![expect(unsafe_code, reason = "vector instructions, which only some machines have")]

use super::block::{Block, Segment};
use super::lanes::{Num, Quad};
use super::step::StepLength;
use std::fmt;

/// The vector instructions that a batch uses. All of them give the same bits.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
#[non_exhaustive]
pub enum Level {
    /// What every machine of the target has.
    Baseline,
    /// x86-64 with AVX2: four numbers at a time.
    Avx2,
    /// x86-64 with AVX-512F: eight numbers at a time.
    Avx512,
}

impl Level {
    /// Every level, slowest first.
    pub const ALL: [Self; 3] = [Self::Baseline, Self::Avx2, Self::Avx512];

    /// The fastest level of this machine.
    #[must_use]
    pub fn detect() -> Self {
        Self::ALL.into_iter().rfind(|level| level.is_available()).unwrap_or(Self::Baseline)
    }

    /// Whether this machine has the instructions.
    #[must_use]
    #[inline]
    pub fn is_available(self) -> bool {
        match self {
            Self::Baseline => true,
            #[cfg(target_arch = "x86_64")]
            Self::Avx2 => is_x86_feature_detected!("avx2"),
            #[cfg(target_arch = "x86_64")]
            Self::Avx512 => is_x86_feature_detected!("avx512f"),
            #[cfg(not(target_arch = "x86_64"))]
            _ => false,
        }
    }
}

impl fmt::Display for Level {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Baseline => "baseline",
            Self::Avx2 => "AVX2",
            Self::Avx512 => "AVX-512",
        })
    }
}

/// Lanes that know how to run a block of bodies with the instructions they need.
pub(super) trait Lanes: Num {
    /// Runs `block` through `segments`, evaluating the first `elements` of its threads.
    fn run(block: &mut Block<Self>, step: &StepLength, segments: &[Segment<Self>], elements: usize);
}

impl Lanes for Quad {
    fn run(
        block: &mut Block<Self>,
        step: &StepLength,
        segments: &[Segment<Self>],
        elements: usize,
    ) {
        block.run(step, segments, elements);
    }
}

/// Something to compute with the fastest instructions of this machine.
pub(crate) trait Work {
    /// What comes out.
    type Outcome;

    /// Does it. Write it, and all that it calls, `#[inline(always)]`: only then is it compiled for
    /// the extension.
    fn done(self) -> Self::Outcome;
}

/// Does `work` of one body with AVX2 where there is AVX2. The instructions are no wider, but have
/// a register for their result, which spares every fifth of them; the bits are the same.
#[inline(always)]
pub(crate) fn done_fast<W: Work>(work: W) -> W::Outcome {
    #[cfg(target_arch = "x86_64")]
    {
        #[target_feature(enable = "avx2")]
        fn with_extension<W: Work>(work: W) -> W::Outcome {
            work.done()
        }
        if Level::Avx2.is_available() {
            // SAFETY: the extension is there.
            return unsafe { with_extension(work) };
        }
    }
    work.done()
}

#[cfg(target_arch = "x86_64")]
pub(super) use x86::{Avx2Lanes, Avx512Lanes};

#[cfg(target_arch = "x86_64")]
mod x86 {
    use super::super::pair::Pair;
    use super::{Block, Lanes, Num, Segment, StepLength};
    use std::arch::x86_64::{
        __m256d, __m512d, _mm256_add_pd, _mm256_div_pd, _mm256_max_pd, _mm256_min_pd,
        _mm256_mul_pd, _mm256_set1_pd, _mm256_sub_pd, _mm512_add_pd, _mm512_div_pd, _mm512_max_pd,
        _mm512_min_pd, _mm512_mul_pd, _mm512_set1_pd, _mm512_sub_pd,
    };
    use std::ops::{Add, Div, Mul, Sub};

    /// Eight numbers in two AVX registers.
    pub(in super::super) type Avx2Lanes = Pair<Avx2>;
    /// Sixteen numbers in two AVX-512 registers.
    pub(in super::super) type Avx512Lanes = Pair<Avx512>;

    macro_rules! vector {
        (
            $(#[$doc:meta])* $name:ident($register:ty) of $lanes:literal, $set1:ident, $min:ident,
            $max:ident, $($operator:ident $method:ident $intrinsic:ident),*
        ) => {
            $(#[$doc])*
            #[derive(Debug, Clone, Copy)]
            pub(in super::super) struct $name($register);

            $(impl $operator for $name {
                type Output = Self;

                #[inline(always)]
                fn $method(self, other: Self) -> Self {
                    // SAFETY: the batch makes numbers of this type only after `is_available`.
                    Self(unsafe { $intrinsic(self.0, other.0) })
                }
            })*

            impl Num for $name {
                const LANES: usize = $lanes;

                #[inline(always)]
                fn splat(value: f64) -> Self {
                    // SAFETY: the batch makes numbers of this type only after `is_available`.
                    Self(unsafe { $set1(value) })
                }

                #[inline(always)]
                fn lane(&self, lane: usize) -> f64 {
                    // SAFETY: the register is as large as its lanes, and any bits are a number.
                    unsafe { std::mem::transmute::<$register, [f64; $lanes]>(self.0)[lane] }
                }

                #[inline(always)]
                fn set_lane(&mut self, lane: usize, value: f64) {
                    let register: *mut $register = &mut self.0;
                    // SAFETY: borrowed for as long as `self`, of the same size, and more loosely
                    // aligned; any bits are a number.
                    let lanes = unsafe { &mut *register.cast::<[f64; $lanes]>() };
                    lanes[lane] = value;
                }

                #[inline(always)]
                fn min(self, other: Self) -> Self {
                    // SAFETY: the batch makes numbers of this type only after `is_available`.
                    Self(unsafe { $min(self.0, other.0) })
                }

                #[inline(always)]
                fn max(self, other: Self) -> Self {
                    // SAFETY: the batch makes numbers of this type only after `is_available`.
                    Self(unsafe { $max(self.0, other.0) })
                }
            }
        };
    }

    vector! {
        /// Four numbers in one AVX register.
        Avx2(__m256d) of 4, _mm256_set1_pd, _mm256_min_pd, _mm256_max_pd,
        Add add _mm256_add_pd, Sub sub _mm256_sub_pd, Mul mul _mm256_mul_pd, Div div _mm256_div_pd
    }

    vector! {
        /// Eight numbers in one AVX-512 register.
        Avx512(__m512d) of 8, _mm512_set1_pd, _mm512_min_pd, _mm512_max_pd,
        Add add _mm512_add_pd, Sub sub _mm512_sub_pd, Mul mul _mm512_mul_pd, Div div _mm512_div_pd
    }

    macro_rules! entry {
        ($lanes:ident, $feature:literal) => {
            impl Lanes for $lanes {
                fn run(
                    block: &mut Block<Self>,
                    step: &StepLength,
                    segments: &[Segment<Self>],
                    elements: usize,
                ) {
                    /// Compiled for the extension, with all that it calls inlined. No closures:
                    /// one would be compiled without the extension and ten times slower.
                    #[target_feature(enable = $feature)]
                    fn with_extension(
                        block: &mut Block<$lanes>,
                        step: &StepLength,
                        segments: &[Segment<$lanes>],
                        elements: usize,
                    ) {
                        block.run(step, segments, elements);
                    }
                    // SAFETY: a block of this type exists, and the batch makes one only after
                    // `is_available`.
                    unsafe { with_extension(block, step, segments, elements) }
                }
            }
        };
    }

    entry!(Avx2Lanes, "avx2");
    entry!(Avx512Lanes, "avx512f");
}
