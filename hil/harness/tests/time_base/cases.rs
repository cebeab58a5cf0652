//! Simulated lines: which sample arrived when, and when it was taken.

use struna_kernel::SimTime;
use struna_line::{Bridge, LineModel, LineSettings};

/// The sensor's clock runs this much slow.
pub(crate) const SKEW: f64 = 50e-6;
/// Share of frames lost.
const DROPS: f64 = 1e-3;
/// Share of reads that the host's scheduler holds up, and for how long on average.
const SPIKES: f64 = 0.01;
const SPIKE_S: f64 = 3.9e-3;
/// Mean delay of the other reads.
const JITTER_S: f64 = 40e-6;

/// One sample.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Sample {
    pub(crate) index: u64,
    pub(crate) taken_s: f64,
    pub(crate) arrival: SimTime,
}

/// A line to be simulated.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Case {
    pub(crate) name: &'static str,
    pub(crate) rate_hz: f64,
    pub(crate) frame_bytes: usize,
    pub(crate) baud: f64,
    /// Latency timer of the bridge, ms; zero for none.
    pub(crate) timer_ms: i64,
}

pub(crate) const CASES: [Case; 4] = [
    Case { name: "300 Hz pty", rate_hz: 300.0, frame_bytes: 11, baud: 115_200.0, timer_ms: 0 },
    Case {
        name: "300 Hz FTDI 16 ms",
        rate_hz: 300.0,
        frame_bytes: 11,
        baud: 115_200.0,
        timer_ms: 16,
    },
    Case {
        name: "300 Hz FTDI 1 ms",
        rate_hz: 300.0,
        frame_bytes: 11,
        baud: 115_200.0,
        timer_ms: 1,
    },
    Case {
        name: "1400 Hz FTDI 16 ms",
        rate_hz: 1400.0,
        frame_bytes: 7,
        baud: 230_400.0,
        timer_ms: 16,
    },
];

/// SplitMix64: any good stream will do.
pub(crate) struct Random(pub(crate) u64);

impl Random {
    pub(crate) fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn exponential(&mut self, mean: f64) -> f64 {
        -mean * (1.0 - self.uniform()).ln()
    }
}

impl Case {
    pub(crate) fn period_s(&self) -> f64 {
        1.0 / self.rate_hz
    }

    fn line(&self) -> LineModel {
        let bridge = match self.timer_ms {
            0 => Bridge::Direct,
            timer_ms => Bridge::Ftdi {
                packet_bytes: 62,
                latency_timer: SimTime::from_ns(timer_ms * 1_000_000),
                usb_frame: SimTime::from_ns(1_000_000),
            },
        };
        LineModel::new(LineSettings { bridge, ..LineSettings::direct(self.baud) })
    }

    /// What arrives within `duration_s`. Each read of the host has a delay of its own, and reads
    /// keep their order.
    pub(crate) fn samples(&self, duration_s: f64, seed: u64) -> Vec<Sample> {
        let mut random = Random(seed);
        let mut line = self.line();
        let frame = vec![0; self.frame_bytes];
        // Frames on the line, by the number of the byte that completes each.
        let mut sent: Vec<(u64, f64)> = Vec::new();
        let (mut samples, mut bytes, mut last_ns) = (Vec::new(), 0, 0);
        let count = whole(duration_s * self.rate_hz);
        for index in 0..count {
            let taken_s = index as f64 * self.period_s() * (1.0 + SKEW);
            if random.uniform() < DROPS {
                continue;
            }
            sent.push((index, taken_s));
            line.send(SimTime::from_s(taken_s).unwrap(), &frame, &mut |time, chunk| {
                let spike = if random.uniform() < SPIKES { SPIKE_S } else { 0.0 };
                let delay_s = random.exponential(JITTER_S) + random.exponential(spike);
                last_ns = last_ns.max(SimTime::from_s(time.as_s() + delay_s).unwrap().as_ns());
                bytes += chunk.len();
                let arrival = SimTime::from_ns(last_ns);
                while samples.len() < bytes / self.frame_bytes {
                    let (index, taken_s) = sent[samples.len()];
                    samples.push(Sample { index, taken_s, arrival });
                }
            });
        }
        samples
    }
}

fn whole(number: f64) -> u64 {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "small, positive"
    )]
    return number as u64;
}
