//! Allan and Hadamard variance of one stretch, from its cumulative angle.

/// Independent sums of a loop, so that its additions need not wait for each other.
const LANES: usize = 8;
/// Differences per block: partial sums are added block by block, which bounds their rounding.
const BLOCK: usize = 4096;

/// The angle that a stretch of rates adds up to, mean removed: one point more than samples.
///
/// Its unit is that of the rates times one sample, so no product with the sampling interval rounds
/// it. The sum is compensated; a plain one would lose a digit for every decade of samples.
#[derive(Debug, Clone)]
pub struct CumulativeAngle {
    points: Vec<f64>,
}

impl CumulativeAngle {
    /// Adds up `rates` less `mean`, in any unit.
    #[must_use]
    pub fn of(rates: &[f64], mean: f64) -> Self {
        let mut points = Vec::with_capacity(rates.len() + 1);
        points.push(0.0);
        let (mut sum, mut carry) = (0.0_f64, 0.0_f64);
        for rate in rates {
            let term = rate - mean;
            let next = sum + term;
            // Neumaier: what the addition dropped, whichever operand was the larger.
            carry +=
                if sum.abs() >= term.abs() { (sum - next) + term } else { (term - next) + sum };
            sum = next;
            points.push(sum + carry);
        }
        Self { points }
    }

    /// Points of the angle: samples plus one.
    #[must_use]
    pub fn points(&self) -> usize {
        self.points.len()
    }

    /// Overlapping Allan variance at an averaging time of `factor` samples, in squared units of
    /// the rates. None when not one difference fits in.
    ///
    /// # Source
    /// Riley, *Handbook of Frequency Stability Analysis* (NIST SP 1065), 2008, overlapping Allan
    /// variance from phase data; checked against `oadev` of allantools.
    #[must_use]
    pub fn allan_variance(&self, factor: usize) -> Option<f64> {
        let count = self.differences(factor, 2)?;
        let [a, b, c] = [0, 1, 2].map(|k| &self.points[k * factor..k * factor + count]);
        let total = blocks(count).map(|span| {
            let [a, b, c] = [a, b, c].map(|points| points[span.clone()].as_chunks::<LANES>());
            let mut lanes = [0.0; LANES];
            for ((a, b), c) in a.0.iter().zip(b.0).zip(c.0) {
                for lane in 0..LANES {
                    let second = (c[lane] - b[lane]) - (b[lane] - a[lane]);
                    lanes[lane] += second * second;
                }
            }
            let rest = a.1.iter().zip(b.1).zip(c.1);
            let rest = rest.map(|((a, b), c)| ((c - b) - (b - a)).powi(2));
            lanes.iter().sum::<f64>() + rest.sum::<f64>()
        });
        Some(total.sum::<f64>() / (2.0 * (factor as f64).powi(2) * count as f64))
    }

    /// Overlapping Hadamard variance, blind to a steady ramp of the rate; otherwise as
    /// [`Self::allan_variance`].
    #[must_use]
    pub fn hadamard_variance(&self, factor: usize) -> Option<f64> {
        let count = self.differences(factor, 3)?;
        let [a, b, c, d] = [0, 1, 2, 3].map(|k| &self.points[k * factor..k * factor + count]);
        let total = blocks(count).map(|span| {
            let [a, b, c, d] = [a, b, c, d].map(|points| &points[span.clone()]);
            let mut lanes = [0.0; LANES];
            for (k, (((a, b), c), d)) in a.iter().zip(b).zip(c).zip(d).enumerate() {
                let third = (d - a) - 3.0 * (c - b);
                lanes[k % LANES] += third * third;
            }
            lanes.iter().sum::<f64>()
        });
        Some(total.sum::<f64>() / (6.0 * (factor as f64).powi(2) * count as f64))
    }

    /// How many overlapping differences of `order` there are.
    fn differences(&self, factor: usize, order: usize) -> Option<usize> {
        let reach = factor.checked_mul(order).filter(|reach| *reach > 0)?;
        self.points.len().checked_sub(reach).filter(|count| *count > 0)
    }
}

fn blocks(count: usize) -> impl Iterator<Item = std::ops::Range<usize>> {
    (0..count).step_by(BLOCK).map(move |start| start..(start + BLOCK).min(count))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The definition, on averages of the rates and not on the angle.
    fn by_averages(rates: &[f64], m: usize, weights: &[f64]) -> f64 {
        let average = |k: usize| rates[k..k + m].iter().sum::<f64>() / m as f64;
        let starts = rates.len() + 1 - weights.len() * m;
        let squares = (0..starts).map(|k| {
            weights.iter().enumerate().map(|(j, w)| w * average(k + j * m)).sum::<f64>().powi(2)
        });
        squares.sum::<f64>() / starts as f64
    }

    /// Numbers without pattern, from a quadratic map.
    fn chaos(n: usize) -> Vec<f64> {
        let mut x = 0.3;
        let step = |_| {
            x = 3.99 * x * (1.0 - x);
            x
        };
        (0..n).map(step).collect()
    }

    #[test]
    fn both_variances_are_those_of_their_definitions() {
        // Longer than two blocks, and no multiple of the lanes.
        let rates = chaos(9001);
        let angle = CumulativeAngle::of(&rates, 0.5);
        for m in [1, 2, 7, 64, 1000, 2999] {
            let allan = by_averages(&rates, m, &[-1.0, 1.0]) / 2.0;
            let hadamard = by_averages(&rates, m, &[1.0, -2.0, 1.0]) / 6.0;
            // Averages of a thousand numbers carry some 1e-14.
            let close = |a: f64, b: f64| (a / b - 1.0).abs() < 1e-11;
            assert!(close(angle.allan_variance(m).unwrap(), allan), "Allan, {m}");
            assert!(close(angle.hadamard_variance(m).unwrap(), hadamard), "Hadamard, {m}");
        }
    }

    #[test]
    fn a_ramp_shows_in_the_allan_and_not_in_the_hadamard_variance() {
        let rates: Vec<f64> = (0..1000).map(|k| 0.25 * f64::from(k)).collect();
        let angle = CumulativeAngle::of(&rates, 0.0);
        // R² τ² / 2 with R = 1/4 per sample and τ = 40 samples; all of it exact in binary.
        assert!((angle.allan_variance(40).unwrap() - 50.0).abs() < 1e-9);
        assert!(angle.hadamard_variance(40).unwrap() < 1e-18);
    }

    #[test]
    fn what_does_not_fit_in_has_no_variance() {
        let angle = CumulativeAngle::of(&[1.0, 2.0, 4.0], 0.0);
        assert_eq!(angle.points(), 4);
        assert!(angle.allan_variance(1).is_some() && angle.hadamard_variance(1).is_some());
        assert_eq!(angle.allan_variance(2), None);
        assert_eq!(angle.hadamard_variance(2), None);
        assert_eq!(angle.allan_variance(0), None);
        assert_eq!(angle.hadamard_variance(usize::MAX), None);
    }

    #[test]
    fn a_large_offset_costs_no_digits() {
        let rates = chaos(3000);
        // 2^20 is added exactly up to the last 20 bits of the fraction.
        let raised: Vec<f64> = rates.iter().map(|rate| rate + 1_048_576.0).collect();
        let plain = CumulativeAngle::of(&rates, 0.0).allan_variance(100).unwrap();
        let shifted = CumulativeAngle::of(&raised, 1_048_576.0).allan_variance(100).unwrap();
        assert!((shifted / plain - 1.0).abs() < 1e-8);
    }
}
