//! What a receiver makes of a bit stream that was sent at another baud rate.

/// Data bits of a character. Frames are made of whole bytes.
const DATA_BITS: u32 = 8;

/// Parity bit of a character.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Parity {
    /// No parity bit.
    #[default]
    None,
    /// An even number of ones, the parity bit included.
    Even,
    /// An odd number of ones.
    Odd,
}

/// How a byte stands on the line: start bit, eight data bits from the lowest on, parity, stop bits.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CharacterFormat {
    /// Parity bit.
    pub parity: Parity,
    /// Stop bits, 1 or 2.
    pub stop_bits: u32,
}

impl Default for CharacterFormat {
    fn default() -> Self {
        Self { parity: Parity::None, stop_bits: 1 }
    }
}

impl CharacterFormat {
    /// Symbols that one byte takes.
    #[must_use]
    pub const fn symbols(self) -> u32 {
        1 + DATA_BITS + self.parity_bits() + self.stop_bits
    }

    const fn parity_bits(self) -> u32 {
        match self.parity {
            Parity::None => 0,
            Parity::Even | Parity::Odd => 1,
        }
    }

    /// The parity bit of a byte; the level of a stop bit when there is none.
    const fn parity_of(self, byte: u8) -> bool {
        let odd = byte.count_ones() % 2 == 1;
        match self.parity {
            Parity::None => true,
            Parity::Even => odd,
            Parity::Odd => !odd,
        }
    }

    /// Level of symbol `k` of `byte`, true for mark.
    fn level(self, byte: u8, k: u32) -> bool {
        match k {
            0 => false,
            1..=DATA_BITS => byte >> (k - 1) & 1 == 1,
            _ if k == DATA_BITS + self.parity_bits() => self.parity_of(byte),
            _ => true,
        }
    }
}

/// What a receiver found wrong.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct ReceiverErrors {
    /// Characters whose stop bit was low.
    pub framing: u64,
    /// Characters whose parity bit did not fit.
    pub parity: u64,
}

/// A character that is being received.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Character {
    /// Its falling edge.
    start: f64,
    /// The symbol to be looked at next.
    symbol: u32,
    byte: u8,
    parity: bool,
}

/// The receiving half of a UART: waits for a falling edge, then looks at the line in the middle of
/// each symbol, by its own clock.
///
/// A receiver whose clock is the transmitter's to some 5 % reads what was sent; any other reads
/// bytes all the same, other ones. A terminal that does not ask for parity checks hands such bytes
/// over as they are, low stop bit or not, and that is done here: no byte is marked, errors are only
/// counted. After a low stop bit the line must rise before the next character can start.
///
/// Everything is counted in symbols of the transmitter, so that the result depends on the ratio of
/// the rates alone.
#[derive(Debug, Clone)]
pub struct UartReceiver {
    format: CharacterFormat,
    /// Length of the receiver's symbol.
    symbol: f64,
    /// Where the search for the next falling edge begins, from the end of what was received.
    free_from: f64,
    character: Option<Character>,
    errors: ReceiverErrors,
}

impl UartReceiver {
    /// A receiver set to `rx_baud` on an idle line that is driven at `tx_baud`; both positive.
    #[must_use]
    pub fn new(format: CharacterFormat, tx_baud: f64, rx_baud: f64) -> Self {
        let errors = ReceiverErrors::default();
        Self { format, symbol: tx_baud / rx_baud, free_from: 0.0, character: None, errors }
    }

    /// What it found wrong so far.
    #[must_use]
    pub const fn errors(&self) -> ReceiverErrors {
        self.errors
    }

    /// The line is idle for `gap` symbols, then carries `bytes` without a pause. Bytes whose last
    /// symbol has been seen by then are appended to `out`: at most five for each one sent.
    pub fn receive(&mut self, gap: f64, bytes: &[u8], out: &mut Vec<u8>) {
        self.move_origin(gap.max(0.0));
        let wire = Wire { format: self.format, bytes };
        loop {
            let Some(character) = self.character else {
                let Some(start) = wire.falling_edge(self.free_from) else { break };
                let (symbol, byte, parity) = (0, 0, true);
                self.character = Some(Character { start, symbol, byte, parity });
                continue;
            };
            let at = character.start + (f64::from(character.symbol) + 0.5) * self.symbol;
            if at >= wire.end() {
                break;
            }
            self.look(character, at, wire.level(at), out);
        }
        self.move_origin(wire.end());
    }

    /// Lets the line be idle until the last character is complete.
    pub fn finish(&mut self, out: &mut Vec<u8>) {
        while let Some(character) = self.character {
            let at = character.start + (f64::from(character.symbol) + 0.5) * self.symbol;
            self.look(character, at, true, out);
        }
    }

