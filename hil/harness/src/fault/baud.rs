//! What a receiver makes of bytes from a bit clock that is off.

/// Symbols of a byte with eight data bits, one start and one stop bit.
const SYMBOLS: usize = 10;
/// A receiver looks at the line sixteen times in a bit and finds a falling edge up to this late.
const EDGE_LATE: f64 = 1.0 / 16.0;

/// Reads the bits of `bytes`, sent without pause by a clock that runs fast by `share`, as a
/// receiver at the declared rate does; what it reads goes to `out`.
///
/// It waits for a falling edge, finds it up to a sixteenth of a bit late (`late` in 0 to 1 says how
/// much), and reads each bit in what it takes for its middle. A stop bit that reads 0 is a framing
/// error; the byte is handed on all the same, as a port that was not asked to mark errors does, and
/// the receiver waits for the line to be idle before it looks for the next edge.
pub(super) fn misread(bytes: &[u8], share: f64, late: &mut dyn FnMut() -> f64, out: &mut Vec<u8>) {
    let line = |at: f64| level(bytes, at * (1.0 + share));
    let end = (bytes.len() * SYMBOLS) as f64 / (1.0 + share);
    // A step finer than any symbol, so that no edge is missed.
    let step = 1.0 / 16.0;
    let mut now = 0.0;
    loop {
        while now < end && line(now) {
            now += step;
        }
        if now >= end {
            return;
        }
        let edge = falling_edge(now, share) + late() * EDGE_LATE;
        let bit = |k: usize| line(edge + k as f64 + 0.5);
        out.push((0..8).fold(0, |byte, k| byte | u8::from(bit(k + 1)) << k));
        now = edge + 9.5;
        while now < end && !line(now) {
            now += step;
        }
    }
}

/// The line `at` symbols after the start: idle is high.
fn level(bytes: &[u8], at: f64) -> bool {
    // Not above the symbols there are by more than a few: the caller stops at the end.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "not negative; a float-to-int cast saturates"
    )]
    let symbol = at.max(0.0) as usize;
    let Some(byte) = bytes.get(symbol / SYMBOLS) else { return true };
    match symbol % SYMBOLS {
        0 => false,
        9 => true,
        k => byte >> (k - 1) & 1 == 1,
    }
}

/// Where the low symbol that holds `now` began, in the receiver's bits.
fn falling_edge(now: f64, share: f64) -> f64 {
    (now * (1.0 + share)).floor() / (1.0 + share)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(bytes: &[u8], share: f64, late: f64) -> Vec<u8> {
        let mut out = Vec::new();
        misread(bytes, share, &mut || late, &mut out);
        out
    }

    #[test]
    fn a_clock_within_four_per_cent_is_read_right() {
        let bytes: Vec<u8> = (0..=255).collect();
        for share in [-0.04, -0.02, 0.0, 0.02, 0.04] {
            for late in [0.0, 0.5, 1.0] {
                assert_eq!(read(&bytes, share, late), bytes, "{share} {late}");
            }
        }
    }

    #[test]
    fn a_clock_beyond_six_per_cent_garbles() {
        let bytes: Vec<u8> = (0..=255).collect();
        // 8.5 bits after the edge a clock 6.5 % off has reached the next symbol or is still in the
        // one before.
        for share in [-0.12, -0.065, 0.065, 0.12] {
            assert_ne!(read(&bytes, share, 0.5), bytes, "{share}");
        }
    }
}
