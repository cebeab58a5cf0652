//! When the batch fit says no, or only so much.

use crate::batch::fitted;
use crate::rig::{B, C, D, PERIOD_S, R_RAD2_S2, Scenario};
use crate::runs::{Run, belief_error_squared};
use struna_estimator::{
    AugmentedConfig, BatchEstimate, BatchFit, FitRefusal, GyroRange, InnovationTest, RateSample,
    SmoothError, StartPrior, Verdict,
};
use struna_kernel::RAD_PER_DEG;

fn fit_with(config: &AugmentedConfig, run: &Run) -> Result<BatchEstimate, FitRefusal> {
    BatchFit::new(config, &InnovationTest::STANDARD).unwrap().fit(&run.record())
}

/// The same gyro on a body that does not move.
fn at_rest(scenario: Scenario, run: u32) -> Run {
    let mut run = Run::of(scenario, run);
    for (sample, truth) in run.samples.iter_mut().zip(&mut run.truth) {
        sample.rate_rad_s -= truth.rate_rad_s;
        (truth.angle_rad, truth.rate_rad_s) = (0.0, 0.0);
    }
    run
}

#[test]
fn a_record_without_motion_has_no_period() {
    for k in 0..6 {
        let run = at_rest(B, k);
        let start = StartPrior::released(0.0, PERIOD_S);
        for period_sigma_s in [4.8, 480.0] {
            let start = StartPrior { period_sigma_s, angle_sigma_rad: 6.0, ..start };
            let fit = fit_with(&AugmentedConfig { start, ..B.config(0.0) }, &run);
            let refusal = fit.map(|fit| fit.learnt).unwrap_err();
            assert!(matches!(refusal, FitRefusal::NoMotion { .. }), "run {k}: {refusal:?}");
            let words = refusal.to_string();
            assert!(words.starts_with("period not identifiable from this record: no motion"));
        }
    }
}

#[test]
fn a_record_too_short_for_the_period_says_so() {
    let mut run = Run::of(B, 4);
    run.samples.truncate(1_000);
    let start = StartPrior::released(run.believed_start_deg * RAD_PER_DEG, PERIOD_S);
    let wide = StartPrior { period_sigma_s: 240.0, damping_ratio_sigma: 0.1, ..start };
    let fit = fit_with(&AugmentedConfig { start: wide, ..B.config(0.0) }, &run);
    let refusal = fit.map(|fit| fit.learnt).unwrap_err();
    assert!(matches!(refusal, FitRefusal::PeriodUnknown { .. }), "{refusal:?}");
}

/// With a period known beforehand a short record still tells the angle, as well as it claims.
#[test]
fn a_short_record_is_as_sure_as_it_can_be() {
    let mut sum = 0.0;
    for k in 0..20 {
        let mut run = Run::of(B, k);
        run.samples.truncate(6_000);
        let fit = fitted(B, &run).unwrap();
        assert_eq!(fit.verdict, Verdict::Accepted);
        sum += belief_error_squared(&fit.beliefs[5_999], &run.truth[5_999]);
        let sigma_deg = fit.beliefs[5_999].covariance.angle_rad2.sqrt() / RAD_PER_DEG;
        assert!((0.5..10.0).contains(&sigma_deg), "{sigma_deg}°");
    }
    // Two degrees of freedom, mean of twenty at the level of 1 %.
    assert!((0.6..3.4).contains(&(sum / 20.0)), "{}", sum / 20.0);
}

#[test]
fn too_few_samples_are_refused() {
    let mut run = Run::of(B, 0);
    run.samples.truncate(19);
    assert!(matches!(fitted(B, &run), Err(FitRefusal::TooFewSamples { used: 19, need: 20, .. })));
    run.samples.clear();
    assert_eq!(fitted(B, &run).unwrap_err(), FitRefusal::Unusable(SmoothError::Empty));
}

#[test]
fn a_record_of_rejected_samples_is_refused() {
    let mut run = Run::of(B, 0);
    run.samples.truncate(3_000);
    run.samples.iter_mut().for_each(|sample| sample.over_range = true);
    assert!(matches!(fitted(B, &run), Err(FitRefusal::TooFewSamples { used: 0, .. })));
    // A gyro taken for ten thousand times better than it is: everything is an outlier.
    let mut run = Run::of(B, 0);
    run.samples.truncate(3_000);
    let config = AugmentedConfig {
        measurement_variance_rad2_s2: 1e-8 * R_RAD2_S2,
        ..B.config(run.believed_start_deg)
    };
    match fit_with(&config, &run) {
        Ok(fit) => assert_eq!(fit.verdict, Verdict::RecordExceedsModel),
        Err(refusal) => assert!(
            matches!(refusal, FitRefusal::TooFewSamples { .. } | FitRefusal::TooManyKicks { .. }),
            "{refusal:?}"
        ),
    }
}

#[test]
fn time_that_goes_back_and_variances_below_zero_are_refused() {
    let mut run = Run::of(B, 0);
    run.samples.truncate(3_000);
    run.samples[1_500].time_s = 1.0;
    let refusal = fitted(B, &run).unwrap_err();
    assert!(matches!(refusal, FitRefusal::Unusable(SmoothError::BadSample { index: 1_500, .. })));
    for bad in [-1.0, 0.0, f64::NAN] {
        let config = AugmentedConfig { measurement_variance_rad2_s2: bad, ..B.config(0.0) };
        assert!(BatchFit::new(&config, &InnovationTest::STANDARD).is_err(), "{bad}");
    }
}

