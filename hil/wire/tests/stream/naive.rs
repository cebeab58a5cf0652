//! The decoder as one would write it on a napkin: the whole stream at hand, everything looked up
//! again at every byte, the CRC bit by bit.

use struna_wire::{Coding, Counters, Crc16Params, Endian, FieldSpec, FrameSpec};

/// A frame as the naive decoder tells it: index, lost before, raw values.
pub(crate) type Told = (u64, u64, Vec<i64>);

pub(crate) fn decode(spec: &FrameSpec, bytes: &[u8]) -> (Vec<Told>, Counters) {
    let len = spec.frame_len();
    let mut counters = Counters { bytes: bytes.len() as u64, ..Counters::default() };
    let (mut told, mut last, mut astray, mut at) = (Vec::new(), None, false, 0);
    while at < bytes.len() {
        match judge(spec, &bytes[at..], &mut counters) {
            None => {
                (at, astray) = (at + 1, true);
                counters.skipped_bytes += 1;
                continue;
            }
            Some(counter) => {
                counters.resyncs += u64::from(astray && last.is_some());
                astray = false;
                let index = unwrap(spec, last, counter);
                if last == Some(index) {
                    counters.duplicates += 1;
                } else {
                    let lost = last.map_or(0, |last: u64| index - last - 1);
                    counters.ok += 1;
                    counters.lost += lost;
                    counters.sequence_gaps += u64::from(lost > 0);
                    let frame = &bytes[at..at + len];
                    told.push((
                        index,
                        lost,
                        spec.fields().iter().map(|f| read(f, frame)).collect(),
                    ));
                }
                last = Some(index);
            }
        }
        at += len;
    }
    (told, counters)
}

/// The counter of the good frame at the front, zero when it has none; `None` for no frame.
fn judge(spec: &FrameSpec, rest: &[u8], counters: &mut Counters) -> Option<u64> {
    let frame = rest.get(..spec.frame_len()).filter(|frame| frame.starts_with(spec.sync()))?;
    let check = spec.check();
    let (first, last) = check.range();
    let stored = number(&frame[check.at()..check.at() + 2], check.endian());
    if u64::from(crc(check.crc().params(), &frame[first..=last])) != stored {
        counters.bad_check += 1;
        return None;
    }
    let Some(seq) = spec.sequence() else { return Some(0) };
    let counter = number(&frame[seq.at()..seq.at() + seq.bits() / 8], seq.endian());
    let sane = counter < seq.modulus();
    counters.bad_sequence += u64::from(!sane);
    sane.then_some(counter)
}

fn unwrap(spec: &FrameSpec, last: Option<u64>, counter: u64) -> u64 {
    match (spec.sequence(), last) {
        (None, last) => last.map_or(0, |last| last + 1),
        (Some(_), None) => counter,
        (Some(seq), Some(last)) => {
            let same_lap = last - last % seq.modulus() + counter;
            if same_lap < last { same_lap + seq.modulus() } else { same_lap }
        }
    }
}

fn read(field: &FieldSpec, frame: &[u8]) -> i64 {
    let code = number(&frame[field.at()..field.at() + field.bits() / 8], field.endian());
    let code = i64::try_from(code).expect("at most 32 bits");
    match field.coding() {
        Coding::Twos if code >= 1 << (field.bits() - 1) => code - (1 << field.bits()),
        Coding::OffsetBinary { null } => code - i64::from(null),
        _ => code,
    }
}

fn number(bytes: &[u8], endian: Endian) -> u64 {
    let value = |(k, byte): (u32, u8)| u64::from(byte) * 256_u64.pow(k);
    match endian {
        Endian::Little => (0..).zip(bytes.iter().copied()).map(value).sum(),
        Endian::Big => (0..).zip(bytes.iter().rev().copied()).map(value).sum(),
    }
}

fn crc(params: Crc16Params, bytes: &[u8]) -> u16 {
    let Crc16Params { poly, init, refin, refout, xorout } = params;
    let reflect = |word: u16, yes: bool| if yes { word.reverse_bits() } else { word };
    // Bit by bit, as the definition reads.
    let register = bytes.iter().fold(init, |register, byte| {
        let byte = if refin { byte.reverse_bits() } else { *byte };
        (0..8).rev().fold(register, |register, bit| {
            let out = (register >> 15) ^ u16::from(byte >> bit & 1);
            (register << 1) ^ (poly * out)
        })
    });
    reflect(register, refout) ^ xorout
}
