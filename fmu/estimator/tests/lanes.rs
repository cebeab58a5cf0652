//! Filters in lanes are the single filters, to the bit.

#![expect(clippy::unwrap_used, reason = "a failed unwrap fails the test")]

#[path = "shared/config.rs"]
mod shared;

use proptest::prelude::*;
use shared::CONFIG;
use struna_estimator::{
    Belief, EstimatorError, Filter, FilterConfig, FilterLanes, Motion, RateEstimator, Reading,
    Refinement, TorsionalOscillation,
};

/// Filters that differ in all they can.
fn filters<const N: usize>() -> [Filter<TorsionalOscillation>; N] {
    std::array::from_fn(|lane| {
        let k = 1.0 + lane as f64;
        let config = FilterConfig {
            angle_start_rad: 6.0 - k,
            angle_variance_start_rad2: 0.01 * k,
            measurement_variance_rad2_s2: 6e-7 * k,
            process_noise_rad2_s3: if lane == 2 { 0.0 } else { 1e-8 / k },
            ..CONFIG
        };
        Filter::torsional_oscillation(config, 100.0 * k).unwrap()
    })
}

fn bits(belief: Belief) -> [u64; 5] {
    let c = belief.covariance;
    [belief.angle_rad, belief.rate_rad_s, c.angle_rad2, c.cross_rad2_s, c.rate_rad2_s2]
        .map(f64::to_bits)
}

/// Steps lanes and single filters alike, and holds them against each other.
fn step_both<M: Motion, const N: usize>(
    lanes: &mut FilterLanes<M, N>,
    singles: &mut [Filter<M>; N],
    span_s: f64,
    rates_rad_s: [f64; N],
) -> [Option<EstimatorError>; N] {
    let outcome = lanes.step(span_s, &rates_rad_s);
    std::array::from_fn(|lane| {
        let single = singles[lane].step(span_s, rates_rad_s[lane]);
        let refused = outcome.err().and_then(|errors| errors.of(lane));
        // By their words, for the refused value may be NaN.
        let words = |error: Option<EstimatorError>| error.map(|error| error.to_string());
        assert_eq!(words(single.err()), words(refused), "lane {lane}");
        assert_eq!(bits(lanes.belief(lane)), bits(singles[lane].belief()), "lane {lane}");
        if let Ok(innovation) = single {
            assert_eq!(lanes.innovation(lane), innovation, "lane {lane}");
        }
        refused
    })
}

fn rates<const N: usize>(k: u32) -> [f64; N] {
    std::array::from_fn(|lane| (f64::from(k) * (0.7 + lane as f64)).cos())
}

fn run_alike<const N: usize>() {
    let (mut singles, mut lanes) = (filters::<N>(), FilterLanes::new(filters::<N>()).unwrap());
    for k in 0..2000 {
        // Spans change now and then, as they do when samples are lost.
        let span_s = match k % 97 {
            5 => 0.03,
            6 => 0.0,
            _ => 0.01,
        };
        let refused = step_both(&mut lanes, &mut singles, span_s, rates(k));
        assert_eq!(refused, [None; N], "step {k}");
        if k % 211 == 0 {
            lanes.predict(0.5).unwrap();
            singles.iter_mut().for_each(|single| single.predict(0.5).unwrap());
        }
    }
}

#[test]
fn any_number_of_lanes_has_the_bits_of_single_filters() {
    run_alike::<1>();
    run_alike::<2>();
    run_alike::<3>();
    run_alike::<8>();
    run_alike::<17>();
}

#[test]
fn rotation_in_lanes_has_the_bits_of_single_filters() {
    let filter = || Filter::permanent_rotation(CONFIG).unwrap();
    let mut singles: [_; 4] = std::array::from_fn(|_| filter());
    let mut lanes = FilterLanes::new(singles.clone()).unwrap();
    for k in 0..500 {
        assert_eq!(step_both(&mut lanes, &mut singles, 0.01, rates(k)), [None; 4]);
    }
}

#[test]
fn filters_are_taken_over_where_they_stand() {
    let mut singles = filters::<4>();
    for (k, single) in singles.iter_mut().enumerate() {
        single.step(0.01, 0.1 * k as f64).unwrap();
        single.predict(0.3).unwrap();
    }
    let mut lanes = FilterLanes::new(singles.clone()).unwrap();
    assert_eq!(step_both(&mut lanes, &mut singles, 0.01, rates(1)), [None; 4]);
}

#[test]
fn a_refused_lane_stands_still_and_the_others_go_on() {
    let (mut singles, mut lanes) = (filters::<8>(), FilterLanes::new(filters::<8>()).unwrap());
    step_both(&mut lanes, &mut singles, 0.01, rates(0));
    // The last two are numbers, and without refinement nothing of them is squared.
    let cases = [(f64::NAN, true), (f64::INFINITY, true), (1e200, false), (f64::MAX, false)];
    for (k, (bad, refuses)) in (1..).zip(cases) {
        let lane = k as usize;
        let before = bits(lanes.belief(lane));
        let mut given = rates::<8>(k);
        given[lane] = bad;
        let refused = step_both(&mut lanes, &mut singles, 0.01, given);
        for (other, error) in refused.iter().enumerate() {
            assert_eq!(error.is_some(), other == lane && refuses, "{bad}, lane {other}");
        }
        assert_eq!(bits(lanes.belief(lane)) == before, refuses, "{bad}");
        // And it goes on as if nothing had been.
        assert_eq!(step_both(&mut lanes, &mut singles, 0.01, rates(k)), [None; 8]);
    }
}

