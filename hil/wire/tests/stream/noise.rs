//! Line noise that knows the frame: uniform bytes would almost never fake a start.

use proptest::prelude::*;
use proptest::sample::Index;
use struna_wire::{Encoder, FrameSpec, Kind};

/// One stretch of a stream.
#[derive(Debug, Clone)]
enum Piece {
    /// A frame as sent.
    Intact,
    /// A frame that breaks off.
    Truncated(Index),
    /// A frame with one wrong bit.
    Flipped(Index, u8),
    /// A frame that arrives twice.
    Twice,
    /// Frames that never arrive.
    Lost(u8),
    /// Two frames that change places.
    Swapped,
    /// Bytes that were never a frame; `None` stands for the next byte that means something here.
    Garbage(Vec<Option<u8>>),
}

/// A stream and where in it whole, uncorrupted frames begin.
#[derive(Debug, Clone)]
pub(crate) struct Stream {
    pub(crate) bytes: Vec<u8>,
    pub(crate) intact_at: Vec<usize>,
}

fn piece() -> impl Strategy<Value = (Piece, u64)> {
    let garbage = prop::collection::vec(prop::option::weighted(0.4, any::<u8>()), 0..40);
    let piece = prop_oneof![
        4 => Just(Piece::Intact),
        1 => any::<Index>().prop_map(Piece::Truncated),
        1 => (any::<Index>(), 0_u8..8).prop_map(|(byte, bit)| Piece::Flipped(byte, bit)),
        1 => Just(Piece::Twice),
        1 => any::<u8>().prop_map(Piece::Lost),
        1 => Just(Piece::Swapped),
        2 => garbage.prop_map(Piece::Garbage),
    ];
    (piece, any::<u64>())
}

/// A stream of `spec` made of up to `most` pieces.
pub(crate) fn stream(spec: &FrameSpec, most: usize) -> impl Strategy<Value = Stream> + use<> {
    let spec = spec.clone();
    (any::<u32>(), prop::collection::vec(piece(), 0..most)).prop_map(move |(first, pieces)| {
        let mut encoder = Encoder::starting_at(&spec, u64::from(first));
        let mut stream = Stream { bytes: Vec::new(), intact_at: Vec::new() };
        for (piece, entropy) in pieces {
            append(&mut stream, &spec, &mut encoder, &piece, entropy);
        }
        stream
    })
}

fn append(
    stream: &mut Stream,
    spec: &FrameSpec,
    encoder: &mut Encoder,
    piece: &Piece,
    entropy: u64,
) {
    let mut frame = Vec::new();
    encoder.encode(&raw_values(spec, entropy), &mut frame).expect("values in range");
    let here = stream.bytes.len();
    match piece {
        Piece::Intact => stream.intact_at.push(here),
        Piece::Truncated(keep) => frame.truncate(keep.index(frame.len())),
        Piece::Flipped(byte, bit) => {
            let byte = byte.index(frame.len());
            frame[byte] ^= 1 << bit;
        }
        Piece::Twice => {
            stream.intact_at.extend([here, here + frame.len()]);
            frame.extend_from_within(..);
        }
        Piece::Swapped => {
            let mut earlier = Vec::new();
            encoder.encode(&raw_values(spec, !entropy), &mut earlier).expect("values in range");
            stream.intact_at.extend([here, here + earlier.len()]);
            frame.splice(0..0, earlier);
        }
        Piece::Lost(frames) => {
            *encoder = Encoder::starting_at(spec, encoder.next_index() + u64::from(*frames));
            frame.clear();
        }
        Piece::Garbage(bytes) => {
            let meaningful = meaningful(spec);
            let known = meaningful.iter().cycle();
            frame = bytes.iter().zip(known).map(|(byte, known)| byte.unwrap_or(*known)).collect();
        }
    }
    stream.bytes.extend(frame);
}

/// Bytes that open, close or fill frames of this kind.
pub(crate) fn meaningful(spec: &FrameSpec) -> Vec<u8> {
    match spec.kind() {
        Kind::Cobs => vec![0, 1, 2, 0, 3],
        Kind::Ascii => [spec.sync(), b"1.-\n, 2\r\n*0 "].concat(),
        _ => spec.sync().to_vec(),
    }
}

/// Values over the whole range of every field, its ends included.
pub(crate) fn raw_values(spec: &FrameSpec, entropy: u64) -> Vec<i64> {
    let value = |(k, field): (u64, &struna_wire::FieldSpec)| {
        let mixed = (entropy ^ (k << 7)).wrapping_mul(2 * k + 1);
        match mixed % 8 {
            0 => field.raw_min(),
            1 => field.raw_max(),
            _ => {
                let codes = (field.raw_max() - field.raw_min()).unsigned_abs() + 1;
                field.raw_min() + ((mixed >> 3) % codes).cast_signed()
            }
        }
    };
    let mut raw: Vec<_> = (0..).zip(spec.fields()).map(value).collect();
    for k in 0..raw.len() {
        // What a frame does not carry comes out as zero.
        if spec.fields()[k].when().is_some_and(|(decider, value)| raw[decider] != value) {
            raw[k] = 0;
        }
    }
    raw
}
