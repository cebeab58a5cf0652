//! Many bodies at once: truth for campaigns.
//!
//! A campaign asks for the same run with other starts, other bodies, other noise, a thousand times
//! over. Its bodies do not touch each other, so they can share every instruction: a block holds
//! one body in each lane of the machine's vectors and steps them together. What a body does
//! depends on itself alone, to the bit: not on its company, the vectors' width, or the number of
//! threads.
//!
//! ```
//! use struna_body::batch::{Batch, BatchBody, NoiseGrid};
//! use struna_body::{Body, reference};
//! use struna_kernel::Seed;
//!
//! let body = Body::new(&reference::PARAMS)?;
//! let bodies: Vec<BatchBody> = (0..100)
//!     .map(|run| BatchBody {
//!         run,
//!         torque_noise_b_n_m_sqrt_hz: [1e-7; 3],
//!         ..BatchBody::new(body, reference::S3)
//!     })
//!     .collect();
//! let noise = NoiseGrid { seed: Seed(7), steps_per_cell: 1 };
//! let mut batch = Batch::new(&bodies, 1.0 / 1400.0, noise)?;
//! batch.advance(1400)?;
//! assert!(batch.motion(99)?.twist_rad.is_finite());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod block;
mod fast;
mod lanes;
mod noise;
#[cfg(target_arch = "x86_64")]
mod pair;
mod params;
mod step;
mod vector;

pub use fast::{FastEquations, FastMotion};
pub use params::{BatchBody, NoiseGrid, SlipElement};
pub use step::{FAST_STATES, SLIP_ELEMENTS_MAX};
pub use vector::Level;
pub(crate) use vector::{Work, done_fast};

use crate::BodyError;
use block::{Block, LaneState, Segment};
use lanes::{Num, Quad};
use noise::{BlockTorque, SEGMENTS_MAX};
use std::num::NonZeroUsize;
use step::StepLength;
use struna_kernel::{Bound, ParameterError, SimTime};
use vector::Lanes;
#[cfg(target_arch = "x86_64")]
use vector::{Avx2Lanes, Avx512Lanes};

/// Longest run, s: 31 years, and 1e18 ns fit in simulated time.
const RUN_MAX_S: f64 = 1e9;

/// Why a batch is refused, or has no motion to tell.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum BatchError {
    /// A value that no batch can have.
    #[error(transparent)]
    Parameter(#[from] ParameterError),
    /// A start that no body can have.
    #[error(transparent)]
    Body(#[from] BodyError),
    /// The machine lacks the vector instructions asked for.
    #[error("this machine has no {level} instructions: let the batch choose its level")]
    LevelMissing {
        /** The level asked for. */
        level: Level,
    },
    /// A body whose axes are not principal or whose centre of mass is off its z axis.
    #[error("run {run}: a batch moves bodies with principal axes and the centre of mass on z only")]
    NotAligned {
        /** The body's number in its campaign. */
        run: u64,
    },
    /// There is no such body.
    #[error("body {index} was asked for, of a batch of {bodies}")]
    NoSuchBody {
        /** The index asked for. */
        index: usize,
        /** Bodies in the batch. */
        bodies: usize,
    },
    /// The body turned upside down, where its twist is undefined, its string went slack, or its
    /// step is far too long. Only this body is lost.
    #[error(
        "run {run} left the domain of its equations before {time}: start it gentler, or step finer"
    )]
    OutsideDomain {
        /** The body's number in its campaign. */
        run: u64,
        /** The time that the batch has reached. */
        time: SimTime,
    },
}

/// A block and the torques on it.
#[derive(Debug, Clone)]
struct Member<N> {
    block: Block<N>,
    torque: BlockTorque,
}

/// The blocks, in the lanes chosen once.
#[derive(Debug, Clone)]
enum Blocks {
    Baseline(Vec<Member<Quad>>),
    #[cfg(target_arch = "x86_64")]
    Avx2(Vec<Member<Avx2Lanes>>),
    #[cfg(target_arch = "x86_64")]
    Avx512(Vec<Member<Avx512Lanes>>),
}

