//! Whether the body swings, as far as the measured rate shows it.

use super::config::{CALIBRATED_SIGMAS, is_calibrated};
use super::noise::RateNoise;
use super::tape::Sample;
use crate::config::ConfigError;
use crate::state_bytes::{Reader, RestoreError, Writer};
use crate::swing::{SWING_PRESENT_RAD, SwingConfig, SwingMeter};

/// Share of the least swing of note below which it counts as gone.
pub(super) const GONE: f64 = 2.0 / 3.0;
/// What noise alone shows as a swing, in its own standard deviations: present, in each of three
/// windows, one window in a million; not gone, one in five hundred.
const NOISE_SIGMAS: (f64, f64) = (4.5, 3.5);
/// Windows of the meter that fit into the time that it takes to fill them all, halves.
const METER_HALVES: usize = 19;
/// Windows in a row that must show a swing. A blow that only turns the body lies in two of them,
/// which overlap by half, and looks like a swing in both.
const WINDOWS_SEEN: u32 = 3;
/// Windows in a row that must show none until it counts as gone: 25 s, in which a swing across
/// the axis, which leaks nothing, is turned into sight.
const WINDOWS_CALM: u32 = 18;
/// Excess of the variance over R from which on an unknown body counts as swinging, and below which
/// it is calm. Sixty samples of noise alone exceed twice R once in a million blocks.
const SHAKEN: (f64, f64) = (3.0, 2.0);
/// Missing samples that are counted one by one; a longer gap hides nothing more.
const MISSED_MAX: f64 = 1000.0;

/// What the gyro's axis lets be seen of a swing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Sight {
    /// The misalignment is known: the leak of the swing measures it.
    Sharp,
    /// It is not: a leak shows that there is a swing, and not how large.
    Blurred,
    /// Nothing is known of the body: whatever shakes the rate may be a swing.
    Blind,
}

/// Watches the rate for swing, sample by sample.
#[derive(Debug, Clone)]
pub(super) struct SwingEye {
    sight: Sight,
    meter: Option<SwingMeter>,
    noise: RateNoise,
    /// Swing that is there, and below which it is gone, rad.
    present_rad: f64,
    gone_rad: f64,
    r_rad2_s2: f64,
    period_s: f64,
    verdict: Verdict,
}

/// What the windows of late have shown.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Verdict {
    /// Windows in a row with swing, and without.
    seen: u32,
    calm: u32,
    /// Whether a window without swing has been seen since the start.
    has_been_calm: bool,
}

impl Verdict {
    /// Takes what a window shows, and what counts as present and as gone.
    fn window(&mut self, size: f64, present: f64, gone: f64) {
        self.seen = if size > present { self.seen.saturating_add(1) } else { 0 };
        self.calm = if size < gone { self.calm.saturating_add(1) } else { 0 };
        self.has_been_calm |= self.seen == 0;
    }
}

impl SwingEye {
    pub(super) fn new(
        swing: Option<&SwingConfig>,
        r_rad2_s2: f64,
        period_s: f64,
    ) -> Result<Self, ConfigError> {
        let mut eye = Self {
            sight: Sight::Blind,
            meter: None,
            noise: RateNoise::default(),
            present_rad: SWING_PRESENT_RAD,
            gone_rad: GONE * SWING_PRESENT_RAD,
            r_rad2_s2,
            period_s,
            verdict: Verdict::default(),
        };
        if let Some(swing) = swing {
            eye.look_along(swing)?;
        }
        Ok(eye)
    }

    /// Looks for the swing of a declared body, unless the gyro's axis is the body's for certain.
    fn look_along(&mut self, swing: &SwingConfig) -> Result<(), ConfigError> {
        let (tilt_rad, sigma_rad) = (swing.axis.tilt_rad(), swing.axis.tilt_sigma_rad);
        let is_sharp = is_calibrated(&swing.axis);
        // Of an axis not calibrated the most that it may be off: the least swing.
        let most_rad = tilt_rad + if is_sharp { 0.0 } else { CALIBRATED_SIGMAS * sigma_rad };
        if most_rad <= 0.0 {
            return Ok(());
        }
        let frequency_rad_s = swing.body.swing_frequency_rad_s();
        let meter = SwingMeter::new(frequency_rad_s, most_rad, self.period_s)?;
        // The amplitude of a sine in n samples of noise has a deviation of √(2R/n) each way.
        let samples = (2 * meter.samples_to_fill() / METER_HALVES).max(1) as f64;
        let noise_rad = libm::sqrt(2.0 * self.r_rad2_s2 / samples) / (most_rad * frequency_rad_s);
        self.present_rad = SWING_PRESENT_RAD.max(NOISE_SIGMAS.0 * noise_rad);
        self.gone_rad = (GONE * SWING_PRESENT_RAD).max(NOISE_SIGMAS.1 * noise_rad);
        self.sight = if is_sharp { Sight::Sharp } else { Sight::Blurred };
        self.meter = Some(meter);
        Ok(())
    }

