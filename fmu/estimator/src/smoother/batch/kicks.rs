//! Where exactly the kicks are.

use super::trajectory::Observation;

/// How far from where it was seen a kick is looked for, samples.
const REACH: usize = 400;

/// The place that explains the residuals best of a kick of this size, which now lies at
/// observation `at`; between `least` and `most`.
///
/// To move a kick by a sample changes the expected rate of that sample by the kick's size, and
/// that of all others by next to nothing.
pub(super) fn better_place(
    observations: &[Observation],
    residuals: &[f64],
    at: usize,
    size_rad_s: f64,
    clip_rad_s: f64,
    (least, most): (usize, usize),
) -> usize {
    let clip2 = clip_rad_s * clip_rad_s;
    // By how much χ²·R grows when the sample is taken to the other side of the kick.
    let change = |k: usize, other_side: f64| {
        let (r, moved) = (residuals[k], residuals[k] + other_side);
        if observations[k].over_range {
            0.0
        } else {
            (moved * moved).min(clip2) - (r * r).min(clip2)
        }
    };
    let (mut best, mut place) = (0.0, at);
    let mut sum = 0.0;
    for later in at + 1..=most.min(at.saturating_add(REACH)) {
        sum += change(later - 1, size_rad_s);
        if sum < best {
            (best, place) = (sum, later);
        }
    }
    sum = 0.0;
    for earlier in (least.max(at.saturating_sub(REACH))..at).rev() {
        sum += change(earlier, -size_rad_s);
        if sum < best {
            (best, place) = (sum, earlier);
        }
    }
    place
}

#[cfg(test)]
mod tests {
    use super::*;
    use alloc::vec::Vec;

    /// Residuals of a kick of size 1 at 50 that is taken to be at `at`.
    fn misplaced(at: usize) -> (Vec<Observation>, Vec<f64>) {
        let rate = |k: usize| match k {
            _ if k < 50 && k >= at => -1.0,
            _ if k >= 50 && k < at => 1.0,
            _ => 0.0,
        };
        let residuals: Vec<f64> =
            (0..100).map(|k| rate(k) + if k % 2 == 0 { 0.05 } else { -0.05 }).collect();
        let observation =
            Observation { time_s: 0.0, rate_rad_s: 0.0, used: true, over_range: false };
        (std::vec![observation; 100], residuals)
    }

    #[test]
    fn a_kick_goes_where_it_belongs() {
        for at in [10, 49, 50, 51, 99] {
            let (observations, mut residuals) = misplaced(at);
            assert_eq!(better_place(&observations, &residuals, at, 1.0, 3.0, (0, 99)), 50);
            residuals[40] = 1e9;
            assert_eq!(better_place(&observations, &residuals, at, 1.0, 3.0, (0, 99)), 50);
        }
    }

    #[test]
    fn it_does_not_pass_its_neighbour() {
        let (observations, residuals) = misplaced(70);
        assert_eq!(better_place(&observations, &residuals, 70, 1.0, 3.0, (60, 80)), 60);
    }
}
