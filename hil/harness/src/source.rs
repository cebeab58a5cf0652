//! Where the motion comes from: the body model, or a recording.

use struna_body::{BodyError, Mounting, TruthMotion};
use struna_kernel::SimTime;

/// The motion at one instant, as far as its source knows it.
///
/// Two rates that part as soon as the gyro is misaligned or the Earth turns: what the gyro is given
/// (`input`), and what estimates are judged by (the rest). A recording knows one rate, which serves
/// as both.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reference {
    /// The instant.
    pub time: SimTime,
    /// Integral of the inertial rate about the gyro's input axis since the start, rad.
    pub input_angle_rad: f64,
    /// Inertial rate about the gyro's input axis, the Earth's included, rad/s.
    pub input_rate_rad_s: f64,
    /// Specific force at the gyro along the axes of its case, m/s²; the third is the input axis. A
    /// recording does not know it.
    pub specific_force_s_m_s2: Option<[f64; 3]>,
    /// Integral of the rate relative to the room about the body's axis, rad.
    pub spin_rad: f64,
    /// Rate relative to the room about the body's axis, rad/s.
    pub rate_rad_s: f64,
    /// Twist of the string, rad; a recording does not know it.
    pub twist_rad: Option<f64>,
    /// Rate of the twist, rad/s; a recording does not know it.
    pub twist_rate_rad_s: Option<f64>,
}

/// Something that turns, sampled at non-decreasing instants.
pub trait MotionSource: Send {
    /// The motion at `time`.
    ///
    /// # Errors
    /// [`SourceError`] when the motion cannot be carried that far.
    fn reference_at(&mut self, time: SimTime) -> Result<Reference, SourceError>;

    /// What gyros about the other two axes of the case are given at `time`; none when the source
    /// knows one axis only. Asked only for a line of three rates, after [`Self::reference_at`] of
    /// the same instant.
    ///
    /// # Errors
    /// [`SourceError`] when the motion cannot be carried that far.
    fn cross_axes_at(&mut self, time: SimTime) -> Result<Option<CrossAxes>, SourceError> {
        let _ = time;
        Ok(None)
    }
}

/// The motion about the x and y axes of the gyro's case, whose third axis is the input axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CrossAxes {
    /// Integrals of the inertial rates since the start, rad.
    pub angles_rad: [f64; 2],
    /// Inertial rates, the Earth's included, rad/s.
    pub rates_rad_s: [f64; 2],
}

/// Why a source has no motion to give.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SourceError {
    /// The body model stopped.
    #[error(transparent)]
    Body(#[from] BodyError),
    /// A recording that cannot be used.
    #[error("sample {sample} of the recording: {reason}")]
    Recording {
        /** Sample number, from 0. */
        sample: usize,
        /** What is wrong with it. */
        reason: &'static str,
    },
    /// A recording too short to be one.
    #[error("the recording has {samples} samples; at least 2 are needed")]
    TooShort {
        /** Samples in it. */
        samples: usize,
    },
}

/// The body model as a source, with a gyro mounted on the body.
#[derive(Debug)]
pub struct BodySource {
    /// What the body does.
    pub truth: TruthMotion,
    /// How the gyro sits on it.
    pub mounting: Mounting,
}

impl MotionSource for BodySource {
    fn reference_at(&mut self, time: SimTime) -> Result<Reference, SourceError> {
        let motion = self.truth.mounted_at(time, &self.mounting)?;
        Ok(Reference {
            time,
            input_angle_rad: motion.input_angle_rad,
            input_rate_rad_s: motion.input_rate_rad_s,
            specific_force_s_m_s2: Some(motion.specific_force_s_m_s2),
            spin_rad: motion.spin_rad,
            rate_rad_s: motion.rate_rad_s,
            twist_rad: Some(motion.twist_rad),
            twist_rate_rad_s: Some(motion.twist_rate_rad_s),
        })
    }

    fn cross_axes_at(&mut self, time: SimTime) -> Result<Option<CrossAxes>, SourceError> {
        let motion = self.truth.motion_at(time)?;
        let [x_b, y_b, _] = self.mounting.case_axes_b();
        Ok(Some(CrossAxes {
            angles_rad: [x_b, y_b].map(|axis_b| axis_b.dot(&motion.inertial_angle_b_rad)),
            rates_rad_s: [x_b, y_b].map(|axis_b| axis_b.dot(&motion.omega_ib_b_rad_s)),
        }))
    }
}

/// A recorded rate, taken as linear between its samples.
#[derive(Debug, Clone, PartialEq)]
pub struct Recording {
    time_s: Vec<f64>,
    rate_rad_s: Vec<f64>,
    /// Integral of the rate from the first sample to each.
    spin_rad: Vec<f64>,
    /// Interval in use; instants do not decrease, so it only moves on.
    at: usize,
}

