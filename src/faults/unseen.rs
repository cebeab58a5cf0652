//! What of a scenario's faults nobody will notice, said before the run.

use crate::scenario::Scenario;
use struna_harness::monitor::{Declared, Limits, Observability, observability};

/// A scenario declares no motion, so a body may turn as sharply as it likes, rad/s².
const ACCELERATION_RAD_S2: f64 = 1e6;

/// A line for each fault of `scenario` that one gyro cannot show, with the reason. Nothing is said
/// when a gyro of these parameters cannot be monitored at all.
#[must_use]
pub fn unseen(scenario: &Scenario) -> Vec<String> {
    let declared = declared(scenario);
    let Ok(limits) = Limits::of(&declared) else { return Vec::new() };
    let faults = scenario.faults.faults().iter().enumerate();
    faults
        .filter_map(|(k, fault)| match observability(fault, &declared, &limits) {
            Observability::Observable => None,
            Observability::NotObservable(reason) => {
                let name = fault.kind.name();
                Some(format!("fault {k} ({name}) is not observable with this gyro: {reason}"))
            }
        })
        .collect()
}

fn declared(scenario: &Scenario) -> Declared {
    let (gyro, frame) = (&scenario.gyro, &scenario.frame);
    let band_hz = gyro.response.natural_frequency_hz;
    let filtered = gyro.response.noise_before_filter && band_hz > 0.0;
    Declared {
        sample_rate_hz: gyro.sample_rate_hz,
        frame_len: frame.frame_len(),
        counter_modulus: frame.sequence().map(|sequence| sequence.modulus()),
        rate_max_rad_s: gyro.rate_max_rad_s,
        lsb_rad_s: gyro.lsb_rad_s,
        // White noise of deviation N·√f has N·√(π·f₀/√2) behind a Butterworth filter.
        noise_sigma_rad_s: if filtered {
            let width_hz = std::f64::consts::PI * band_hz / std::f64::consts::SQRT_2;
            gyro.angle_random_walk_rad_sqrt_s * width_hz.sqrt()
        } else {
            gyro.noise_sigma_rad_s()
        },
        noise_bandwidth_hz: filtered.then_some(band_hz),
        acceleration_max_rad_s2: ACCELERATION_RAD_S2,
        bias_max_rad_s: gyro.bias_rad_s.abs() + 4.0 * gyro.turn_on_bias_sigma_rad_s,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    #[test]
    fn the_example_says_which_of_its_faults_nobody_will_notice() {
        let text = include_str!("../../scenarios/faults.toml");
        let scenario = Scenario::parse(text, Path::new("scenarios/faults.toml")).unwrap();
        assert_eq!(scenario.faults.faults().len(), 3);
        let unseen = unseen(&scenario);
        assert_eq!(unseen.len(), 1, "{unseen:?}");
        assert!(unseen[0].contains("fault 2 (bias-step)"), "{unseen:?}");
    }
}
