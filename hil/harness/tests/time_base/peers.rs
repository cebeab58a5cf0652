//! What others make of arrival times. Each returns the error of each sample's time, s.

use crate::cases::Sample;
use struna_harness::clock::{Point, edge_over, extend};

/// The arrival itself.
pub(crate) fn arrival(samples: &[Sample]) -> Vec<f64> {
    samples.iter().map(|sample| sample.arrival.as_s() - sample.taken_s).collect()
}

/// The line through all arrivals that least squares draws.
pub(crate) fn least_squares(samples: &[Sample]) -> Vec<f64> {
    let count = samples.len() as f64;
    let mean_k = samples.iter().map(|s| s.index as f64).sum::<f64>() / count;
    let mean_s = samples.iter().map(|s| s.arrival.as_s()).sum::<f64>() / count;
    let (mut kk, mut ky) = (0.0, 0.0);
    for s in samples {
        let k = s.index as f64 - mean_k;
        kk += k * k;
        ky += k * (s.arrival.as_s() - mean_s);
    }
    let slope = ky / kk;
    samples.iter().map(|s| mean_s + slope * (s.index as f64 - mean_k) - s.taken_s).collect()
}

/// The edge of the lower hull of all arrivals over their middle.
pub(crate) fn batch_hull(samples: &[Sample], period_s: f64) -> Vec<f64> {
    let mut hull = Vec::new();
    for s in samples {
        let index = s.index as f64;
        // Heights over the nominal line, so that the cross products keep their digits.
        extend(&mut hull, Point { index, arrival_s: s.arrival.as_s() - index * period_s });
    }
    let middle = samples[samples.len() - 1].index as f64 / 2.0;
    let (a, b) = edge_over(&hull, middle).unwrap();
    let tilt = (b.arrival_s - a.arrival_s) / (b.index - a.index);
    let line = |k: f64| a.arrival_s + tilt * (k - a.index) + k * period_s;
    samples.iter().map(|s| line(s.index as f64) - s.taken_s).collect()
}

/// Olson's passive synchronisation: the sensor's clock is off by at most the share `drift`, so
/// the best offset seen gets worse by that with time.
pub(crate) fn olson(samples: &[Sample], period_s: f64, drift: f64) -> Vec<f64> {
    let (mut best_s, mut last_s) = (f64::NEG_INFINITY, 0.0);
    let mut error = |s: &Sample| {
        let sensor_s = s.index as f64 * period_s;
        best_s = (best_s - drift * (sensor_s - last_s)).max(sensor_s - s.arrival.as_s());
        last_s = sensor_s;
        sensor_s - best_s - s.taken_s
    };
    samples.iter().map(&mut error).collect()
}

/// A phase-locked loop of gain `alpha`, critically damped.
pub(crate) fn locked_loop(samples: &[Sample], period_s: f64, alpha: f64) -> Vec<f64> {
    let (mut time_s, mut period_s) = (samples[0].arrival.as_s(), period_s);
    let mut last = samples[0].index;
    let mut error = |s: &Sample| {
        time_s += (s.index - last) as f64 * period_s;
        last = s.index;
        let off_s = s.arrival.as_s() - time_s;
        time_s += alpha * off_s;
        period_s += alpha * alpha / 4.0 * off_s;
        time_s - s.taken_s
    };
    samples.iter().map(&mut error).collect()
}