/// Does the same with the blocks in whatever lanes they are.
macro_rules! with_blocks {
    ($blocks:expr, $members:ident => $what:expr) => {
        match $blocks {
            Blocks::Baseline($members) => $what,
            #[cfg(target_arch = "x86_64")]
            Blocks::Avx2($members) => $what,
            #[cfg(target_arch = "x86_64")]
            Blocks::Avx512($members) => $what,
        }
    };
}

/// Bodies that move side by side by RK4 at a fixed step, each by itself.
///
/// Uses [`FastEquations`], no fused products and no library functions, hence the same bits at
/// every [`Level`]. A body that turns upside down or slackens its string is lost alone: the others
/// go on, and only [`Batch::motion`] of the lost one is an error.
#[derive(Debug, Clone)]
pub struct Batch {
    blocks: Blocks,
    level: Level,
    /// The numbers of the bodies in their campaign.
    runs: Vec<u64>,
    step: StepLength,
    /// Elements of the threads that any body has.
    elements: usize,
    threads: NonZeroUsize,
    /// Steps taken; time is `index·step_s`, never a running sum.
    index: u64,
}

impl Batch {
    /// A batch at its start, with the fastest instructions of this machine, on one thread.
    ///
    /// # Errors
    /// [`BatchError::Parameter`] and [`BatchError::Body`] with name, value, bound and reason for
    /// the first value that is unusable.
    pub fn new(bodies: &[BatchBody], step_s: f64, noise: NoiseGrid) -> Result<Self, BatchError> {
        Self::with_level(bodies, step_s, noise, Level::detect())
    }

    /// Like [`Batch::new`] with instructions of choice, to compare them.
    ///
    /// # Errors
    /// As [`Batch::new`], and [`BatchError::LevelMissing`].
    pub fn with_level(
        bodies: &[BatchBody],
        step_s: f64,
        noise: NoiseGrid,
        level: Level,
    ) -> Result<Self, BatchError> {
        params::check(bodies, step_s, &noise)?;
        if !level.is_available() {
            return Err(BatchError::LevelMissing { level });
        }
        let blocks = match level {
            Level::Baseline => Blocks::Baseline(members(bodies, step_s, &noise)?),
            #[cfg(target_arch = "x86_64")]
            Level::Avx2 => Blocks::Avx2(members(bodies, step_s, &noise)?),
            #[cfg(target_arch = "x86_64")]
            Level::Avx512 => Blocks::Avx512(members(bodies, step_s, &noise)?),
            #[cfg(not(target_arch = "x86_64"))]
            _ => return Err(BatchError::LevelMissing { level }),
        };
        Ok(Self {
            blocks,
            level,
            runs: bodies.iter().map(|body| body.run).collect(),
            step: StepLength::new(step_s),
            elements: bodies.iter().map(BatchBody::elements).max().unwrap_or(0),
            threads: NonZeroUsize::MIN,
            index: 0,
        })
    }

    /// The same batch on as many threads; its bits do not change.
    #[must_use]
    pub fn on_threads(mut self, threads: NonZeroUsize) -> Self {
        self.threads = threads;
        self
    }

    /// The instructions in use.
    #[must_use]
    pub fn level(&self) -> Level {
        self.level
    }

    /// How many bodies there are.
    #[must_use]
    pub fn bodies(&self) -> usize {
        self.runs.len()
    }

    /// The time reached.
    #[must_use]
    pub fn time(&self) -> SimTime {
        // `advance` keeps the product below RUN_MAX_S, far inside the range of SimTime.
        SimTime::from_s(self.index as f64 * self.step.full_s()).unwrap_or(SimTime::ZERO)
    }

