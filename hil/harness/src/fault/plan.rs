//! What goes wrong, when, and for how long.

use super::{FaultKind, Stage};
use struna_kernel::SimTime;

/// Faults in a plan. Each has random streams of its own, so a plan is not free.
pub const FAULTS_MAX: usize = 64;

/// When events of a fault begin. Times are the gyro's, and an event takes hold of the first sample
/// that is not before its beginning.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Trigger {
    /// Once.
    At(SimTime),
    /// Again and again.
    Every {
        /** The first time. */
        first: SimTime,
        /** From each to the next, s. Positive. */
        period_s: f64,
        /** Each comes later by a random time up to this, s. Less than the period. */
        jitter_s: f64,
    },
    /// At random: exponential waiting times from each event to the next.
    Random {
        /** Mean number in a second. Positive. */
        rate_hz: f64,
    },
    /// At random bytes: exponential distances. For faults of single bytes, which then hit the byte
    /// that was drawn.
    PerByte {
        /** Mean number in a byte, above 0 and at most 1. */
        rate_per_byte: f64,
    },
}

/// One fault of a plan.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fault {
    /// What goes wrong.
    pub kind: FaultKind,
    /// When.
    pub trigger: Trigger,
    /// For how long. A kind that lasts needs it; any other hits every frame until then, or a single
    /// one when it is zero.
    pub duration: SimTime,
}

/// Faults that act together, in this order.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct FaultPlan(Vec<Fault>);

/// Why a plan cannot be carried out.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("fault {number}: {reason}")]
pub struct FaultPlanError {
    /// Which fault, from 0.
    pub number: usize,
    /// What is wrong with it.
    pub reason: &'static str,
}

impl FaultPlan {
    /// A plan of `faults`.
    ///
    /// # Errors
    /// [`FaultPlanError`] names the first fault that cannot be carried out.
    pub fn new(faults: Vec<Fault>) -> Result<Self, FaultPlanError> {
        if faults.len() > FAULTS_MAX {
            let reason = "a plan has at most 64 faults";
            return Err(FaultPlanError { number: FAULTS_MAX, reason });
        }
        for (number, fault) in faults.iter().enumerate() {
            fault.validate().map_err(|reason| FaultPlanError { number, reason })?;
        }
        Ok(Self(faults))
    }

    /// The faults in the order in which they act.
    #[must_use]
    pub fn faults(&self) -> &[Fault] {
        &self.0
    }

    /// Whether nothing goes wrong.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}

impl Fault {
    /// Judges the fault.
    ///
    /// # Errors
    /// What is wrong with it, in words.
    pub fn validate(&self) -> Result<(), &'static str> {
        if self.duration < SimTime::ZERO {
            return Err("a duration is not negative");
        }
        if self.kind.lasts() && self.duration == SimTime::ZERO {
            return Err("this kind lasts and needs a duration above 0");
        }
        self.validate_trigger()?;
        validate_magnitude(&self.kind)
    }

    fn validate_trigger(&self) -> Result<(), &'static str> {
        let positive = |x: f64| x.is_finite() && x > 0.0;
        match self.trigger {
            Trigger::At(_) => Ok(()),
            Trigger::Every { period_s, jitter_s, .. } => {
                if !positive(period_s) || period_s > 1e9 {
                    return Err("a period lies above 0 and below 1e9 s");
                }
                if !(0.0..period_s).contains(&jitter_s) {
                    return Err("the jitter of a period is not negative and less than the period");
                }
                if self.duration.as_s() + jitter_s >= period_s {
                    return Err("each event ends before the next begins: lengthen the period");
                }
                Ok(())
            }
            Trigger::Random { rate_hz } if positive(rate_hz) && rate_hz <= 1e6 => Ok(()),
            Trigger::Random { .. } => Err("a random rate lies above 0 and up to 1e6 Hz"),
            Trigger::PerByte { .. } if self.kind.stage() != Stage::Byte => {
                Err("only faults of single bytes come by the byte")
            }
            Trigger::PerByte { .. } if self.duration > SimTime::ZERO => {
                Err("what comes by the byte has no duration")
            }
            Trigger::PerByte { rate_per_byte } if rate_per_byte > 0.0 && rate_per_byte <= 1.0 => {
                Ok(())
            }
            Trigger::PerByte { .. } => Err("a rate per byte lies above 0 and up to 1"),
        }
    }
}

fn validate_magnitude(kind: &FaultKind) -> Result<(), &'static str> {
    let sound = match *kind {
        FaultKind::Burst { bytes } => (1..=4096).contains(&bytes),
        FaultKind::NoiseChange { factor } => factor.is_finite() && factor >= 0.0,
        FaultKind::Delay { delay_s: span_s }
        | FaultKind::Jitter { delay_max_s: span_s }
        | FaultKind::ClockJump { jump_s: span_s } => (0.0..=1e3).contains(&span_s),
        FaultKind::BaudError { share } => share.abs() <= 0.5,
        FaultKind::ClockDrift { share } => share.abs() <= 0.5,
        _ => kind.magnitude().0.is_finite(),
    };
    if sound {
        return Ok(());
    }
    Err(match kind {
        FaultKind::Burst { .. } => "a burst has 1 to 4096 bytes",
        FaultKind::NoiseChange { .. } => "a noise factor is finite and not negative",
        FaultKind::Delay { .. } | FaultKind::Jitter { .. } | FaultKind::ClockJump { .. } => {
            "bytes come later, not earlier, and by at most 1000 s"
        }
        FaultKind::BaudError { .. } | FaultKind::ClockDrift { .. } => {
            "a clock is off by at most half of its rate"
        }
        _ => "a magnitude is a finite number",
    })
}