#[test]
fn a_period_wrong_by_a_factor_of_three_is_not_accepted() {
    for factor in [1.0 / 3.0, 3.0] {
        let run = Run::of(B, 2);
        let start = StartPrior::released(run.believed_start_deg * RAD_PER_DEG, PERIOD_S * factor);
        let config = AugmentedConfig { start, ..B.config(0.0) };
        match fit_with(&config, &run) {
            Ok(fit) => assert_ne!(fit.verdict, Verdict::Accepted, "{factor}: {:?}", fit.learnt),
            Err(refusal) => {
                let lost =
                    matches!(refusal, FitRefusal::TooManyKicks { .. } | FitRefusal::NotConverged);
                assert!(lost, "{factor}: {refusal:?}");
            }
        }
    }
}

/// Eight sigma of the start angle off, and all else in order.
#[test]
fn a_start_belief_that_the_record_contradicts_is_named() {
    let run = Run::of(B, 2);
    let config = Scenario { start_sigma_deg: 1.0, ..B }.config(368.0);
    let fit = fit_with(&config, &run).unwrap();
    match fit.verdict {
        Verdict::AgainstStartBelief { quantity, sigmas } => {
            assert_eq!(quantity, "angle");
            assert!((7.0..9.0).contains(&sigmas), "{sigmas}");
        }
        other => panic!("{other:?}"),
    }
}

#[test]
fn given_kicks_are_used_and_no_others() {
    let run = Run::of(D, 3);
    let config = D.config(run.believed_start_deg);
    let fit = BatchFit::new(&config, &InnovationTest::STANDARD).unwrap();
    let times_s: Vec<f64> = run.kicks.iter().map(|(k, _)| run.samples[*k].time_s).collect();
    let given = fit.fit_with_kicks(&run.record(), &times_s).unwrap();
    assert_eq!(given.verdict, Verdict::Accepted);
    assert_eq!(given.kicks.len(), 3);
    let found = fit.fit(&run.record()).unwrap();
    for (given, found) in given.kicks.iter().zip(&found.kicks) {
        assert_eq!(given.sample, found.sample);
        // The same fit from the same start, but for how it got there.
        assert!((given.size_rad_s - found.size_rad_s).abs() < 0.05 * given.size_sigma_rad_s);
    }
    let missing = fit.fit_with_kicks(&run.record(), &times_s[..2]).unwrap();
    assert_eq!(missing.verdict, Verdict::RecordExceedsModel, "a kick is missing");
    for outside in [-1.0, 480.1, f64::NAN] {
        let refusal = fit.fit_with_kicks(&run.record(), &[outside]).unwrap_err();
        assert!(matches!(refusal, FitRefusal::BadKick { .. }));
    }
    let many = vec![100.0; 65];
    let refusal = fit.fit_with_kicks(&run.record(), &many).unwrap_err();
    assert_eq!(refusal, FitRefusal::TooManyKicks { kicks: 65, most: 64 });
}

#[test]
fn clipped_and_irregular_records_are_fitted() {
    let mut run = Run::of(B, 2);
    let limit_rad_s = 3.5 * RAD_PER_DEG;
    for sample in &mut run.samples {
        sample.rate_rad_s = sample.rate_rad_s.clamp(-limit_rad_s, limit_rad_s);
    }
    let keep = |k: usize| k.is_multiple_of(3) || (k / 700).is_multiple_of(2);
    let kept: Vec<usize> = (0..48_000).filter(|&k| keep(k)).collect();
    run.samples = kept.iter().map(|&k| run.samples[k]).collect::<Vec<RateSample>>();
    run.truth = kept.iter().map(|&k| run.truth[k]).collect();
    let range = Some(GyroRange::with_raw_sigma(limit_rad_s, R_RAD2_S2.sqrt()));
    let config = AugmentedConfig { range, ..B.config(run.believed_start_deg) };
    let fit = fit_with(&config, &run).unwrap();
    assert_eq!(fit.verdict, Verdict::Accepted);
    assert!(fit.over_range > 5_000, "{}", fit.over_range);
    let rms_deg = run.mean_squares(fit.beliefs.iter().copied())[0].sqrt();
    assert!(rms_deg < 0.25, "{rms_deg}°");
}

#[test]
fn what_is_certain_stays_so() {
    let run = Run::of(B, 6);
    let (s, _) = run.parameters;
    let start = StartPrior {
        period_s: std::f64::consts::TAU / s.sqrt(),
        period_sigma_s: 0.0,
        rate_sigma_rad_s: 0.0,
        ..StartPrior::released(run.believed_start_deg * RAD_PER_DEG, PERIOD_S)
    };
    let fit = fit_with(&AugmentedConfig { start, ..B.config(0.0) }, &run).unwrap();
    assert!((fit.parameters[2] / s - 1.0).abs() < 1e-14);
    assert_eq!(fit.parameters[1].to_bits(), 0.0_f64.to_bits());
    assert!(fit.covariance[2].iter().all(|entry| entry.abs() < f64::MIN_POSITIVE));
    assert_eq!(fit.verdict, Verdict::Accepted);
    let loose = fitted(B, &run).unwrap();
    assert!(fit.covariance[0][0] < loose.covariance[0][0], "certainty helps the rest");
}

/// What random torque does to the fit, the smoother survives.
#[test]
fn the_smoother_is_better_where_the_fit_steps_back() {
    let (mut of_fit, mut of_smoother) = (0.0, 0.0);
    for k in 0..4 {
        let run = Run::of(C, k);
        let fit = fitted(C, &run).unwrap();
        assert_eq!(fit.verdict, Verdict::RecordExceedsModel);
        of_fit += run.mean_squares(fit.beliefs.iter().copied())[0];
        of_smoother += run.mean_squares(crate::accuracy::smoothed(C, &run).beliefs())[0];
    }
    assert!(of_smoother < 0.5 * of_fit, "{of_smoother} {of_fit}");
}
