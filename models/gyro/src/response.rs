//! Band limit and delay: what of the rate reaches the measurement.

use crate::{Response, Sampling};
use std::f64::consts::TAU;

/// Size of the matrix whose exponential steps the filter: two states, their integral, the input.
const N: usize = 4;
type Matrix = [[f64; N]; N];

/// A second-order low-pass and a pure delay, advanced by one sample at a time.
///
/// The input is taken as constant through each sample interval, at its mean; for that input the
/// step is exact, at any ratio of bandwidth and sample rate. What a constant in place of the true
/// course costs is a shift of a changing rate: by 1e-5 of a sample for the ADIS16100, whose band is
/// a 35th of its sample rate, and by 0.02 of a sample for the VG-910D, whose band is a third of it.
#[derive(Debug, Clone)]
pub(crate) struct Responder {
    delay: Delay,
    filter: Option<Filter>,
}

impl Responder {
    pub(crate) fn new(response: &Response, sample_rate_hz: f64, sampling: Sampling) -> Self {
        let is_limited = response.natural_frequency_hz > 0.0;
        Self {
            delay: Delay::new(response.delay_s * sample_rate_hz),
            filter: is_limited.then(|| Filter::new(response, sample_rate_hz, sampling)),
        }
    }

    /// Starts as if `rate_rad_s` had lasted for ever.
    pub(crate) fn settle(&mut self, rate_rad_s: f64) {
        self.delay.settle(rate_rad_s);
        if let Some(filter) = &mut self.filter {
            filter.state = [rate_rad_s, 0.0];
        }
    }

    /// One sample interval on. `noise_rad_s` enters between delay and filter.
    #[inline]
    pub(crate) fn step(&mut self, rate_rad_s: f64, noise_rad_s: f64) -> f64 {
        let input_rad_s = self.delay.step(rate_rad_s) + noise_rad_s;
        match &mut self.filter {
            Some(filter) => filter.step(input_rad_s),
            None => input_rad_s,
        }
    }
}

/// The filter's rate, and the rate of that over ωₙ, stepped through one interval.
#[derive(Debug, Clone)]
struct Filter {
    state: [f64; 2],
    step: [[f64; 3]; 2],
    output: [f64; 3],
}

impl Filter {
    fn new(response: &Response, sample_rate_hz: f64, sampling: Sampling) -> Self {
        let turned = TAU * response.natural_frequency_hz / sample_rate_hz;
        // x₁′ = ωₙx₂, x₂′ = ωₙ(u − x₁ − 2ζx₂); the third row integrates x₁ over the interval.
        let mut rates = [[0.0; N]; N];
        rates[0][1] = turned;
        rates[1] = [-turned, -2.0 * response.damping_ratio * turned, 0.0, turned];
        rates[2][0] = 1.0;
        let over = exponential(&rates);
        let row = |k: usize| [over[k][0], over[k][1], over[k][3]];
        let output = match sampling {
            Sampling::Mean => row(2),
            Sampling::Instantaneous => row(0),
        };
        Self { state: [0.0; 2], step: [row(0), row(1)], output }
    }

    #[inline]
    fn step(&mut self, input_rad_s: f64) -> f64 {
        let [x, y] = self.state;
        let of = |row: &[f64; 3]| row[0] * x + row[1] * y + row[2] * input_rad_s;
        let output = of(&self.output);
        self.state = [of(&self.step[0]), of(&self.step[1])];
        output
    }
}

/// e^M by Taylor's series of a halved matrix, squared back: plain arithmetic, so the same bits on
/// every platform.
fn exponential(matrix: &Matrix) -> Matrix {
    let row_sum = |row: &[f64; N]| row.iter().map(|entry| entry.abs()).sum::<f64>();
    let norm = matrix.iter().map(row_sum).fold(0.0, f64::max);
    let mut halvings = 0;
    let mut scale = 1.0;
    while norm * scale > 0.5 {
        scale *= 0.5;
        halvings += 1;
    }
    let scaled = matrix.map(|row| row.map(|entry| entry * scale));
    let mut sum = identity();
    let mut term = identity();
    // 0.5^16/16! is below 1e-18.
    for k in 1..=16 {
        term = product(&term, &scaled).map(|row| row.map(|entry| entry / f64::from(k)));
        for (sum, term) in sum.iter_mut().flatten().zip(term.iter().flatten()) {
            *sum += term;
        }
    }
    for _ in 0..halvings {
        sum = product(&sum, &sum);
    }
    sum
}

