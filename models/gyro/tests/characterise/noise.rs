//! Noise with known coefficients, made sample by sample and apart from what is under test.

use struna_gyro::characterise::{NoiseModel, RateRecord, Term};
use struna_kernel::{Channel, RAD_PER_DEG, RandomStream, Seed};

/// Gauss-Markov processes per decade of correlation time in flicker. Two leave a ripple of a
/// hundredth in the Allan variance.
const PER_DECADE: f64 = 2.0;

/// °/h as rad/s.
pub(crate) const DEG_H: f64 = RAD_PER_DEG / 3600.0;

/// Noise of a model at a rate.
pub(crate) struct Maker {
    white: f64,
    walk: f64,
    rounding: f64,
    ramp: f64,
    walked: f64,
    rounded: f64,
    index: f64,
    /// State, decay and step of each Gauss-Markov process.
    flicker: Vec<[f64; 3]>,
    stream: RandomStream,
}

impl Maker {
    /// Noise for about `samples` samples, in run `run`.
    pub(crate) fn new(model: &NoiseModel, rate_hz: f64, samples: usize, run: u64) -> Self {
        // Any channel does; it only keys the stream.
        let mut stream = RandomStream::new(Seed(1963), Channel::GyroAngleRandomWalk, run);
        let step_s = 1.0 / rate_hz;
        let rounding = model.coefficient(Term::Quantisation) / step_s;
        let spacing = std::f64::consts::LN_10 / PER_DECADE;
        let b = model.coefficient(Term::BiasInstability);
        let sigma = b * (spacing / std::f64::consts::PI).sqrt();
        let corners = (0..).map(|k| 0.5 * (spacing * f64::from(k)).exp());
        let flicker = corners.take_while(|c| b > 0.0 && *c < 5.0 * samples as f64).map(|corner| {
            let decay = f64::exp(-1.0 / corner);
            [sigma * stream.standard_normal(), decay, sigma * (1.0 - decay * decay).sqrt()]
        });
        Self {
            flicker: flicker.collect(),
            white: model.coefficient(Term::AngleRandomWalk) / step_s.sqrt(),
            walk: model.coefficient(Term::RateRandomWalk) * step_s.sqrt(),
            rounded: rounding * stream.standard_normal(),
            rounding,
            ramp: model.coefficient(Term::RateRamp) * step_s,
            walked: 0.0,
            index: 0.0,
            stream,
        }
    }

    fn next(&mut self) -> f64 {
        let mut rate = self.white * self.stream.standard_normal() + self.ramp * self.index;
        self.index += 1.0;
        if self.walk > 0.0 {
            self.walked += self.walk * self.stream.standard_normal();
        }
        if self.rounding > 0.0 {
            let before = self.rounded;
            self.rounded = self.rounding * self.stream.standard_normal();
            rate += self.rounded - before;
        }
        for [state, decay, step] in &mut self.flicker {
            *state = *decay * *state + *step * self.stream.standard_normal();
            rate += *state;
        }
        rate + self.walked
    }

    /// The next `samples` rates.
    pub(crate) fn take(&mut self, samples: usize) -> Vec<f64> {
        (0..samples).map(|_| self.next()).collect()
    }
}

/// A record of the model.
pub(crate) fn record(model: &NoiseModel, rate_hz: f64, samples: usize, run: u64) -> RateRecord {
    let rates = Maker::new(model, rate_hz, samples, run).take(samples);
    RateRecord::contiguous(rate_hz, rates).expect("a positive rate")
}

/// A model of one term.
pub(crate) fn single(term: Term, coefficient: f64) -> NoiseModel {
    let mut coefficients = [0.0; 5];
    coefficients[term.index()] = coefficient;
    NoiseModel::from_coefficients(coefficients)
}

/// A fibre-optic gyro of the middle class: 0.0014 °/s/√Hz, 1 °/h and 3 °/h/√h.
pub(crate) fn gyro() -> NoiseModel {
    NoiseModel::from_coefficients([0.0, 1.4e-3 * RAD_PER_DEG, DEG_H, 3.0 * DEG_H / 60.0, 0.0])
}
