//! Bytes decoded per second, beside the rate that was asked for and beside the crates `cobs` and
//! `crc` on the same payload.

use crate::table::Row;
use crate::timing::{best_in_turns, time_per_unit};
use anyhow::{Result, ensure};
use std::hint::black_box;
use struna::frames::SHIPPED;
use struna_wire::{Decoder, Encoder, FrameSpec, Kind};

const FRAMES: u32 = 20_000;
/// Bytes per push: what one read of a serial line returns at most.
const READ_LEN: usize = 4096;
/// Of good frames, and of a stream in which every twentieth byte is damaged.
const CLEAN_BYTES_PER_S: f64 = 200e6;
const DAMAGED_BYTES_PER_S: f64 = 100e6;

pub(crate) fn rows() -> Result<Vec<Row>> {
    let default = FrameSpec::from_toml(SHIPPED[0].1)?;
    let mut rows = against_limits(&default)?;
    rows.push(against_cobs(&default)?);
    for (name, text) in &SHIPPED[1..] {
        let spec = FrameSpec::from_toml(text)?;
        let clean = clean_stream(&spec)?;
        let decode = Box::new(|| time_per_unit(clean.len(), || decode(&spec, &clean, FRAMES - 1)));
        let [s_per_byte] = best_in_turns([decode])?;
        rows.push(row(name, s_per_byte, None));
    }
    Ok(rows)
}

fn against_limits(spec: &FrameSpec) -> Result<Vec<Row>> {
    let clean = clean_stream(spec)?;
    let [fiftieth, twentieth] = [50, 20].map(|every| damaged_stream(&clean, every));
    let [clean_s, fiftieth_s, twentieth_s] = best_in_turns([
        Box::new(|| time_per_unit(clean.len(), || decode(spec, &clean, FRAMES))),
        Box::new(|| time_per_unit(clean.len(), || decode(spec, &fiftieth, FRAMES / 2))),
        Box::new(|| time_per_unit(clean.len(), || decode(spec, &twentieth, FRAMES / 4))),
    ])?;
    Ok(vec![
        row("good frames", clean_s, Some(CLEAN_BYTES_PER_S)),
        row("1 byte in 50 damaged", fiftieth_s, Some(DAMAGED_BYTES_PER_S)),
        row("1 byte in 20 damaged", twentieth_s, Some(DAMAGED_BYTES_PER_S)),
    ])
}

fn row(what: &str, s_per_byte: f64, limit: Option<f64>) -> Row {
    let mb_per_s = |bytes_per_s: f64| format!("{:.0} MB/s", 1e-6 * bytes_per_s);
    Row {
        what: format!("decoder, {what}"),
        ours: mb_per_s(1.0 / s_per_byte),
        other: limit.map_or("-".to_owned(), |limit| mb_per_s(limit) + " (limit)"),
        ratio: limit.map(|limit| 1.0 / (s_per_byte * limit)),
        target: 1.0,
    }
}

/// The same counter, status, rate and temperature with CRC, framed by COBS: our decoder beside the
/// crates `cobs` and `crc`, which read the same numbers out.
fn against_cobs(default: &FrameSpec) -> Result<Row> {
    let text = SHIPPED[0].1.replace("\"fixed\"", "\"cobs\"").replace("sync = \"A5 5A\"", "");
    let spec = FrameSpec::from_toml(&text)?;
    let ours = clean_stream(default)?;
    let theirs = clean_stream(&spec)?;
    let payload = ours.len();
    let [ours_s, theirs_s] = best_in_turns([
        Box::new(|| time_per_unit(payload, || decode(default, &ours, FRAMES))),
        Box::new(|| time_per_unit(payload, || decode_with_crates(&theirs, FRAMES))),
    ])?;
    let other = format!("{:.0} MB/s (cobs + crc)", 1e-6 / theirs_s);
    Ok(Row { other, ratio: Some(theirs_s / ours_s), ..row("same payload", ours_s, None) })
}

/// Frames of the emulated gyro with slowly changing rates.
fn clean_stream(spec: &FrameSpec) -> Result<Vec<u8>> {
    let mut encoder = Encoder::new(spec);
    let rate = spec.field_index("rate").expect("every shipped frame has a rate");
    let mut raw = vec![0; spec.fields().len()];
    // A line begins behind the end of another; before anything else that would be noise.
    let mut bytes = if spec.kind() == Kind::Ascii { b"\n".to_vec() } else { Vec::new() };
    for k in 0..FRAMES {
        raw[rate] = spec.fields()[rate].from_si((f64::from(k) * 1e-3).sin());
        encoder.encode(&raw, &mut bytes)?;
    }
    Ok(bytes)
}

/// Some bytes turned into the start of a sync word: the damage that costs a decoder most.
fn damaged_stream(clean: &[u8], every: usize) -> Vec<u8> {
    clean.iter().enumerate().map(|(k, &byte)| if k % every == 0 { 0xA5 } else { byte }).collect()
}

#[inline(never)]
fn decode(spec: &FrameSpec, bytes: &[u8], at_least: u32) -> Result<()> {
    let mut decoder = Decoder::new(spec.clone());
    for read in bytes.chunks(READ_LEN) {
        decoder.push(black_box(read), &mut |frame| {
            black_box(frame);
        });
    }
    let found = decoder.finish().ok;
    ensure!(found >= u64::from(at_least), "{found} frames decoded, at least {at_least} expected");
    Ok(())
}

/// As one would do it with the crates: split at zeros, undo COBS, check the CRC, take the numbers.
#[inline(never)]
fn decode_with_crates(bytes: &[u8], at_least: u32) -> Result<()> {
    let crc = crc::Crc::<u16>::new(&crc::CRC_16_IBM_3740);
    let mut content = [0; 64];
    let mut found = 0;
    for coded in black_box(bytes).split(|byte| *byte == 0) {
        let Ok(length) = cobs::decode(coded, &mut content) else { continue };
        if length != 11 {
            continue;
        }
        let [_, _, seq, status, r0, r1, r2, t0, t1, c0, c1, ..] = content;
        if crc.checksum(&content[2..9]) == u16::from_be_bytes([c0, c1]) {
            found += 1;
            let rate = i32::from_be_bytes([r0, r1, r2, 0]) >> 8;
            black_box((seq, status, rate, i16::from_be_bytes([t0, t1])));
        }
    }
    ensure!(found >= at_least, "{found} frames decoded, at least {at_least} expected");
    Ok(())
}
