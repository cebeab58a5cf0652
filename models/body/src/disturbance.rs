//! Torques and blows that nobody commands: noise, impulses, and when they act.

use nalgebra::Vector3;
use struna_kernel::{
    AddressedRandom, Bound, Channel, GridWalk, ParameterError, SampleGrid, Seed, SimTime, TimeError,
};

/// Rate of the disturbance grid unless told otherwise, Hz.
pub const DISTURBANCE_GRID_HZ: f64 = 1400.0;

/// White torque noise about the three body axes.
///
/// On each cell of the disturbance grid, of length Δ, the torque is held at a Gaussian value of
/// variance S/Δ. The value of a cell depends on seed, run, cell and axis only, so the path is the
/// same whatever step the integration takes and wherever it is sampled.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TorqueNoise {
    /// √S about each body axis, N·m/√Hz, with S the two-sided spectral density.
    pub density_b_n_m_sqrt_hz: [f64; 3],
}

/// A blow too short to be resolved.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Impulse {
    /// When it acts. The motion at this very instant is still the one before.
    pub time: SimTime,
    /// Angular impulse, body components, N·m·s.
    pub angular_b_n_m_s: [f64; 3],
    /// Linear impulse through the centre of mass, world components, N·s.
    pub linear_w_n_s: [f64; 3],
}

/// Angular impulses at random times: in each cell of the disturbance grid but the first at most
/// one, at its start, with the probability of a Poisson process of this rate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PoissonImpulses {
    /// Mean number in a second, Hz.
    pub rate_hz: f64,
    /// Standard deviation of the angular impulse about each body axis, N·m·s.
    pub angular_sigma_b_n_m_s: [f64; 3],
}

/// All disturbances of a run.
#[derive(Debug, Clone, PartialEq)]
pub struct Disturbances {
    /// Key of everything random here, with `run`.
    pub seed: Seed,
    /// Number of the run within its campaign.
    pub run: u64,
    /// Cells in a second of the grid on which noise and random impulses live, Hz.
    pub grid_hz: f64,
    /// White torque noise.
    pub noise: Option<TorqueNoise>,
    /// Impulses at given times.
    pub impulses: Vec<Impulse>,
    /// Impulses at random times.
    pub poisson: Option<PoissonImpulses>,
}

impl Default for Disturbances {
    fn default() -> Self {
        Self {
            seed: Seed(0),
            run: 0,
            grid_hz: DISTURBANCE_GRID_HZ,
            noise: None,
            impulses: Vec::new(),
            poisson: None,
        }
    }
}

impl Disturbances {
    /// Whether no impulse strikes.
    pub(crate) fn is_noise_at_most(&self) -> bool {
        self.impulses.is_empty() && self.poisson.is_none()
    }

    pub(crate) fn check(&self) -> Result<(), ParameterError> {
        if let Some(noise) = &self.noise {
            for density in noise.density_b_n_m_sqrt_hz {
                let reason = "a density is the root of a power";
                Bound::AtLeast(0.0).check("torque_noise_n_m_sqrt_hz", density, reason)?;
            }
        }
        for impulse in &self.impulses {
            for part in impulse.angular_b_n_m_s.iter().chain(&impulse.linear_w_n_s) {
                Bound::Finite.check("impulse", *part, "the body cannot follow it")?;
            }
            let reason = "the run starts at zero";
            Bound::AtLeast(0.0).check("impulse_time_s", impulse.time.as_s(), reason)?;
        }
        if let Some(poisson) = &self.poisson {
            let rate = "impulses come one by one";
            Bound::Above(0.0).check("impulse_rate_hz", poisson.rate_hz, rate)?;
            // Above a tenth of the cells, two in one cell would no longer be rare.
            let cells = "impulses this dense are noise; raise the grid rate or use torque noise";
            Bound::AtMost(0.1 * self.grid_hz).check("impulse_rate_hz", poisson.rate_hz, cells)?;
            for sigma in poisson.angular_sigma_b_n_m_s {
                let reason = "a standard deviation is not negative";
                Bound::AtLeast(0.0).check("impulse_sigma_n_m_s", sigma, reason)?;
            }
        }
        Ok(())
    }
}

