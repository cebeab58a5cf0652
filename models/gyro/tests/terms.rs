//! Every deterministic term of the error model against its closed form, one at a time.

#![expect(clippy::unwrap_used, reason = "a failed unwrap fails the test")]

use std::f64::consts::{FRAC_1_SQRT_2, FRAC_PI_2, TAU};
use struna_gyro::datasheet::{rad_s_from_deg_h, rad_s_from_deg_s, vg910d};
use struna_gyro::{
    BiasEffects, DriftParams, Gyro, GyroInput, GyroParams, Law, Linearity, Response, Rounding,
    SINE_NONLINEARITY, Sampling, ScaleFactor, preset,
};
use struna_kernel::{Seed, SimTime};

/// A VG-910D that clips and rounds and has no other error.
fn exact() -> GyroParams {
    vg910d().without_errors()
}

fn gyro(params: GyroParams) -> Gyro {
    Gyro::new(params, Seed(42), 0).unwrap()
}

/// The rate that is read of one input, rad/s.
fn read(gyro: &mut Gyro, input: impl Into<GyroInput>) -> f64 {
    f64::from(gyro.sample(input).counts.0) * gyro.params().lsb_rad_s
}

/// Half a count, and some roundings of rates of up to 4 rad/s.
fn half_a_count_rad_s() -> f64 {
    0.5 * exact().lsb_rad_s + 4e-15
}

#[track_caller]
fn reads(gyro: &mut Gyro, input: impl Into<GyroInput>, expected_rad_s: f64) {
    let got_rad_s = read(gyro, input);
    let off = got_rad_s - expected_rad_s;
    assert!(off.abs() <= half_a_count_rad_s(), "{got_rad_s} instead of {expected_rad_s}");
}

#[test]
fn scale_error_and_asymmetry_part_positive_from_negative_rates() {
    let scale = ScaleFactor { error: 0.01, asymmetry: 0.004, ..ScaleFactor::default() };
    let mut gyro = gyro(GyroParams { scale, ..exact() });
    for rate in [0.1, 1.0, 3.0] {
        reads(&mut gyro, rate, 1.012 * rate);
        reads(&mut gyro, -rate, -1.008 * rate);
    }
    let scale = ScaleFactor { asymmetry: -0.004, ..ScaleFactor::default() };
    let mut gyro = self::gyro(GyroParams { scale, ..exact() });
    reads(&mut gyro, 1.0, 0.998);
    reads(&mut gyro, -1.0, -1.002);
}

#[test]
fn the_scale_factor_of_a_run_is_drawn_anew_and_kept() {
    let scale = ScaleFactor { turn_on_sigma: 0.002, ..ScaleFactor::default() };
    let params = GyroParams { scale, ..exact() };
    let runs = 10_000;
    let mut sum = 0.0;
    for run in 0..runs {
        let mut gyro = Gyro::new(params, Seed(42), run).unwrap();
        let (first, second) = (gyro.sample(3.0), gyro.sample(3.0));
        assert_eq!(first, second);
        sum += (f64::from(first.counts.0) * params.lsb_rad_s / 3.0 - 1.0).powi(2);
    }
    let ratio = (sum / runs as f64).sqrt() / 0.002;
    // Four standard errors of a deviation; rounding to counts is 1e-7 of the rate.
    assert!((ratio - 1.0).abs() < 4.0 / (2.0 * runs as f64).sqrt(), "{ratio}");
}

#[test]
fn temperature_moves_scale_and_bias_from_the_reference_on() {
    let scale = ScaleFactor { per_deg_c: 1e-4, ..ScaleFactor::default() };
    let bias_effects = BiasEffects {
        per_deg_c_rad_s: 1e-5,
        per_temperature_rate_rad_deg_c: 1e-2,
        ..BiasEffects::default()
    };
    let reference_temperature_deg_c = 20.0;
    let mut gyro = gyro(GyroParams { scale, bias_effects, reference_temperature_deg_c, ..exact() });
    let at = |temperature_deg_c, temperature_rate_deg_c_s| GyroInput {
        temperature_deg_c,
        temperature_rate_deg_c_s,
        ..GyroInput::from(2.0)
    };
    reads(&mut gyro, at(20.0, 0.0), 2.0);
    reads(&mut gyro, at(50.0, 0.0), 2.0 * 1.003 + 30e-5);
    reads(&mut gyro, at(0.0, 0.0), 2.0 * 0.998 - 20e-5);
    reads(&mut gyro, at(20.0, 0.05), 2.0 + 0.05e-2);
    assert!((gyro.sample(at(33.0, 0.0)).temperature_deg_c - 33.0).abs() < 1e-15);
}

