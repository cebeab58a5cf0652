//! CRCs of 8, 16 and 32 bits with parameters known only at run time.

use std::fmt;

/// The numbers that name a CRC (the parametric model of R. N. Williams).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CrcParams {
    /// Width, bits: 8, 16 or 32.
    pub width: u32,
    /// Generator polynomial without its top term, in unreflected form.
    pub poly: u32,
    /// Initial register.
    pub init: u32,
    /// Bits of each input byte enter lowest first.
    pub refin: bool,
    /// The register is mirrored before `xorout`.
    pub refout: bool,
    /// Exclusive-ored into the result.
    pub xorout: u32,
}

/// Bytes taken at a time.
const STRIDE: usize = 8;

/// A table-driven CRC.
///
/// Own, because the parameters come from a file and the `crc` crate wants them `'static`; that
/// crate is the oracle in the tests.
///
/// One register of 32 bits serves every width and direction: the eight bits that meet the next
/// byte always lie lowest. So the bits are in the register's order when they enter lowest first,
/// and its bytes are swapped when they enter highest first. Up to eight bytes are looked up at
/// once, each in a table of its own, for a frame is too short to wait for one after the other.
#[derive(Clone, PartialEq, Eq)]
pub struct Crc {
    params: CrcParams,
    /// What a byte does to the register with 0 to 7 bytes behind it.
    tables: Box<[[u32; 256]; STRIDE]>,
}

impl Crc {
    /// Builds the tables of `params`. Bits of the parameters above the width are not looked at.
    #[must_use]
    pub fn new(params: CrcParams) -> Self {
        let CrcParams { width, poly, refin, .. } = params;
        let mut last = [0; 256];
        for (byte, slot) in (0..=u8::MAX).zip(&mut last) {
            *slot = if refin {
                shift_low_first(u32::from(byte), poly.reverse_bits() >> (32 - width))
            } else {
                shift_high_first(u32::from(byte) << 24, poly << (32 - width)).swap_bytes()
            };
        }
        let mut tables = Box::new([last; STRIDE]);
        for k in 1..STRIDE {
            for byte in 0..256 {
                let register = tables[k - 1][byte];
                tables[k][byte] = last[lowest(register)] ^ (register >> 8);
            }
        }
        Self { params, tables }
    }

    /// The CRC of `bytes`.
    #[must_use]
    #[inline]
    pub fn checksum(&self, bytes: &[u8]) -> u32 {
        let CrcParams { width, init, refin, refout, xorout, .. } = self.params;
        let unused = 32 - width;
        let start =
            if refin { init.reverse_bits() >> unused } else { (init << unused).swap_bytes() };
        let end = bytes.chunks(STRIDE).fold(start, |register, bytes| self.take(register, bytes));
        // The low-first register is mirrored already.
        let register = if refin { end } else { end.swap_bytes() >> unused };
        let mirrored = if refin == refout { register } else { register.reverse_bits() >> unused };
        mirrored ^ xorout
    }

    /// The register behind at most eight `bytes`.
    #[inline]
    fn take(&self, register: u32, bytes: &[u8]) -> u32 {
        // The register meets the first four bytes; what fewer leave of it moves down.
        let mut met = u64::from(register);
        let mut after = 0;
        for (byte, table) in bytes.iter().zip(self.tables[..bytes.len()].iter().rev()) {
            let [low, ..] = met.to_le_bytes();
            after ^= table[usize::from(low ^ byte)];
            met >>= 8;
        }
        after ^ lower_half(met)
    }

    /// The parameters it was built from.
    #[must_use]
    pub const fn params(&self) -> CrcParams {
        self.params
    }
}

/// The parameters alone: 256 table entries would drown every message.
impl fmt::Debug for Crc {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("Crc").field(&self.params).finish()
    }
}

fn lowest(register: u32) -> usize {
    let [low, ..] = register.to_le_bytes();
    usize::from(low)
}

#[expect(clippy::cast_possible_truncation, reason = "the lower half is what is wanted")]
pub(crate) const fn lower_half(register: u64) -> u32 {
    register as u32
}

fn shift_high_first(register: u32, poly: u32) -> u32 {
    (0..8).fold(register, |r, _| if r & (1 << 31) == 0 { r << 1 } else { (r << 1) ^ poly })
}