/// The disturbances of a run in the order of time.
#[derive(Debug, Clone)]
pub(crate) struct Timeline {
    grid: GridWalk,
    /// Cells matter only when something lives on them.
    noise: Option<Noise>,
    poisson: Option<Poisson>,
    /// Given impulses in the order of time.
    impulses: Vec<Impulse>,
    next_impulse: usize,
    cell: u64,
    /// Where the current cell ends, if cells matter; kept, for a grid divides to find it.
    cell_end: Option<SimTime>,
    /// See [`Self::next_change`]; kept, for it is asked for with every sample.
    next_change: Option<SimTime>,
}

/// Cells whose numbers are drawn at once.
const CELLS: usize = 16;
const AXES: usize = 3;

/// The torques of the cells.
#[derive(Debug, Clone)]
struct Noise {
    sigma_b_n_m: Vector3<f64>,
    random: AddressedRandom,
    /// Number of the block of cells held, none before the first reading, and the normal numbers
    /// of its cells, one for each axis.
    block: Option<u64>,
    normals: [f64; CELLS * AXES],
}

impl Noise {
    fn new(sigma_b_n_m: Vector3<f64>, random: AddressedRandom) -> Self {
        Self { sigma_b_n_m, random, block: None, normals: [0.0; CELLS * AXES] }
    }

    /// Torque held on `cell`, body components, N·m.
    #[inline(always)]
    fn of(&mut self, cell: u64) -> Vector3<f64> {
        let block = cell / CELLS as u64;
        if self.block != Some(block) {
            self.read_block(block);
        }
        #[expect(clippy::cast_possible_truncation, reason = "the remainder is below CELLS")]
        let first = AXES * (cell % CELLS as u64) as usize;
        let [x, y, z] = [0, 1, 2].map(|axis| self.normals[first + axis]);
        Vector3::new(x, y, z).component_mul(&self.sigma_b_n_m)
    }

    #[inline(never)]
    fn read_block(&mut self, block: u64) {
        let first = (CELLS * AXES) as u64 * block;
        self.random.fill_standard_normal(first, &mut self.normals);
        self.block = Some(block);
    }
}

#[derive(Debug, Clone)]
struct Poisson {
    probability: f64,
    sigma_b_n_m_s: Vector3<f64>,
    times: AddressedRandom,
    sizes: AddressedRandom,
}

impl Timeline {
    pub(crate) fn new(disturbances: &Disturbances) -> Result<Self, TimeError> {
        let d = disturbances;
        let grid = SampleGrid::new(SimTime::ZERO, d.grid_hz)?;
        let random = |channel| AddressedRandom::new(d.seed, channel, d.run);
        let noise = d.noise.map(|noise| {
            // Variance S/Δ on each cell: the integral over a second then has variance S.
            let sigma = Vector3::from(noise.density_b_n_m_sqrt_hz) / grid.period_s().sqrt();
            Noise::new(sigma, random(Channel::TorqueNoise))
        });
        let poisson = d.poisson.map(|poisson| Poisson {
            probability: 1.0 - libm::exp(-poisson.rate_hz * grid.period_s()),
            sigma_b_n_m_s: poisson.angular_sigma_b_n_m_s.into(),
            times: random(Channel::ImpulseTime),
            sizes: random(Channel::ImpulseSize),
        });
        let mut impulses = d.impulses.clone();
        impulses.sort_by_key(|impulse| impulse.time);
        let cells_matter = noise.is_some() || poisson.is_some();
        let mut grid = GridWalk::new(grid);
        let cell_end = cells_matter.then(|| grid.time_of(1));
        let first = impulses.first().map(|impulse| impulse.time);
        let next_change = earlier(cell_end, first);
        let (next_impulse, cell) = (0, 0);
        Ok(Self { grid, noise, poisson, impulses, next_impulse, cell, cell_end, next_change })
    }

    /// The next instant at which something changes.
    #[inline]
    pub(crate) fn next_change(&self) -> Option<SimTime> {
        self.next_change
    }

