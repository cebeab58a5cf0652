//! A gyro preset with the noise that was measured.

use super::Characterized;
use super::text::time;
use super::unit::{DEG_H, of_term, on_data_sheet, plain, significant};
use std::fmt::Write;
use struna_gyro::characterise::{Term, Verdict};

/// Noise that a preset has a key for.
const TERMS: [Term; 4] =
    [Term::AngleRandomWalk, Term::BiasInstability, Term::RateRandomWalk, Term::RateRamp];

/// What a preset must say and no record at rest can.
const UNKNOWN: &str = r#"
# A record at rest does not show these: write in what the gyro has. The step is finer than any,
# because the measured noise holds that of the gyro's own rounding.
kind = { value = "mems", provenance = "invented", note = "fog or mems" }
rate_max_deg_s = { value = 250.0, provenance = "invented" }
lsb_deg_s = { value = 3.0517578125e-5, provenance = "invented", note = "noise holds the rounding" }
counts_bits = { value = 24, provenance = "invented" }
"#;

/// The preset as TOML text. Only coefficients that were estimated become values; what was bounded
/// or refused is a comment. With an over-bounding model its three coefficients are the values.
#[must_use]
pub fn toml(of: &Characterized) -> String {
    let record = &of.record;
    let source = of.source.escape_debug();
    let mut text = format!(
        "# Noise of a gyro as `struna characterize` found it in {source}:\n\
         # {} samples at rest, {} of them lost, {}.\n\n[gyro]\nname = {}\n",
        record.rates_rad_s().len(),
        record.lost(),
        time(record.duration_s()),
        quoted(&of.name),
    );
    let rate_hz = record.sample_rate_hz();
    put(&mut text, "sample_rate_hz", rate_hz, "measured", "of the record");
    if let Some(bandwidth_hz) = of.options.bandwidth_hz {
        put(&mut text, "bandwidth_hz", bandwidth_hz, "given", "not measured");
        let note = "the noise below the band is what was measured";
        let _ = writeln!(
            text,
            "noise_before_filter = {{ value = true, provenance = \"given\", note = \"{note}\" }}"
        );
    }
    text.push_str(UNKNOWN);
    let mean = significant(record.mean_rad_s() / DEG_H, 4);
    let _ = writeln!(
        text,
        "\n# The mean rate was {mean} deg/h: turn-on bias of that run and the Earth's rate about \
         the axis."
    );
    for term in TERMS {
        noise(&mut text, of, term);
    }
    text
}

fn noise(text: &mut String, of: &Characterized, term: Term) {
    let (unit, key, _) = of_term(term);
    let number = |value| on_data_sheet(term, value);
    if let Some(model) = &of.found.overbound {
        if term != Term::RateRamp {
            let note = "with the others above the Allan deviation's upper confidence limit";
            put(text, key, number(model.coefficient(term)), "measured", note);
        }
        return;
    }
    match of.found.verdict(term) {
        Verdict::Estimated { value, interval: [low, high] } => {
            let [low, high] = [low, high].map(|end| significant(number(end), 3));
            let confidence = plain(100.0 * of.options.confidence, 3);
            let note = format!("{low} to {high} with {confidence} % confidence");
            put(text, key, number(value), "measured", &note);
        }
        Verdict::AtMost { bound, reason } => {
            let bound = significant(number(bound), 3);
            let _ = writeln!(text, "# {key}: at most {bound} {unit}; {reason}");
        }
        Verdict::Refused { reason } => {
            let _ = writeln!(text, "# {key}: {reason}");
        }
    }
}

fn put(text: &mut String, key: &str, value: f64, provenance: &str, note: &str) {
    let (provenance, note) = (quoted(provenance), quoted(note));
    // No record knows a ninth digit.
    let value: f64 = format!("{value:.7e}").parse().unwrap_or(value);
    let entry = format!("{{ value = {value:?}, provenance = {provenance}, note = {note} }}");
    let _ = writeln!(text, "{key} = {entry}");
}

/// A TOML string. Control characters have no place in a name.
fn quoted(text: &str) -> String {
    let plain: String = text.chars().filter(|c| !c.is_control()).collect();
    format!("\"{}\"", plain.replace('\\', "\\\\").replace('"', "\\\""))
}
