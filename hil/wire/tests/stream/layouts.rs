//! Random layouts of every kind, written as frame files so that the parser takes part.

use proptest::prelude::*;
use std::fmt::Write as _;
use struna_wire::FrameSpec;

/// The default frame.
pub(crate) fn vg910d() -> FrameSpec {
    let file = include_str!("../../../../frames/vg910d.toml");
    FrameSpec::from_toml(file).expect("the default file is good")
}

/// The other shipped frames.
pub(crate) fn shipped() -> impl Strategy<Value = FrameSpec> {
    let files = prop::sample::select(vec![
        include_str!("../../../../frames/vg910d.toml"),
        include_str!("../../../../frames/vg910d-raw4.toml"),
        include_str!("../../../../frames/vg910d-sum.toml"),
        include_str!("../../../../frames/adis16100.toml"),
        include_str!("../../../../frames/kvh-dsp3000-1k.toml"),
        include_str!("../../../../frames/kvh-dsp3000-ascii.toml"),
        include_str!("../../../../frames/fog-septet-xor.toml"),
    ]);
    files.prop_map(|file| FrameSpec::from_toml(file).expect("shipped files are good"))
}

const END: &str = "[line]\nbaud=115200\ndata=8\nparity='none'\nstop=1\n\
                   [timing]\nrate_hz=1.0\nrate_tol=0.0\n";

#[derive(Debug, Clone)]
enum Item {
    /// A check of so many bytes; the text is its algorithm.
    Check {
        bytes: usize,
        text: String,
    },
    /// Bits of a container: the counter.
    Sequence {
        bits: Bits,
        modulus: u64,
    },
    Field {
        bits: Bits,
        coding: &'static str,
        vouched: bool,
    },
    /// Two address bits and twelve bits that mean one thing or the other.
    Channels {
        little: bool,
    },
    /// A byte of flags.
    Status,
    /// A byte in which parity finds its bit.
    Spare,
}

/// Bits in a container; `septets` when the container is made of those.
#[derive(Debug, Clone, Copy)]
struct Bits {
    bytes: usize,
    shift: usize,
    bits: usize,
    little: bool,
    septets: bool,
}

impl Bits {
    fn text(&self) -> String {
        let endian = if self.little { "le" } else { "be" };
        let Self { bytes, shift, bits, .. } = self;
        if self.septets {
            return format!("septets={bytes}\nendian='{endian}'\n");
        }
        format!("bytes={bytes}\nshift={shift}\nbits={bits}\nendian='{endian}'\n")
    }

    fn values(&self) -> u64 {
        1 << self.bits
    }
}

impl Item {
    fn bytes(&self) -> usize {
        match self {
            Self::Check { bytes, .. } => *bytes,
            Self::Sequence { bits, .. } | Self::Field { bits, .. } => bits.bytes,
            Self::Channels { .. } => 2,
            Self::Status | Self::Spare => 1,
        }
    }
}

/// Any bits of a container, often all of them.
fn bits(septets: bool) -> impl Strategy<Value = Bits> {
    let most = if septets { 5 } else { 4 };
    (1_usize..=most, any::<[bool; 2]>(), 0_usize..32, 1_usize..=32).prop_map(
        move |(bytes, [little, whole], shift, bits)| {
            let room = if septets { (7 * bytes).min(32) } else { 8 * bytes };
            if whole || septets {
                return Bits { bytes, shift: 0, bits: room, little, septets };
            }
            let bits = bits.min(room);
            Bits { bytes, shift: shift % (room - bits + 1), bits, little, septets }
        },
    )
}

fn crc() -> impl Strategy<Value = Item> {
    let words = (any::<u32>(), any::<u32>(), any::<u32>());
    (1_usize..=3, words, any::<[bool; 3]>()).prop_map(|(size, words, [little, refin, refout])| {
        let (poly, init, xorout) = words;
        let bytes = [1, 2, 4][size - 1];
        let [poly, init, xorout] = [poly, init, xorout].map(|word| word >> (32 - 8 * bytes));
        let endian = if little { "le" } else { "be" };
        let text = format!(
            "kind='crc{}'\npoly={}\ninit={init}\nrefin={refin}\nrefout={refout}\n\
             xorout={xorout}\nendian='{endian}'\n",
            8 * bytes,
            poly.max(1)
        );
        Item::Check { bytes, text }
    })
}

