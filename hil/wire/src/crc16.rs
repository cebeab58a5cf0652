//! CRC-16 with parameters known only at run time.

use std::fmt;

/// The five numbers that name a 16-bit CRC (the parametric model of R. N. Williams).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Crc16Params {
    /// Generator polynomial without its top term, in unreflected form.
    pub poly: u16,
    /// Initial register.
    pub init: u16,
    /// Bits of each input byte enter lowest first.
    pub refin: bool,
    /// The register is mirrored before `xorout`.
    pub refout: bool,
    /// Exclusive-ored into the result.
    pub xorout: u16,
}

/// A table-driven CRC-16.
///
/// Own, because the parameters come from a file and the `crc` crate wants them `'static`; that
/// crate is the oracle in the tests.
#[derive(Clone, PartialEq, Eq)]
pub struct Crc16 {
    params: Crc16Params,
    table: [u16; 256],
}

impl Crc16 {
    /// Builds the table of `params`.
    #[must_use]
    pub fn new(params: Crc16Params) -> Self {
        let mut table = [0; 256];
        for (byte, slot) in (0..=u8::MAX).zip(&mut table) {
            *slot = if params.refin {
                shift_low_first(u16::from(byte), params.poly.reverse_bits())
            } else {
                shift_high_first(u16::from(byte) << 8, params.poly)
            };
        }
        Self { params, table }
    }

    /// The CRC of `bytes`.
    #[must_use]
    pub fn checksum(&self, bytes: &[u8]) -> u16 {
        let Crc16Params { init, refin, refout, xorout, .. } = self.params;
        let register = if refin {
            bytes.iter().fold(init.reverse_bits(), |register, byte| {
                let [low, _] = register.to_le_bytes();
                self.table[usize::from(low ^ byte)] ^ (register >> 8)
            })
        } else {
            bytes.iter().fold(init, |register, byte| {
                let [high, _] = register.to_be_bytes();
                self.table[usize::from(high ^ byte)] ^ (register << 8)
            })
        };
        // The low-first register is mirrored already.
        let mirrored = if refin == refout { register } else { register.reverse_bits() };
        mirrored ^ xorout
    }

    /// The parameters it was built from.
    #[must_use]
    pub const fn params(&self) -> Crc16Params {
        self.params
    }
}

/// The parameters alone: 256 table entries would drown every message.
impl fmt::Debug for Crc16 {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("Crc16").field(&self.params).finish()
    }
}

fn shift_high_first(register: u16, poly: u16) -> u16 {
    (0..8).fold(register, |r, _| if r & 0x8000 == 0 { r << 1 } else { (r << 1) ^ poly })
}

fn shift_low_first(register: u16, poly: u16) -> u16 {
    (0..8).fold(register, |r, _| if r & 1 == 0 { r >> 1 } else { (r >> 1) ^ poly })
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn ours(model: &crc::Algorithm<u16>) -> Crc16 {
        let crc::Algorithm { poly, init, refin, refout, xorout, .. } = *model;
        Crc16::new(Crc16Params { poly, init, refin, refout, xorout })
    }

    #[test]
    fn the_published_check_values_come_out() {
        // Check values of "123456789" from the catalogue of parametrised CRC algorithms.
        let model = |poly, init, reflect, xorout| {
            Crc16::new(Crc16Params { poly, init, refin: reflect, refout: reflect, xorout })
        };
        for (name, crc, check) in [
            ("IBM-3740", model(0x1021, 0xFFFF, false, 0x0000), 0x29B1),
            ("ARC", model(0x8005, 0x0000, true, 0x0000), 0xBB3D),
            ("XMODEM", model(0x1021, 0x0000, false, 0x0000), 0x31C3),
            ("MODBUS", model(0x8005, 0xFFFF, true, 0x0000), 0x4B37),
            ("IBM-SDLC", model(0x1021, 0xFFFF, true, 0xFFFF), 0x906E),
            ("GENIBUS", model(0x1021, 0xFFFF, false, 0xFFFF), 0xD64E),
        ] {
            assert_eq!(crc.checksum(b"123456789"), check, "{name}");
        }
    }

    #[test]
    fn the_catalogue_of_the_crc_crate_agrees() {
        for model in [
            &crc::CRC_16_ARC,
            &crc::CRC_16_CDMA2000,
            &crc::CRC_16_DNP,
            &crc::CRC_16_EN_13757,
            &crc::CRC_16_IBM_3740,
            &crc::CRC_16_KERMIT,
            &crc::CRC_16_MODBUS,
            &crc::CRC_16_RIELLO,
            &crc::CRC_16_TELEDISK,
            &crc::CRC_16_USB,
            &crc::CRC_16_XMODEM,
        ] {
            assert_eq!(ours(model).checksum(b"123456789"), model.check, "{model:?}");
        }
    }

    proptest! {
        #[test]
        fn any_parameters_agree_with_the_crc_crate(
            (poly, init, xorout) in any::<(u16, u16, u16)>(),
            (refin, refout) in any::<(bool, bool)>(),
            bytes in proptest::collection::vec(any::<u8>(), 0..80),
        ) {
            let model = crc::Algorithm {
                width: 16, poly, init, refin, refout, xorout, check: 0, residue: 0,
            };
            // The crate borrows its parameters for ever; a test may leak twenty bytes.
            let oracle = crc::Crc::<u16>::new(Box::leak(Box::new(model)));
            prop_assert_eq!(ours(oracle.algorithm).checksum(&bytes), oracle.checksum(&bytes));
        }
    }
}
