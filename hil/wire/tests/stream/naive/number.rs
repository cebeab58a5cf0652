//! Numbers out of a frame's content, bit by bit.

use struna_wire::{CheckKind, Coding, CrcParams, Endian, FieldSpec, FrameSpec, Kind};

/// The bits of some bytes of the frame as a number: each byte's bits, highest first, in a row.
fn number(
    spec: &FrameSpec,
    content: &[u8],
    (at, bytes): (usize, usize),
    (shift, bits): (usize, usize),
    endian: Endian,
) -> u64 {
    let mut bytes: Vec<u8> = content[at..at + bytes].to_vec();
    if endian == Endian::Little {
        bytes.reverse();
    }
    let per_byte = if spec.kind() == Kind::Septet { 7 } else { 8 };
    let mut row: Vec<bool> = bytes
        .iter()
        .flat_map(|byte| (0..per_byte).rev().map(move |k| byte >> k & 1 == 1))
        .collect();
    row.truncate(row.len() - shift);
    let low = &row[row.len() - bits..];
    low.iter().fold(0, |number, bit| 2 * number + u64::from(*bit))
}

pub(crate) fn field_value(spec: &FrameSpec, field: &FieldSpec, content: &[u8]) -> i64 {
    let place = (field.at(), field.bytes());
    let code = number(spec, content, place, (field.shift(), field.bits()), field.endian());
    let code = i128::from(code);
    let value = match field.coding() {
        Coding::Twos if code >= 1 << (field.bits() - 1) => code - (1 << field.bits()),
        // Columns of text arrive as 64 bits in two's complement.
        Coding::Decimal { .. } if code >= 1 << 63 => code - (1 << 64),
        Coding::OffsetBinary { null } => code - i128::from(null),
        _ => code,
    };
    i64::try_from(value).expect("at most 64 bits")
}

pub(crate) fn sequence_value(spec: &FrameSpec, content: &[u8]) -> Option<u64> {
    let seq = spec.sequence()?;
    let place = (seq.at(), seq.bytes());
    Some(number(spec, content, place, (seq.shift(), seq.bits()), seq.endian()))
}

pub(crate) fn check_holds(spec: &FrameSpec, content: &[u8]) -> bool {
    let check = spec.check();
    let (first, last) = check.range();
    let covered = &content[first..=last];
    if spec.kind() == Kind::Ascii {
        return true;
    }
    let sum: u32 = covered.iter().map(|byte| u32::from(*byte)).sum();
    let expected = match check.kind() {
        CheckKind::None => return true,
        CheckKind::Parity { odd } => {
            let ones: u32 = covered.iter().map(|byte| byte.count_ones()).sum();
            return (ones % 2 == 1) == odd;
        }
        CheckKind::Sum8 => sum % 256,
        CheckKind::NegSum8 => (256 - sum % 256) % 256,
        CheckKind::Xor8 => u32::from(covered.iter().fold(0, |xor, byte| xor ^ byte)),
        CheckKind::Crc(params) => crc(params, covered),
        // A check that this file does not know holds for nothing.
        _ => return false,
    };
    let bytes = check.bits().div_ceil(8) as usize;
    let stored =
        number(spec, content, (check.at(), bytes), (0, check.bits() as usize), check.endian());
    u64::from(expected) & ((1 << check.bits()) - 1) == stored
}

/// Bit by bit, as the definition reads: each bit of the message meets the register's top bit.
fn crc(params: CrcParams, bytes: &[u8]) -> u32 {
    let CrcParams { width, poly, init, refin, refout, xorout } = params;
    let mut register = u64::from(init);
    for byte in bytes {
        for k in 0..8 {
            let bit = if refin { byte >> k & 1 } else { byte >> (7 - k) & 1 };
            let out = ((register >> (width - 1)) & 1) ^ u64::from(bit);
            register = ((register << 1) ^ (out * u64::from(poly))) & ((1 << width) - 1);
        }
    }
    let mirrored = (0..width).fold(0, |mirror, k| mirror << 1 | (register >> k & 1));
    let register = if refout { mirrored } else { register };
    u32::try_from(register).expect("at most 32 bits") ^ xorout
}
