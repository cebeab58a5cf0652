//! `[[fault]]`: what goes wrong on purpose.

use super::numbers::or;
use struna_gyro::Rail;
use struna_harness::fault::{FAULTS_MAX, Fault, FaultKind, FaultPlan, Trigger};
use struna_kernel::{RAD_PER_DEG, SimTime};
use struna_settings::{Result, Table, Value};

/// Keys that say when.
const WHEN: [&str; 7] =
    ["kind", "at_s", "every_s", "first_s", "jitter_s", "rate_hz", "rate_per_byte"];
/// The keys of size, of which each kind knows its own.
const SIZES: [(&str, &str); 12] = [
    ("burst", "bytes"),
    ("saturation", "rail"),
    ("bias-step", "rate_deg_s"),
    ("bias-ramp", "rate_deg_s2"),
    ("scale-change", "share"),
    ("noise-change", "factor"),
    ("spike", "rate_deg_s"),
    ("delay", "delay_s"),
    ("jitter", "delay_max_s"),
    ("baud-error", "share"),
    ("clock-drift", "drift_ppm"),
    ("clock-jump", "jump_s"),
];
/// Kinds without a size.
const PLAIN: [(&str, FaultKind); 11] = [
    ("byte-drop", FaultKind::ByteDrop),
    ("bit-flip", FaultKind::BitFlip),
    ("duplicate-byte", FaultKind::DuplicateByte),
    ("inserted-byte", FaultKind::InsertedByte),
    ("truncated-frame", FaultKind::Truncated),
    ("wrong-value", FaultKind::WrongValue),
    ("swapped-frames", FaultKind::SwappedFrames),
    ("duplicated-frame", FaultKind::DuplicatedFrame),
    ("stuck", FaultKind::Stuck),
    ("dropout", FaultKind::Dropout),
    ("port-loss", FaultKind::PortLoss),
];

pub(super) fn plan(root: &Table<'_>) -> Result<FaultPlan> {
    let tables = root.tables("fault", FAULTS_MAX)?;
    let faults = tables.iter().map(fault).collect::<Result<Vec<_>>>()?;
    FaultPlan::new(faults).map_err(|error| root.because(error.to_string()))
}

fn fault(table: &Table<'_>) -> Result<Fault> {
    let kind = kind(table)?;
    let duration = or(table, "duration_s", time, SimTime::ZERO)?;
    let fault = Fault { kind, trigger: trigger(table)?, duration };
    fault.validate().map_err(|reason| table.because(reason))?;
    Ok(fault)
}

fn kind(table: &Table<'_>) -> Result<FaultKind> {
    let value = table.required("kind")?;
    let sized = SIZES.map(|(kind, key)| (kind, (kind, Some(key))));
    let plain = PLAIN.map(|(kind, _)| (kind, (kind, None)));
    let (kind, key) = value.word(&[&sized[..], &plain[..]].concat())?;
    let known: Vec<_> = WHEN.into_iter().chain(["duration_s"]).chain(key).collect();
    table.only(&known)?;
    match key {
        Some(key) => sized_kind(kind, &table.required(key)?),
        None => value.word(&PLAIN),
    }
}

fn sized_kind(kind: &str, size: &Value<'_>) -> Result<FaultKind> {
    let rails = [("positive", Rail::Positive), ("negative", Rail::Negative)];
    Ok(match kind {
        "burst" => FaultKind::Burst { bytes: size.integer_in(1..=4096)? },
        "saturation" => FaultKind::Saturation { rail: size.word(&rails)? },
        "bias-step" => FaultKind::BiasStep { rate_rad_s: size.number()? * RAD_PER_DEG },
        "bias-ramp" => FaultKind::BiasRamp { rate_rad_s2: size.number()? * RAD_PER_DEG },
        "scale-change" => FaultKind::ScaleChange { share: size.number()? },
        "noise-change" => FaultKind::NoiseChange { factor: size.not_negative()? },
        "spike" => FaultKind::Spike { rate_rad_s: size.number()? * RAD_PER_DEG },
        "delay" => FaultKind::Delay { delay_s: size.number_in(0.0..=1e3)? },
        "jitter" => FaultKind::Jitter { delay_max_s: size.number_in(0.0..=1e3)? },
        "baud-error" => FaultKind::BaudError { share: size.number_in(-0.5..=0.5)? },
        "clock-drift" => FaultKind::ClockDrift { share: size.number_in(-5e5..=5e5)? * 1e-6 },
        _ => FaultKind::ClockJump { jump_s: size.number_in(0.0..=1e3)? },
    })
}

