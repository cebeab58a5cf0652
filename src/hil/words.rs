//! Events in words: kind and detail for `events.csv`, a sentence for people.

use struna_harness::clock::Basis;
use struna_harness::live::{Gap, GapCause, Guess, LiveEvent, Sighting};

/// The kind of an event, for `events.csv`.
#[must_use]
pub fn kind(event: &LiveEvent) -> &'static str {
    match event {
        LiveEvent::Gap(_) => "gap",
        LiveEvent::PortLost { .. } => "port-lost",
        LiveEvent::PortBack { .. } => "port-back",
        LiveEvent::Resync { .. } => "resync",
        LiveEvent::CounterRestarted => "counter-restarted",
        LiveEvent::ClockSet { .. } => "clock-set",
        LiveEvent::NoFrames(_) => "no-frames",
        _ => "other",
    }
}

/// What happened.
#[must_use]
pub fn detail(event: &LiveEvent) -> String {
    match event {
        LiveEvent::Gap(gap) => gap_in_words(gap),
        LiveEvent::PortLost { reason } => reason.clone(),
        LiveEvent::PortBack { after_s } => format!("after {after_s:.3} s"),
        LiveEvent::Resync { skipped_bytes } => format!("{skipped_bytes} bytes skipped"),
        LiveEvent::CounterRestarted => "the frame counter began anew".to_owned(),
        LiveEvent::ClockSet { by_s } => format!("the host's clock was set by {by_s:.6} s"),
        LiveEvent::NoFrames(seen) => sighting(seen),
        other => format!("{other:?}"),
    }
}

fn gap_in_words(gap: &Gap) -> String {
    let by = match gap.basis {
        Basis::Counter => "by the counter",
        Basis::CounterAndTime => "by counter and time",
        Basis::Inferred => "inferred from time",
        Basis::Restarted => "inferred from time, the counter began anew",
    };
    let cause = match gap.cause {
        GapCause::Line => "lost on the line",
        GapCause::Port => "port gone",
        GapCause::Pause => "sensor paused",
    };
    let (lost, from_s, to_s) = (gap.lost, gap.from.as_s(), gap.to.as_s());
    format!("{lost} samples from {from_s:.6} s to {to_s:.6} s: {cause}; {by}")
}

/// What a line without frames brought instead, and what may be the matter.
#[must_use]
pub fn sighting(seen: &Sighting) -> String {
    let per_s = |count: u64| count as f64 / seen.span_s.max(f64::MIN_POSITIVE);
    let guess = match seen.guess() {
        Guess::Silence => "nothing is sent: is the device on, and is this its port?",
        Guess::OtherCheck => "frames begin as they should but fail their check: another version?",
        Guess::OtherFrame => "about as many bytes as expected: probably another frame",
        Guess::OtherBaud => "another device, another frame, or another baud rate",
    };
    format!(
        "no good frame in {:.1} s: {:.0} bytes/s ({:.0} expected), {:.1} sync words/s with a bad \
         check ({:.0} frames/s expected); {guess}",
        seen.span_s,
        per_s(seen.bytes),
        seen.expected_bytes_per_s,
        per_s(seen.false_starts),
        seen.expected_frames_per_s,
    )
}