fn identity() -> Matrix {
    std::array::from_fn(|i| std::array::from_fn(|j| if i == j { 1.0 } else { 0.0 }))
}

fn product(a: &Matrix, b: &Matrix) -> Matrix {
    std::array::from_fn(|i| std::array::from_fn(|j| (0..N).map(|k| a[i][k] * b[k][j]).sum()))
}

/// A pure delay: part of an interval mixes two neighbouring inputs, as means over shifted
/// intervals do when the input is constant through each.
#[derive(Debug, Clone)]
struct Delay {
    kept: Vec<f64>,
    newest: usize,
    /// Share of the older of the two inputs.
    older_share: f64,
}

impl Delay {
    fn new(samples: f64) -> Self {
        let whole = samples.floor();
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "validated: 0 to DELAY_SAMPLES_MAX"
        )]
        let length = if samples > 0.0 { whole as usize + 2 } else { 0 };
        Self { kept: vec![0.0; length], newest: 0, older_share: samples - whole }
    }

    fn settle(&mut self, rate_rad_s: f64) {
        self.kept.fill(rate_rad_s);
    }

    #[inline]
    fn step(&mut self, rate_rad_s: f64) -> f64 {
        let length = self.kept.len();
        if length == 0 {
            return rate_rad_s;
        }
        let next = |at: usize| if at + 1 == length { 0 } else { at + 1 };
        self.newest = next(self.newest);
        self.kept[self.newest] = rate_rad_s;
        // The ring holds whole + 2 inputs: behind the newest come the oldest two.
        let oldest = next(self.newest);
        let (older, younger) = (self.kept[oldest], self.kept[next(oldest)]);
        younger + self.older_share * (older - younger)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::FRAC_1_SQRT_2;

    const RATE_HZ: f64 = 1400.0;

    fn low_pass(natural_frequency_hz: f64, damping_ratio: f64, delay_s: f64) -> Response {
        Response { natural_frequency_hz, damping_ratio, delay_s, ..Response::default() }
    }

    fn responder(response: &Response, sampling: Sampling) -> Responder {
        Responder::new(response, RATE_HZ, sampling)
    }

    /// Response of the filter to a unit step at time zero, and its integral.
    fn closed_form(damping_ratio: f64, turned: f64) -> (f64, f64) {
        if turned <= 0.0 {
            return (0.0, 0.0);
        }
        let decay = (-damping_ratio * turned).exp();
        let (c, s) = if damping_ratio < 1.0 {
            let damped = (1.0 - damping_ratio * damping_ratio).sqrt();
            ((damped * turned).cos(), (damped * turned).sin() / damped)
        } else {
            let damped = (damping_ratio * damping_ratio - 1.0).sqrt();
            ((damped * turned).cosh(), (damped * turned).sinh() / damped)
        };
        let value = 1.0 - decay * (c + damping_ratio * s);
        // From the equation of the filter: the integral of x₁ is turned − 2ζx₁ − x₂.
        (value, turned - 2.0 * damping_ratio * value - decay * s)
    }

    #[test]
    fn a_step_is_answered_by_the_closed_form_of_the_filter() {
        for (frequency_hz, damping_ratio) in
            [(40.0, FRAC_1_SQRT_2), (100.0, 0.3), (5.0, 2.0), (3000.0, FRAC_1_SQRT_2)]
        {
            let response = low_pass(frequency_hz, damping_ratio, 0.0);
            let mut instants = responder(&response, Sampling::Instantaneous);
            let mut means = responder(&response, Sampling::Mean);
            let turn = TAU * frequency_hz / RATE_HZ;
            for k in 1..=400_u32 {
                let (now, upto) = closed_form(damping_ratio, turn * f64::from(k));
                let (_, before) = closed_form(damping_ratio, turn * f64::from(k - 1));
                let (instant, mean) = (instants.step(1.0, 0.0), means.step(1.0, 0.0));
                // Rounding of 400 steps; the closed form loses digits in its difference.
                assert!((instant - now).abs() < 1e-12, "{frequency_hz}, {k}: {instant} {now}");
                let expected = (upto - before) / turn;
                assert!((mean - expected).abs() < 1e-11, "{frequency_hz}, {k}: {mean}");
            }
        }
    }

    #[test]
    fn a_delayed_step_comes_late_by_the_delay() {
        let mut exact = responder(&low_pass(40.0, FRAC_1_SQRT_2, 0.0), Sampling::Instantaneous);
        let mut late =
            responder(&low_pass(40.0, FRAC_1_SQRT_2, 3.0 / RATE_HZ), Sampling::Instantaneous);
        let exact: Vec<f64> = (0..100).map(|_| exact.step(1.0, 0.0)).collect();
        let late: Vec<f64> = (0..103).map(|_| late.step(1.0, 0.0)).collect();
        assert!(late[..3].iter().all(|rate| *rate == 0.0));
        for (exact, late) in exact.iter().zip(&late[3..]) {
            assert_eq!(exact.to_bits(), late.to_bits());
        }
    }

    #[test]
    fn part_of_a_sample_of_delay_mixes_neighbours() {
        let mut late = responder(&low_pass(0.0, 1.0, 2.25 / RATE_HZ), Sampling::Mean);
        let read: Vec<f64> =
            [4.0, 8.0, 12.0, 16.0, 20.0].iter().map(|rate| late.step(*rate, 0.0)).collect();
        // The delay in samples is rounded once.
        for (read, expected) in read.iter().zip([0.0, 0.0, 3.0, 7.0, 11.0]) {
            assert!((read - expected).abs() < 1e-12, "{read} {expected}");
        }
    }

    #[test]
    fn a_ramp_lags_by_the_delay_of_the_filter() {
        let slope = 0.01;
        // Bandwidth and sample rate of both presets, and the share of a sample that taking the
        // input as constant through each interval costs.
        for (frequency_hz, rate_hz, share) in [(40.0, 1400.0, 2e-5), (100.0, 300.0, 0.02)] {
            let response = low_pass(frequency_hz, FRAC_1_SQRT_2, 0.0);
            let mut responder = Responder::new(&response, rate_hz, Sampling::Instantaneous);
            let mut lag = 0.0;
            for k in 1..=2000 {
                let mean = slope * (f64::from(k) - 0.5);
                lag = f64::from(k) - responder.step(mean, 0.0) / slope;
            }
            let turn = TAU * frequency_hz / rate_hz;
            let off = lag - 2.0 * FRAC_1_SQRT_2 / turn;
            println!("{frequency_hz} Hz at {rate_hz} Hz: lag {lag} samples, off by {off}");
            assert!(off.abs() < share, "off by {off} samples");
        }
    }

    #[test]
    fn settled_on_a_rate_there_is_no_transient() {
        let response = low_pass(40.0, FRAC_1_SQRT_2, 1.5 / RATE_HZ);
        for sampling in [Sampling::Mean, Sampling::Instantaneous] {
            let mut responder = responder(&response, sampling);
            responder.settle(2.0);
            for _ in 0..50 {
                // The rows of the exponential sum to one within their rounding.
                assert!((responder.step(2.0, 0.0) - 2.0).abs() < 1e-13);
            }
        }
    }

    #[test]
    fn no_band_limit_and_no_delay_change_no_bit() {
        let mut none = responder(&Response::default(), Sampling::Mean);
        for rate in [0.1, -3.7, 1e9] {
            assert_eq!(none.step(rate, 0.0).to_bits(), f64::to_bits(rate));
        }
    }
}
