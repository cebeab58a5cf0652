//! What the tests of the two-state filters tell them.

use struna_estimator::{FilterConfig, Refinement};

/// A rotation about known to 0.2 rad, a gyro of 45 m°/s, and a little torque noise: nothing that a
/// filter does is then too small to be seen.
pub(crate) const CONFIG: FilterConfig = FilterConfig {
    angle_start_rad: 6.0,
    rate_start_rad_s: 0.0,
    angle_variance_start_rad2: 0.04,
    rate_variance_start_rad2_s2: 0.01,
    measurement_variance_rad2_s2: 6e-7,
    process_noise_rad2_s3: 1e-8,
    refinement: Refinement::OFF,
};