fn check(septets: bool) -> impl Strategy<Value = Item> {
    let byte = prop::sample::select(vec!["sum8", "negsum8", "xor8"])
        .prop_map(|kind| Item::Check { bytes: 1, text: format!("kind='{kind}'\n") });
    let none = Just(Item::Check { bytes: 0, text: "kind='none'\n".to_owned() });
    let parity = prop::sample::select(vec!["even", "odd"]).prop_map(|sense| Item::Check {
        bytes: 0,
        text: format!("kind='parity'\nword_parity='{sense}'\n"),
    });
    if septets {
        prop_oneof![3 => byte, 1 => none].boxed()
    } else {
        prop_oneof![4 => crc(), 2 => byte, 1 => none, 1 => parity].boxed()
    }
}

/// Small moduli, so that wraps happen within a short stream, and the full width.
fn sequence(septets: bool) -> impl Strategy<Value = Item> {
    (bits(septets), 2_u64..=40, any::<bool>()).prop_filter_map(
        "one bit is no counter worth the name",
        |(bits, small, full)| {
            let modulus = if full { bits.values() } else { small.min(bits.values()) };
            (modulus >= 2).then_some(Item::Sequence { bits, modulus })
        },
    )
}

fn field(septets: bool) -> impl Strategy<Value = Item> {
    let coding = prop::sample::select(vec!["twos", "unsigned", "offset_binary", "float"]);
    (bits(septets), coding, any::<bool>()).prop_map(|(bits, coding, vouched)| {
        let float = coding != "float" || (bits.bits == 32 && !bits.septets);
        Item::Field { bits, coding: if float { coding } else { "twos" }, vouched }
    })
}

/// Bytes that repeat themselves, so that sync words overlap their own beginnings.
fn sync() -> impl Strategy<Value = Vec<u8>> {
    prop::collection::vec(prop::sample::select(vec![0xA5_u8, 0x5A, 0x00, 0xFF]), 1..=4)
}

/// Heading of the frame, and the bytes that it takes.
fn heading() -> impl Strategy<Value = (String, usize)> {
    let hex =
        |bytes: &[u8]| bytes.iter().map(|byte| format!("{byte:02X}")).collect::<Vec<_>>().join(" ");
    let fixed = (sync(), prop::option::weighted(0.3, any::<u8>())).prop_map(move |(sync, mask)| {
        let mut text = format!("kind='fixed'\nsync='{}'\n", hex(&sync));
        if let Some(first) = mask {
            let mut masks = vec![0xFF; sync.len()];
            masks[0] = first | 0x18;
            let sync: Vec<_> = sync.iter().zip(&masks).map(|(byte, mask)| byte & mask).collect();
            text = format!("kind='fixed'\nsync='{}'\nsync_mask='{}'\n", hex(&sync), hex(&masks));
        }
        (text, sync.len())
    });
    prop_oneof![4 => fixed, 2 => Just(("kind='cobs'\n".to_owned(), 0))]
}

