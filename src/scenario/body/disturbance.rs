//! `[body.disturbance]`: torque noise and blows. The seed is the run's.

use super::super::numbers::{or, section, triple};
use struna_body::{DISTURBANCE_GRID_HZ, Disturbances, Impulse, PoissonImpulses, TorqueNoise};
use struna_kernel::SimTime;
use struna_settings::{Result, Table, Value};

/// More impulses than anyone writes by hand.
const IMPULSES_MAX: usize = 1000;
/// Cells of the disturbance grid are integrated one by one.
const GRID_HZ_MAX: f64 = 1e5;

pub(super) fn disturbances(disturbance: &Table<'_>) -> Result<Disturbances> {
    disturbance.only(&["grid_hz", "torque_noise_n_m_sqrt_hz", "impulse", "random_impulses"])?;
    let grid = |value: &Value<'_>| value.number_in(1e-3..=GRID_HZ_MAX);
    let noise = disturbance.optional("torque_noise_n_m_sqrt_hz");
    let impulses = disturbance.tables("impulse", IMPULSES_MAX)?;
    Ok(Disturbances {
        grid_hz: or(disturbance, "grid_hz", grid, DISTURBANCE_GRID_HZ)?,
        noise: noise.map(|value| torque_noise(&value)).transpose()?,
        impulses: impulses.iter().map(impulse).collect::<Result<_>>()?,
        poisson: section(disturbance, "random_impulses", random_impulses)?,
        ..Disturbances::default()
    })
}

fn torque_noise(value: &Value<'_>) -> Result<TorqueNoise> {
    Ok(TorqueNoise { density_b_n_m_sqrt_hz: triple(value, Value::not_negative)? })
}

fn impulse(impulse: &Table<'_>) -> Result<Impulse> {
    impulse.only(&["time_s", "angular_n_m_s", "linear_n_s"])?;
    let time = impulse.required("time_s")?;
    let part = |key: &str| or(impulse, key, |value| triple(value, Value::number), [0.0; 3]);
    Ok(Impulse {
        time: SimTime::from_s(time.not_negative()?).map_err(|e| time.because(e.to_string()))?,
        angular_b_n_m_s: part("angular_n_m_s")?,
        linear_w_n_s: part("linear_n_s")?,
    })
}

fn random_impulses(random: &Table<'_>) -> Result<PoissonImpulses> {
    random.only(&["rate_hz", "angular_sigma_n_m_s"])?;
    let sigma = random.required("angular_sigma_n_m_s")?;
    Ok(PoissonImpulses {
        rate_hz: random.required("rate_hz")?.positive()?,
        angular_sigma_b_n_m_s: triple(&sigma, Value::not_negative)?,
    })
}