impl Recording {
    /// A recording from sample times, s, and rates, rad/s. Time starts at the first sample.
    ///
    /// # Errors
    /// [`SourceError`] names the first sample that is not finite or not later than the one before.
    pub fn new(time_s: &[f64], rate_rad_s: &[f64]) -> Result<Self, SourceError> {
        let samples = time_s.len().min(rate_rad_s.len());
        if samples < 2 {
            return Err(SourceError::TooShort { samples });
        }
        let refuse = |sample, reason| Err(SourceError::Recording { sample, reason });
        let mut spin_rad = vec![0.0];
        for k in 0..samples {
            if !(time_s[k].is_finite() && rate_rad_s[k].is_finite()) {
                return refuse(k, "time or rate is not a finite number");
            }
            if k > 0 {
                let span_s = time_s[k] - time_s[k - 1];
                if span_s <= 0.0 {
                    return refuse(k, "its time is not later than the time before");
                }
                let mean_rad_s = 0.5 * (rate_rad_s[k] + rate_rad_s[k - 1]);
                spin_rad.push(spin_rad[k - 1] + mean_rad_s * span_s);
            }
        }
        let time_s = time_s[..samples].iter().map(|t| t - time_s[0]).collect();
        Ok(Self { time_s, rate_rad_s: rate_rad_s[..samples].to_vec(), spin_rad, at: 0 })
    }

    /// Length of the recording, s.
    #[must_use]
    pub fn duration_s(&self) -> f64 {
        self.time_s[self.time_s.len() - 1]
    }
}

impl MotionSource for Recording {
    /// The last rate holds beyond the end.
    fn reference_at(&mut self, time: SimTime) -> Result<Reference, SourceError> {
        let t_s = time.as_s();
        let last = self.time_s.len() - 1;
        while self.at + 1 < last && t_s >= self.time_s[self.at + 1] {
            self.at += 1;
        }
        let (from, to) = (self.at, self.at + 1);
        let span_s = self.time_s[to] - self.time_s[from];
        let into_s = t_s - self.time_s[from];
        let slope = (self.rate_rad_s[to] - self.rate_rad_s[from]) / span_s;
        let linear_s = into_s.min(span_s);
        let rate_rad_s = self.rate_rad_s[from] + slope * linear_s;
        let spin_rad = self.spin_rad[from]
            + 0.5 * (self.rate_rad_s[from] + rate_rad_s) * linear_s
            + rate_rad_s * (into_s - linear_s);
        Ok(Reference {
            time,
            input_angle_rad: spin_rad,
            input_rate_rad_s: rate_rad_s,
            specific_force_s_m_s2: None,
            spin_rad,
            rate_rad_s,
            twist_rad: None,
            twist_rate_rad_s: None,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn a_recording_is_linear_between_samples_and_holds_its_end() {
        let mut recording = Recording::new(&[10.0, 11.0, 13.0], &[0.0, 2.0, 2.0]).unwrap();
        let mut at = |t_s: f64| {
            let r = recording.reference_at(SimTime::from_s(t_s).unwrap()).unwrap();
            // The gyro is given what was recorded.
            assert_eq!((r.input_rate_rad_s, r.input_angle_rad), (r.rate_rad_s, r.spin_rad));
            (r.rate_rad_s, r.spin_rad)
        };
        // Halves and quarters: exact in binary.
        assert_eq!(at(0.5), (1.0, 0.25));
        assert_eq!(at(1.0), (2.0, 1.0));
        assert_eq!(at(2.0), (2.0, 3.0));
        assert_eq!(at(4.0), (2.0, 7.0));
    }

    #[test]
    fn a_recording_that_runs_backwards_or_has_holes_is_refused_by_sample() {
        let backwards = Recording::new(&[0.0, 1.0, 1.0], &[0.0; 3]).unwrap_err();
        assert!(matches!(backwards, SourceError::Recording { sample: 2, .. }));
        let hole = Recording::new(&[0.0, 1.0, 2.0], &[0.0, f64::NAN, 0.0]).unwrap_err();
        assert!(matches!(hole, SourceError::Recording { sample: 1, .. }));
        let short = Recording::new(&[0.0], &[0.0]).unwrap_err();
        assert!(matches!(short, SourceError::TooShort { samples: 1 }));
    }

    proptest! {
        #[test]
        fn the_spin_of_a_recording_does_not_depend_on_where_it_is_sampled(
            rates in proptest::collection::vec(-4.0_f64..4.0, 2..40),
            steps in 1_u32..200,
        ) {
            let time_s: Vec<f64> = (0..rates.len()).map(|k| k as f64 * 0.01).collect();
            let end = SimTime::from_s(time_s[time_s.len() - 1]).unwrap();
            let mut coarse = Recording::new(&time_s, &rates).unwrap();
            let mut fine = coarse.clone();
            for k in 0..steps {
                let t_s = end.as_s() * f64::from(k) / f64::from(steps);
                fine.reference_at(SimTime::from_s(t_s).unwrap()).unwrap();
            }
            let a = coarse.reference_at(end).unwrap().spin_rad;
            let b = fine.reference_at(end).unwrap().spin_rad;
            prop_assert_eq!(a.to_bits(), b.to_bits());
        }
    }
}
