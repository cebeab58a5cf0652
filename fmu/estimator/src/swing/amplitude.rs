//! How far the body swings, from what of the swing leaks into the measured rate.
//!
//! A gyro that sits askew by ε sees ε·ω_s of every radian of swing about its direction of
//! misalignment. Within a window of 2.56 s, a few periods of the swing and a small part of the
//! torsion's, the rate is c₀ + c₁t + c₂t² + c₃cos ωt + c₄sin ωt, and |c₃, c₄| is that leak.

use super::fit::cholesky::{Cholesky, Square};
use crate::config::{ConfigError, judge, positive};
use crate::state_bytes::{Reader, RestoreError, Writer};

/// Half of a window, s: the next window starts in the middle of the one before.
const HALF_WINDOW_S: f64 = 1.28;
/// Least frequency of the swing of which that is enough, rad/s.
const USUAL_RAD_S: f64 = 9.0;
/// Windows of which the largest counts: those that fit into 25 s.
const WINDOWS: usize = 18;
/// Fewer samples than twice the coefficients say little of them.
const COUNT_MIN: u32 = 10;
/// Largest phase of the swing from sample to sample, rad: a dozen samples per period.
const PHASE_MAX_RAD: f64 = 0.5;
/// Swing from which on a filter that knows of none is wrong, rad: 0.3°. Coning then turns by less
/// than 0.02 °/s; at 1° such a filter is off by 0.25°.
pub const SWING_PRESENT_RAD: f64 = 0.3 * core::f64::consts::PI / 180.0;

/// Sums of a least-squares fit of c₀ + c₁s + c₂s² + c₃cos ωt + c₄sin ωt, s the time in windows.
#[derive(Debug, Clone, Copy, PartialEq)]
struct HarmonicSums {
    normal: Square<5>,
    right: [f64; 5],
    squares: f64,
    count: u32,
}

impl HarmonicSums {
    const EMPTY: Self = Self { normal: [[0.0; 5]; 5], right: [0.0; 5], squares: 0.0, count: 0 };

    fn add(&mut self, s: f64, (cos, sin): (f64, f64), value: f64) {
        let basis = [1.0, s, s * s, cos, sin];
        for (i, row) in self.normal.iter_mut().enumerate() {
            for (entry, other) in row.iter_mut().zip(&basis[..=i]) {
                *entry += basis[i] * other;
            }
        }
        for (right, basis) in self.right.iter_mut().zip(basis) {
            *right += basis * value;
        }
        self.squares += value * value;
        self.count += 1;
    }

    /// Coefficients, and the sum of squares that they leave.
    fn solve(&self) -> Option<([f64; 5], f64)> {
        if self.count < COUNT_MIN {
            return None;
        }
        let c = Cholesky::of(&self.normal)?.solve(&self.right);
        let explained: f64 = c.iter().zip(self.right).map(|(c, r)| c * r).sum();
        c.iter().all(|c| c.is_finite()).then_some((c, self.squares - explained))
    }
}

/// A phase that advances by the same angle with every sample: one sine and cosine for all of them.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Phasor {
    now: (f64, f64),
    step: (f64, f64),
}

impl Phasor {
    fn new(step_rad: f64) -> Self {
        Self { now: (1.0, 0.0), step: (libm::cos(step_rad), libm::sin(step_rad)) }
    }

    /// The phase now, before it moves on.
    fn advance(&mut self) -> (f64, f64) {
        let ((c, s), (dc, ds)) = (self.now, self.step);
        self.now = (c * dc - s * ds, s * dc + c * ds);
        (c, s)
    }
}

/// Where the swing's leak stands in a record of the rate, fitted to its first seconds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Leak {
    /// Frequency at which the fit leaves least, rad/s.
    pub(super) frequency_rad_s: f64,
    /// c₃ and c₄: the leak is c₃·cos ωt + c₄·sin ωt, rad/s.
    pub(super) coefficients_rad_s: [f64; 2],
}

/// Frequencies tried about the believed one: 17 from 0.94 to 1.02 of it. Large swing is slower.
const SCAN: (u32, f64, f64) = (17, 0.94, 1.02);

