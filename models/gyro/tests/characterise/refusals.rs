//! Records and options that allow no answer.

use struna_gyro::characterise::{CharacteriseError, Options, RateRecord, characterise};

fn refused(rates: impl IntoIterator<Item = f64>, options: &Options) -> CharacteriseError {
    let record = RateRecord::contiguous(100.0, rates).expect("a positive rate");
    characterise(&record, options).expect_err("no answer")
}

fn alternating(n: u32) -> impl Iterator<Item = f64> {
    (0..n).map(|k| f64::from(k * k % 7))
}

#[test]
fn records_without_noise_or_length_are_refused() {
    let options = Options::default();
    assert!(matches!(refused([], &options), CharacteriseError::TooShort { longest: 0, .. }));
    let short = refused(alternating(53), &options);
    assert_eq!(short, CharacteriseError::TooShort { longest: 53, needed: 54 });
    assert!(short.to_string().contains("53 samples") && short.to_string().contains("54"));
    let record = RateRecord::contiguous(100.0, alternating(54)).expect("a positive rate");
    assert!(characterise(&record, &options).is_ok(), "as many as are needed");
    assert_eq!(refused([0.25; 1000], &options), CharacteriseError::Constant);
    assert_eq!(refused([0.1; 1000], &options), CharacteriseError::Constant);
    let huge = alternating(1000).map(|rate| 1e200 * rate);
    assert_eq!(refused(huge, &options), CharacteriseError::Overflow);
    let tiny = alternating(1000).map(|rate| 1e-200 * rate);
    assert_eq!(refused(tiny, &options), CharacteriseError::Constant);
}

#[test]
fn a_record_of_nothing_but_losses_is_too_short() {
    let error = refused(std::iter::repeat_n(f64::NAN, 1000), &Options::default());
    assert!(matches!(error, CharacteriseError::TooShort { longest: 0, .. }));
    let every_other = (0..1000).map(|k| if k % 2 == 0 { f64::from(k) } else { f64::NAN });
    let error = refused(every_other, &Options::default());
    assert!(matches!(error, CharacteriseError::TooShort { longest: 1, .. }));
}

#[test]
fn a_band_that_hides_the_whole_record_is_refused() {
    let options = Options { bandwidth_hz: Some(0.1), ..Options::default() };
    let error = refused(alternating(1000), &options);
    assert!(matches!(error, CharacteriseError::Filtered { .. }), "{error}");
    assert!(error.to_string().contains("19.099 s"), "{error}");
}

#[test]
fn options_that_mean_nothing_are_refused() {
    for bandwidth_hz in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let options = Options { bandwidth_hz: Some(bandwidth_hz), ..Options::default() };
        let error = refused(alternating(1000), &options);
        assert!(matches!(error, CharacteriseError::Bandwidth { .. }), "{error}");
    }
    for confidence in [0.0, 1.0, -0.5, f64::NAN] {
        let options = Options { confidence, ..Options::default() };
        let error = refused(alternating(1000), &options);
        assert!(matches!(error, CharacteriseError::Confidence { .. }), "{error}");
    }
}