fn shift_low_first(register: u32, poly: u32) -> u32 {
    (0..8).fold(register, |r, _| if r & 1 == 0 { r >> 1 } else { (r >> 1) ^ poly })
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    macro_rules! ours {
        ($model:expr, $width:expr) => {{
            let crc::Algorithm { poly, init, refin, refout, xorout, .. } = $model;
            let [poly, init, xorout] = [poly, init, xorout].map(u32::from);
            Crc::new(CrcParams { width: $width, poly, init, refin, refout, xorout })
        }};
    }

    #[test]
    fn the_published_check_values_come_out() {
        // Check values of "123456789" from the catalogue of parametrised CRC algorithms.
        let model = |width, poly, init, reflect, xorout| {
            Crc::new(CrcParams { width, poly, init, refin: reflect, refout: reflect, xorout })
        };
        for (name, crc, check) in [
            ("8/SMBUS", model(8, 0x07, 0, false, 0), 0xF4),
            ("8/MAXIM-DOW", model(8, 0x31, 0, true, 0), 0xA1),
            ("16/IBM-3740", model(16, 0x1021, 0xFFFF, false, 0), 0x29B1),
            ("16/ARC", model(16, 0x8005, 0, true, 0), 0xBB3D),
            ("16/XMODEM", model(16, 0x1021, 0, false, 0), 0x31C3),
            ("16/MODBUS", model(16, 0x8005, 0xFFFF, true, 0), 0x4B37),
            ("16/IBM-SDLC", model(16, 0x1021, 0xFFFF, true, 0xFFFF), 0x906E),
            ("16/GENIBUS", model(16, 0x1021, 0xFFFF, false, 0xFFFF), 0xD64E),
            ("32/ISO-HDLC", model(32, 0x04C1_1DB7, u32::MAX, true, u32::MAX), 0xCBF4_3926),
            ("32/BZIP2", model(32, 0x04C1_1DB7, u32::MAX, false, u32::MAX), 0xFC89_1918),
        ] {
            assert_eq!(crc.checksum(b"123456789"), check, "{name}");
        }
    }

    #[test]
    fn the_catalogue_of_the_crc_crate_agrees() {
        for model in [&crc::CRC_8_AUTOSAR, &crc::CRC_8_BLUETOOTH, &crc::CRC_8_SAE_J1850] {
            assert_eq!(ours!(*model, 8).checksum(b"123456789"), u32::from(model.check));
        }
        for model in [
            &crc::CRC_16_ARC,
            &crc::CRC_16_CDMA2000,
            &crc::CRC_16_DNP,
            &crc::CRC_16_EN_13757,
            &crc::CRC_16_KERMIT,
            &crc::CRC_16_RIELLO,
            &crc::CRC_16_TELEDISK,
            &crc::CRC_16_USB,
        ] {
            assert_eq!(ours!(*model, 16).checksum(b"123456789"), u32::from(model.check));
        }
        for model in [&crc::CRC_32_AUTOSAR, &crc::CRC_32_CKSUM, &crc::CRC_32_ISCSI] {
            assert_eq!(ours!(*model, 32).checksum(b"123456789"), model.check);
        }
    }

    /// Ours beside the crate's for one width. The crate borrows its parameters for ever; a test
    /// may leak twenty bytes.
    macro_rules! beside {
        ($width:expr, $word:ty, $numbers:expr, $reflect:expr, $bytes:expr) => {{
            let ([poly, init, xorout], [refin, refout]): ([$word; 3], [bool; 2]) =
                ($numbers, $reflect);
            let model = crc::Algorithm {
                width: $width,
                poly,
                init,
                refin,
                refout,
                xorout,
                check: 0,
                residue: 0,
            };
            let ours = ours!(model, u32::from($width)).checksum($bytes);
            let theirs = crc::Crc::<$word>::new(Box::leak(Box::new(model))).checksum($bytes);
            prop_assert_eq!(ours, u32::from(theirs));
        }};
    }

    proptest! {
        #[test]
        fn any_parameters_agree_with_the_crc_crate(
            (eight, sixteen, long) in any::<([u8; 3], [u16; 3], [u32; 3])>(),
            reflect in any::<[bool; 2]>(),
            bytes in proptest::collection::vec(any::<u8>(), 0..80),
        ) {
            beside!(8_u8, u8, eight, reflect, &bytes);
            beside!(16_u8, u16, sixteen, reflect, &bytes);
            beside!(32_u8, u32, long, reflect, &bytes);
        }
    }
}