#[test]
fn a_span_that_is_none_is_refused_by_all() {
    let (mut singles, mut lanes) = (filters::<8>(), FilterLanes::new(filters::<8>()).unwrap());
    for span_s in [-0.01, f64::NAN, f64::INFINITY] {
        let refused = step_both(&mut lanes, &mut singles, span_s, rates(1));
        assert!(refused.iter().all(Option::is_some), "{span_s}");
        let refused = lanes.predict(span_s).unwrap_err();
        assert_eq!(refused.to_string(), "8 of 8 filters refuse");
    }
    assert_eq!(step_both(&mut lanes, &mut singles, 0.01, rates(1)), [None; 8]);
}

/// What only a sum shows: every number that a step would leave is finite.
#[test]
fn sums_that_overflow_are_refused_as_single_filters_refuse_them() {
    let innovation = FilterConfig {
        rate_variance_start_rad2_s2: 1.7e308,
        measurement_variance_rad2_s2: 1.7e308,
        ..CONFIG
    };
    let belief = FilterConfig { angle_start_rad: 0.85e308, rate_start_rad_s: 0.95e308, ..CONFIG };
    for config in [innovation, belief] {
        let filter = |config| Filter::permanent_rotation(config).unwrap();
        let mut singles = [filter(CONFIG), filter(config)];
        let mut lanes = FilterLanes::new(singles.clone()).unwrap();
        let refused = step_both(&mut lanes, &mut singles, 0.0, [0.0, 0.0]);
        assert!(refused[0].is_none() && refused[1].is_some(), "{refused:?}");
    }
}

/// Every filter integrates the rate; one that believes nothing of the gyro shows that alone.
#[test]
fn an_integral_that_overflows_is_refused_as_single_filters_refuse_it() {
    let deaf = FilterConfig {
        rate_variance_start_rad2_s2: 1e-300,
        measurement_variance_rad2_s2: 1.0,
        process_noise_rad2_s3: 0.0,
        ..CONFIG
    };
    let singles: [_; 2] = [CONFIG, deaf].map(|config| Filter::permanent_rotation(config).unwrap());
    // 1e300 rad/s for 1e9 s, in the step itself and since a measurement long ago.
    for (before_s, span_s) in [(0.0, 1e9), (1e9, 0.01)] {
        let (mut singles, mut lanes) =
            (singles.clone(), FilterLanes::new(singles.clone()).unwrap());
        // The constants of the span are there when it matters.
        assert_eq!(step_both(&mut lanes, &mut singles, span_s, [0.0; 2]), [None; 2]);
        lanes.predict(before_s).unwrap();
        singles.iter_mut().for_each(|single| single.predict(before_s).unwrap());
        let refused = step_both(&mut lanes, &mut singles, span_s, [0.0, 1e300]);
        assert_eq!(refused, [None, Some(EstimatorError::Overflow)], "{before_s} s, {span_s} s");
    }
}

/// An oscillator known to have no rate has none again after half a period: what is left of its
/// variance is rounding, of either sign, and far more than the noise of the gyro.
#[test]
fn a_variance_rounded_below_zero_is_refused_as_single_filters_refuse_it() {
    let still = FilterConfig {
        rate_variance_start_rad2_s2: 0.0,
        measurement_variance_rad2_s2: 1e-300,
        process_noise_rad2_s3: 0.0,
        ..CONFIG
    };
    let mut refusals = 0;
    for part in 1..100 {
        let start = Filter::torsional_oscillation(still, 2.0).unwrap();
        let (mut singles, mut lanes) = ([start.clone()], FilterLanes::new([start]).unwrap());
        let part_s = f64::from(part) / 100.0;
        lanes.predict(part_s).unwrap();
        singles[0].predict(part_s).unwrap();
        let [refused] = step_both(&mut lanes, &mut singles, 1.0 - part_s, [0.0]);
        if let Some(error) = refused {
            assert!(matches!(error, EstimatorError::SingularInnovation { .. }), "{error}");
            refusals += 1;
        }
    }
    assert!(refusals > 10, "{refusals} of 99");
}

#[test]
fn a_filter_that_refines_is_no_lane() {
    let refinement = Refinement { samples: 7, reading: Reading::M6 };
    let filter = Filter::permanent_rotation(FilterConfig { refinement, ..CONFIG }).unwrap();
    let refusal = FilterLanes::new([filter]).unwrap_err();
    assert_eq!(refusal.name, "refinement_samples");
}

proptest! {
    /// Numbers near both ends of floating point: overflow, underflow, and what lies between.
    #[test]
    fn extreme_lanes_are_judged_as_single_filters_are(
        variances in proptest::collection::vec(-300.0_f64..300.0, 12),
        spans in proptest::collection::vec(-12.0_f64..12.0, 1..6),
        rates_log10 in proptest::collection::vec(-300.0_f64..309.0, 4),
    ) {
        let mut singles: [_; 4] = std::array::from_fn(|lane| {
            let of = |k: usize| 10_f64.powf(variances[3 * lane + k]);
            let config = FilterConfig {
                angle_variance_start_rad2: of(0),
                rate_variance_start_rad2_s2: of(1),
                measurement_variance_rad2_s2: of(2),
                ..CONFIG
            };
            Filter::torsional_oscillation(config, 480.0).unwrap()
        });
        let mut lanes = FilterLanes::new(singles.clone()).unwrap();
        let rates_rad_s = std::array::from_fn(|lane| 10_f64.powf(rates_log10[lane]));
        for span in spans {
            step_both(&mut lanes, &mut singles, 10_f64.powf(span), rates_rad_s);
        }
    }
}
