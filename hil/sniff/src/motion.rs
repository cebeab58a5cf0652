//! Whether a gyro was turned, told from its rate alone.

use crate::length::as_f64;

/// Below this share of full scale nothing was turned.
pub(crate) const REST_EXCURSION: f64 = 0.003;
/// The range of white noise is four of its median steps; a turn is much more.
const STEPS_MIN: f64 = 8.0;

/// How a number moved.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Motion {
    /// From the 3rd to the 97th percentile, as a share of full scale.
    pub(crate) excursion: f64,
    /// It went well beyond its noise, up and down: no drift, no noise.
    pub(crate) turned: bool,
}

impl Motion {
    /// Of values in the order of time.
    pub(crate) fn of(values: &[f64], full: f64) -> Self {
        let range = spread(values.to_vec(), 0.03);
        let steps: Vec<f64> = values.windows(2).map(|pair| (pair[1] - pair[0]).abs()).collect();
        let excursion = range / full;
        let far = excursion >= REST_EXCURSION && range >= STEPS_MIN * median(steps);
        Self { excursion, turned: far && goes_both_ways(values) }
    }
}

/// Whether values, divided into a low quarter, a middle and a high quarter of their range, go
/// from one quarter to the other and back, or from the middle to both. A drift begins in one
/// quarter and ends in the other.
fn goes_both_ways(values: &[f64]) -> bool {
    let (Some(first), mut sorted) = (values.first(), values.to_vec()) else { return false };
    sorted.sort_by(f64::total_cmp);
    let cut = sorted.len() * 3 / 100;
    let (least, most) = (sorted[cut], sorted[sorted.len() - 1 - cut]);
    let quarter = 0.25 * (most - least);
    let zone = |value: f64| match value {
        low if low < least + quarter => -1,
        high if high > most - quarter => 1,
        _ => 0,
    };
    let (mut last, mut crossings) = (0, 0);
    for zone in values.iter().map(|value| zone(*value)).filter(|zone| *zone != 0) {
        crossings += i32::from(last != 0 && zone != last);
        last = zone;
    }
    crossings >= 2 || (crossings == 1 && zone(*first) == 0)
}

/// The range without the `cut` share at each end.
pub(crate) fn spread(mut values: Vec<f64>, cut: f64) -> f64 {
    if values.is_empty() {
        return 0.0;
    }
    values.sort_by(f64::total_cmp);
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a share of the number of values"
    )]
    let skipped = (cut * as_f64(values.len())) as usize;
    values[values.len() - 1 - skipped] - values[skipped]
}

pub(crate) fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn turned(value: impl Fn(f64) -> f64) -> bool {
        let values: Vec<f64> = (0..2000).map(|k| value(f64::from(k) / 2000.0)).collect();
        Motion::of(&values, 1.0).turned
    }

    #[test]
    fn a_turn_both_ways_is_told_from_drift_noise_and_rest() {
        assert!(turned(|t| if t < 0.4 { 0.0 } else { (10.0 * (t - 0.4)).sin() }));
        assert!(turned(|t| (20.0 * t).cos()));
        assert!(!turned(|t| 0.5 * t), "a drift");
        assert!(!turned(|t| if t < 0.4 { 0.0 } else { 0.3 }), "a step");
        assert!(!turned(|t| (1e6 * t * t).sin()), "noise");
        assert!(!turned(|t| 1e-3 * (20.0 * t).cos()), "less than a hundredth of the range");
        assert!(!turned(|_| 0.0));
    }
}