    /// Takes the level at `at`, the middle of the symbol that `character` waits for.
    fn look(&mut self, mut character: Character, at: f64, level: bool, out: &mut Vec<u8>) {
        let last = DATA_BITS + self.format.parity_bits() + 1;
        match character.symbol {
            // Not a start bit but a spike shorter than half of one.
            0 if level => return self.end_character(at),
            0 => {}
            k @ 1..=DATA_BITS => character.byte |= u8::from(level) << (k - 1),
            k if k < last => character.parity = level,
            _ => {
                self.errors.framing += u64::from(!level);
                let parity = self.format.parity_of(character.byte);
                self.errors.parity += u64::from(character.parity != parity);
                out.push(character.byte);
                return self.end_character(at);
            }
        }
        character.symbol += 1;
        self.character = Some(character);
    }

    fn end_character(&mut self, at: f64) {
        self.character = None;
        self.free_from = at;
    }

    fn move_origin(&mut self, symbols: f64) {
        self.free_from -= symbols;
        if let Some(character) = &mut self.character {
            character.start -= symbols;
        }
    }
}

/// Bytes on the line, one after another, from position 0 on; idle before.
struct Wire<'a> {
    format: CharacterFormat,
    bytes: &'a [u8],
}

impl Wire<'_> {
    fn end(&self) -> f64 {
        self.bytes.len() as f64 * f64::from(self.format.symbols())
    }

    fn level(&self, at: f64) -> bool {
        #[expect(clippy::cast_possible_truncation, reason = "a float-to-int cast saturates")]
        let symbol = at.floor() as i64;
        self.symbol(symbol)
    }

    fn symbol(&self, symbol: i64) -> bool {
        let Ok(symbol) = u64::try_from(symbol) else { return true };
        let symbols = u64::from(self.format.symbols());
        let byte = usize::try_from(symbol / symbols).ok().and_then(|at| self.bytes.get(at));
        let within = u32::try_from(symbol % symbols).unwrap_or(u32::MAX);
        byte.is_none_or(|byte| self.format.level(*byte, within))
    }

    /// The first passage from mark to space not before `from`.
    fn falling_edge(&self, from: f64) -> Option<f64> {
        #[expect(clippy::cast_possible_truncation, reason = "a float-to-int cast saturates")]
        let (first, end) = (from.max(0.0).ceil() as i64, self.end() as i64);
        let edge = (first..end).find(|k| !self.symbol(*k) && self.symbol(k - 1))?;
        Some(edge as f64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const FORMATS: [CharacterFormat; 4] = [
        CharacterFormat { parity: Parity::None, stop_bits: 1 },
        CharacterFormat { parity: Parity::None, stop_bits: 2 },
        CharacterFormat { parity: Parity::Even, stop_bits: 1 },
        CharacterFormat { parity: Parity::Odd, stop_bits: 2 },
    ];

    /// What one burst becomes, and what was wrong with it.
    fn read(format: CharacterFormat, ratio: f64, bytes: &[u8]) -> (Vec<u8>, ReceiverErrors) {
        let mut receiver = UartReceiver::new(format, ratio, 1.0);
        let mut out = Vec::new();
        receiver.receive(0.0, bytes, &mut out);
        receiver.finish(&mut out);
        (out, receiver.errors())
    }

    fn plain(ratio: f64, bytes: &[u8]) -> Vec<u8> {
        read(CharacterFormat::default(), ratio, bytes).0
    }

    #[test]
    fn a_character_has_the_symbols_of_its_format() {
        assert_eq!(FORMATS.map(CharacterFormat::symbols), [10, 11, 11, 12]);
        // 0x61 has three ones: even parity adds a fourth, odd parity none.
        let line = |format: CharacterFormat| -> Vec<u8> {
            (0..format.symbols()).map(|k| u8::from(format.level(0x61, k))).collect()
        };
        assert_eq!(line(FORMATS[0]), [0, 1, 0, 0, 0, 0, 1, 1, 0, 1]);
        assert_eq!(line(FORMATS[2]), [0, 1, 0, 0, 0, 0, 1, 1, 0, 1, 1]);
        assert_eq!(line(FORMATS[3]), [0, 1, 0, 0, 0, 0, 1, 1, 0, 0, 1, 1]);
    }

    #[test]
    fn a_receiver_at_half_the_rate_sees_every_second_symbol() {
        // 0x00 is low for symbols 0 to 8. Looks fall on 1, 3, 5, 7, 9, 11 ...: start, three zeros,
        // then the idle line.
        assert_eq!(plain(2.0, &[0x00]), [0xF8]);
        // 0xFF is low for its start bit alone, and half of a slow start bit is over by then.
        assert_eq!(plain(2.0, &[0xFF]), []);
    }

    #[test]
    fn a_receiver_at_twice_the_rate_sees_every_symbol_twice() {
        // Looks at 0.25, 0.75, 1.25 ...: the start bit counts as data as well.
        assert_eq!(plain(0.5, &[0xFF]), [0xFE]);
        // All looks of the first character, stop bit included, fall on zeros; the line then rises
        // for good before another can start.
        let (bytes, errors) = read(CharacterFormat::default(), 0.5, &[0x00]);
        assert_eq!((bytes, errors.framing), (vec![0x00], 1));
    }

    #[test]
    fn a_low_line_is_one_nul_however_long() {
        // Twenty times faster: all ten looks fall into the start bit, and the line has to rise
        // before a next character.
        let (bytes, errors) = read(CharacterFormat::default(), 0.05, &[0x00]);
        assert_eq!((bytes, errors.framing), (vec![0x00], 1));
    }

    #[test]
    fn a_missed_parity_bit_is_counted_and_the_byte_handed_over() {
        // Sent without parity and read with it, the stop bit stands where parity is expected.
        let mut receiver = UartReceiver::new(FORMATS[2], 1.0, 1.0);
        let mut out = Vec::new();
        let (start, byte) = (0.0, 0x03);
        let character = Character { start, symbol: DATA_BITS + 1, byte, parity: true };
        receiver.look(character, 9.5, true, &mut out);
        receiver.finish(&mut out);
        assert_eq!((out, receiver.errors().parity), (vec![0x03], 1));
    }

    /// The line as levels on a fine grid and a receiver that walks over it: no shared code.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "positions on the grid are small and not negative"
    )]
    fn walked(format: CharacterFormat, ratio: f64, bursts: &[(u32, Vec<u8>)]) -> Vec<u8> {
        const FINE: usize = 64;
        let mut line = vec![true; FINE];
        for (gap, bytes) in bursts {
            line.extend(vec![true; *gap as usize * FINE]);
            for byte in bytes {
                let ones = byte.count_ones() % 2 == 1;
                let mut symbols = vec![false];
                symbols.extend((0..8).map(|k| byte & (1 << k) != 0));
                match format.parity {
                    Parity::None => {}
                    Parity::Even => symbols.push(ones),
                    Parity::Odd => symbols.push(!ones),
                }
                symbols.extend(vec![true; format.stop_bits as usize]);
                line.extend(symbols.iter().flat_map(|level| [*level; FINE]));
            }
        }
        let looks = if format.parity == Parity::None { 10 } else { 11 };
        let at = |position: f64| line.get(position as usize).copied().unwrap_or(true);
        let (mut out, mut position) = (Vec::new(), 1);
        while position < line.len() {
            if line[position] || !line[position - 1] {
                position += 1;
                continue;
            }
            let look = |k: i32| position as f64 + (f64::from(k) + 0.5) * ratio * FINE as f64;
            if at(look(0)) {
                position = look(0).ceil() as usize;
                continue;
            }
            out.push((0..8).fold(0, |byte, k| byte | (u8::from(at(look(k + 1))) << k)));
            position = look(looks - 1).ceil() as usize;
        }
        out
    }

    fn bursts() -> impl Strategy<Value = Vec<(u32, Vec<u8>)>> {
        let bytes = proptest::collection::vec(any::<u8>(), 0..12);
        proptest::collection::vec((0..40_u32, bytes), 1..8)
    }

    proptest! {
        #[test]
        fn a_clock_within_four_per_cent_reads_what_was_sent(
            bursts in bursts(),
            // The middle of the last look leaves its symbol at 1/21 = 4.8 % with parity.
            ratio in 0.96..1.04,
            format in 0..FORMATS.len(),
        ) {
            let mut receiver = UartReceiver::new(FORMATS[format], ratio, 1.0);
            let (mut sent, mut got) = (Vec::new(), Vec::new());
            for (gap, bytes) in &bursts {
                receiver.receive(f64::from(*gap), bytes, &mut got);
                sent.extend_from_slice(bytes);
            }
            receiver.finish(&mut got);
            prop_assert_eq!(got, sent);
            prop_assert_eq!(receiver.errors(), ReceiverErrors::default());
        }

        #[test]
        fn any_ratio_reads_what_a_walk_along_the_line_reads(
            bursts in bursts(),
            // In steps that keep every look off the edges of the fine grid.
            steps in 3..200_u32,
            format in 0..FORMATS.len(),
        ) {
            let ratio = (f64::from(steps) + 0.37) / 50.0;
            let mut receiver = UartReceiver::new(FORMATS[format], ratio, 1.0);
            let mut got = Vec::new();
            for (gap, bytes) in &bursts {
                receiver.receive(f64::from(*gap), bytes, &mut got);
            }
            receiver.finish(&mut got);
            prop_assert_eq!(got, walked(FORMATS[format], ratio, &bursts));
        }

        #[test]
        fn no_byte_becomes_more_than_five(
            bytes in proptest::collection::vec(any::<u8>(), 0..50),
            ratio in 1e-6..1e6,
        ) {
            prop_assert!(plain(ratio, &bytes).len() <= 5 * bytes.len());
        }
    }
}
