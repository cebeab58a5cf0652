//! Layouts for the fuzz targets, and the naive decoder of the tests.

// The decoder from scratch is the tests' own, word for word.
#[path = "../../hil/wire/tests/stream/naive/mod.rs"]
mod naive;

use std::sync::LazyLock;
use struna_wire::{Counters, Decoder, Frame, FrameSpec};

const SHIPPED: [&str; 7] = [
    include_str!("../../frames/vg910d.toml"),
    include_str!("../../frames/vg910d-raw4.toml"),
    include_str!("../../frames/vg910d-sum.toml"),
    include_str!("../../frames/adis16100.toml"),
    include_str!("../../frames/kvh-dsp3000-1k.toml"),
    include_str!("../../frames/kvh-dsp3000-ascii.toml"),
    include_str!("../../frames/fog-septet-xor.toml"),
];

/// The same, read once: most of the time would go into it.
static SPECS: LazyLock<Vec<FrameSpec>> = LazyLock::new(|| {
    let read = |text| FrameSpec::from_toml(text).expect("shipped files are good");
    SHIPPED.iter().copied().map(read).collect()
});

const END: &str = "[line]\nbaud=115200\ndata=8\nparity='none'\nstop=1\n\
                   [timing]\nrate_hz=1.0\nrate_tol=0.0\n";

/// Takes bytes off the front of the fuzzer's input; zeros when there are none left.
pub struct Choices<'a>(pub &'a [u8]);

impl Choices<'_> {
    pub fn byte(&mut self) -> u8 {
        match self.0.split_first() {
            Some((first, rest)) => {
                self.0 = rest;
                *first
            }
            None => 0,
        }
    }

    pub fn below(&mut self, limit: usize) -> usize {
        usize::from(self.byte()) % limit
    }

    pub fn number(&mut self) -> u64 {
        (0..8).fold(0, |number, _| number << 8 | u64::from(self.byte()))
    }

    fn one<'t>(&mut self, words: &[&'t str]) -> &'t str {
        words[self.below(words.len())]
    }
}

/// A shipped layout, or one that the choices put together; `None` when they contradict themselves.
pub fn layout(choices: &mut Choices<'_>) -> Option<FrameSpec> {
    let which = choices.below(2 * SHIPPED.len());
    match SPECS.get(which) {
        Some(spec) => Some(spec.clone()),
        None => FrameSpec::from_toml(&generated(choices)).ok(),
    }
}

fn generated(choices: &mut Choices<'_>) -> String {
    let kind = choices.one(&["fixed", "fixed", "septet", "cobs", "ascii"]);
    let head = format!("[frame]\nname='f'\nprovenance='unverified'\nkind='{kind}'\n");
    if kind == "ascii" {
        return head + &lines(choices) + END;
    }
    let len = 4 + choices.below(24);
    let sync = match kind {
        "fixed" => choices.one(&["sync='A5 5A'\n", "sync='00'\n", "sync='20'\nsync_mask='60'\n"]),
        _ => "",
    };
    let check = choices.one(&["none", "sum8", "negsum8", "xor8", "parity", "crc8", "crc16"]);
    let mut text = format!("{head}len={len}\n{sync}[frame.check]\nkind='{check}'\n");
    if check.starts_with("crc") {
        let poly = 1 + choices.byte() % 127;
        text += &format!("poly={poly}\ninit={}\nxorout=3\n", choices.byte());
        text += choices.one(&["refin=true\nrefout=true\n", "refin=false\nrefout=true\n"]);
        text += "endian='le'\n";
    }
    if check == "parity" {
        text += "word_parity='odd'\n";
    }
    if check != "none" {
        let place = if check == "parity" { String::new() } else { format!("at={}\n", len - 2) };
        text += &format!("range=[{},{}]\n{place}", choices.below(2), len - 3);
    }
    if choices.byte() % 2 == 0 {
        text += &format!("[frame.seq]\nat=2\nbits=8\nmodulus={}\n", 2 + choices.below(126));
    }
    let width = if kind == "septet" { "septets=1\n" } else { "bytes=1\nshift=1\nbits=5\n" };
    let coding = choices.one(&["twos", "unsigned"]);
    text += &format!(
        "[[frame.field]]\nname='rate'\nat={}\ncoding='{coding}'\nunit='counts'\n{width}",
        choices.below(len)
    );
    if choices.byte() % 4 == 0 {
        text += &format!("[frame.plausible]\nrate_step_max={}\n", 1 + choices.below(20));
    }
    text + END
}

fn lines(choices: &mut Choices<'_>) -> String {
    let prefix = choices.one(&["", "sync='24'\n", "sync='52 52'\n"]);
    let separator = choices.one(&[" ", ","]);
    let check = choices.one(&["none", "xor8"]);
    let (digits, decimals) = (1 + choices.below(4), choices.below(4));
    format!(
        "{prefix}separator='{separator}'\ncolumns=3\n[frame.check]\nkind='{check}'\n\
         [frame.seq]\ncolumn=1\nmodulus={}\n[[frame.field]]\nname='rate'\ncolumn=0\n\
         coding='decimal'\ndigits={digits}\ndecimals={decimals}\nunit='counts'\n",
        2 + choices.below(200)
    )
}

/// What a naive decoder told of a stream: index, lost before, raw values, fields it has.
pub type Told = (u64, u64, Vec<i64>, Vec<bool>);

/// The decoder from scratch.
pub fn naive(spec: &FrameSpec, bytes: &[u8]) -> (Vec<Told>, Counters) {
    naive::decode(spec, bytes)
}

/// What a decoder told of a stream, in the words of the naive one.
pub fn decode(spec: &FrameSpec, bytes: &[u8], piece: usize) -> (Vec<Told>, Counters) {
    let mut decoder = Decoder::new(spec.clone());
    let mut told = Vec::new();
    for piece in bytes.chunks(piece.max(1)) {
        decoder.push(piece, &mut |frame| told.push(tell(spec, frame)));
        let c = decoder.counters();
        let pending = decoder.pending_bytes() as u64;
        assert_eq!(c.bytes, c.frame_bytes + c.skipped_bytes + pending);
    }
    (told, decoder.finish())
}

fn tell(spec: &FrameSpec, frame: &Frame) -> Told {
    let has = (0..spec.fields().len()).map(|field| frame.has(field)).collect();
    (frame.index, frame.lost_before, frame.raw().to_vec(), has)
}
