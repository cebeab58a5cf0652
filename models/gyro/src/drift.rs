//! What moves the bias during a run, slowly: instability, random walk, ramp, warming up.

use crate::GyroParams;
use struna_kernel::{Channel, RandomStream, Seed};

/// Longest cell, s, and smallest number of cells in the shortest time constant.
const CELL_S_MAX: f64 = 0.05;
const CELLS_PER_TIME: f64 = 20.0;

/// Correlation times that make flicker noise, s: flat from some 0.2 s on, below which white noise
/// hides it in any gyro worth the name.
pub(crate) const FLICKER_TIMES_S: [f64; 6] = [0.1, 1.0, 10.0, 100.0, 1e3, 1e4];
/// Variance of each of them over B². Processes of equal variance σ², spaced by the ratio r in
/// correlation time, have the spectral density σ²/(2f·ln r) between their corners; flicker noise
/// has B²/(2πf).
const FLICKER_SHARE: f64 = std::f64::consts::LN_10 * std::f64::consts::FRAC_1_PI;
/// Variance of a single process over B² whose Allan variance peaks at the floor of flicker noise:
/// (2 ln 2/π)/0.381 139, the peak of the Gauss-Markov Allan variance over σ².
pub(crate) const SINGLE_SHARE: f64 = 1.157_770_8;

/// Slow changes of the bias, computed on a grid of cells and linear within each.
///
/// Cells last 0.05 s, a twentieth of the shortest time constant (that of flicker aside, whose
/// fastest process has its cells at half its time) or one sample, whichever is
/// shorter for the first two and longer for the last. At the ends of cells the values are exact,
/// in distribution or in fact; within, a straight line errs by at most (1/20)²/8 = 3·10⁻⁴ of a
/// decaying exponential, and Allan variances are those of the exact processes from some cells on.
#[derive(Debug, Clone)]
pub(crate) struct Drift {
    instability: Instability,
    walk: Walk,
    ramp_rad_s2: f64,
    warm_up: WarmUp,
    cell_s: f64,
    samples_per_cell: u32,
    /// Sample within the cell, from 1; cells so far, the present one included.
    sample: u32,
    cells: u64,
    from_rad_s: f64,
    slope_rad_s: f64,
    warming_up: bool,
}

impl Drift {
    pub(crate) fn new(params: &GyroParams, seed: Seed, run: u64) -> Self {
        let instability_stream = RandomStream::new(seed, Channel::GyroBiasInstability, run);
        let walk_stream = RandomStream::new(seed, Channel::GyroRateRandomWalk, run);
        let warm_up = WarmUp::new(params);
        let samples_per_cell = samples_per_cell(params);
        let cell_s = f64::from(samples_per_cell) / params.sample_rate_hz;
        let walk_sigma_rad_s = params.drift.rate_random_walk_rad_s_sqrt_s * cell_s.sqrt();
        Self {
            instability: Instability::new(params, cell_s, instability_stream),
            walk: Walk { stream: walk_stream, sigma_rad_s: walk_sigma_rad_s, now_rad_s: 0.0 },
            ramp_rad_s2: params.drift.rate_ramp_rad_s2,
            from_rad_s: warm_up.at(0.0),
            warm_up,
            cell_s,
            samples_per_cell,
            sample: samples_per_cell,
            cells: 0,
            slope_rad_s: 0.0,
            warming_up: false,
        }
    }

    /// The bias added to the next sample, rad/s.
    #[inline]
    pub(crate) fn step(&mut self) -> f64 {
        if self.sample == self.samples_per_cell {
            self.enter_cell();
        }
        self.sample += 1;
        self.from_rad_s + self.slope_rad_s * f64::from(self.sample)
    }

    /// Whether the gyro has not warmed up yet: less than three time constants since switch-on, to
    /// the cell.
    #[inline]
    pub(crate) fn is_warming_up(&self) -> bool {
        self.warming_up
    }

    #[inline(never)]
    fn enter_cell(&mut self) {
        let samples = f64::from(self.samples_per_cell);
        if self.cells > 0 {
            self.from_rad_s += self.slope_rad_s * samples;
        }
        self.warming_up = self.warm_up.is_under_way(self.cells as f64 * self.cell_s);
        self.cells += 1;
        let end_s = self.cells as f64 * self.cell_s;
        let end_rad_s = self.instability.step()
            + self.walk.step()
            + self.ramp_rad_s2 * end_s
            + self.warm_up.at(end_s);
        self.slope_rad_s = (end_rad_s - self.from_rad_s) / samples;
        self.sample = 0;
    }
}

/// Samples in a cell.
fn samples_per_cell(params: &GyroParams) -> u32 {
    let mut shortest_s = f64::INFINITY;
    let effects = [
        (params.drift.bias_instability_rad_s, params.drift.correlation_time_s),
        (params.bias_effects.warm_up_rad_s, params.bias_effects.warm_up_time_s),
    ];
    for (size, time_s) in effects {
        if size != 0.0 && time_s > 0.0 {
            shortest_s = shortest_s.min(time_s);
        }
    }
    let samples = (shortest_s / CELLS_PER_TIME).min(CELL_S_MAX) * params.sample_rate_hz;
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "between 1 and a billion by clamp"
    )]
    let whole = samples.clamp(1.0, 1e9) as u32;
    whole
}

