//! Random frame layouts.

use rand::{Rng, RngExt};
use struna_sniff::{Check, CheckKind, Coding, Counter, Crc, Field, Kind, Layout, Role};

/// A layout and what its sender does beyond it.
pub(crate) struct Sender {
    pub(crate) layout: Layout,
    /// Where the status byte is and the values it takes in turn.
    pub(crate) status: Option<(usize, Vec<u8>)>,
    /// Frames per second.
    pub(crate) rate_hz: f64,
}

/// What a byte of a frame belongs to, before places are given out.
#[derive(Clone, Copy, PartialEq)]
enum Part {
    Counter,
    Status,
    Temperature,
    Reserved,
    Rate,
}

/// A random sender, drawn from the ranges that published gyro frames span.
pub(crate) fn random_sender(rng: &mut impl Rng) -> Sender {
    let septet = rng.random_bool(0.12);
    let rate_hz = (100f64.ln() + rng.random::<f64>() * 20f64.ln()).exp().round();
    let big_endian = rng.random_bool(0.65);
    let sync = if septet { vec![0x80 | rng.random_range(0..0x80u8)] } else { random_sync(rng) };
    let digit_bits = if septet { 7 } else { 8 };
    let rate = random_rate(rng, septet, big_endian);
    let counter = random_counter(rng, digit_bits);
    let mut parts = vec![Part::Rate];
    parts.extend(counter.map(|_| Part::Counter));
    for (part, odds) in [(Part::Status, 0.5), (Part::Temperature, 0.5), (Part::Reserved, 0.2)] {
        parts.extend(rng.random_bool(odds).then_some(part));
    }
    for k in (1..parts.len()).rev() {
        parts.swap(k, rng.random_range(0..=k));
    }
    let mut layout = Layout {
        kind: if septet { Kind::Septet } else { Kind::Fixed },
        len: sync.len(),
        sync,
        check: None,
        counter: None,
        fields: Vec::new(),
    };
    let mut status = None;
    for part in parts {
        let at = layout.len;
        layout.len += match part {
            Part::Counter => {
                let counter = Counter { at, ..counter.unwrap() };
                layout.counter = Some(counter);
                counter.bytes
            }
            Part::Status => {
                status = Some((at, random_status(rng, septet)));
                layout.fields.push(number(Role::Status, at, 1, digit_bits, Coding::Unsigned));
                1
            }
            Part::Temperature => {
                let field = number(Role::Temperature, at, 2, 2 * digit_bits, Coding::Twos);
                layout.fields.push(Field { big_endian, ..field });
                2
            }
            Part::Reserved => 1,
            Part::Rate => {
                layout.fields.push(Field { at, ..rate });
                rate.bytes
            }
        };
    }
    if !rng.random_bool(0.10) {
        let check = random_check(rng, &layout);
        layout.len += check.kind.bytes();
        layout.check = Some(check);
    }
    Sender { layout, status, rate_hz }
}

/// One to four bytes of any value.
fn random_sync(rng: &mut impl Rng) -> Vec<u8> {
    (0..rng.random_range(1..=4)).map(|_| rng.random()).collect()
}

fn number(role: Role, at: usize, bytes: usize, bits: u32, coding: Coding) -> Field {
    let (shift, big_endian, only_channel_zero) = (0, true, false);
    Field { role, at, bytes, bits, shift, big_endian, coding, only_channel_zero }
}

fn random_rate(rng: &mut impl Rng, septet: bool, big_endian: bool) -> Field {
    use Coding::{Float, OffsetBinary, Twos};
    let (bytes, bits, coding) = if septet {
        let septets = rng.random_range(3..=5usize);
        (septets, [21, 28, 32][septets - 3], Twos)
    } else {
        let kinds = [
            (2, 12, OffsetBinary),
            (2, 16, Twos),
            (2, 16, OffsetBinary),
            (3, 20, OffsetBinary),
            (3, 24, Twos),
            (4, 32, Twos),
            (4, 32, Float),
        ];
        kinds[rng.random_range(0..kinds.len())]
    };
    Field { big_endian, ..number(Role::Rate, 0, bytes, bits, coding) }
}

fn random_counter(rng: &mut impl Rng, digit_bits: u32) -> Option<Counter> {
    let whole = 1u32 << digit_bits;
    match rng.random_range(0..3) {
        0 => None,
        1 => {
            let moduli = [16, 100, 128, whole];
            let modulus = moduli[rng.random_range(0..moduli.len())];
            Some(Counter { at: 0, bytes: 1, big_endian: true, modulus })
        }
        _ => {
            let big_endian = rng.random_bool(0.5);
            Some(Counter { at: 0, bytes: 2, big_endian, modulus: whole * whole })
        }
    }
}

/// Half of the status bytes never change.
fn random_status(rng: &mut impl Rng, septet: bool) -> Vec<u8> {
    let top = if septet { 0x7F } else { 0xFF };
    let value = rng.random::<u8>() & top;
    if rng.random_bool(0.5) {
        vec![value]
    } else {
        vec![value, value ^ (1 << rng.random_range(0..7))]
    }
}

fn random_check(rng: &mut impl Rng, layout: &Layout) -> Check {
    let seven_bits = layout.kind == Kind::Septet;
    let sums = [CheckKind::Sum8, CheckKind::NegSum8, CheckKind::Xor8];
    let kind = match rng.random_range(0..2) {
        0 if !seven_bits => CheckKind::Crc(random_crc(rng)),
        _ => sums[rng.random_range(0..3)],
    };
    let begins = [0, layout.sync.len(), layout.sync.len() + 1][rng.random_range(0..3)];
    let (first, at) = (begins.min(layout.len - 2), layout.len);
    let big_endian = kind.bytes() == 1 || rng.random_bool(0.5);
    Check { kind, first, last: at - 1, at, big_endian, seven_bits }
}

/// Any of the common CRCs of each width.
fn random_crc(rng: &mut impl Rng) -> Crc {
    let all = Crc::catalogue();
    all[rng.random_range(0..all.len())]
}