impl Leak {
    /// The leak in `rates_rad_s`, of which those that are not finite are missing.
    ///
    /// None when nothing can be fitted.
    pub(super) fn scan(rates_rad_s: &[f64], period_s: f64, believed_rad_s: f64) -> Option<Self> {
        let (points, low, high) = SCAN;
        let mut best: Option<(f64, Self)> = None;
        for point in 0..points {
            let share = f64::from(point) / f64::from(points - 1);
            let frequency_rad_s = believed_rad_s * (low + (high - low) * share);
            let Some((c, left)) = fit_once(rates_rad_s, frequency_rad_s * period_s) else {
                continue;
            };
            if best.is_none_or(|(least, _)| left < least) {
                best = Some((left, Self { frequency_rad_s, coefficients_rad_s: [c[3], c[4]] }));
            }
        }
        best.map(|(_, leak)| leak)
    }
}

/// The harmonic fit of one record at one frequency.
fn fit_once(rates_rad_s: &[f64], step_rad: f64) -> Option<([f64; 5], f64)> {
    let (mut sums, mut phasor) = (HarmonicSums::EMPTY, Phasor::new(step_rad));
    let scale = 1.0 / rates_rad_s.len().max(1) as f64;
    for (k, rate) in rates_rad_s.iter().enumerate() {
        let phase = phasor.advance();
        if rate.is_finite() {
            sums.add(k as f64 * scale, phase, *rate);
        }
    }
    sums.solve()
}

/// One of the two overlapping windows.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Window {
    sums: HarmonicSums,
    phasor: Phasor,
    /// Samples seen; negative before its first.
    at: i64,
}

impl Window {
    fn new(step_rad: f64, wait: u32) -> Self {
        Self { sums: HarmonicSums::EMPTY, phasor: Phasor::new(step_rad), at: -i64::from(wait) }
    }

    /// The size of the leak when this sample completes the window of `length` samples: zero when
    /// more than half of them are missing.
    fn push(&mut self, rate_rad_s: Option<f64>, length: u32) -> Option<f64> {
        self.at += 1;
        if self.at <= 0 {
            return None;
        }
        let phase = self.phasor.advance();
        if let Some(rate) = rate_rad_s {
            let s = (self.at - 1) as f64 / f64::from(length);
            self.sums.add(s, phase, rate);
        }
        if self.at < i64::from(length) {
            return None;
        }
        let complete = core::mem::replace(&mut self.sums, HarmonicSums::EMPTY);
        (self.at, self.phasor.now) = (0, (1.0, 0.0));
        let solved = if 2 * complete.count > length { complete.solve() } else { None };
        Some(solved.map_or(0.0, |(c, _)| libm::hypot(c[3], c[4])))
    }
}

/// Measures the size of the swing, sample by sample, in fixed memory and without allocation.
///
/// What it shows is the swing about the direction in which the gyro sits askew; the body turns, so
/// that the largest of the last 25 s comes close to the largest of the swing itself.
#[derive(Debug, Clone, PartialEq)]
pub struct SwingMeter {
    windows: [Window; 2],
    length: u32,
    /// ε·ω_s: leak in rad/s for each radian of swing.
    leak_per_rad: f64,
    recent_rad: [f64; WINDOWS],
    complete: u32,
    last_rad: f64,
}

