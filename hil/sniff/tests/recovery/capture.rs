//! Bytes that a sender puts on a line: at rest, then turned both ways; whole or damaged.

use crate::layouts::Sender;
use rand::{Rng, RngExt};
use std::f64::consts::TAU;
use struna_sniff::{CheckKind, Coding, Field, Kind, Layout, Role};

/// How a capture is made.
#[derive(Clone, Copy)]
pub(crate) struct Conditions {
    pub(crate) seconds: f64,
    /// Share of bytes flipped, lost or doubled.
    pub(crate) corrupted: f64,
    pub(crate) turned: bool,
}

/// A capture of `sender` that begins anywhere in a frame.
pub(crate) fn capture(sender: &Sender, conditions: Conditions, rng: &mut impl Rng) -> Vec<u8> {
    let mut motion = Motion::random(sender, conditions, rng);
    let frames = (conditions.seconds * sender.rate_hz).round();
    let mut bytes = Vec::new();
    let mut temperature = rng.random_range(1000.0..9000.0);
    let drift = rng.random_range(-300.0..300.0) / frames;
    let noise = rng.random_range(0.6..12.0);
    let toggling = 10f64.powf(rng.random_range(-3.0..-1.0));
    let (mut k, mut count) = (0.0, rng.random::<u32>());
    let mut level = 0;
    while k < frames {
        temperature += drift;
        level ^= usize::from(rng.random_bool(toggling));
        let values = Values {
            count,
            status: sender.status.as_ref().map_or(0, |(_, levels)| levels[level % levels.len()]),
            temperature: temperature + noise * gaussian(rng),
            rate: motion.rate_at(k / frames, k / sender.rate_hz, rng),
        };
        bytes.extend(frame(&sender.layout, &values));
        count = count.wrapping_add(1);
        k += 1.0;
    }
    let begin = rng.random_range(0..sender.layout.len);
    damaged(&bytes[begin..], conditions.corrupted, sender.layout.kind, rng)
}

/// Frames that the capture did not hold: large motion, any status. With the numbers put in.
pub(crate) fn fresh(layout: &Layout, count: usize, rng: &mut impl Rng) -> (Vec<u8>, Vec<i64>) {
    let (mut bytes, mut rates) = (Vec::new(), Vec::new());
    let field = *layout.rate().unwrap();
    let start = rng.random::<u32>();
    for k in 0..count {
        let full = full_scale(&field);
        let values = Values {
            count: start.wrapping_add(u32::try_from(k).unwrap()),
            status: rng.random::<u8>() & if layout.kind == Kind::Septet { 0x7F } else { 0xFF },
            temperature: rng.random_range(1000.0..9000.0),
            rate: rng.random_range(-0.9..0.9) * full,
        };
        bytes.extend(frame(layout, &values));
        rates.push(raw(&field, values.rate));
    }
    (bytes, rates)
}

struct Values {
    count: u32,
    status: u8,
    temperature: f64,
    rate: f64,
}

/// Rest for a while, then two tones.
struct Motion {
    rest: f64,
    amplitudes: [f64; 2],
    frequencies_hz: [f64; 2],
    noise: f64,
    bias: f64,
    turned: bool,
}

impl Motion {
    fn random(sender: &Sender, conditions: Conditions, rng: &mut impl Rng) -> Self {
        let field = sender.layout.rate().unwrap();
        let full = full_scale(field);
        let share = rng.random_range(0.05..0.65);
        let first = rng.random_range(0.5..0.9);
        // From below one count to hundreds, as far as the range allows.
        let loudest = (full / 50.0).clamp(1.0, 600.0);
        let mut noise = (0.8f64.ln() + rng.random::<f64>() * (loudest / 0.8).ln()).exp();
        if field.coding == Coding::Float {
            noise = full * 10f64.powf(rng.random_range(-6.0..-3.5));
        }
        Self {
            rest: rng.random_range(0.25..0.55),
            amplitudes: [share * full * first, share * full * (1.0 - first)],
            frequencies_hz: [rng.random_range(0.2..0.6), rng.random_range(0.6..1.6)],
            noise,
            bias: noise * rng.random_range(-2.0..2.0),
            turned: conditions.turned,
        }
    }

    fn rate_at(&mut self, progress: f64, time_s: f64, rng: &mut impl Rng) -> f64 {
        let rest = self.bias + self.noise * gaussian(rng);
        if !self.turned || progress < self.rest {
            return rest;
        }
        let tone = |k: usize| self.amplitudes[k] * (TAU * self.frequencies_hz[k] * time_s).sin();
        rest + tone(0) + tone(1)
    }
}