    /// Takes a sample. True when a block of it has ended and the noise is measured anew.
    #[inline(always)]
    pub(super) fn push(&mut self, sample: Sample) -> bool {
        let ended = match sample.rate_rad_s {
            Some(rate_rad_s) => self.noise.push(sample.span_s, rate_rad_s),
            None => false,
        };
        match &mut self.meter {
            Some(meter) => {
                let absent = core::iter::repeat(f64::NAN);
                let absent = absent.take(missed(sample.span_s, self.period_s));
                for rate_rad_s in absent.chain([sample.rate_rad_s.unwrap_or(f64::NAN)]) {
                    if let Some(swing_rad) = meter.push(rate_rad_s) {
                        self.verdict.window(swing_rad, self.present_rad, self.gone_rad);
                    }
                }
            }
            None if ended => {
                let excess = self.noise.latest_about_line_rad2_s2() / self.r_rad2_s2;
                self.verdict.window(excess, SHAKEN.0, SHAKEN.1);
            }
            None => {}
        }
        ended
    }

    pub(super) fn sight(&self) -> Sight {
        self.sight
    }

    /// Whether the body swings for certain. At the start a swing need not be told from a blow.
    pub(super) fn sees_swing(&self) -> bool {
        let needed = if self.verdict.has_been_calm { WINDOWS_SEEN } else { 1 };
        self.verdict.seen >= needed
    }

    /// Whether the swing has been there since the first sample.
    pub(super) fn has_never_been_calm(&self) -> bool {
        !self.verdict.has_been_calm
    }

    /// Whether the last window showed more than a body at rest.
    pub(super) fn is_suspicious(&self) -> bool {
        self.verdict.seen > 0
    }

    /// Swing below which it counts as gone, rad.
    pub(super) fn gone_rad(&self) -> f64 {
        self.gone_rad
    }

    /// Whether no swing has been seen for 25 s.
    pub(super) fn is_calm(&self) -> bool {
        self.verdict.calm >= WINDOWS_CALM
    }

    /// Swing in the last window, and the largest of the last 25 s, rad; none without a meter that
    /// knows its scale.
    pub(super) fn swing_rad(&self) -> Option<(f64, f64)> {
        let meter = self.meter.as_ref().filter(|_| self.sight == Sight::Sharp)?;
        Some((meter.last_rad(), meter.largest_rad()))
    }

    /// Variance of the rate about its mean over 0.64 s, the largest of late, rad²/s².
    pub(super) fn rate_variance_rad2_s2(&self) -> f64 {
        self.noise.variance_rad2_s2()
    }
}

/// Samples that a gap of `span_s` has swallowed.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped")]
pub(super) fn missed(span_s: f64, period_s: f64) -> usize {
    (libm::rint(span_s / period_s) - 1.0).clamp(0.0, MISSED_MAX) as usize
}

impl SwingEye {
    pub(super) const SAVED_LEN: usize = RateNoise::SAVED_LEN + 3 * 4 + SwingMeter::SAVED_LEN;

    /// The meter comes last, and is left out where there is none.
    pub(super) fn write(&self, out: &mut Writer<'_>) {
        self.noise.write(out);
        out.u32(self.verdict.seen);
        out.u32(self.verdict.calm);
        out.u32(u32::from(self.verdict.has_been_calm));
        if let Some(meter) = &self.meter {
            meter.write(out);
        }
    }

    /// An eye of the same making with what was written.
    pub(super) fn read(&self, bytes: &mut Reader<'_>) -> Result<Self, RestoreError> {
        let mut eye = self.clone();
        eye.noise = RateNoise::read(bytes)?;
        eye.verdict.seen = bytes.u32();
        eye.verdict.calm = bytes.u32();
        eye.verdict.has_been_calm = bytes.u32() != 0;
        if let Some(meter) = &mut eye.meter {
            meter.read(bytes)?;
        }
        Ok(eye)
    }
}
