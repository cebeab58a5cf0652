//! What sniffing says: proposals with their evidence, what the bytes cannot decide, a verdict.

use crate::layout::{Check, CheckKind, Coding, Kind, Layout};
use crate::text::Lines;
use crate::word::ParityWord;
use std::fmt;

/// Everything found out about a capture.
#[derive(Debug, Clone, PartialEq)]
pub struct Report {
    /// Bytes in the capture.
    pub bytes: usize,
    /// How far the first proposal can be trusted.
    pub verdict: Verdict,
    /// The likeliest layout first; empty when nothing was recognised.
    pub proposals: Vec<Proposal>,
}

/// How far the first proposal can be trusted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Verdict {
    /// It has read bytes that it was not made from.
    Confirmed {
        /// Share of those bytes in good frames.
        share: f64,
    },
    /// It fits, but something stands against believing it.
    Unconfirmed(Doubt),
    /// There is none.
    Unknown,
}

/// What stands against believing a proposal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Doubt {
    /// The gyro was not turned, so the rate may be misjudged.
    AtRest {
        /// Excursion of the rate as a share of full scale.
        excursion: f64,
    },
    /// Too much of the capture is in no good frame.
    Damaged {
        /// Share of the bytes in good frames.
        share: f64,
    },
    /// Neither a check nor a counter vouches for frames.
    NothingVouches,
    /// No sync word: nothing says where a frame begins.
    NoSync,
    /// There is no rate.
    NoRate,
    /// Three quarters of the capture, taken alone, give another layout.
    PartDisagrees,
    /// Bytes held back, or the second capture, are not read by it.
    SecondDisagrees {
        /// Share of those bytes in good frames.
        share: f64,
    },
}

impl fmt::Display for Doubt {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::AtRest { excursion } => write!(
                f,
                "the gyro was not turned to both sides (the rate moved over {:.2} % of its range); \
                 turn the gyro by hand both ways and capture again",
                100.0 * excursion
            ),
            Self::Damaged { share } => write!(
                f,
                "only {:.1} % of the bytes are in good frames, 95 % are needed; check baud rate, \
                 parity and cable",
                100.0 * share
            ),
            Self::NothingVouches => f.write_str(
                "the frame has neither check nor counter, so no frame can prove the layout; \
                 compare the rate with a known turn",
            ),
            Self::NoSync => {
                f.write_str("no byte of the frame is constant, so it has no sync word to begin at")
            }
            Self::NoRate => f.write_str("no number of two bytes or more was found in the frame"),
            Self::PartDisagrees => f.write_str(
                "three quarters of the capture, taken alone, give another layout; capture longer",
            ),
            Self::SecondDisagrees { share } => write!(
                f,
                "of the bytes kept for the test only {:.1} % are in good frames, 95 % are needed",
                100.0 * share
            ),
        }
    }
}

/// A layout of any kind.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Shape {
    /// Binary, with a sync word or marker.
    Binary(Layout),
    /// Lines of text.
    Lines(Lines),
    /// Words with parity.
    Word(ParityWord),
}

/// One layout and what speaks for it.
#[derive(Debug, Clone, PartialEq)]
pub struct Proposal {
    /// The layout.
    pub shape: Shape,
    /// Rank, 0 to 1. It orders proposals; it is no probability.
    pub score: f64,
    /// What speaks for each part.
    pub evidence: Evidence,
    /// What the bytes cannot decide.
    pub alternatives: Vec<Alternative>,
}

/// What speaks for the parts of a layout.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Evidence {
    /// Good frames.
    pub frames: usize,
    /// Share of the bytes in good frames; with a check, in frames that pass it.
    pub share: f64,
    /// Bits per byte that the frame length saves, of 8.
    pub saved_bits: f64,
    /// Share of counter steps that are by one.
    pub counter_share: f64,
    /// Times the counter went back to zero.
    pub wraps: usize,
    /// From the 3rd to the 97th percentile of the rate, as a share of full scale.
    pub excursion: f64,
    /// The rate went well beyond its noise, up and down.
    pub turned: bool,
}

/// Something that the bytes leave open.
#[derive(Debug, Clone, PartialEq)]
pub enum Alternative {
    /// The sync word may be of any of these lengths.
    SyncLength {
        /// Shortest.
        least: usize,
        /// Longest.
        most: usize,
    },
    /// Checks that hold equally.
    Checks(Vec<Check>),
    /// Bytes that never changed: sync, status, reserved, or the top of a number at rest.
    ConstantBytes(Vec<usize>),
    /// A check that is in no catalogue: start value and final XOR cannot be told apart.
    GenericCheck,
    /// The lowest bytes of the rate are noise and could be a number of their own.
    NoisyBytes {
        /// How many.
        bytes: usize,
    },
    /// The top byte of the rate never changed and was taken for its sign.
    ConstantTop,
    /// Scale and sign are not in the bytes, ever.
    ScaleAndSign,
    /// Which slow field is what.
    SlowFields,
}