/// Exactly one of `at_s`, `every_s`, `rate_hz` and `rate_per_byte`.
fn trigger(table: &Table<'_>) -> Result<Trigger> {
    let ways = ["at_s", "every_s", "rate_hz", "rate_per_byte"];
    let given: Vec<_> =
        ways.into_iter().filter_map(|way| Some((way, table.optional(way)?))).collect();
    let [(way, value)] = given.as_slice() else {
        return Err(table.because(format!("give exactly one of: {}", ways.join(", "))));
    };
    for key in ["first_s", "jitter_s"] {
        if let Some(stray) = table.optional(key).filter(|_| *way != "every_s") {
            return Err(stray.because("belongs to `every_s`; remove it"));
        }
    }
    Ok(match *way {
        "at_s" => Trigger::At(time(value)?),
        "every_s" => {
            let period_s = value.positive()?;
            let first = or(table, "first_s", time, time(value)?)?;
            Trigger::Every { first, period_s, jitter_s: or(table, "jitter_s", Value::number, 0.0)? }
        }
        "rate_hz" => Trigger::Random { rate_hz: value.positive()? },
        _ => Trigger::PerByte { rate_per_byte: value.positive()? },
    })
}

fn time(value: &Value<'_>) -> Result<SimTime> {
    SimTime::from_s(value.not_negative()?).map_err(|error| value.because(error.to_string()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<FaultPlan> {
        struna_settings::read(text, plan)
    }

    fn refusal(text: &str) -> String {
        read(&format!("[[fault]]\n{text}")).unwrap_err().to_string()
    }

    #[test]
    fn every_kind_of_the_catalogue_can_be_written() {
        for (kind, _) in PLAIN {
            let plan = read(&format!("[[fault]]\nkind = \"{kind}\"\nat_s = 1\nduration_s = 0.5"));
            assert_eq!(plan.unwrap().faults()[0].kind.name(), kind);
        }
        for (kind, key) in SIZES {
            let size = if key == "rail" { "\"negative\"" } else { "1" };
            let size = if matches!(kind, "baud-error") { "0.1" } else { size };
            let text =
                format!("[[fault]]\nkind = \"{kind}\"\nat_s = 1\nduration_s = 2\n{key} = {size}");
            assert_eq!(read(&text).unwrap().faults()[0].kind.name(), kind, "{text}");
        }
    }

    #[test]
    fn sizes_become_si() {
        let text = "[[fault]]\nkind = \"spike\"\nrate_hz = 2\nrate_deg_s = 180";
        let FaultKind::Spike { rate_rad_s } = read(text).unwrap().faults()[0].kind else {
            panic!("a spike was written")
        };
        assert!((rate_rad_s - std::f64::consts::PI).abs() < 1e-15);
        let text = "[[fault]]\nkind = \"clock-drift\"\nat_s = 1\nduration_s = 9\ndrift_ppm = 50";
        let FaultKind::ClockDrift { share } = read(text).unwrap().faults()[0].kind else {
            panic!("a drift was written")
        };
        assert!((share - 5e-5).abs() < 1e-18);
    }

    #[test]
    fn what_contradicts_itself_is_refused_with_a_reason() {
        for (text, reason) in [
            ("kind = \"bit-flop\"\nat_s = 1", "bit-flip"),
            ("kind = \"bit-flip\"", "exactly one of"),
            ("kind = \"bit-flip\"\nat_s = 1\nrate_hz = 1", "exactly one of"),
            ("kind = \"bit-flip\"\nat_s = 1\nshare = 1", "share"),
            ("kind = \"bit-flip\"\nat_s = 1\njitter_s = 1", "every_s"),
            ("kind = \"bit-flip\"\nat_s = -1", "0 or a greater number"),
            ("kind = \"stuck\"\nat_s = 1", "needs a duration"),
            ("kind = \"stuck\"\nevery_s = 1\nduration_s = 2", "lengthen the period"),
            ("kind = \"stuck\"\nrate_per_byte = 0.1\nduration_s = 1", "single bytes"),
            ("kind = \"byte-drop\"\nrate_per_byte = 2", "up to 1"),
            ("kind = \"delay\"\nat_s = 1\nduration_s = 1\ndelay_s = -1", "1e3"),
            ("kind = \"burst\"\nat_s = 1\nbytes = 0", "1 to 4096"),
            ("kind = \"bias-step\"\nat_s = 1\nduration_s = 1", "rate_deg_s"),
            ("kind = \"baud-error\"\nat_s = 1\nduration_s = 1\nshare = nan", "number"),
            ("kind = \"bit-flip\"\nat_s = 1e300", "not a time"),
        ] {
            let message = refusal(text);
            assert!(message.contains(reason), "{text}: {message}");
        }
    }
}
