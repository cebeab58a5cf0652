//! Random torques, held on a grid in time.

use super::block::Segment;
use super::lanes::Num;
use super::params::{BatchBody, NoiseGrid};
use super::step::{lane, set_lane};
use struna_kernel::{AddressedRandom, Channel};

/// Most segments filled at once. Their torques stay in the nearest cache.
pub(super) const SEGMENTS_MAX: usize = 32;
const AXES: u64 = 3;

/// The torque on one body.
#[derive(Debug, Clone)]
struct LaneTorque {
    constant_n_m: [f64; 3],
    /// √(S/Δ) for each axis, N·m: what makes the variance of the motion independent of Δ.
    sigma_n_m: [f64; 3],
    /// None for a body without noise, which then costs no random numbers.
    random: Option<Box<AddressedRandom>>,
}

impl LaneTorque {
    fn new(body: &BatchBody, grid: &NoiseGrid, cell_s: f64) -> Self {
        let random = || AddressedRandom::new(grid.seed, Channel::TorqueNoise, body.run);
        Self {
            constant_n_m: body.torque_b_n_m,
            sigma_n_m: body.torque_noise_b_n_m_sqrt_hz.map(|density| density / cell_s.sqrt()),
            random: body.is_noisy().then(|| Box::new(random())),
        }
    }

    fn in_cell(&mut self, cell: u64) -> [f64; 3] {
        let mut torque_n_m = self.constant_n_m;
        if let Some(random) = &mut self.random {
            for ((torque, sigma), axis) in torque_n_m.iter_mut().zip(self.sigma_n_m).zip(0..) {
                *torque += sigma * random.standard_normal(AXES * cell + axis);
            }
        }
        torque_n_m
    }
}

/// The torques on the bodies of one block.
#[derive(Debug, Clone)]
pub(super) struct BlockTorque {
    lanes: Vec<LaneTorque>,
    steps_per_cell: u64,
    noisy: bool,
}

impl BlockTorque {
    pub(super) fn new(bodies: &[BatchBody], grid: &NoiseGrid, step_s: f64) -> Self {
        let cell_s = f64::from(grid.steps_per_cell) * step_s;
        Self {
            lanes: bodies.iter().map(|body| LaneTorque::new(body, grid, cell_s)).collect(),
            steps_per_cell: u64::from(grid.steps_per_cell),
            noisy: bodies.iter().any(BatchBody::is_noisy),
        }
    }

    /// Fills `segments` with the torques from step `from` on, at most up to step `to`; gives the
    /// step they reach.
    pub(super) fn fill<N: Num>(
        &mut self,
        segments: &mut Vec<Segment<N>>,
        mut from: u64,
        to: u64,
    ) -> u64 {
        segments.clear();
        while from < to && segments.len() < SEGMENTS_MAX {
            let cell = from / self.steps_per_cell;
            let cell_end = if self.noisy { (cell + 1) * self.steps_per_cell } else { to };
            let mut segment = Segment { steps: cell_end.min(to) - from, ..Segment::idle() };
            for at in 0..N::LANES {
                // Lanes left over copy the last body's torque as they copy the body.
                let torque_n_m = match self.lanes.get_mut(at) {
                    Some(body) => body.in_cell(cell),
                    None => lane(&segment.torque, self.lanes.len() - 1),
                };
                set_lane(&mut segment.torque, at, &torque_n_m);
            }
            segments.push(segment);
            from = cell_end.min(to);
        }
        from
    }
}