impl SwingMeter {
    /// A meter for a swing of `frequency_rad_s`, seen by a gyro that sits askew by
    /// `misalignment_rad` and is sampled every `period_s`.
    ///
    /// # Errors
    /// [`ConfigError`] when a value is not positive and finite, or when the swing is sampled less
    /// than a dozen times per period.
    pub fn new(
        frequency_rad_s: f64,
        misalignment_rad: f64,
        period_s: f64,
    ) -> Result<Self, ConfigError> {
        positive("frequency_rad_s", frequency_rad_s)?;
        positive("misalignment_rad", misalignment_rad)?;
        positive("period_s", period_s)?;
        let step_rad = frequency_rad_s * period_s;
        judge("period_s", period_s, step_rad <= PHASE_MAX_RAD, "half a radian of swing at most")?;
        // The window holds as many periods of a slow swing as of the usual one, 1.4 Hz.
        let half_s = HALF_WINDOW_S * (USUAL_RAD_S / frequency_rad_s).max(1.0);
        let ratio = half_s / period_s;
        judge("period_s", period_s, ratio < 1e6, "not less than a millionth of a window")?;
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "between 12 and a million"
        )]
        let half = libm::round(ratio) as u32;
        Ok(Self {
            windows: [Window::new(step_rad, 0), Window::new(step_rad, half)],
            length: 2 * half,
            leak_per_rad: misalignment_rad * frequency_rad_s,
            recent_rad: [0.0; WINDOWS],
            complete: 0,
            last_rad: 0.0,
        })
    }

    /// Takes a sample of the rate; one that is not finite counts as missing. Returns the swing,
    /// rad, when the sample completes a window.
    pub fn push(&mut self, rate_rad_s: f64) -> Option<f64> {
        let rate_rad_s = rate_rad_s.is_finite().then_some(rate_rad_s);
        let [first, second] = &mut self.windows;
        let first = first.push(rate_rad_s, self.length);
        // Both hear of every sample; they never complete together.
        let leak = second.push(rate_rad_s, self.length).or(first)?;
        let swing_rad = leak / self.leak_per_rad;
        self.last_rad = if swing_rad.is_finite() { swing_rad } else { 0.0 };
        let slot = self.complete as usize % WINDOWS;
        if let Some(slot) = self.recent_rad.get_mut(slot) {
            *slot = self.last_rad;
        }
        self.complete = self.complete.wrapping_add(1);
        Some(self.last_rad)
    }

    /// Swing in the last complete window, rad; zero before there is one.
    #[must_use]
    pub fn last_rad(&self) -> f64 {
        self.last_rad
    }

    /// Largest swing in the windows of the last 25 s, rad.
    #[must_use]
    pub fn largest_rad(&self) -> f64 {
        self.recent_rad.iter().copied().fold(0.0, f64::max)
    }

    /// Whether the swing of the last 25 s is too large for a filter that knows of none.
    #[must_use]
    pub fn is_swinging(&self) -> bool {
        self.largest_rad() > SWING_PRESENT_RAD
    }

    /// Samples that fill all windows of which the largest counts.
    #[must_use]
    pub fn samples_to_fill(&self) -> usize {
        self.length as usize / 2 * (WINDOWS + 1)
    }
}

impl SwingMeter {
    pub(crate) const SAVED_LEN: usize = 2 * Window::SAVED_LEN + (WINDOWS + 1) * 8 + 4;

    pub(crate) fn write(&self, out: &mut Writer<'_>) {
        self.windows.iter().for_each(|window| window.write(out));
        self.recent_rad.iter().for_each(|swing_rad| out.f64(*swing_rad));
        out.f64(self.last_rad);
        out.u32(self.complete);
    }

    /// Takes over what was written by a meter of the same making.
    pub(crate) fn read(&mut self, bytes: &mut Reader<'_>) -> Result<(), RestoreError> {
        let length = i64::from(self.length);
        for window in &mut self.windows {
            window.read(bytes)?;
            if !(-length..length).contains(&window.at) {
                return Err(RestoreError::Impossible);
            }
        }
        for swing_rad in &mut self.recent_rad {
            *swing_rad = bytes.finite("swing of a window")?;
        }
        self.last_rad = bytes.finite("swing of the last window")?;
        self.complete = bytes.u32();
        Ok(())
    }
}

impl Window {
    const SAVED_LEN: usize = (15 + 5 + 1 + 2) * 8 + 4 + 8;

    fn write(&self, out: &mut Writer<'_>) {
        let sums = &self.sums;
        for (i, row) in sums.normal.iter().enumerate() {
            row[..=i].iter().for_each(|entry| out.f64(*entry));
        }
        sums.right.iter().for_each(|entry| out.f64(*entry));
        out.f64(sums.squares);
        out.u32(sums.count);
        out.f64(self.phasor.now.0);
        out.f64(self.phasor.now.1);
        out.u64(self.at.cast_unsigned());
    }

