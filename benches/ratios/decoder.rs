//! Bytes decoded per second, beside the rate that was asked for.

use crate::table::Row;
use crate::timing::{best_in_turns, time_per_unit};
use anyhow::{Result, ensure};
use std::hint::black_box;
use struna_wire::{Decoder, Encoder, FrameSpec};

const FRAMES: u32 = 20_000;
/// Bytes per push: what one read of a serial line returns at most.
const READ_LEN: usize = 4096;
const LIMIT_BYTES_PER_S: f64 = 100e6;

pub(crate) fn rows() -> Result<Vec<Row>> {
    let spec = FrameSpec::from_toml(include_str!("../../frames/vg910d.toml"))?;
    let clean = clean_stream(&spec)?;
    let damaged = damaged_stream(&clean);
    let [clean_s, damaged_s] = best_in_turns([
        Box::new(|| time_per_unit(clean.len(), || decode(&spec, &clean, FRAMES))),
        Box::new(|| time_per_unit(damaged.len(), || decode(&spec, &damaged, FRAMES / 2))),
    ])?;
    let row = |what: &str, s_per_byte: f64| Row {
        what: format!("decoder, {what}"),
        ours: format!("{:.0} MB/s", 1e-6 / s_per_byte),
        other: format!("{:.0} MB/s (limit)", 1e-6 * LIMIT_BYTES_PER_S),
        ratio: Some(1.0 / (s_per_byte * LIMIT_BYTES_PER_S)),
        target: 1.0,
    };
    Ok(vec![row("good frames", clean_s), row("1 byte in 50 damaged", damaged_s)])
}

/// Frames of the emulated gyro with changing rates.
fn clean_stream(spec: &FrameSpec) -> Result<Vec<u8>> {
    let mut encoder = Encoder::new(spec);
    let mut raw = vec![0; spec.fields().len()];
    let mut bytes = Vec::new();
    for k in 0..FRAMES {
        raw[0] = i64::from(k.wrapping_mul(2_654_435_761) >> 9) - (1 << 22);
        encoder.encode(&raw, &mut bytes)?;
    }
    Ok(bytes)
}

/// Every 50th byte turned into the start of a sync word: the damage that costs a decoder most.
fn damaged_stream(clean: &[u8]) -> Vec<u8> {
    clean.iter().enumerate().map(|(k, &byte)| if k % 50 == 0 { 0xA5 } else { byte }).collect()
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