#[test]
fn specific_force_and_magnetic_field_add_to_the_bias_by_axis() {
    let bias_effects = BiasEffects {
        per_specific_force_s_m: [1e-3, 2e-3, -3e-3],
        per_magnetic_field_rad_s_t: 5.0,
        ..BiasEffects::default()
    };
    let mut gyro = gyro(GyroParams { bias_effects, ..exact() });
    let felt = |specific_force_s_m_s2, magnetic_field_t| GyroInput {
        specific_force_s_m_s2,
        magnetic_field_t,
        ..GyroInput::from(0.0)
    };
    reads(&mut gyro, felt([1.0, 0.0, 0.0], 0.0), 1e-3);
    reads(&mut gyro, felt([0.0, 1.0, 0.0], 0.0), 2e-3);
    reads(&mut gyro, felt([0.0, 0.0, 1.0], 0.0), -3e-3);
    reads(&mut gyro, felt([0.0; 3], 5e-5), 25e-5);
    // A rate alone stands upright under standard gravity.
    reads(&mut gyro, 0.0, -3e-3 * 9.80665);
}

#[test]
fn an_adis16100_on_its_side_shows_a_fifth_of_a_degree_per_second_per_g() {
    let all = preset::adis16100();
    let bias_effects = BiasEffects { warm_up_rad_s: 0.0, per_deg_c_rad_s: 0.0, ..all.bias_effects };
    let fine = rad_s_from_deg_s(0.2) / 1000.0;
    let params =
        GyroParams { bias_effects, lsb_rad_s: fine, counts_max: i32::MAX, ..all.without_errors() };
    let on_its_side =
        GyroInput { specific_force_s_m_s2: [9.80665, 0.0, 0.0], ..GyroInput::from(0.0) };
    assert_eq!(gyro(params).sample(on_its_side).counts.0, 1000);
}

#[test]
fn warming_up_dies_out_and_its_flag_falls_after_three_time_constants() {
    let warm_up_rad_s = rad_s_from_deg_h(1000.0);
    let bias_effects = BiasEffects { warm_up_rad_s, warm_up_time_s: 2.0, ..BiasEffects::default() };
    let mut cold = gyro(GyroParams { bias_effects, ..exact() });
    for k in 1..=3000_u32 {
        let time_s = f64::from(k) / 300.0;
        let reading = cold.sample(0.0);
        let got_rad_s = f64::from(reading.counts.0) * exact().lsb_rad_s;
        let expected_rad_s = warm_up_rad_s * (-time_s / 2.0).exp();
        // A straight line between 40 points in the time constant: 8e-5 of the value.
        let tolerance = half_a_count_rad_s() + 8e-5 * expected_rad_s;
        assert!((got_rad_s - expected_rad_s).abs() <= tolerance, "{time_s} s");
        assert!(k == 1800 || reading.flags.warm_up == (k < 1800), "{time_s} s");
    }
    let bias_effects = BiasEffects { on_before_s: 60.0, ..bias_effects };
    let mut warm = gyro(GyroParams { bias_effects, ..exact() });
    assert!(!warm.sample(0.0).flags.warm_up);
    reads(&mut warm, 0.0, 0.0);
}

#[test]
fn a_rate_ramp_rises_by_itself_from_the_start() {
    let drift = DriftParams { rate_ramp_rad_s2: 1e-4, ..DriftParams::default() };
    let mut gyro = gyro(GyroParams { drift, ..exact() });
    for k in 1..=3000_u32 {
        reads(&mut gyro, 0.0, 1e-4 * f64::from(k) / 300.0);
    }
}