    fn read(&mut self, bytes: &mut Reader<'_>) -> Result<(), RestoreError> {
        let sums = &mut self.sums;
        for (i, row) in sums.normal.iter_mut().enumerate() {
            for entry in &mut row[..=i] {
                *entry = bytes.finite("sums of a window")?;
            }
        }
        for entry in &mut sums.right {
            *entry = bytes.finite("sums of a window")?;
        }
        sums.squares = bytes.finite("sums of a window")?;
        sums.count = bytes.u32();
        self.phasor.now = (bytes.finite("phase")?, bytes.finite("phase")?);
        self.at = bytes.u64().cast_signed();
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec::Vec;

    const PERIOD_S: f64 = 0.01;
    const SWING_RAD_S: f64 = 9.75;
    const ASKEW_RAD: f64 = 0.0175;

    /// Slow torsion and a leak of the given size and phase.
    fn record(swing_rad: f64, phase_rad: f64, seconds: u32) -> Vec<f64> {
        let rate = |k: u32| {
            let t = f64::from(k) * PERIOD_S;
            let leak = ASKEW_RAD * SWING_RAD_S * swing_rad;
            0.3 * (0.052 * t).sin() + 0.001 + leak * (SWING_RAD_S * t + phase_rad).cos()
        };
        (0..100 * seconds).map(rate).collect()
    }

    fn meter() -> SwingMeter {
        SwingMeter::new(SWING_RAD_S, ASKEW_RAD, PERIOD_S).unwrap()
    }

    #[test]
    fn the_leak_gives_the_swing_back() {
        for swing_rad in [0.0, 0.01, 0.2] {
            let mut meter = meter();
            let mut sizes = Vec::new();
            for rate in record(swing_rad, 1.0, 25) {
                sizes.extend(meter.push(rate));
            }
            assert_eq!(sizes.len(), WINDOWS, "every window that fits into 25 s");
            for size in sizes {
                // The third derivative of the torsion, 4e-5 rad/s³ over 1.28³/6 s³, is 2e-5 rad/s
                // at the ends of a window: 1e-4 rad of swing at most.
                assert!((size - swing_rad).abs() < 1e-4, "{size} for {swing_rad}");
            }
            assert_eq!(meter.is_swinging(), swing_rad > 0.006);
        }
    }

    #[test]
    fn the_windows_fill_as_announced() {
        let mut meter = meter();
        let samples = meter.samples_to_fill();
        let record = record(0.1, 0.0, 25);
        let complete = record.iter().take(samples).filter_map(|rate| meter.push(*rate));
        assert_eq!(complete.count(), WINDOWS);
        assert_eq!(samples, 2432);
    }

    #[test]
    fn a_swing_that_has_died_is_forgotten() {
        let mut meter = meter();
        for rate in record(0.1, 0.0, 10).into_iter().chain(record(0.0, 0.0, 26)) {
            meter.push(rate);
        }
        assert!(!meter.is_swinging(), "{}", meter.largest_rad());
    }

    #[test]
    fn missing_samples_are_left_out_and_not_taken_for_swing() {
        let mut meter = meter();
        for (k, rate) in record(0.05, 0.3, 25).into_iter().enumerate() {
            meter.push(if k % 3 == 0 { f64::NAN } else { rate });
        }
        assert!((meter.last_rad() - 0.05).abs() < 1e-4, "{}", meter.last_rad());
        for _ in 0..300 {
            meter.push(f64::INFINITY);
        }
        assert!(meter.last_rad() < 1e-300, "nothing was measured");
    }

    #[test]
    fn the_scan_finds_frequency_and_phase() {
        let record = record(0.1, 0.7, 4);
        let leak = Leak::scan(&record, PERIOD_S, SWING_RAD_S / 0.975).unwrap();
        // Points lie half a percent apart; 0.975 is one of them.
        assert!((leak.frequency_rad_s / SWING_RAD_S - 1.0).abs() < 1e-12);
        let size = ASKEW_RAD * SWING_RAD_S * 0.1;
        let [c, s] = leak.coefficients_rad_s;
        assert!((c - size * 0.7_f64.cos()).abs() < 2e-4 * size);
        assert!((s + size * 0.7_f64.sin()).abs() < 2e-4 * size);
        assert!(Leak::scan(&[f64::NAN; 400], PERIOD_S, SWING_RAD_S).is_none());
        assert!(Leak::scan(&[1.0; 4], PERIOD_S, SWING_RAD_S).is_none());
    }

    #[test]
    fn what_cannot_be_measured_is_refused() {
        for (frequency, askew, period) in [
            (0.0, ASKEW_RAD, PERIOD_S),
            (SWING_RAD_S, 0.0, PERIOD_S),
            (SWING_RAD_S, ASKEW_RAD, f64::NAN),
            (SWING_RAD_S, ASKEW_RAD, 0.06),
            (1e-9, ASKEW_RAD, PERIOD_S),
        ] {
            assert!(SwingMeter::new(frequency, askew, period).is_err());
        }
    }
}