/// The largest value either way; of a float, 200 of its units.
fn full_scale(field: &Field) -> f64 {
    if field.coding == Coding::Float { 200.0 } else { f64::from(field.bits - 1).exp2() }
}

fn raw(field: &Field, rate: f64) -> i64 {
    if field.coding == Coding::Float {
        #[expect(clippy::cast_possible_truncation, reason = "a float is what the frame carries")]
        let single = rate as f32;
        return i64::from(single.to_bits());
    }
    let full = full_scale(field);
    #[expect(clippy::cast_possible_truncation, reason = "clamped to the field's range")]
    let raw = rate.round().clamp(-full, full - 1.0) as i64;
    raw
}

fn frame(layout: &Layout, values: &Values) -> Vec<u8> {
    let digit_bits = layout.digit_bits();
    let mut frame = layout.sync.clone();
    frame.resize(layout.len, 0);
    if let Some(counter) = &layout.counter {
        let code = u64::from(values.count % counter.modulus);
        put(&mut frame, counter.at, counter.bytes, counter.big_endian, code, digit_bits);
    }
    for field in &layout.fields {
        let raw = match field.role {
            Role::Rate => raw(field, values.rate),
            Role::Status => values.status.into(),
            _ => {
                #[expect(clippy::cast_possible_truncation, reason = "within two bytes")]
                let raw = values.temperature.round() as i64;
                raw
            }
        };
        let code = match field.coding {
            Coding::OffsetBinary => raw + (1 << (field.bits - 1)),
            _ => raw,
        };
        let digits = if field.coding == Coding::OffsetBinary { 32 } else { 64 };
        let code = u64::from_ne_bytes(code.to_ne_bytes()) & (u64::MAX >> (64 - digits));
        put(&mut frame, field.at, field.bytes, field.big_endian, code, digit_bits);
    }
    if let Some(check) = &layout.check {
        let mut value = check_of(check.kind, &frame[check.first..=check.last]);
        value &= if check.seven_bits { 0x7F } else { u64::MAX };
        put(&mut frame, check.at, check.kind.bytes(), check.big_endian, value, 8);
    }
    frame
}

fn put(frame: &mut [u8], at: usize, bytes: usize, big_endian: bool, code: u64, digit_bits: u32) {
    for k in 0..bytes {
        let place = if big_endian { bytes - 1 - k } else { k };
        let digit = (code >> (digit_bits * u32::try_from(k).unwrap())) & ((1 << digit_bits) - 1);
        frame[at + place] = u8::try_from(digit).unwrap();
    }
}

/// Bit by bit, so that no table is shared with the code under test.
fn check_of(kind: CheckKind, range: &[u8]) -> u64 {
    let sum: u64 = range.iter().map(|byte| u64::from(*byte)).sum();
    match kind {
        CheckKind::Sum8 => sum & 0xFF,
        CheckKind::NegSum8 => sum.wrapping_neg() & 0xFF,
        CheckKind::Xor8 => range.iter().fold(0, |a, b| a ^ u64::from(*b)),
        CheckKind::Crc(crc) => {
            let (top, mask) = (1u64 << (crc.width - 1), (1u64 << crc.width) - 1);
            let mut register = u64::from(crc.init);
            for byte in range {
                let byte = if crc.reflected { byte.reverse_bits() } else { *byte };
                for bit in (0..8).rev() {
                    let feedback = (register & top != 0) != ((byte >> bit) & 1 == 1);
                    register = (register << 1) & mask;
                    register ^= if feedback { u64::from(crc.poly) } else { 0 };
                }
            }
            if crc.reflected {
                register = register.reverse_bits() >> (64 - crc.width);
            }
            register ^ u64::from(crc.xorout)
        }
    }
}

/// Equal shares of flipped, lost and inserted bytes.
pub(crate) fn damaged(bytes: &[u8], share: f64, kind: Kind, rng: &mut impl Rng) -> Vec<u8> {
    let _ = kind;
    let mut out = Vec::with_capacity(bytes.len() + bytes.len() / 50);
    for byte in bytes {
        if !rng.random_bool(share) {
            out.push(*byte);
            continue;
        }
        match rng.random_range(0..3) {
            0 => out.push(byte ^ (1 << rng.random_range(0..8))),
            1 => {}
            _ => out.extend([rng.random(), *byte]),
        }
    }
    out
}

/// Standard normal, by Box and Muller.
fn gaussian(rng: &mut impl Rng) -> f64 {
    let radius = (-2.0 * (1.0 - rng.random::<f64>()).ln()).sqrt();
    radius * (TAU * rng.random::<f64>()).cos()
}