/// Any binary layout that the format allows: items in any order, with unused bytes between them.
fn binary(septets: bool) -> impl Strategy<Value = FrameSpec> {
    let heading =
        if septets { Just(("kind='septet'\n".to_owned(), 1)).boxed() } else { heading().boxed() };
    let group = if septets { Just(None).boxed() } else { prop::option::of(channels()).boxed() };
    let items = (
        check(septets),
        prop::option::of(sequence(septets)),
        prop::collection::vec(field(septets), 1..=5),
        group,
        any::<bool>(),
    )
        .prop_map(|(check, sequence, fields, group, status)| {
            let status = status.then_some(Item::Status);
            let spare = matches!(&check, Item::Check { text, .. } if text.contains("parity"));
            fields
                .into_iter()
                .chain(sequence)
                .chain(group)
                .chain(status)
                .chain(spare.then_some(Item::Spare))
                .chain([check])
                .collect::<Vec<_>>()
        })
        .prop_shuffle();
    let gaps = prop::collection::vec(0_usize..=2, 12);
    let picks = any::<[prop::sample::Index; 2]>();
    let plausible = prop::option::weighted(0.2, 1_usize..=4);
    (heading, items, gaps, picks, plausible).prop_map(
        |((heading, start), items, gaps, [from, to], confirm)| {
            let pick = |n: usize| (from.index(n), to.index(n));
            let mut text = frame_file(&heading, start, &items, &gaps, pick);
            if let Some(confirm) = confirm {
                write!(text, "[frame.plausible]\nconfirm={confirm}\n").expect("text");
            }
            let text = text + END;
            FrameSpec::from_toml(&text).expect(&text)
        },
    )
}

fn channels() -> impl Strategy<Value = Item> {
    any::<bool>().prop_map(|little| Item::Channels { little })
}

fn frame_file(
    heading: &str,
    start: usize,
    items: &[Item],
    gaps: &[usize],
    pick: impl Fn(usize) -> (usize, usize),
) -> String {
    let mut places = Vec::new();
    let mut at = start;
    for (item, gap) in items.iter().zip(gaps) {
        places.push(at + gap);
        at += gap + item.bytes();
    }
    let len = at + gaps[items.len()];
    let mut text = format!("[frame]\nname='random'\nprovenance='unverified'\nlen={len}\n{heading}");
    let flags = items.iter().any(|item| matches!(item, Item::Status));
    // The parity bit is the first free one, so the range must hold the spare byte.
    let spare = items.iter().position(|item| matches!(item, Item::Spare)).map(|k| places[k]);
    for (item, at) in items.iter().zip(places) {
        match item {
            Item::Check { bytes, text: algorithm } => {
                text += &format!("[frame.check]\n{algorithm}");
                text += &check_place(*bytes, algorithm, (at, len, spare), &pick);
            }
            item => write_item(&mut text, item, at, flags),
        }
    }
    if flags {
        text += "[[frame.flag]]\nname='ok'\nfield='status'\nbit=0\n\
                 [[frame.flag]]\nname='warm'\nfield='status'\nbit=3\n";
    }
    text
}

/// Where a check lies and what it covers: the longer side of it, then any stretch of that.
fn check_place(
    bytes: usize,
    algorithm: &str,
    (at, len, spare): (usize, usize, Option<usize>),
    pick: &impl Fn(usize) -> (usize, usize),
) -> String {
    if algorithm.contains("none") {
        return String::new();
    }
    if let Some(spare) = spare {
        let (a, b) = (pick(spare + 1).0, spare + pick(len - spare).1);
        return format!("range=[{a},{b}]\n");
    }
    let behind = len - at - bytes;
    let (base, room) = if at >= behind { (0, at) } else { (at + bytes, behind) };
    let (a, b) = pick(room);
    format!("range=[{},{}]\nat={at}\n", base + a.min(b), base + a.max(b))
}

