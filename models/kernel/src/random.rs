//! Seeded random streams that do not depend on the order or the thread in which they are drawn.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal, StandardUniform};

/// The seed of a whole campaign: one seed, one record, byte for byte.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Seed(pub u64);

/// What a random stream feeds. Each consumer owns a channel, so adding one leaves the others alone.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[non_exhaustive]
pub enum Channel {
    /// White rate noise (angle random walk) of the gyro.
    GyroAngleRandomWalk,
    /// Run-to-run spread of the gyro's bias.
    GyroTurnOnBias,
    /// Random torque on the body.
    TorqueNoise,
    /// Instants at which the body is struck.
    ImpulseTime,
    /// How hard the body is struck.
    ImpulseSize,
    /// Spread of the starts of a campaign.
    StartError,
    /// Instants at which injected faults begin.
    FaultTime,
    /// What an injected fault hits and how: byte, bit, value, delay.
    FaultChoice,
    /// Trial of a declared noise, for a limit that has no closed form.
    NoiseTrial,
    /// Bias instability of the gyro.
    GyroBiasInstability,
    /// Rate random walk of the gyro.
    GyroRateRandomWalk,
    /// Run-to-run spread of the gyro's scale factor.
    GyroTurnOnScale,
    /// Run-to-run spread of the rate of the gyro's clock.
    GyroClockOffset,
    /// Jitter of the gyro's sample instants.
    GyroClockJitter,
}

impl Channel {
    /// The number that keys the stream. Part of the record format: never renumber.
    const fn number(self) -> u64 {
        match self {
            Self::GyroAngleRandomWalk => 1,
            Self::GyroTurnOnBias => 2,
            Self::TorqueNoise => 3,
            Self::ImpulseTime => 4,
            Self::ImpulseSize => 5,
            Self::StartError => 6,
            Self::FaultTime => 20,
            Self::FaultChoice => 21,
            Self::NoiseTrial => 22,
            Self::GyroBiasInstability => 32,
            Self::GyroRateRandomWalk => 33,
            Self::GyroTurnOnScale => 34,
            Self::GyroClockOffset => 35,
            Self::GyroClockJitter => 36,
        }
    }
}

/// A reproducible stream of random numbers, keyed by (seed, channel, run).
///
/// ChaCha8 is itself a counter-based generator: seed and channel make its key, the run number is
/// its stream, so run *k* draws the same numbers whatever was drawn before it.
#[derive(Debug, Clone)]
pub struct RandomStream(ChaCha8Rng);

impl RandomStream {
    /// Opens the stream of `channel` in run `run` of the campaign `seed`.
    #[must_use]
    pub fn new(seed: Seed, channel: Channel, run: u64) -> Self {
        Self(generator(seed, channel, run))
    }

    /// The next standard normal number (mean 0, variance 1).
    pub fn standard_normal(&mut self) -> f64 {
        StandardNormal.sample(&mut self.0)
    }

    /// The next number uniform in `[0, 1)`.
    pub fn uniform(&mut self) -> f64 {
        StandardUniform.sample(&mut self.0)
    }
}

/// The generator behind (seed, channel, run), at its first word.
pub(crate) fn generator(seed: Seed, channel: Channel, run: u64) -> ChaCha8Rng {
    let mut key = [0_u8; 32];
    key[..8].copy_from_slice(&seed.0.to_le_bytes());
    key[8..16].copy_from_slice(&channel.number().to_le_bytes());
    let mut rng = ChaCha8Rng::from_seed(key);
    rng.set_stream(run);
    rng
}

#[cfg(test)]
mod tests {
    use super::*;

    fn draw(seed: u64, channel: Channel, run: u64) -> Vec<u64> {
        let mut stream = RandomStream::new(Seed(seed), channel, run);
        (0..64).map(|_| stream.standard_normal().to_bits()).collect()
    }

    #[test]
    fn a_run_draws_the_same_numbers_in_any_order() {
        let forwards: Vec<_> = (0..4).map(|k| draw(7, Channel::GyroAngleRandomWalk, k)).collect();
        let mut backwards: Vec<_> =
            (0..4).rev().map(|k| draw(7, Channel::GyroAngleRandomWalk, k)).collect();
        backwards.reverse();
        assert_eq!(forwards, backwards);
    }

    #[test]
    fn seed_channel_and_run_each_change_the_stream() {
        let base = draw(7, Channel::GyroAngleRandomWalk, 0);
        assert_ne!(base, draw(8, Channel::GyroAngleRandomWalk, 0));
        assert_ne!(base, draw(7, Channel::GyroTurnOnBias, 0));
        assert_ne!(base, draw(7, Channel::GyroAngleRandomWalk, 1));
    }

    #[test]
    fn normal_numbers_have_mean_zero_and_variance_one() {
        let n = 200_000;
        let mut stream = RandomStream::new(Seed(1), Channel::GyroAngleRandomWalk, 0);
        let draws: Vec<f64> = (0..n).map(|_| stream.standard_normal()).collect();
        let mean = draws.iter().sum::<f64>() / f64::from(n);
        let variance = draws.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / f64::from(n - 1);
        // Four standard errors: 1/√n for the mean, √(2/n) for the variance.
        assert!(mean.abs() < 4.0 / f64::from(n).sqrt(), "mean {mean}");
        assert!((variance - 1.0).abs() < 4.0 * (2.0 / f64::from(n)).sqrt(), "variance {variance}");
    }
}
