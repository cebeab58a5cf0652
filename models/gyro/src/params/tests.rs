//! What no gyro can have is refused by name.

use super::*;
use crate::datasheet::vg910d;

fn name_of_refused(change: impl Fn(&mut GyroParams)) -> String {
    let mut params = vg910d();
    change(&mut params);
    match params.validate() {
        Err(refused) => {
            assert!(!refused.reason.is_empty());
            refused.name.to_owned()
        }
        Ok(()) => "accepted".to_owned(),
    }
}

type Place = fn(&mut GyroParams) -> &mut f64;

/// Every number, by the name that its refusal gives.
const PLACES: [(&str, Place); 32] = [
    ("sample_rate_hz", |p| &mut p.sample_rate_hz),
    ("response.natural_frequency_hz", |p| &mut p.response.natural_frequency_hz),
    ("response.damping_ratio", |p| &mut p.response.damping_ratio),
    ("response.delay_s", |p| &mut p.response.delay_s),
    ("scale.error", |p| &mut p.scale.error),
    ("scale.turn_on_sigma", |p| &mut p.scale.turn_on_sigma),
    ("scale.asymmetry", |p| &mut p.scale.asymmetry),
    ("scale.per_deg_c", |p| &mut p.scale.per_deg_c),
    ("|linearity.nonlinearity|", |p| &mut p.linearity.nonlinearity),
    ("bias_rad_s", |p| &mut p.bias_rad_s),
    ("turn_on_bias_sigma_rad_s", |p| &mut p.turn_on_bias_sigma_rad_s),
    ("bias_effects.per_deg_c_rad_s", |p| &mut p.bias_effects.per_deg_c_rad_s),
    ("bias_effects.per_temperature_rate_rad_deg_c", |p| {
        &mut p.bias_effects.per_temperature_rate_rad_deg_c
    }),
    ("bias_effects.per_specific_force_s_m", |p| &mut p.bias_effects.per_specific_force_s_m[0]),
    ("bias_effects.per_specific_force_s_m", |p| &mut p.bias_effects.per_specific_force_s_m[2]),
    ("bias_effects.per_magnetic_field_rad_s_t", |p| &mut p.bias_effects.per_magnetic_field_rad_s_t),
    ("bias_effects.warm_up_rad_s", |p| &mut p.bias_effects.warm_up_rad_s),
    ("bias_effects.warm_up_time_s", |p| &mut p.bias_effects.warm_up_time_s),
    ("bias_effects.on_before_s", |p| &mut p.bias_effects.on_before_s),
    ("angle_random_walk_rad_sqrt_s", |p| &mut p.angle_random_walk_rad_sqrt_s),
    ("drift.bias_instability_rad_s", |p| &mut p.drift.bias_instability_rad_s),
    ("drift.correlation_time_s", |p| &mut p.drift.correlation_time_s),
    ("drift.rate_random_walk_rad_s_sqrt_s", |p| &mut p.drift.rate_random_walk_rad_s_sqrt_s),
    ("drift.rate_ramp_rad_s2", |p| &mut p.drift.rate_ramp_rad_s2),
    ("rate_max_rad_s", |p| &mut p.rate_max_rad_s),
    ("lsb_rad_s", |p| &mut p.lsb_rad_s),
    ("reference_temperature_deg_c", |p| &mut p.reference_temperature_deg_c),
    ("|clock.offset|", |p| &mut p.clock.offset),
    ("clock.turn_on_sigma", |p| &mut p.clock.turn_on_sigma),
    ("|clock.drift_per_s|", |p| &mut p.clock.drift_per_s),
    ("clock.jitter_s", |p| &mut p.clock.jitter_s),
    ("|linearity.nonlinearity|", |p| {
        p.linearity.law = Law::Sine { fold_back: true };
        &mut p.linearity.nonlinearity
    }),
];

#[test]
fn numbers_that_are_none_are_refused_by_name() {
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        for (name, place) in PLACES {
            assert_eq!(name_of_refused(|p| *place(p) = bad), name, "{bad}");
        }
    }
}

#[test]
fn negative_deviations_and_times_are_refused_by_name() {
    let positive = ["sample_rate_hz", "lsb_rad_s", "rate_max_rad_s"];
    for (name, place) in PLACES {
        let is_size = name.contains("sigma")
            || name.contains("walk")
            || name.contains("instability")
            || name.contains("time_s")
            || name.contains("before_s")
            || name.contains("jitter")
            || name.contains("delay")
            || name.contains("frequency")
            || positive.contains(&name);
        if is_size {
            assert_eq!(name_of_refused(|p| *place(p) = -1e-9), name);
        }
        if positive.contains(&name) {
            assert_eq!(name_of_refused(|p| *place(p) = 0.0), name);
        }
    }
    for bad in [0, -1, i32::MIN] {
        assert_eq!(name_of_refused(|p| p.counts_max = bad), "counts_max");
    }
}

#[test]
fn what_overflows_or_is_out_of_proportion_is_refused_by_name() {
    let loud = name_of_refused(|p| {
        p.angle_random_walk_rad_sqrt_s = 1e300;
        p.sample_rate_hz = 1e300;
    });
    assert_eq!(loud, "noise_sigma_rad_s");
    assert_eq!(name_of_refused(|p| p.response.delay_s = 1.0), "response.delay_s * sample_rate_hz");
    let fast = name_of_refused(|p| p.response.natural_frequency_hz = 30_001.0);
    assert_eq!(fast, "response.natural_frequency_hz");
    let untimed = name_of_refused(|p| p.bias_effects.warm_up_rad_s = 1e-3);
    assert_eq!(untimed, "bias_effects.warm_up_time_s");
    for (name, place) in PLACES.iter().filter(|(name, _)| name.contains("clock")) {
        let refused = name_of_refused(|p| *place(p) = 0.2);
        assert!(refused.starts_with(name), "{refused}");
    }
    let bent = name_of_refused(|p| p.linearity.nonlinearity = -0.31);
    assert_eq!(bent, "|linearity.nonlinearity|");
}

#[test]
fn a_range_must_fit_into_the_output_code() {
    let limit = 6_553_600;
    assert_eq!(name_of_refused(|p| p.counts_max = limit), "accepted");
    let narrow = name_of_refused(|p| p.counts_max = limit - 1);
    assert_eq!(narrow, "rate_max_rad_s / lsb_rad_s");
    assert_eq!(name_of_refused(|p| p.lsb_rad_s = 1e-300), "rate_max_rad_s / lsb_rad_s");
}

#[test]
fn a_refusal_names_value_bound_and_reason() {
    let error = GyroParams { lsb_rad_s: -2.0, ..vg910d() }.validate().unwrap_err();
    assert_eq!(
        error.to_string(),
        "lsb_rad_s = -2 is refused: it must be finite and above 0, because counts stand for \
         rates"
    );
}

#[test]
fn a_gyro_without_errors_keeps_its_rate_range_and_code() {
    let all = crate::preset::adis16100();
    let exact = all.without_errors();
    exact.validate().unwrap();
    assert_eq!(exact.sample_rate_hz.to_bits(), all.sample_rate_hz.to_bits());
    assert_eq!(exact.counts_at_range(), all.counts_at_range());
    assert_eq!((exact.sampling, exact.rounding), (all.sampling, all.rounding));
    assert_eq!(exact.drift, DriftParams::default());
    assert_eq!(exact.clock, ClockParams::default());
    assert!(exact.noise_sigma_rad_s() == 0.0 && exact.response == Response::default());
}