    /// Passes `now`, which [`Self::next_change`] gave, and gives the impulses that act then.
    #[inline(always)]
    pub(crate) fn pass(&mut self, now: SimTime) -> Vec<Impulse> {
        let mut acting = Vec::new();
        while let Some(impulse) = self.impulses.get(self.next_impulse).filter(|i| i.time <= now) {
            acting.push(*impulse);
            self.next_impulse += 1;
        }
        if self.cell_end.is_some_and(|end| end <= now) {
            self.cell += 1;
            self.cell_end = Some(self.grid.time_of(self.cell + 1));
            if self.poisson.is_some() {
                acting.extend(self.random_impulse(self.cell));
            }
        }
        let impulse = self.impulses.get(self.next_impulse).map(|impulse| impulse.time);
        self.next_change = earlier(self.cell_end, impulse);
        acting
    }

    fn random_impulse(&mut self, cell: u64) -> Option<Impulse> {
        let time = self.grid.time_of(cell);
        let poisson = self.poisson.as_mut()?;
        if poisson.times.uniform(cell) >= poisson.probability {
            return None;
        }
        let size = normals(&mut poisson.sizes, cell).component_mul(&poisson.sigma_b_n_m_s);
        Some(Impulse { time, angular_b_n_m_s: size.into(), linear_w_n_s: [0.0; 3] })
    }

    /// Torque held on the current cell, body components, N·m.
    #[inline(always)]
    pub(crate) fn held_b_n_m(&mut self) -> Vector3<f64> {
        self.noise_of(self.cell)
    }

    #[inline(always)]
    fn noise_of(&mut self, cell: u64) -> Vector3<f64> {
        match &mut self.noise {
            Some(noise) => noise.of(cell),
            None => Vector3::zeros(),
        }
    }

    /// Mean noise torque from `from` to `to`, body components, N·m: the same path on a grid of the
    /// engine's own.
    pub(crate) fn mean_noise_b_n_m(&mut self, from: SimTime, to: SimTime) -> Vector3<f64> {
        if self.noise.is_none() || to <= from {
            return Vector3::zeros();
        }
        let mut cell = self.grid.grid().periods_until(from);
        let (mut start, mut sum) = (from, Vector3::zeros());
        while start < to {
            let end = self.grid.time_of(cell + 1).min(to);
            sum += self.noise_of(cell) * end.seconds_since(start);
            (start, cell) = (end, cell + 1);
        }
        sum / to.seconds_since(from)
    }
}

/// The earlier of two instants, where there are any.
#[inline]
fn earlier(a: Option<SimTime>, b: Option<SimTime>) -> Option<SimTime> {
    match (a, b) {
        (Some(a), Some(b)) => Some(a.min(b)),
        (a, b) => a.or(b),
    }
}

