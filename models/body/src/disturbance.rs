//! Torques and blows that nobody commands: noise, impulses, and when they act.

use nalgebra::Vector3;
use struna_kernel::{
    AddressedRandom, Bound, Channel, ParameterError, SampleGrid, Seed, SimTime, TimeError,
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

/// Angular impulses at random times: in each cell of the disturbance grid at most one, at its
/// start, with the probability of a Poisson process of this rate.
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
    /// Whether nothing disturbs.
    pub(crate) fn is_none(&self) -> bool {
        self.noise.is_none() && self.impulses.is_empty() && self.poisson.is_none()
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
    grid: SampleGrid,
    /// Cells matter only when something lives on them.
    noise: Option<(Vector3<f64>, AddressedRandom)>,
    poisson: Option<Poisson>,
    /// Given impulses in the order of time.
    impulses: Vec<Impulse>,
    next_impulse: usize,
    cell: u64,
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
            (sigma, random(Channel::TorqueNoise))
        });
        let poisson = d.poisson.map(|poisson| Poisson {
            probability: 1.0 - libm::exp(-poisson.rate_hz * grid.period_s()),
            sigma_b_n_m_s: poisson.angular_sigma_b_n_m_s.into(),
            times: random(Channel::ImpulseTime),
            sizes: random(Channel::ImpulseSize),
        });
        let mut impulses = d.impulses.clone();
        impulses.sort_by_key(|impulse| impulse.time);
        Ok(Self { grid, noise, poisson, impulses, next_impulse: 0, cell: 0 })
    }

    /// The next instant at which something changes.
    pub(crate) fn next_change(&self) -> Option<SimTime> {
        let cells_matter = self.noise.is_some() || self.poisson.is_some();
        let cell = cells_matter.then(|| self.grid.time_of(self.cell + 1));
        let impulse = self.impulses.get(self.next_impulse).map(|impulse| impulse.time);
        cell.into_iter().chain(impulse).min()
    }

    /// Passes `now`, which [`Self::next_change`] gave, and gives the impulses that act then.
    pub(crate) fn pass(&mut self, now: SimTime) -> Vec<Impulse> {
        let mut acting = Vec::new();
        while let Some(impulse) = self.impulses.get(self.next_impulse).filter(|i| i.time <= now) {
            acting.push(*impulse);
            self.next_impulse += 1;
        }
        if (self.noise.is_some() || self.poisson.is_some())
            && self.grid.time_of(self.cell + 1) <= now
        {
            self.cell += 1;
            acting.extend(self.random_impulse(self.cell));
        }
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
    pub(crate) fn held_b_n_m(&mut self) -> Vector3<f64> {
        self.noise_of(self.cell)
    }

    fn noise_of(&mut self, cell: u64) -> Vector3<f64> {
        match &mut self.noise {
            Some((sigma, random)) => normals(random, cell).component_mul(sigma),
            None => Vector3::zeros(),
        }
    }

    /// Mean noise torque from `from` to `to`, body components, N·m: the same path on a grid of the
    /// engine's own.
    pub(crate) fn mean_noise_b_n_m(&mut self, from: SimTime, to: SimTime) -> Vector3<f64> {
        if self.noise.is_none() || to <= from {
            return Vector3::zeros();
        }
        let mut cell = self.grid.periods_until(from);
        let (mut start, mut sum) = (from, Vector3::zeros());
        while start < to {
            let end = self.grid.time_of(cell + 1).min(to);
            sum += self.noise_of(cell) * end.seconds_since(start);
            (start, cell) = (end, cell + 1);
        }
        sum / to.seconds_since(from)
    }
}

/// Three standard normal numbers of a cell, one for each axis.
fn normals(random: &mut AddressedRandom, cell: u64) -> Vector3<f64> {
    Vector3::from_fn(|axis, _| random.standard_normal(3 * cell + axis as u64))
}