/// Bias instability since the start of the run.
#[derive(Debug, Clone)]
struct Instability {
    stream: RandomStream,
    processes: Vec<GaussMarkov>,
    start_rad_s: f64,
}

/// An exponentially correlated process, stepped exactly: x ← x·e^(−T/τ) + σ·√(1 − e^(−2T/τ))·w.
#[derive(Debug, Clone)]
struct GaussMarkov {
    now_rad_s: f64,
    keep: f64,
    renew_rad_s: f64,
}

impl Instability {
    fn new(params: &GyroParams, cell_s: f64, mut stream: RandomStream) -> Self {
        let drift = &params.drift;
        let floor_rad_s = drift.bias_instability_rad_s;
        let single = [drift.correlation_time_s];
        let (times_s, share): (&[f64], f64) = match drift.correlation_time_s {
            _ if floor_rad_s == 0.0 => (&[], 0.0),
            0.0 => (&FLICKER_TIMES_S, FLICKER_SHARE),
            _ => (&single, SINGLE_SHARE),
        };
        let sigma_rad_s = floor_rad_s * share.sqrt();
        let processes: Vec<_> = times_s
            .iter()
            .map(|time_s| GaussMarkov {
                now_rad_s: sigma_rad_s * stream.standard_normal(),
                keep: libm::exp(-cell_s / time_s),
                renew_rad_s: sigma_rad_s * (-libm::expm1(-2.0 * cell_s / time_s)).sqrt(),
            })
            .collect();
        let start_rad_s = processes.iter().map(|process| process.now_rad_s).sum();
        Self { stream, processes, start_rad_s }
    }

    fn step(&mut self) -> f64 {
        let mut sum_rad_s = -self.start_rad_s;
        for process in &mut self.processes {
            let renewed_rad_s = process.renew_rad_s * self.stream.standard_normal();
            process.now_rad_s = process.now_rad_s * process.keep + renewed_rad_s;
            sum_rad_s += process.now_rad_s;
        }
        sum_rad_s
    }
}

/// Rate random walk.
#[derive(Debug, Clone)]
struct Walk {
    stream: RandomStream,
    sigma_rad_s: f64,
    now_rad_s: f64,
}

impl Walk {
    fn step(&mut self) -> f64 {
        if self.sigma_rad_s > 0.0 {
            self.now_rad_s += self.sigma_rad_s * self.stream.standard_normal();
        }
        self.now_rad_s
    }
}

/// What is left of the bias at switch-on.
#[derive(Debug, Clone, Copy)]
struct WarmUp {
    size_rad_s: f64,
    time_s: f64,
    on_before_s: f64,
}

impl WarmUp {
    fn new(params: &GyroParams) -> Self {
        let effects = &params.bias_effects;
        Self {
            size_rad_s: effects.warm_up_rad_s,
            time_s: effects.warm_up_time_s,
            on_before_s: effects.on_before_s,
        }
    }

    fn at(&self, time_s: f64) -> f64 {
        if self.size_rad_s == 0.0 {
            return 0.0;
        }
        self.size_rad_s * libm::exp(-(time_s + self.on_before_s) / self.time_s)
    }

