//! The errors are as small as they can be, and as large as they are claimed to be.

use crate::bound::bound;
use crate::campaign::{Campaign, EPOCHS};
use crate::rig::{A, B, C, D, E, Scenario};
use std::sync::LazyLock;

static OF_A: LazyLock<Campaign> = LazyLock::new(|| Campaign::of(A, 200));
static OF_B: LazyLock<Campaign> = LazyLock::new(|| Campaign::of(B, 200));
static OF_C: LazyLock<Campaign> = LazyLock::new(|| Campaign::of(C, 200));
static OF_D: LazyLock<Campaign> = LazyLock::new(|| Campaign::of(D, 200));
static OF_E: LazyLock<Campaign> = LazyLock::new(|| Campaign::of(E, 200));
/// B and C with a start rate drawn from what the filter believes of it, and B with the little
/// random torque that the filter believes in too.
static OF_PUSHED_B: LazyLock<Campaign> = LazyLock::new(|| Campaign::of(pushed(B), 200));
static OF_PUSHED_C: LazyLock<Campaign> = LazyLock::new(|| Campaign::of(pushed(C), 200));

fn pushed(scenario: Scenario) -> Scenario {
    let acceleration_density_deg2_s3 = scenario.acceleration_density_deg2_s3.max(1e-9);
    Scenario { rate_sigma_deg_s: 0.01, acceleration_density_deg2_s3, ..scenario }
}

/// RMS over the second half, as shares of the least any filter can have.
fn shares(campaign: &Campaign, scenario: Scenario) -> (f64, f64) {
    let (angle_deg, rate_deg_s) = bound(scenario);
    (campaign.angle_deg() / angle_deg, campaign.rate_deg_s() / rate_deg_s)
}

/// Above 1 by Monte Carlo error (1/√400 = 5 %, one sigma) and the price of the innovation test, a
/// few per cent; below, because the bound counts a start rate of 0.01 °/s that A and B lack.
const SHARE: std::ops::RangeInclusive<f64> = 0.8..=1.15;

#[test]
fn angle_and_rate_are_at_the_bound() {
    for (name, campaign, scenario) in [
        ("A", &OF_A, A),
        ("B", &OF_B, B),
        ("B, pushed", &OF_PUSHED_B, pushed(B)),
        ("C, pushed", &OF_PUSHED_C, pushed(C)),
    ] {
        let (angle, rate) = shares(campaign, scenario);
        assert!(SHARE.contains(&angle), "{name}: angle at {angle:.3} of the bound");
        assert!(SHARE.contains(&rate), "{name}: rate at {rate:.3} of the bound");
    }
}

/// Under random torque the bias can hardly be told from a start rate. The bound lets the rate be
/// wrong by 0.01 °/s at the start, it is not, and the difference never decays: 0.0096 °/s where
/// the bound has 0.0132.
#[test]
fn a_body_truly_at_rest_is_known_better_than_the_prior_allows() {
    let (angle, rate) = shares(&OF_C, C);
    assert!(SHARE.contains(&angle), "angle at {angle:.3} of the bound");
    assert!((0.66..0.8).contains(&rate), "rate at {rate:.3} of the bound");
}

#[test]
fn kicks_and_outliers_cost_little() {
    for (name, campaign) in [("D", &OF_D), ("E", &OF_E)] {
        let angle_deg = campaign.angle_deg();
        assert!(angle_deg <= 0.6, "{name}: {angle_deg:.3}° over the second half");
        // 0.166° and 0.105° published; a kick late in the run takes part of the knowledge away.
        let end_deg = campaign.end_deg();
        assert!(end_deg <= 0.25, "{name}: {end_deg:.3}° at the end");
    }
}

/// What is claimed is what is made, at every epoch and in all five states at once.
///
/// Five degrees of freedom with a start rate drawn from the prior and the torque noise that the
/// filter believes in; between four and five without, for then one of the five prior errors is
/// always zero. Bounds are those of the mean over 200
/// runs at the level of 5 % for all seventy together: ±3.39 sigma with sigma = √(2n/200).
#[test]
fn the_whole_error_is_as_large_as_claimed() {
    let band = |low_n: f64, high_n: f64| {
        low_n - 3.39 * (low_n / 100.0).sqrt()..=high_n + 3.39 * (high_n / 100.0).sqrt()
    };
    let campaigns = [
        ("A", &OF_A, band(4.0, 5.0)),
        ("B", &OF_B, band(4.0, 5.0)),
        ("C", &OF_C, band(4.0, 5.0)),
        ("D", &OF_D, band(4.0, 5.0)),
        ("E", &OF_E, band(4.0, 5.0)),
        ("B, pushed", &OF_PUSHED_B, band(5.0, 5.0)),
        ("C, pushed", &OF_PUSHED_C, band(5.0, 5.0)),
    ];
    for (name, campaign, band) in campaigns {
        for epoch in 0..EPOCHS {
            let nees = campaign.nees(epoch);
            assert!(band.contains(&nees), "{name}, epoch {epoch}: {nees:.2} not in {band:?}");
        }
    }
}

#[test]
fn no_run_ends_far_beyond_its_claim() {
    for campaign in [&OF_A, &OF_B, &OF_C, &OF_D, &OF_E, &OF_PUSHED_B, &OF_PUSHED_C] {
        // 200 normal numbers reach 3 sigma now and then, 4 once in 80 campaigns.
        assert!(campaign.worst_sigmas() < 4.0, "{}", campaign.worst_sigmas());
    }
}

#[test]
fn alarms_without_a_kick_are_rare() {
    for (name, campaign) in [("A", &OF_A), ("B", &OF_B)] {
        // Twelve windows at one in a hundred runs each, were they independent: 0.9 an hour. Two are
        // allowed: 0.267 a run.
        let per_hour = campaign.alarms() * 3600.0 / 480.0;
        assert!(per_hour <= 2.0, "{name}: {per_hour:.2} an hour");
    }
}

#[test]
fn outliers_are_gated_and_not_taken_for_kicks() {
    let more = OF_E.alarms() - OF_B.alarms();
    // 480 outliers in a run; the published 0.35 alarms more, to 1/√200·0.6 = 0.04 at one sigma.
    assert!(more < 0.5, "{more} alarms more than without outliers");
}