impl fmt::Display for Alternative {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::SyncLength { least, most } => write!(
                f,
                "Is the sync word {least} or up to {most} bytes long? A constant status byte looks \
                 the same. Change the status (cover or power-cycle the sensor) and capture again."
            ),
            Self::Checks(checks) => {
                f.write_str("These checks hold equally:")?;
                for check in checks {
                    write!(f, " {}", Described(check))?;
                }
                f.write_str(". Capture again after a change of status to tell them apart.")
            }
            Self::ConstantBytes(at) => write!(
                f,
                "Byte{} {} never changed: sync, status or reserved?",
                if at.len() == 1 { "" } else { "s" },
                at.iter().map(ToString::to_string).collect::<Vec<_>>().join(", ")
            ),
            Self::GenericCheck => f.write_str(
                "The CRC is in no catalogue. Start value and final XOR cannot be told apart at \
                 one length; the pair given here is as good as any.",
            ),
            Self::NoisyBytes { bytes } => write!(
                f,
                "The lowest {} of the rate shows noise alone. Part of the rate, or something \
                 else? It makes no difference to the rate beyond its noise.",
                if *bytes == 1 { "byte".to_owned() } else { format!("part, {bytes} bytes,") }
            ),
            Self::ConstantTop => f.write_str(
                "The top byte of the rate never changed and was taken for its sign. Turn the gyro \
                 both ways to make sure.",
            ),
            Self::ScaleAndSign => f.write_str(
                "Scale and sign are not in the bytes. Turn the gyro by a known angle, 90 or 360 \
                 degrees, and divide it by the sum of the rate counts over the frame rate.",
            ),
            Self::SlowFields => f.write_str(
                "Names of fields other than the rate are guesses. Warm the sensor by hand: the \
                 field that follows is the temperature.",
            ),
        }
    }
}

/// A check in words.
#[derive(Debug)]
pub struct Described<'a>(pub &'a Check);

impl fmt::Display for Described<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Check { kind, first, last, .. } = self.0;
        match kind {
            CheckKind::Sum8 => f.write_str("sum8")?,
            CheckKind::NegSum8 => f.write_str("negsum8")?,
            CheckKind::Xor8 => f.write_str("xor8")?,
            CheckKind::Crc(crc) => match crc.name {
                "generic" => write!(f, "CRC-{} with poly 0x{:X}", crc.width, crc.poly)?,
                name => f.write_str(name)?,
            },
        }
        write!(f, " over bytes {first} to {last}")
    }
}

const fn in_words(coding: Coding) -> &'static str {
    match coding {
        Coding::Twos => "two's complement",
        Coding::OffsetBinary => "offset binary",
        Coding::Unsigned => "unsigned",
        Coding::Float => "float",
    }
}

impl Proposal {
    /// The binary layout, if it is one.
    #[must_use]
    pub const fn layout(&self) -> Option<&Layout> {
        match &self.shape {
            Shape::Binary(layout) => Some(layout),
            _ => None,
        }
    }

    /// Bytes of one frame, on average: lines of text vary.
    #[must_use]
    pub fn mean_len(&self, bytes: usize) -> f64 {
        match &self.shape {
            Shape::Binary(layout) => crate::length::as_f64(layout.len),
            Shape::Word(_) => 4.0,
            Shape::Lines(_) => {
                let frames = crate::length::as_f64(self.evidence.frames.max(1));
                self.evidence.share * crate::length::as_f64(bytes) / frames
            }
        }
    }

    /// The evidence part by part: what, what was found, why it is believed.
    #[must_use]
    pub fn table(&self) -> Vec<[String; 3]> {
        let evidence = &self.evidence;
        let share =
            format!("{} frames, {:.1} % of the bytes", evidence.frames, 100.0 * evidence.share);
        let moved = format!("moved over {:.1} % of full scale", 100.0 * evidence.excursion);
        let row = |what: &str, found: String, why: String| [what.to_owned(), found, why];
        match &self.shape {
            Shape::Word(word) => {
                let parity = if word.odd { "odd" } else { "even" };
                vec![
                    row("word", format!("4 bytes, {parity} parity, KVH's 1000 Hz form"), share),
                    row("rate", "26 bits, two's complement".to_owned(), moved),
                ]
            }
            Shape::Lines(lines) => {
                let check = if lines.checked { "checked by *hh" } else { "no check" };
                vec![
                    row("lines", format!("{} columns, {check}", lines.columns.len()), share),
                    row("rate", "decimal text".to_owned(), moved),
                ]
            }
            Shape::Binary(layout) => self.binary_table(layout, share, moved),
        }
    }

    fn binary_table(&self, layout: &Layout, share: String, moved: String) -> Vec<[String; 3]> {
        let evidence = &self.evidence;
        let hex: Vec<String> = layout.sync.iter().map(|byte| format!("{byte:02X}")).collect();
        let saved = match layout.kind {
            Kind::Fixed => format!("saves {:.1} of 8 bits a byte", evidence.saved_bits),
            Kind::Septet => "distance of the bytes with bit 7 set".to_owned(),
        };
        let mut rows = vec![
            ["length".to_owned(), format!("{} bytes", layout.len), saved],
            ["sync".to_owned(), hex.join(" "), "never changes".to_owned()],
        ];
        if let Some(counter) = layout.counter {
            let why = format!(
                "{:.1} % of steps by one, {} wraps seen",
                100.0 * evidence.counter_share,
                evidence.wraps
            );
            let (at, modulus) = (counter.at, counter.modulus);
            rows.push(["counter".to_owned(), format!("byte {at}, modulo {modulus}"), why]);
        }
        rows.push(match &layout.check {
            Some(check) => ["check".to_owned(), Described(check).to_string(), share],
            None => ["check".to_owned(), "none found".to_owned(), share],
        });
        for field in &layout.fields {
            let (at, bits) = (field.at, field.bits);
            let order = if field.big_endian { "high byte first" } else { "low byte first" };
            let order = if field.bytes == 1 { "one byte" } else { order };
            let name = crate::toml::name_of(field.role);
            let found = format!("byte {at}, {bits} bits, {}, {order}", in_words(field.coding));
            let is_rate = field.role == crate::Role::Rate;
            let why = if is_rate { moved.clone() } else { "by its size and motion".to_owned() };
            rows.push([name.to_owned(), found, why]);
        }
        rows
    }
}