/// Three standard normal numbers of a cell, one for each axis.
fn normals(random: &mut AddressedRandom, cell: u64) -> Vector3<f64> {
    Vector3::from_fn(|axis, _| random.standard_normal(3 * cell + axis as u64))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn timeline(disturbances: &Disturbances) -> Timeline {
        Timeline::new(disturbances).unwrap()
    }

    fn noisy(grid_hz: f64) -> Disturbances {
        let noise = Some(TorqueNoise { density_b_n_m_sqrt_hz: [1e-3, 2e-3, 0.0] });
        Disturbances { seed: Seed(3), grid_hz, noise, ..Disturbances::default() }
    }

    #[test]
    fn a_cell_holds_the_numbers_of_its_addresses_in_whatever_order_it_is_asked_for() {
        let mut timeline = timeline(&noisy(100.0));
        let mut random = AddressedRandom::new(Seed(3), Channel::TorqueNoise, 0);
        let sigma_n_m = [1e-3, 2e-3, 0.0].map(|density: f64| density / 0.1);
        for cell in [0, 1, 15, 16, 17, 1000, 3, 31, 16] {
            let torque = timeline.noise_of(cell);
            for (axis, sigma_n_m) in (0..3).zip(sigma_n_m) {
                let expected = sigma_n_m * random.standard_normal(3 * cell + axis as u64);
                // The root of the period and one product.
                let off = (torque[axis] - expected).abs();
                assert!(off <= 4.0 * f64::EPSILON * expected.abs(), "cell {cell}, axis {axis}");
            }
        }
    }

    proptest! {
        #[test]
        fn the_mean_noise_of_any_partition_adds_up_to_the_same_integral(
            grid_hz in 1.0..3000.0_f64,
            mut cuts_ns in proptest::collection::vec(0..5_000_000_i64, 2..12),
        ) {
            cuts_ns.sort_unstable();
            let mut timeline = timeline(&noisy(grid_hz));
            let cuts: Vec<_> = cuts_ns.into_iter().map(SimTime::from_ns).collect();
            let mut integral = |from: SimTime, to: SimTime| {
                timeline.mean_noise_b_n_m(from, to) * to.seconds_since(from)
            };
            let parts: Vector3<f64> = cuts.windows(2).map(|w| integral(w[0], w[1])).sum();
            let whole = integral(cuts[0], cuts[cuts.len() - 1]);
            // Some thirty roundings of 0.2 N·m times 5 ms.
            prop_assert!((parts - whole).norm() < 1e-17, "{parts} {whole}");
        }

        #[test]
        fn the_mean_noise_of_a_cell_is_the_torque_held_on_it(
            grid_hz in 1.0..3000.0_f64,
            cell in 0..5000_u64,
        ) {
            let mut timeline = timeline(&noisy(grid_hz));
            let (from, to) = (timeline.grid.time_of(cell), timeline.grid.time_of(cell + 1));
            let held = timeline.noise_of(cell);
            let mean = timeline.mean_noise_b_n_m(from, to);
            prop_assert!((mean - held).norm() <= 4.0 * f64::EPSILON * held.norm());
        }
    }

    #[test]
    fn no_noise_and_no_time_have_no_mean() {
        let at = SimTime::from_ns(1_000_000);
        assert_eq!(timeline(&noisy(70.0)).mean_noise_b_n_m(at, at), Vector3::zeros());
        let mut quiet = timeline(&Disturbances::default());
        assert_eq!(quiet.mean_noise_b_n_m(SimTime::ZERO, at), Vector3::zeros());
        assert_eq!(quiet.next_change(), None);
    }

    #[test]
    fn the_held_value_has_the_spectral_density_on_each_axis() {
        let grid_hz = 200.0;
        let mut timeline = timeline(&noisy(grid_hz));
        let n = 20_000_u32;
        let mut square = Vector3::zeros();
        for cell in 0..u64::from(n) {
            square += timeline.noise_of(cell).map(|v| v * v) / f64::from(n);
        }
        // The variance of n squares: four standard errors of √(2/n).
        let slack = 4.0 * (2.0 / f64::from(n)).sqrt();
        assert!((square.x / (1e-6 * grid_hz) - 1.0).abs() < slack, "{square}");
        assert!((square.y / (4e-6 * grid_hz) - 1.0).abs() < slack, "{square}");
        assert!(square.z == 0.0);
    }

    fn poisson(rate_hz: f64) -> Disturbances {
        let poisson = PoissonImpulses { rate_hz, angular_sigma_b_n_m_s: [1e-3, 2e-3, 0.0] };
        Disturbances { poisson: Some(poisson), grid_hz: 100.0, ..Disturbances::default() }
    }

    #[test]
    fn random_impulses_come_as_often_and_as_hard_as_they_say() {
        let mut timeline = timeline(&poisson(5.0));
        let cells = 100_000_u64;
        let impulses: Vec<_> = (1..=cells).filter_map(|k| timeline.random_impulse(k)).collect();
        let n = impulses.len() as f64;
        // Binomial: at a mean rate of 5 Hz in cells of 10 ms, p = 1 − e^{−1/20}.
        let p = 1.0 - (-0.05_f64).exp();
        let mean = p * cells as f64;
        assert!((n - mean).abs() < 4.0 * (mean * (1.0 - p)).sqrt(), "{n} against {mean}");
        for (axis, sigma) in [1e-3, 2e-3].into_iter().enumerate() {
            let square = impulses.iter().map(|i| i.angular_b_n_m_s[axis].powi(2)).sum::<f64>() / n;
            assert!((square / (sigma * sigma) - 1.0).abs() < 4.0 * (2.0 / n).sqrt(), "{axis}");
        }
        assert!(impulses.iter().all(|i| i.angular_b_n_m_s[2] == 0.0));
        assert!(impulses.iter().all(|i| i.linear_w_n_s.iter().all(|part| *part == 0.0)));
    }

    /// Every impulse of the first second, in the order in which it acts.
    fn passed(disturbances: &Disturbances) -> Vec<Impulse> {
        let mut timeline = timeline(disturbances);
        let mut all = Vec::new();
        while let Some(change) = timeline.next_change().filter(|t| t.as_s() <= 1.0) {
            all.extend(timeline.pass(change));
        }
        all
    }

    #[test]
    fn given_impulses_act_once_each_in_the_order_of_time() {
        let at = |ns| Impulse {
            time: SimTime::from_ns(ns),
            angular_b_n_m_s: [ns as f64, 0.0, 0.0],
            linear_w_n_s: [0.0; 3],
        };
        let impulses = vec![at(900_000_000), at(0), at(10_000_000), at(10_000_000), at(12_345)];
        let sorted = vec![at(0), at(12_345), at(10_000_000), at(10_000_000), at(900_000_000)];
        let given = Disturbances { impulses, ..Disturbances::default() };
        assert_eq!(passed(&given), sorted);
        // Among cells of noise, one of whose borders they share.
        let among = Disturbances { grid_hz: 100.0, ..noisy(100.0) };
        assert_eq!(passed(&Disturbances { impulses: given.impulses, ..among }), sorted);
    }

    #[test]
    fn seed_and_run_choose_the_random_impulses() {
        let one = passed(&poisson(10.0));
        assert!(!one.is_empty());
        assert_eq!(one, passed(&poisson(10.0)));
        assert_ne!(one, passed(&Disturbances { run: 1, ..poisson(10.0) }));
        assert_ne!(one, passed(&Disturbances { seed: Seed(1), ..poisson(10.0) }));
        let grid = SampleGrid::new(SimTime::ZERO, 100.0).unwrap();
        for impulse in one {
            assert_eq!(grid.time_of(grid.periods_until(impulse.time)), impulse.time);
        }
    }

    fn refusal(disturbances: &Disturbances) -> (&'static str, Bound) {
        let refused = disturbances.check().unwrap_err();
        assert!(!refused.reason.is_empty());
        (refused.name, refused.bound)
    }

    #[test]
    fn disturbances_that_cannot_be_are_refused_by_name_and_bound() {
        for axis in 0..3 {
            for bad in [-1e-9, f64::NAN, f64::INFINITY] {
                let mut density_b_n_m_sqrt_hz = [0.0; 3];
                density_b_n_m_sqrt_hz[axis] = bad;
                let noise = Some(TorqueNoise { density_b_n_m_sqrt_hz });
                let disturbed = Disturbances { noise, ..Disturbances::default() };
                let expected = ("torque_noise_n_m_sqrt_hz", Bound::AtLeast(0.0));
                assert_eq!(refusal(&disturbed), expected);
                let mut disturbed = poisson(5.0);
                disturbed.poisson.as_mut().unwrap().angular_sigma_b_n_m_s[axis] = bad;
                assert_eq!(refusal(&disturbed), ("impulse_sigma_n_m_s", Bound::AtLeast(0.0)));
            }
        }
        for bad in [0.0, -1.0, f64::NAN] {
            assert_eq!(refusal(&poisson(bad)), ("impulse_rate_hz", Bound::Above(0.0)));
        }
        assert_eq!(refusal(&poisson(10.1)), ("impulse_rate_hz", Bound::AtMost(10.0)));
        assert!(poisson(10.0).check().is_ok(), "a tenth of the cells");
    }

    #[test]
    fn blows_that_cannot_be_are_refused_by_name_and_bound() {
        let blow =
            Impulse { time: SimTime::ZERO, angular_b_n_m_s: [0.1; 3], linear_w_n_s: [0.1; 3] };
        let with =
            |impulse| Disturbances { impulses: vec![blow, impulse], ..Disturbances::default() };
        assert!(with(blow).check().is_ok());
        for bad in [f64::NAN, f64::NEG_INFINITY] {
            let angular = Impulse { angular_b_n_m_s: [0.0, bad, 0.0], ..blow };
            assert_eq!(refusal(&with(angular)), ("impulse", Bound::Finite));
            let linear = Impulse { linear_w_n_s: [0.0, 0.0, bad], ..blow };
            assert_eq!(refusal(&with(linear)), ("impulse", Bound::Finite));
        }
        let early = Impulse { time: SimTime::from_ns(-1), ..blow };
        assert_eq!(refusal(&with(early)), ("impulse_time_s", Bound::AtLeast(0.0)));
    }
}
