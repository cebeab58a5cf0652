//! How hard it is for noise to pass as a frame, and how many frames in a row that calls for.

use crate::framing::{Framing, Text};
use crate::{CheckSpec, Coding, FieldSpec, MAX_CONFIRM, PlausibleSpec, SequenceSpec};

/// Evidence that makes a frame believed, bits: at one chance in 2^32 for each byte of noise,
/// 10 GB of noise hold two or three false frames.
pub const BELIEF_BITS: f64 = 32.0;
/// The same where a frame is due, bits. A stream that was good a frame ago needs less.
const DUE_BITS: f64 = 10.0;

/// What speaks for a frame, in bits: noise passes with a chance of two to minus that.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Evidence {
    /// Framing: sync word, clear top bits of septets, delimiters, the form of a line of text.
    pub framing_bits: f64,
    /// Check, and the codes of the counter that its modulus leaves out.
    pub check_bits: f64,
    /// More in each further frame of a row: the counter steps by one, the rate by no more than is
    /// plausible.
    pub following_bits: f64,
    /// Of these, what plausibility gives.
    pub plausible_bits: f64,
    /// Frames in a row, at the expected spacing, before any of them is believed.
    pub confirm: usize,
    /// The same where a frame is due while the decoder is in lock.
    pub confirm_due: usize,
}

impl Evidence {
    pub(crate) fn of(
        framing: (&Framing, &[u8], usize),
        check: &CheckSpec,
        sequence: Option<&SequenceSpec>,
        fields: &[FieldSpec],
        plausible: Option<PlausibleSpec>,
    ) -> Self {
        let framing_bits = framing_bits(framing);
        let width_bits = |sequence: &SequenceSpec| match sequence.bits() {
            // A column of text: the digits are counted with the framing.
            64 => (sequence.modulus() as f64).log2(),
            bits => bits as f64,
        };
        let unused = sequence.map_or(0.0, |s| width_bits(s) - (s.modulus() as f64).log2());
        let check_bits = f64::from(check.bits()) + unused;
        let plausible_bits = plausible.map_or(0.0, |gate| gate_bits(gate, fields));
        let counter_bits = sequence.map_or(0.0, |sequence| (sequence.modulus() as f64).log2());
        let mut evidence = Self {
            framing_bits,
            check_bits,
            following_bits: counter_bits + plausible_bits,
            plausible_bits,
            confirm: 1,
            confirm_due: 1,
        };
        evidence.confirm = evidence.frames_for(BELIEF_BITS);
        evidence.confirm_due =
            whole_frames(DUE_BITS / (evidence.frame_bits() + plausible_bits), evidence.confirm);
        evidence
    }

    /// The same with a number of frames that the file demands.
    pub(crate) fn with_confirm(self, confirm: usize) -> Self {
        Self { confirm, confirm_due: self.confirm_due.min(confirm), ..self }
    }

    /// Bits that speak for a frame on its own.
    #[must_use]
    pub fn frame_bits(&self) -> f64 {
        self.framing_bits + self.check_bits
    }

    /// Bits that speak for the frames that must agree before any is believed.
    #[must_use]
    pub fn row_bits(&self) -> f64 {
        let frames = self.confirm as f64;
        frames * self.frame_bits() + (frames - 1.0) * self.following_bits
    }

    /// Chance that a frame is believed at a given byte of uniform noise.
    #[must_use]
    pub fn false_accepts_per_byte(&self) -> f64 {
        (-self.row_bits()).exp2()
    }

    fn frames_for(&self, bits: f64) -> usize {
        let more = self.following_bits;
        whole_frames((bits + more) / (self.frame_bits() + more), MAX_CONFIRM)
    }
}

fn whole_frames(share: f64, most: usize) -> usize {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "small, positive")]
    let frames = share.ceil() as usize;
    frames.clamp(1, most)
}

fn framing_bits((framing, sync, len): (&Framing, &[u8], usize)) -> f64 {
    let ones = |bytes: &[u8]| bytes.iter().map(|byte| byte.count_ones()).sum::<u32>();
    let sync_bits = 8.0 * sync.len() as f64;
    match framing {
        Framing::Fixed { mask } if mask.is_empty() => sync_bits,
        Framing::Fixed { mask } => f64::from(ones(mask)),
        Framing::Septet => sync_bits + (len - 1) as f64,
        // A zero before and behind, and a chain of codes that ends exactly there: the first code
        // alone decides in most cases, one of 255.
        Framing::Cobs => 16.0 + 7.0,
        Framing::Ascii(text) => sync_bits + text_bits(text),
    }
}

/// What every line of text must show: digits, points, separators and its end. The shortest line
/// counts, with one digit before the point.
fn text_bits(text: &Text) -> f64 {
    let (any, digit, hex) = (8.0, 256_f64.log2() - 10_f64.log2(), 8.0 - 22_f64.log2());
    let column = |coding: &Option<Coding>| match coding {
        Some(Coding::Decimal { decimals: 0, .. }) => digit,
        Some(Coding::Decimal { decimals, .. }) => any + digit * f64::from(1 + decimals),
        Some(Coding::Hex { digits }) => hex * f64::from(*digits),
        _ => 0.0,
    };
    let columns: f64 = text.columns.iter().map(column).sum();
    let marks = text.columns.len() + if text.starred { 1 } else { 0 };
    columns + any * marks as f64
}

/// How many of a random field's values lie within the gate of the last one, as bits.
fn gate_bits(gate: PlausibleSpec, fields: &[FieldSpec]) -> f64 {
    let field = &fields[gate.field];
    if field.when.is_some() || field.coding == Coding::Float {
        return 0.0;
    }
    let values = (field.raw_max() - field.raw_min()) as f64 + 1.0;
    let within = 2.0 * (gate.step_max_si / field.scale_si().abs()).floor() + 1.0;
    (values / within).log2().max(0.0)
}
