//! The widest registers that the processor has, for loops over arrays.

/// Work that can be compiled for more than one instruction set.
///
/// A trait and no closure: what is inlined into a function that may use more instructions may use
/// them too, and a closure is not always inlined.
pub(crate) trait Job {
    type Output;

    /// Does the work. An implementation is to be `#[inline(always)]`, and all that it calls.
    fn run(self) -> Self::Output;
}

/// Which instruction set to run a [`Job`] with: found out once, for asking takes longer than a job.
///
/// Numbers do not depend on it. The wider set has multiplications fused with sums, but Rust never
/// fuses what is written apart. AVX-512 is left alone: loops over arrays do not vectorise well
/// there.
#[derive(Debug, Clone, Copy)]
pub(crate) struct InstructionSet {
    #[cfg(all(target_arch = "x86_64", not(target_os = "none")))]
    avx2: Option<pulp::x86::V3>,
}

impl InstructionSet {
    /// The one of this processor.
    pub(crate) fn of_processor() -> Self {
        Self {
            #[cfg(all(target_arch = "x86_64", not(target_os = "none")))]
            avx2: pulp::x86::V3::try_new(),
        }
    }

    /// The one that every processor of this architecture has.
    #[cfg(test)]
    pub(crate) fn baseline() -> Self {
        Self {
            #[cfg(all(target_arch = "x86_64", not(target_os = "none")))]
            avx2: None,
        }
    }

    /// Runs `job`.
    #[inline(always)]
    pub(crate) fn run<J: Job>(self, job: J) -> J::Output {
        #[cfg(all(target_arch = "x86_64", not(target_os = "none")))]
        if let Some(avx2) = self.avx2 {
            return avx2.vectorize(Vectorised(job));
        }
        job.run()
    }
}

#[cfg(all(target_arch = "x86_64", not(target_os = "none")))]
struct Vectorised<J>(J);

#[cfg(all(target_arch = "x86_64", not(target_os = "none")))]
impl<J: Job> pulp::NullaryFnOnce for Vectorised<J> {
    type Output = J::Output;

    #[inline(always)]
    fn call(self) -> J::Output {
        self.0.run()
    }
}