fn write_item(text: &mut String, item: &Item, at: usize, flags: bool) {
    match item {
        Item::Check { .. } | Item::Spare => Ok(()),
        Item::Sequence { bits, modulus } => {
            write!(text, "[frame.seq]\nat={at}\nmodulus={modulus}\n{}", bits.text())
        }
        Item::Field { bits, coding, vouched } => write!(
            text,
            "[[frame.field]]\nname='at{at}'\nat={at}\ncoding='{coding}'\n{}{}{}unit='counts'\n",
            if *coding == "offset_binary" { "null=1\n" } else { "" },
            if *vouched && flags { "valid_if='ok'\n" } else { "" },
            bits.text(),
        ),
        Item::Status => write!(
            text,
            "[[frame.field]]\nname='status'\nat={at}\nbits=8\ncoding='unsigned'\nunit='counts'\n"
        ),
        Item::Channels { little } => {
            let endian = if *little { "le" } else { "be" };
            let high = if *little { at + 1 } else { at };
            write!(
                text,
                "[[frame.field]]\nname='chan'\nat={high}\nbytes=1\nshift=4\nbits=2\n\
                 coding='unsigned'\nunit='counts'\n"
            )
            .expect("text");
            for (name, coding, equals) in [("one", "twos", 1), ("other", "unsigned", 2)] {
                write!(
                    text,
                    "[[frame.field]]\nname='{name}'\nat={at}\nbytes=2\nbits=12\n\
                     endian='{endian}'\ncoding='{coding}'\nunit='counts'\n\
                     when={{field='chan',equals={equals}}}\n"
                )
                .expect("text");
            }
            Ok(())
        }
    }
    .expect("a string takes any text");
}

/// A column of text: digits before and behind the point, or hexadecimal digits.
#[derive(Debug, Clone)]
enum Column {
    Decimal { digits: u32, decimals: u32 },
    Hex { digits: u32 },
    Counter { modulus: u64 },
    Unread,
}

fn column() -> impl Strategy<Value = Column> {
    prop_oneof![
        4 => (1_u32..=5, 0_u32..=6)
            .prop_map(|(digits, decimals)| Column::Decimal { digits, decimals }),
        2 => (1_u32..=4).prop_map(|digits| Column::Hex { digits }),
        1 => Just(Column::Unread),
    ]
}

/// Any layout of lines.
fn lines() -> impl Strategy<Value = FrameSpec> {
    let columns = prop::collection::vec(column(), 0..4);
    let counter = prop::option::of(2_u64..300);
    let prefix =
        prop::sample::select(vec!["", "sync='24'\n", "sync='52 52'\n", "sync='24 47 2C'\n"]);
    let options = (prefix, any::<[bool; 3]>());
    (columns, counter, options).prop_map(|(columns, counter, (prefix, [comma, star, strict]))| {
        let mut all = vec![Column::Decimal { digits: 3, decimals: 2 }];
        all.extend(columns);
        all.extend(counter.map(|modulus| Column::Counter { modulus }));
        // A prefix that ends in a comma calls for commas.
        let separator = if comma || prefix.contains("2C") { "," } else { " " };
        let mut text = format!(
            "[frame]\nname='random'\nprovenance='unverified'\nkind='ascii'\ncolumns={}\n\
             separator='{separator}'\n{prefix}[frame.check]\nkind='{}'\n",
            all.len(),
            if star { "xor8" } else { "none" }
        );
        for (k, column) in all.iter().enumerate() {
            write_column(&mut text, k, column);
        }
        text += if strict { "[frame.plausible]\nconfirm=3\n" } else { "" };
        let text = text + END;
        FrameSpec::from_toml(&text).expect(&text)
    })
}

fn write_column(text: &mut String, k: usize, column: &Column) {
    match column {
        Column::Decimal { digits, decimals } => write!(
            text,
            "[[frame.field]]\nname='c{k}'\ncolumn={k}\ncoding='decimal'\ndigits={digits}\n\
             decimals={decimals}\nunit='counts'\n"
        ),
        Column::Hex { digits } => write!(
            text,
            "[[frame.field]]\nname='c{k}'\ncolumn={k}\ncoding='hex'\ndigits={digits}\n\
             unit='counts'\n"
        ),
        Column::Counter { modulus } => {
            write!(text, "[frame.seq]\ncolumn={k}\nmodulus={modulus}\n")
        }
        Column::Unread => Ok(()),
    }
    .expect("a string takes any text");
}

/// Any layout of any kind.
pub(crate) fn layout() -> impl Strategy<Value = FrameSpec> {
    prop_oneof![4 => binary(false), 2 => binary(true), 2 => lines()]
}
