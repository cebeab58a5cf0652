//! What one gyro can show at all.

use super::{Declared, Limits};
use crate::fault::{Fault, FaultKind};
use struna_kernel::SimTime;

/// Whether a fault can be told from sound data.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Observability {
    /// Some detector has a chance.
    Observable,
    /// None has, for this reason. It does not mean that there is no fault.
    NotObservable(&'static str),
}

const MOTION: &str = "a body may turn like that";
const COUNTER: &str = "no counter";

/// Whether `fault` can be seen on a gyro of which `declared` is known, by its kind, size and
/// length alone: what a plan can be told before it is run.
#[must_use]
pub fn observability(fault: &Fault, declared: &Declared, limits: &Limits) -> Observability {
    match unseen(fault, declared, limits) {
        Some(reason) => Observability::NotObservable(reason),
        None => Observability::Observable,
    }
}

fn unseen(fault: &Fault, declared: &Declared, limits: &Limits) -> Option<&'static str> {
    let counter = declared.counter_modulus.is_some();
    let lasts_s = fault.duration.as_s();
    match fault.kind {
        FaultKind::SwappedFrames | FaultKind::DuplicatedFrame => (!counter).then_some(COUNTER),
        FaultKind::BiasStep { rate_rad_s } | FaultKind::Spike { rate_rad_s } => {
            let least = limits.step_rad_s.min(limits.innovation_rad_s);
            (rate_rad_s.abs() <= least).then_some(MOTION)
        }
        FaultKind::BiasRamp { rate_rad_s2 } => {
            let end_rad_s = rate_rad_s2.abs() * lasts_s;
            let slow = rate_rad_s2.abs() <= declared.acceleration_max_rad_s2;
            // What a ramp has gained falls back at once when it ends.
            (slow && end_rad_s <= limits.step_rad_s)
                .then_some(MOTION)
                .or_else(|| slow.then_some("a body may turn like that; only its sudden end shows"))
        }
        FaultKind::ScaleChange { .. } => Some("only its edges in motion show; turn a known angle"),
        FaultKind::NoiseChange { factor } if factor * factor <= 1.7 => {
            Some("within the allowance for scatter")
        }
        FaultKind::Stuck => stuck_unseen(lasts_s, declared, limits),
        FaultKind::Dropout if !counter && lasts_s <= limits.silence_s => Some(COUNTER),
        FaultKind::Delay { delay_s } if delay_s <= limits.clock_s => {
            Some("shorter than queues and bridges vary")
        }
        FaultKind::ClockJump { jump_s } if jump_s <= limits.clock_s => {
            Some("shorter than queues and bridges vary")
        }
        FaultKind::Jitter { delay_max_s } if delay_max_s <= limits.silence_s => {
            Some("the least delay hardly changes")
        }
        FaultKind::ClockDrift { share } => {
            let gained_s = share.abs() * lasts_s.min(11.0);
            (gained_s <= limits.clock_s).then_some("needs a better clock than the host's")
        }
        FaultKind::BaudError { share } if share.abs() <= 0.04 => Some("read right all the same"),
        _ if fault.duration < SimTime::ZERO => Some("it never is"),
        _ => None,
    }
}

fn stuck_unseen(lasts_s: f64, declared: &Declared, limits: &Limits) -> Option<&'static str> {
    match limits.stuck_samples {
        None => Some("a sound gyro at rest repeats itself too: noise below one count"),
        Some(samples) if lasts_s * declared.sample_rate_hz < f64::from(samples) => {
            Some("shorter than a run that noise makes")
        }
        Some(_) => None,
    }
}