    /// Takes `steps` steps with every body. Each block takes all of them before the next block
    /// takes any, so it stays in the nearest cache.
    ///
    /// # Errors
    /// [`BatchError::Parameter`] before the first step when the run would last beyond 1e9 s.
    pub fn advance(&mut self, steps: u64) -> Result<(), BatchError> {
        let to = self.index.saturating_add(steps);
        let end_s = to as f64 * self.step.full_s();
        Bound::AtMost(RUN_MAX_S).check("end of the run, s", end_s, "time counts nanoseconds")?;
        let span = Span { from: self.index, to, step: self.step, elements: self.elements };
        with_blocks!(&mut self.blocks, members => span.advance_all(members, self.threads));
        self.index = to;
        Ok(())
    }

    /// The motion of the body at `index` in the order given to [`Batch::new`], now.
    ///
    /// # Errors
    /// [`BatchError::NoSuchBody`]; [`BatchError::OutsideDomain`] for a body that has turned upside
    /// down, slackened its string or diverged at any step so far.
    pub fn motion(&self, index: usize) -> Result<FastMotion, BatchError> {
        let lane = self.lane(index)?;
        if fast::is_sound(&lane) {
            return Ok(FastEquations::motion(self.time(), &lane.state));
        }
        Err(BatchError::OutsideDomain { run: self.runs[index], time: self.time() })
    }

    /// The states of the body at `index`, in the order of [`FastEquations`], whatever they are.
    ///
    /// # Errors
    /// [`BatchError::NoSuchBody`].
    pub fn states(&self, index: usize) -> Result<[f64; FAST_STATES], BatchError> {
        Ok(self.lane(index)?.state)
    }

    /// Elastic twists of the thread's elements of the body at `index`, rad.
    ///
    /// # Errors
    /// [`BatchError::NoSuchBody`].
    pub fn elastic_rad(&self, index: usize) -> Result<[f64; SLIP_ELEMENTS_MAX], BatchError> {
        Ok(self.lane(index)?.elastic_rad)
    }

    fn lane(&self, index: usize) -> Result<LaneState, BatchError> {
        if index >= self.runs.len() {
            return Err(BatchError::NoSuchBody { index, bodies: self.runs.len() });
        }
        Ok(with_blocks!(&self.blocks, members => lane_of(members, index)))
    }
}

fn lane_of<N: Num>(members: &[Member<N>], index: usize) -> LaneState {
    members[index / N::LANES].block.lane(index % N::LANES)
}

fn members<N: Num>(
    bodies: &[BatchBody],
    step_s: f64,
    noise: &NoiseGrid,
) -> Result<Vec<Member<N>>, BatchError> {
    let mut members = Vec::with_capacity(bodies.len().div_ceil(N::LANES));
    for bodies in bodies.chunks(N::LANES) {
        let started: Vec<_> = bodies
            .iter()
            .map(|body| Ok((*body, FastEquations::start(&body.start)?)))
            .collect::<Result<_, BodyError>>()?;
        let torque = BlockTorque::new(bodies, noise, step_s);
        members.extend(Block::new(&started).map(|block| Member { block, torque }));
    }
    Ok(members)
}

/// The steps of one call.
#[derive(Debug, Clone, Copy)]
struct Span {
    from: u64,
    to: u64,
    step: StepLength,
    elements: usize,
}

impl Span {
    fn advance_all<N: Lanes>(&self, members: &mut [Member<N>], threads: NonZeroUsize) {
        let share = members.len().div_ceil(threads.get());
        if share >= members.len() {
            return self.advance(members);
        }
        std::thread::scope(|scope| {
            for members in members.chunks_mut(share) {
                scope.spawn(|| self.advance(members));
            }
        });
    }

    fn advance<N: Lanes>(&self, members: &mut [Member<N>]) {
        let mut segments: Vec<Segment<N>> = Vec::with_capacity(SEGMENTS_MAX);
        for member in members {
            let mut from = self.from;
            while from < self.to {
                from = member.torque.fill(&mut segments, from, self.to);
                N::run(&mut member.block, &self.step, &segments, self.elements);
            }
        }
    }
}
