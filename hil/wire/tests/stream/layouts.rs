//! Random layouts, written as frame files so that the parser takes part.

use proptest::prelude::*;
use std::fmt::Write as _;
use struna_wire::FrameSpec;

/// The default frame.
pub(crate) fn vg910d() -> FrameSpec {
    let file = include_str!("../../../../frames/vg910d.toml");
    FrameSpec::from_toml(file).expect("the default file is good")
}

#[derive(Debug, Clone)]
enum Item {
    Check { little: bool, poly: u16, init: u16, refin: bool, refout: bool, xorout: u16 },
    Sequence { bytes: usize, modulus: u64, little: bool },
    Field { bytes: usize, coding: &'static str, little: bool },
}

impl Item {
    fn bytes(&self) -> usize {
        match self {
            Self::Check { .. } => 2,
            Self::Sequence { bytes, .. } | Self::Field { bytes, .. } => *bytes,
        }
    }
}

fn check() -> impl Strategy<Value = Item> {
    let words = (1..=u16::MAX, any::<u16>(), any::<u16>());
    (words, any::<[bool; 3]>()).prop_map(|((poly, init, xorout), [little, refin, refout])| {
        Item::Check { little, poly, init, refin, refout, xorout }
    })
}

/// Small moduli, so that wraps happen within a short stream, and the full width.
fn sequence() -> impl Strategy<Value = Item> {
    (1_usize..=4, 2_u64..=5, any::<[bool; 2]>()).prop_map(|(bytes, small, [full, little])| {
        let modulus = if full { 1 << (8 * bytes) } else { small };
        Item::Sequence { bytes, modulus, little }
    })
}

fn field() -> impl Strategy<Value = Item> {
    let coding = prop::sample::select(vec!["twos", "unsigned", "offset_binary"]);
    (1_usize..=4, coding, any::<bool>()).prop_map(|(bytes, coding, little)| Item::Field {
        bytes,
        coding,
        little,
    })
}

/// Bytes that repeat themselves, so that sync words overlap their own beginnings.
fn sync() -> impl Strategy<Value = Vec<u8>> {
    prop::collection::vec(prop::sample::select(vec![0xA5_u8, 0x5A, 0x00, 0xFF]), 1..=4)
}

/// Any layout that the format allows: items in any order, with unused bytes between them.
pub(crate) fn layout() -> impl Strategy<Value = FrameSpec> {
    let items = (check(), prop::option::of(sequence()), prop::collection::vec(field(), 1..=6))
        .prop_map(|(check, sequence, fields)| {
            fields.into_iter().chain(sequence).chain([check]).collect::<Vec<_>>()
        })
        .prop_shuffle();
    let gaps = prop::collection::vec(0_usize..=2, 9);
    (sync(), items, gaps, any::<prop::sample::Index>(), any::<prop::sample::Index>()).prop_map(
        |(sync, items, gaps, from, to)| {
            let text = frame_file(&sync, &items, &gaps, |n| (from.index(n), to.index(n)));
            FrameSpec::from_toml(&text).expect(&text)
        },
    )
}

fn frame_file(
    sync: &[u8],
    items: &[Item],
    gaps: &[usize],
    pick: impl Fn(usize) -> (usize, usize),
) -> String {
    let mut places = Vec::new();
    let mut at = sync.len();
    for (item, gap) in items.iter().zip(gaps) {
        places.push(at + gap);
        at += gap + item.bytes();
    }
    let len = at + gaps[items.len()];
    let hex: Vec<_> = sync.iter().map(|byte| format!("{byte:02X}")).collect();
    let mut text = format!(
        "[frame]\nname='random'\nkind='fixed'\nprovenance='unverified'\nsync='{}'\nlen={len}\n",
        hex.join(" ")
    );
    for (item, at) in items.iter().zip(places) {
        write_item(&mut text, item, at, len, &pick);
    }
    text + "[line]\nbaud=115200\ndata=8\nparity='none'\nstop=1\n"
        + "[timing]\nrate_hz=1.0\nrate_tol=0.0\n"
}

fn write_item(
    text: &mut String,
    item: &Item,
    at: usize,
    len: usize,
    pick: &impl Fn(usize) -> (usize, usize),
) {
    let endian = |little: bool| if little { "le" } else { "be" };
    match *item {
        Item::Check { little, poly, init, refin, refout, xorout } => {
            // The longer side of the check, then any stretch of it.
            let (base, room) = if at >= len - at - 2 { (0, at) } else { (at + 2, len - at - 2) };
            let (a, b) = pick(room);
            let (first, last) = (base + a.min(b), base + a.max(b));
            writeln!(
                text,
                "[frame.check]\nkind='crc16'\npoly={poly}\ninit={init}\nrefin={refin}\n\
                 refout={refout}\nxorout={xorout}\nrange=[{first},{last}]\nat={at}\nendian='{}'",
                endian(little)
            )
        }
        Item::Sequence { bytes, modulus, little } => writeln!(
            text,
            "[frame.seq]\nat={at}\nbits={}\nmodulus={modulus}\nendian='{}'",
            8 * bytes,
            endian(little)
        ),
        Item::Field { bytes, coding, little } => writeln!(
            text,
            "[[frame.field]]\nname='at{at}'\nat={at}\nbits={}\ncoding='{coding}'\n{}\
             unit='counts'\nendian='{}'",
            8 * bytes,
            if coding == "offset_binary" { "null=128\n" } else { "" },
            endian(little)
        ),
    }
    .expect("a string takes any text");
}
