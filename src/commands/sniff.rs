//! `struna frame sniff`.

use super::Outcome;
use crate::cli::{Baud, FrameSniff};
use crate::frames;
use crate::output::{create_folder, write_whole};
use anyhow::{Context, Result, bail};
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};
use struna_line::{RawCapture, SerialReader, StopFlag};
use struna_sniff::{Labels, Proposal, Report, Verdict, length_score, sniff};

/// Seconds of a capture, and of each trial of a baud rate.
const CAPTURE_S: f64 = 8.0;
const TRIAL_S: f64 = 0.7;
/// Share of the capture in which the gyro rests.
const REST_SHARE: f64 = 0.375;
/// Bytes of a file that are looked at; more would tell no more.
const FILE_BYTES_MAX: u64 = 16 << 20;
/// Tried in this order; of equals the first is kept.
const BAUDS: [u32; 10] =
    [115_200, 9600, 19_200, 38_400, 57_600, 230_400, 250_000, 460_800, 614_400, 921_600];
/// Of a byte without parity.
const SYMBOLS_PER_BYTE: f64 = 10.0;
/// Below this a length explains nothing: noise scores 0, frames with one sync byte 0.3 and more.
const SENSIBLE_BITS: f64 = 0.2;

/// What to look at, and what is known of it.
struct Capture {
    bytes: Vec<u8>,
    seconds: Option<f64>,
    baud: Option<u32>,
}

pub(super) fn execute(args: &FrameSniff) -> Result<Outcome> {
    let stop = StopFlag::new();
    let (capture, out) = match (&args.port, &args.file) {
        (Some(port), _) => {
            on_ctrl_c(&stop)?;
            let out = args.out.clone().unwrap_or_else(|| PathBuf::from("out/sniffed.toml"));
            (from_port(port, args, &out, &stop)?, Some(out))
        }
        (None, Some(file)) => {
            let capture =
                Capture { bytes: read_file(file)?, seconds: args.seconds, baud: given(args.baud) };
            (capture, args.out.clone())
        }
        (None, None) => bail!("nothing to look at; give --port or --file"),
    };
    if capture.bytes.is_empty() {
        bail!("no bytes at all; check that the gyro is powered and sends by itself");
    }
    let second = args.second.as_deref().map(read_file).transpose()?;
    let report = sniff(&capture.bytes, second.as_deref());
    let toml = report.proposals.first().map(|first| toml_of(first, &report, &capture, args));
    // Whatever may fail comes before the first line is printed.
    let toml = toml.transpose()?.flatten();
    if let (Some(out), Some(text)) = (&out, &toml) {
        write_whole(out, |file| file.write_all(text.as_bytes()))?;
    }
    print_report(&report);
    match (&out, &toml) {
        (Some(out), Some(_)) => println!("\nThe frame file is {}.", out.display()),
        (None, Some(text)) => println!("\n{text}"),
        (_, None) => println!("\nNo frame file can be written for this."),
    }
    Ok(if stop.is_stopped() { Outcome::Interrupted } else { Outcome::Complete })
}

fn on_ctrl_c(stop: &StopFlag) -> Result<()> {
    let switch = stop.clone();
    ctrlc::set_handler(move || switch.stop()).context("cannot listen for Ctrl-C")
}

const fn given(baud: Baud) -> Option<u32> {
    match baud {
        Baud::Auto => None,
        Baud::At(baud) => Some(baud),
    }
}

fn read_file(path: &Path) -> Result<Vec<u8>> {
    let cannot = || format!("cannot read {}; check the path", path.display());
    let mut bytes = Vec::new();
    let file = File::open(path).with_context(cannot)?;
    file.take(FILE_BYTES_MAX).read_to_end(&mut bytes).with_context(cannot)?;
    Ok(bytes)
}