    fn is_under_way(&self, time_s: f64) -> bool {
        self.size_rad_s != 0.0 && time_s + self.on_before_s < 3.0 * self.time_s
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{BiasEffects, DriftParams, datasheet::vg910d};

    const SEED: Seed = Seed(42);

    fn with(drift: DriftParams, bias_effects: BiasEffects) -> GyroParams {
        GyroParams { drift, bias_effects, ..vg910d() }
    }

    fn drift(drift: DriftParams, run: u64) -> Drift {
        Drift::new(&with(drift, BiasEffects::default()), SEED, run)
    }

    /// Allan variance of a Gauss-Markov process of unit variance.
    fn gauss_markov_avar(tau_s: f64, time_s: f64) -> f64 {
        let x = tau_s / time_s;
        (2.0 / x) * (1.0 - (3.0 - 4.0 * (-x).exp() + (-2.0 * x).exp()) / (2.0 * x))
    }

    #[test]
    fn the_sum_over_decades_is_flat_at_the_floor_of_flicker_noise() {
        let floor = 2.0 * std::f64::consts::LN_2 / std::f64::consts::PI;
        for k in 0..=30 {
            let tau_s = 3.0 * 10.0_f64.powf(f64::from(k) / 10.0);
            let sum: f64 = FLICKER_TIMES_S.iter().map(|t| gauss_markov_avar(tau_s, *t)).sum();
            let ratio = (FLICKER_SHARE * sum / floor).sqrt();
            // 3 s to 3000 s: the ends lack the decades beyond, the middle ripples.
            assert!((ratio - 1.0).abs() < 0.08, "{tau_s} s: {ratio} of the floor");
            if (10.0..1000.0).contains(&tau_s) {
                assert!((ratio - 1.0).abs() < 0.03, "{tau_s} s: {ratio} of the floor");
            }
        }
    }

    #[test]
    fn a_single_process_peaks_at_the_floor_of_flicker_noise() {
        let floor = 2.0 * std::f64::consts::LN_2 / std::f64::consts::PI;
        let peak = (100..300)
            .map(|k| SINGLE_SHARE * gauss_markov_avar(f64::from(k) / 100.0, 1.0))
            .fold(0.0, f64::max);
        // The constant has seven digits, the grid misses the flat top by less.
        assert!((peak / floor - 1.0).abs() < 1e-6, "{}", peak / floor);
    }

    #[test]
    fn cells_have_twenty_to_the_shortest_time_and_at_least_one_sample() {
        let cell = |time_s| {
            let instability = DriftParams {
                bias_instability_rad_s: 1.0,
                correlation_time_s: time_s,
                ..DriftParams::default()
            };
            samples_per_cell(&with(instability, BiasEffects::default()))
        };
        // 300 Hz.
        assert_eq!([cell(0.0), cell(300.0), cell(0.5), cell(1e-9)], [15, 15, 7, 1]);
    }

    #[test]
    fn a_ramp_and_a_warm_up_follow_their_closed_forms() {
        let ramp = DriftParams { rate_ramp_rad_s2: 1e-6, ..DriftParams::default() };
        let warming = BiasEffects {
            warm_up_rad_s: 1e-3,
            warm_up_time_s: 2.0,
            on_before_s: 0.5,
            ..BiasEffects::default()
        };
        let mut both = Drift::new(&with(ramp, warming), SEED, 0);
        for k in 1..=3000_u32 {
            let time_s = f64::from(k) / 300.0;
            let left_rad_s = 1e-3 * (-(time_s + 0.5) / 2.0).exp();
            let got_rad_s = both.step();
            // 40 cells in the time constant: a straight line is off by (1/40)²/8 = 8e-5 of it.
            let off = got_rad_s - 1e-6 * time_s - left_rad_s;
            assert!(off.abs() < 8e-5 * left_rad_s + 1e-15, "{time_s} s: {off:e}");
            // Three time constants after switch-on, 5.5 s into the run.
            let edge = (time_s - 5.5).abs() < 1e-9;
            assert!(edge || both.is_warming_up() == (time_s < 5.5), "{time_s} s");
        }
    }

    #[test]
    fn all_drift_is_zero_at_the_start() {
        let wandering = DriftParams {
            bias_instability_rad_s: 1.0,
            rate_random_walk_rad_s_sqrt_s: 0.1,
            ..DriftParams::default()
        };
        for run in 0..20 {
            let first = drift(wandering, run).step();
            // A fifteenth of one cell: the fastest process and the walk move by some 0.02.
            assert!(first.abs() < 0.2, "run {run}: {first}");
        }
    }

    /// Standard deviation, over runs, of what has drifted by 2 s.
    fn spread(params: DriftParams) -> f64 {
        let runs = 4000;
        let sum: f64 = (0..runs)
            .map(|run| {
                let mut drift = drift(params, run);
                (0..600).map(|_| drift.step()).last().unwrap().powi(2)
            })
            .sum();
        (sum / runs as f64).sqrt()
    }

    #[test]
    fn a_rate_random_walk_grows_with_the_root_of_time() {
        let walk = DriftParams { rate_random_walk_rad_s_sqrt_s: 0.1, ..DriftParams::default() };
        let ratio = spread(walk) / (0.1 * 2.0_f64.sqrt());
        // Four standard errors of a deviation over 4000 runs, √(1/8000) each.
        assert!((ratio - 1.0).abs() < 4.0 / 8000.0_f64.sqrt(), "{ratio}");
    }

    #[test]
    fn a_gauss_markov_process_leaves_its_start_as_it_forgets_it() {
        let single = DriftParams {
            bias_instability_rad_s: 0.1,
            correlation_time_s: 2.0,
            ..DriftParams::default()
        };
        // Difference of two values of a stationary process one correlation time apart.
        let expected = 0.1 * (2.0 * SINGLE_SHARE * (1.0 - (-1.0_f64).exp())).sqrt();
        let ratio = spread(single) / expected;
        assert!((ratio - 1.0).abs() < 4.0 / 8000.0_f64.sqrt(), "{ratio}");
    }

    #[test]
    fn each_term_draws_from_a_stream_of_its_own() {
        let instability = DriftParams { bias_instability_rad_s: 0.1, ..DriftParams::default() };
        let walk = DriftParams { rate_random_walk_rad_s_sqrt_s: 0.1, ..DriftParams::default() };
        let both = DriftParams { bias_instability_rad_s: 0.1, ..walk };
        let steps = |params| {
            let mut drift = drift(params, 3);
            (0..1000).map(move |_| drift.step()).collect::<Vec<_>>()
        };
        for ((one, other), sum) in steps(instability).iter().zip(steps(walk)).zip(steps(both)) {
            // Sums of lines in another order.
            assert!((one + other - sum).abs() < 1e-14, "{one} + {other} is not {sum}");
        }
    }
}
