//! Errors in hindsight are as small as they can be, and as large as they are claimed to be.

use crate::bound;
use crate::rig::{A, B, C, D, E, Scenario};
use crate::runs::{Run, belief_error_squared, each, error_squared, root_mean};
use std::sync::LazyLock;
use struna_estimator::{InnovationTest, RateEstimator, Smoothed, smooth};

const RUNS: u32 = 20;
/// Instants at which the whole error is weighed against the whole covariance.
const EPOCHS: usize = 10;

pub(crate) fn smoothed(scenario: Scenario, run: &Run) -> Smoothed {
    let config = scenario.config(run.believed_start_deg);
    smooth(&config, &InnovationTest::STANDARD, &run.record()).unwrap()
}

/// What all runs of a scenario come to.
struct Campaign {
    /// RMS over the whole run: angle, deg, and rate, deg/s.
    rms: [f64; 2],
    /// NEES of five states, and of angle and rate, at each epoch.
    nees: Vec<[f64; 2]>,
}

static OF_A: LazyLock<Campaign> = LazyLock::new(|| campaign(A));
static OF_B: LazyLock<Campaign> = LazyLock::new(|| campaign(B));
static OF_C: LazyLock<Campaign> = LazyLock::new(|| campaign(C));
static OF_D: LazyLock<Campaign> = LazyLock::new(|| campaign(D));
static OF_E: LazyLock<Campaign> = LazyLock::new(|| campaign(E));

fn campaign(scenario: Scenario) -> Campaign {
    let runs = each(scenario, RUNS, |run| {
        let smoothed = smoothed(scenario, run);
        let nees: [[f64; 2]; EPOCHS] = std::array::from_fn(|epoch| {
            let k = run.truth.len() / EPOCHS * epoch + 2_400;
            let at = smoothed.at(k).unwrap();
            [
                error_squared(at.mean(), at.covariance(), run.state(k)),
                belief_error_squared(&at.belief(), &run.truth[k]),
            ]
        });
        (run.mean_squares(smoothed.beliefs()), nees)
    });
    let mean = |epoch: usize, i: usize| {
        runs.iter().map(|(_, nees)| nees[epoch][i]).sum::<f64>() / f64::from(RUNS)
    };
    Campaign {
        rms: root_mean(&runs.iter().map(|(squares, _)| *squares).collect::<Vec<_>>()),
        nees: (0..EPOCHS).map(|epoch| [mean(epoch, 0), mean(epoch, 1)]).collect(),
    }
}

/// The smoother of these coordinates is at the bound; in (φ, φ′, …) it is published at 1.53 in B.
///
/// Monte Carlo error of a share is 1/√40 = 16 % of one sigma were the error of a run constant; it
/// varies over the run and over two to four parameters, which leaves about 8 %.
#[test]
fn angle_and_rate_are_at_the_bound() {
    for (name, campaign, bound) in [("A", &OF_A, &bound::OF_A), ("B", &OF_B, &bound::OF_B)] {
        let [angle, rate] = campaign.rms;
        let shares = [angle / bound.0, rate / bound.1];
        assert!(shares.iter().all(|share| (0.8..1.2).contains(share)), "{name}: {shares:?}");
    }
}

/// The bound lets the start rate be wrong by 0.01 °/s, which it is not, and in C it stays hard to
/// tell from the bias.
#[test]
fn random_torque_is_smoothed_to_the_bound() {
    let ([angle, rate], bound) = (OF_C.rms, *bound::OF_C);
    assert!((0.85..1.15).contains(&(angle / bound.0)), "{angle}° of {}°", bound.0);
    assert!((0.5..0.8).contains(&(rate / bound.1)), "{rate} °/s of {} °/s", bound.1);
}

/// Published: 0.112° and 0.078°; the filter, 0.47° and 0.42°.
#[test]
fn kicks_and_outliers_cost_little() {
    assert!(OF_D.rms[0] < 0.2, "D: {}°", OF_D.rms[0]);
    assert!(OF_E.rms[0] < 0.09, "E: {}°", OF_E.rms[0]);
}

/// Between four and five degrees of freedom of five states, since one of the five start errors is
/// zero, and at most two of angle and rate. Bounds are those of the mean of twenty at the level of
/// 5 % for all hundred together: ±3.48 sigma with sigma = √(2n/20).
#[test]
fn the_whole_error_is_as_large_as_claimed() {
    let high = |n: f64| n + 3.48 * (n / 10.0).sqrt();
    let least = 4.0 - 3.48 * 0.4_f64.sqrt();
    for (name, of) in [("A", &OF_A), ("B", &OF_B), ("C", &OF_C), ("D", &OF_D), ("E", &OF_E)] {
        for (epoch, [whole, belief]) in of.nees.iter().enumerate() {
            assert!((least..high(5.0)).contains(whole), "{name}, epoch {epoch}: {whole:.2}");
            // From below: 0.5 is no claim five times too large.
            assert!((0.5..high(2.0)).contains(belief), "{name}, epoch {epoch}: {belief:.2}");
        }
    }
}