/// Captures, and saves what came before anything is made of it.
fn from_port(port: &Path, args: &FrameSniff, out: &Path, stop: &StopFlag) -> Result<Capture> {
    let baud = match args.baud {
        Baud::At(baud) => baud,
        Baud::Auto => likeliest_baud(port, stop)?,
    };
    let mut reader = SerialReader::open(port, baud)?;
    let seconds = args.seconds.unwrap_or(CAPTURE_S);
    let rest_s = REST_SHARE * seconds;
    println!("Keep the gyro still for {rest_s:.1} s ...");
    let mut turning = false;
    let raw = RawCapture::read(&mut reader, seconds, stop, &mut |passed_s| {
        if !turning && passed_s >= rest_s {
            turning = true;
            println!("... and turn it by hand, both ways, for {:.1} s.", seconds - rest_s);
        }
    })?;
    let beside = out.with_extension("bin");
    if let Some(folder) = beside.parent().filter(|folder| !folder.as_os_str().is_empty()) {
        create_folder(folder)?;
    }
    write_whole(&beside, |file| file.write_all(&raw.bytes))?;
    println!(
        "{} bytes in {:.2} s at {baud} baud are in {}.",
        raw.bytes.len(),
        raw.duration_s,
        beside.display()
    );
    Ok(Capture { bytes: raw.bytes, seconds: Some(raw.duration_s), baud: Some(baud) })
}

/// The usual baud rate at which frames of one length explain most of what comes.
fn likeliest_baud(port: &Path, stop: &StopFlag) -> Result<u32> {
    let mut best: Option<(f64, u32)> = None;
    for baud in BAUDS {
        let mut reader = SerialReader::open(port, baud)?;
        let raw = RawCapture::read(&mut reader, TRIAL_S, stop, &mut |_| {})?;
        let score = length_score(&raw.bytes);
        println!("{baud:>7} baud: {:>6} bytes, {score:.2} bits a byte explained", raw.bytes.len());
        if best.is_none_or(|(most, _)| score > most) {
            best = Some((score, baud));
        }
    }
    match best {
        Some((score, baud)) if score >= SENSIBLE_BITS => Ok(baud),
        _ => bail!(
            "bytes make no sense at any of the usual baud rates; check that the gyro sends by \
             itself, or give --baud"
        ),
    }
}

/// The frame file, read back by the reader of frame files before anybody relies on it.
fn toml_of(
    first: &Proposal,
    report: &Report,
    capture: &Capture,
    args: &FrameSniff,
) -> Result<Option<String>> {
    let confirmed = matches!(report.verdict, Verdict::Confirmed { .. });
    let labels = Labels {
        name: args.name.clone(),
        baud: capture.baud,
        rate_hz: args.rate_hz.or_else(|| rate_hz(first, capture)),
        measured: confirmed && args.port.is_some(),
    };
    let Some(text) = first.to_toml(&labels) else { return Ok(None) };
    frames::unique(&text)
        .with_context(|| format!("the proposal makes no valid frame file:\n{text}"))?;
    Ok(Some(text))
}

/// To four digits: a hand-timed capture gives no more. Bytes that came faster than their line can
/// carry had been waiting somewhere, and say nothing of the gyro's rate.
fn rate_hz(first: &Proposal, capture: &Capture) -> Option<f64> {
    let bytes = u32::try_from(capture.bytes.len()).ok()?;
    let seconds = capture.seconds.filter(|seconds| *seconds > 0.0)?;
    let bytes_per_s = f64::from(bytes) / seconds;
    if capture.baud.is_some_and(|baud| bytes_per_s * SYMBOLS_PER_BYTE > 1.05 * f64::from(baud)) {
        return None;
    }
    let rate = bytes_per_s / first.mean_len(capture.bytes.len());
    let unit = 10f64.powf(rate.log10().floor() - 3.0);
    Some((rate / unit).round() * unit).filter(|rate| rate.is_finite() && *rate > 0.0)
}

fn print_report(report: &Report) {
    println!("{} bytes looked at; the first byte of a frame is byte 0.", report.bytes);
    for (k, proposal) in report.proposals.iter().enumerate() {
        println!("\nProposal {}, score {:.2}", k + 1, proposal.score);
        for [what, found, why] in proposal.table() {
            println!("  {what:<8} {found:<47} {why}");
        }
    }
    println!("\n{}", verdict(report.verdict));
    let Some(first) = report.proposals.first() else { return };
    println!("\nWhat the bytes cannot tell:");
    for alternative in &first.alternatives {
        println!("  - {alternative}");
    }
}

fn verdict(verdict: Verdict) -> String {
    match verdict {
        Verdict::Confirmed { share } => format!(
            "Confirmed: {:.1} % of bytes kept for the test were read by the first proposal.",
            100.0 * share
        ),
        Verdict::Unconfirmed(doubt) => format!("Unconfirmed: {doubt}."),
        Verdict::Unknown => "Unknown: no layout fits. Is the baud rate right? Frames of varying \
                             length, with stuffed bytes or below 3 bytes are not recognised."
            .to_owned(),
    }
}