#[test]
fn an_open_loop_folds_back_without_a_flag_where_others_saturate() {
    let fold = |fold_back| {
        let law = Law::Sine { fold_back };
        let linearity = Linearity { law, nonlinearity: SINE_NONLINEARITY };
        gyro(GyroParams { linearity, ..exact() })
    };
    let range_rad_s = exact().rate_max_rad_s;
    let (mut folding, mut clipping) = (fold(true), fold(false));
    for share in [0.1, 0.5, 0.99, 1.2, 1.9, 3.0] {
        let reading = folding.sample(share * range_rad_s);
        let expected_rad_s = range_rad_s * (FRAC_PI_2 * share).sin();
        let got_rad_s = f64::from(reading.counts.0) * exact().lsb_rad_s;
        assert!((got_rad_s - expected_rad_s).abs() <= half_a_count_rad_s(), "{share}");
        assert!(!reading.flags.over_range, "{share}: it cannot know");
        let reading = clipping.sample(share * range_rad_s);
        assert_eq!(reading.flags.over_range, share > 1.0);
        assert!(share < 1.0 || reading.counts.0 == 6_553_600);
    }
}

#[test]
fn a_mems_scale_bends_by_the_cubic() {
    let linearity = Linearity { law: Law::Cubic, nonlinearity: 0.0015 };
    let mut gyro = gyro(GyroParams { linearity, ..exact() });
    let range_rad_s = exact().rate_max_rad_s;
    for share in [-1.0, -0.5, 0.0, 0.25, 1.0 / 3.0_f64.sqrt(), 1.0_f64] {
        // 0.0015 of the range at 1/√3: (3√3/2)(x − x³).
        let bend = 0.0015 * 1.5 * 3.0_f64.sqrt() * (share - share.powi(3));
        reads(&mut gyro, share * range_rad_s, range_rad_s * (share + bend));
    }
}

#[test]
fn a_step_passes_filter_and_delay_as_their_closed_form_says() {
    let response = Response {
        natural_frequency_hz: 20.0,
        damping_ratio: FRAC_1_SQRT_2,
        delay_s: 2.0 / 300.0,
        noise_before_filter: false,
    };
    let params = GyroParams { response, sampling: Sampling::Instantaneous, ..exact() };
    let mut gyro = gyro(params);
    // The first input is taken to have lasted for ever.
    reads(&mut gyro, 0.0, 0.0);
    for k in 1..=200 {
        let turned = TAU * 20.0 * (f64::from(k - 2).max(0.0) / 300.0) * FRAC_1_SQRT_2;
        // Of the Butterworth filter: 1 − e^(−a)(cos a + sin a) with a = ωₙt/√2.
        let expected = 1.0 - (-turned).exp() * (turned.cos() + turned.sin());
        reads(&mut gyro, 1.0, expected);
    }
}

#[test]
fn a_gyro_with_a_band_limit_takes_means_however_it_samples() {
    let limited = Response { natural_frequency_hz: 40.0, ..Response::default() };
    for (response, sampling, takes_means) in [
        (Response::default(), Sampling::Mean, true),
        (Response::default(), Sampling::Instantaneous, false),
        (limited, Sampling::Mean, true),
        (limited, Sampling::Instantaneous, true),
    ] {
        let gyro = gyro(GyroParams { response, sampling, ..exact() });
        assert_eq!(gyro.takes_means(), takes_means);
    }
}

#[test]
fn rounded_angles_lose_nothing_and_rounded_rates_do() {
    let rate_rad_s = 0.3 * exact().lsb_rad_s;
    let sum = |rounding| {
        let mut gyro = gyro(GyroParams { rounding, ..exact() });
        (0..10_000).map(|_| i64::from(gyro.sample(rate_rad_s).counts.0)).sum::<i64>()
    };
    // 3000 counts' worth of angle; every rate rounds to none.
    assert_eq!((sum(Rounding::Angle), sum(Rounding::Rate)), (3000, 0));
}

#[test]
fn saturation_is_not_made_up_for_by_rounding_angles() {
    let mut gyro = gyro(GyroParams { rounding: Rounding::Angle, ..exact() });
    for _ in 0..100 {
        assert!(gyro.sample(100.0).flags.over_range);
    }
    assert!(gyro.sample(0.0).counts.0.abs() <= 1);
    assert_eq!(gyro.sample(0.0).counts.0, 0);
}

#[test]
fn the_clock_of_a_gyro_is_that_of_its_run() {
    let params = preset::vg910d();
    let grid = struna_kernel::SampleGrid::new(SimTime::ZERO, 300.0).unwrap();
    let error = |run| Gyro::new(params, Seed(42), run).unwrap().clock(grid).rate_error().to_bits();
    assert_eq!(error(0), error(0));
    assert_ne!(error(0), error(1));
    assert_eq!(gyro(exact()).clock(grid).time_of(144_000), grid.time_of(144_000));
}
