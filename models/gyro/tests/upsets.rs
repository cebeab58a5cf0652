//! What a fault changes, and that it changes nothing afterwards.

#![expect(clippy::unwrap_used, reason = "a failed unwrap fails the test")]

use struna_gyro::datasheet::vg910d;
use struna_gyro::{Gyro, GyroParams, Rail, Upset, preset};
use struna_kernel::{GyroReading, Seed};

fn exact() -> Gyro {
    Gyro::new(vg910d().without_errors(), Seed(42), 0).unwrap()
}

fn all_on() -> Gyro {
    Gyro::new(preset::vg910d(), Seed(42), 0).unwrap()
}

fn rate_rad_s(gyro: &Gyro, reading: GyroReading) -> f64 {
    f64::from(reading.counts.0) * gyro.params().lsb_rad_s
}

#[test]
fn no_upset_changes_no_bit() {
    let (mut plain, mut upset) = (all_on(), all_on());
    for k in 0..1000 {
        let rate = f64::from(k) * 1e-3;
        assert_eq!(plain.sample(rate), upset.sample_upset(rate, &Upset::default()));
    }
}

#[test]
fn scale_and_bias_upsets_act_on_the_rate() {
    let mut gyro = exact();
    let upset = Upset { scale_factor: 0.5, bias_rad_s: 0.25, ..Upset::default() };
    let reading = gyro.sample_upset(1.0, &upset);
    assert!((rate_rad_s(&gyro, reading) - 0.75).abs() <= 0.51 * gyro.params().lsb_rad_s);
}

#[test]
fn a_noise_upset_multiplies_the_white_noise_and_nothing_else() {
    let (mut calm, mut loud) = (Vec::new(), Vec::new());
    let params = GyroParams { bias_rad_s: 0.1, turn_on_bias_sigma_rad_s: 0.0, ..vg910d() };
    let mut gyros = [params, params].map(|params| Gyro::new(params, Seed(42), 0).unwrap());
    let upset = Upset { noise_factor: 3.0, ..Upset::default() };
    for _ in 0..1000 {
        let [one, three] = &mut gyros;
        let (reading, tripled) = (one.sample(0.0), three.sample_upset(0.0, &upset));
        calm.push(rate_rad_s(one, reading) - 0.1);
        loud.push(rate_rad_s(three, tripled) - 0.1);
    }
    for (calm, loud) in calm.iter().zip(&loud) {
        // Both rounded by up to half a count, one of them times three.
        assert!((3.0 * calm - loud).abs() <= 2.01 * params.lsb_rad_s);
    }
}

#[test]
fn a_stuck_gyro_repeats_its_last_counts_and_flag() {
    let mut gyro = exact();
    let stuck = Upset { stuck: true, ..Upset::default() };
    assert_eq!(gyro.sample_upset(1.0, &stuck).counts.0, 0, "it never had another");
    let last = gyro.sample(10.0);
    assert!(last.flags.over_range);
    for _ in 0..10 {
        assert_eq!(gyro.sample_upset(0.0, &stuck), last);
    }
    assert!(!gyro.sample(0.0).flags.over_range);
}

#[test]
fn a_railed_gyro_stands_at_its_range_with_the_flag_up() {
    let mut gyro = exact();
    for (rail, counts) in [(Rail::Positive, 6_553_600), (Rail::Negative, -6_553_600)] {
        for rate in [0.0, f64::NAN] {
            let reading =
                gyro.sample_upset(rate, &Upset { railed: Some(rail), ..Upset::default() });
            assert_eq!(reading.counts.0, counts);
            assert!(reading.flags.over_range && reading.flags.valid);
        }
    }
}

#[test]
fn after_any_upset_the_gyro_reads_as_if_there_had_been_none() {
    let none = Upset::default();
    for upset in [
        Upset { scale_factor: -7.0, ..none },
        Upset { bias_rad_s: 1e300, ..none },
        Upset { bias_rad_s: f64::NAN, ..none },
        Upset { noise_factor: f64::INFINITY, ..none },
        Upset { stuck: true, ..none },
        Upset { railed: Some(Rail::Negative), ..none },
    ] {
        let (mut plain, mut upset_gyro) = (all_on(), all_on());
        for k in 0..100_u32 {
            let acting = (20..50).contains(&k);
            let act = if acting { upset } else { none };
            let (one, other) = (plain.sample(0.3), upset_gyro.sample_upset(0.3, &act));
            assert!(acting || one == other, "{upset:?}, sample {k}");
        }
    }
}
