//! Every 8, 16 and 32 bit algorithm of the CRC catalogue, and CRCs computed by table.

use std::sync::LazyLock;

/// A CRC with all its parameters; values in the low `width` bits.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Crc {
    /// Its name in the catalogue of parametrised CRC algorithms; "generic" when it has none.
    pub name: &'static str,
    /// 8, 16 or 32.
    pub width: u32,
    /// Polynomial without its top term, unreflected.
    pub poly: u32,
    /// Initial register.
    pub init: u32,
    /// Whether bytes and result are mirrored. No algorithm of these widths mirrors only one.
    pub reflected: bool,
    /// XORed into the result.
    pub xorout: u32,
}

macro_rules! row {
    ($name:literal, $algorithm:expr) => {
        Crc {
            name: $name,
            width: $algorithm.width as u32,
            poly: $algorithm.poly as u32,
            init: $algorithm.init as u32,
            reflected: $algorithm.refin,
            xorout: $algorithm.xorout as u32,
        }
    };
}

/// Widest first: where several fit, the widest proves the most.
pub(crate) const CATALOGUE: [Crc; 63] = [
    row!("CRC-32/AIXM", crc::CRC_32_AIXM),
    row!("CRC-32/AUTOSAR", crc::CRC_32_AUTOSAR),
    row!("CRC-32/BASE91-D", crc::CRC_32_BASE91_D),
    row!("CRC-32/BZIP2", crc::CRC_32_BZIP2),
    row!("CRC-32/CD-ROM-EDC", crc::CRC_32_CD_ROM_EDC),
    row!("CRC-32/CKSUM", crc::CRC_32_CKSUM),
    row!("CRC-32/ISCSI", crc::CRC_32_ISCSI),
    row!("CRC-32/ISO-HDLC", crc::CRC_32_ISO_HDLC),
    row!("CRC-32/JAMCRC", crc::CRC_32_JAMCRC),
    row!("CRC-32/MEF", crc::CRC_32_MEF),
    row!("CRC-32/MPEG-2", crc::CRC_32_MPEG_2),
    row!("CRC-32/XFER", crc::CRC_32_XFER),
    row!("CRC-16/ARC", crc::CRC_16_ARC),
    row!("CRC-16/CDMA2000", crc::CRC_16_CDMA2000),
    row!("CRC-16/CMS", crc::CRC_16_CMS),
    row!("CRC-16/DDS-110", crc::CRC_16_DDS_110),
    row!("CRC-16/DECT-R", crc::CRC_16_DECT_R),
    row!("CRC-16/DECT-X", crc::CRC_16_DECT_X),
    row!("CRC-16/DNP", crc::CRC_16_DNP),
    row!("CRC-16/EN-13757", crc::CRC_16_EN_13757),
    row!("CRC-16/GENIBUS", crc::CRC_16_GENIBUS),
    row!("CRC-16/GSM", crc::CRC_16_GSM),
    row!("CRC-16/IBM-3740", crc::CRC_16_IBM_3740),
    row!("CRC-16/IBM-SDLC", crc::CRC_16_IBM_SDLC),
    row!("CRC-16/ISO-IEC-14443-3-A", crc::CRC_16_ISO_IEC_14443_3_A),
    row!("CRC-16/KERMIT", crc::CRC_16_KERMIT),
    row!("CRC-16/LJ1200", crc::CRC_16_LJ1200),
    row!("CRC-16/M17", crc::CRC_16_M17),
    row!("CRC-16/MAXIM-DOW", crc::CRC_16_MAXIM_DOW),
    row!("CRC-16/MCRF4XX", crc::CRC_16_MCRF4XX),
    row!("CRC-16/MODBUS", crc::CRC_16_MODBUS),
    row!("CRC-16/NRSC-5", crc::CRC_16_NRSC_5),
    row!("CRC-16/OPENSAFETY-A", crc::CRC_16_OPENSAFETY_A),
    row!("CRC-16/OPENSAFETY-B", crc::CRC_16_OPENSAFETY_B),
    row!("CRC-16/PROFIBUS", crc::CRC_16_PROFIBUS),
    row!("CRC-16/RIELLO", crc::CRC_16_RIELLO),
    row!("CRC-16/SPI-FUJITSU", crc::CRC_16_SPI_FUJITSU),
    row!("CRC-16/T10-DIF", crc::CRC_16_T10_DIF),
    row!("CRC-16/TELEDISK", crc::CRC_16_TELEDISK),
    row!("CRC-16/TMS37157", crc::CRC_16_TMS37157),
    row!("CRC-16/UMTS", crc::CRC_16_UMTS),
    row!("CRC-16/USB", crc::CRC_16_USB),
    row!("CRC-16/XMODEM", crc::CRC_16_XMODEM),
    row!("CRC-8/AUTOSAR", crc::CRC_8_AUTOSAR),
    row!("CRC-8/BLUETOOTH", crc::CRC_8_BLUETOOTH),
    row!("CRC-8/CDMA2000", crc::CRC_8_CDMA2000),
    row!("CRC-8/DARC", crc::CRC_8_DARC),
    row!("CRC-8/DVB-S2", crc::CRC_8_DVB_S2),
    row!("CRC-8/GSM-A", crc::CRC_8_GSM_A),
    row!("CRC-8/GSM-B", crc::CRC_8_GSM_B),
    row!("CRC-8/HITAG", crc::CRC_8_HITAG),
    row!("CRC-8/I-432-1", crc::CRC_8_I_432_1),
    row!("CRC-8/I-CODE", crc::CRC_8_I_CODE),
    row!("CRC-8/LTE", crc::CRC_8_LTE),
    row!("CRC-8/MAXIM-DOW", crc::CRC_8_MAXIM_DOW),
    row!("CRC-8/MIFARE-MAD", crc::CRC_8_MIFARE_MAD),
    row!("CRC-8/NRSC-5", crc::CRC_8_NRSC_5),
    row!("CRC-8/OPENSAFETY", crc::CRC_8_OPENSAFETY),
    row!("CRC-8/ROHC", crc::CRC_8_ROHC),
    row!("CRC-8/SAE-J1850", crc::CRC_8_SAE_J1850),
    row!("CRC-8/SMBUS", crc::CRC_8_SMBUS),
    row!("CRC-8/TECH-3250", crc::CRC_8_TECH_3250),
    row!("CRC-8/WCDMA", crc::CRC_8_WCDMA),
];

/// What is left of a CRC once start value and final XOR cancel: the XOR of two messages of equal
/// length has, under these alone, the XOR of their checks.
#[derive(Debug, Clone)]
pub(crate) struct Kernel {
    pub(crate) width: u32,
    pub(crate) poly: u32,
    pub(crate) reflected: bool,
    table: [u32; 256],
}

/// Each (width, polynomial, reflection) of the catalogue once, in its order.
pub(crate) static KERNELS: LazyLock<Vec<Kernel>> = LazyLock::new(|| {
    let mut kernels: Vec<Kernel> = Vec::new();
    for crc in &CATALOGUE {
        if !kernels.iter().any(|kernel| kernel.belongs(crc)) {
            kernels.push(Kernel::new(crc.width, crc.poly, crc.reflected));
        }
    }
    kernels
});

impl Crc {
    /// Every 8, 16 and 32 bit algorithm of the catalogue, widest first.
    #[must_use]
    pub const fn catalogue() -> &'static [Self] {
        &CATALOGUE
    }
}

impl Kernel {
    /// The table of a register that is shifted right when reflected, else kept at the top of 32
    /// bits and shifted left.
    pub(crate) fn new(width: u32, poly: u32, reflected: bool) -> Self {
        let mut table = [0; 256];
        for (byte, entry) in (0u32..).zip(&mut table) {
            *entry = if reflected {
                let poly = poly.reverse_bits() >> (32 - width);
                (0..8).fold(byte, |r, _| if r & 1 == 1 { (r >> 1) ^ poly } else { r >> 1 })
            } else {
                let poly = poly << (32 - width);
                (0..8).fold(byte << 24, |r, _| if r >> 31 == 1 { (r << 1) ^ poly } else { r << 1 })
            };
        }
        Self { width, poly, reflected, table }
    }

    pub(crate) fn belongs(&self, crc: &Crc) -> bool {
        (self.width, self.poly, self.reflected) == (crc.width, crc.poly, crc.reflected)
    }

    /// The register that holds `value` before the first byte.
    pub(crate) fn load(&self, value: u32) -> u32 {
        if self.reflected {
            value.reverse_bits() >> (32 - self.width)
        } else {
            value << (32 - self.width)
        }
    }

    /// The register after one more byte.
    pub(crate) fn feed(&self, register: u32, byte: u8) -> u32 {
        if self.reflected {
            self.feed_right(register, byte.into())
        } else {
            self.feed_left(register, byte.into())
        }
    }

    /// [`Self::feed`] when reflected.
    #[inline]
    pub(crate) fn feed_right(&self, register: u32, byte: u32) -> u32 {
        (register >> 8) ^ self.table[((register ^ byte) & 0xFF) as usize]
    }

    /// [`Self::feed`] when not.
    #[inline]
    pub(crate) fn feed_left(&self, register: u32, byte: u32) -> u32 {
        (register << 8) ^ self.table[((register >> 24) ^ byte) as usize & 0xFF]
    }

    /// The CRC that a register stands for, before the final XOR.
    #[inline]
    pub(crate) fn value(&self, register: u32) -> u32 {
        if self.reflected { register } else { register >> (32 - self.width) }
    }

    /// The whole CRC of `bytes`.
    pub(crate) fn crc(&self, crc: &Crc, bytes: impl Iterator<Item = u8>) -> u32 {
        let register = bytes.fold(self.load(crc.init), |register, byte| self.feed(register, byte));
        self.value(register) ^ crc.xorout
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn published_check_values_come_out() {
        let value_of = |name: &str| {
            let crc = CATALOGUE.iter().find(|crc| crc.name == name).unwrap();
            Kernel::new(crc.width, crc.poly, crc.reflected).crc(crc, b"123456789".iter().copied())
        };
        assert_eq!(value_of("CRC-16/IBM-3740"), 0x29B1);
        assert_eq!(value_of("CRC-16/ARC"), 0xBB3D);
        assert_eq!(value_of("CRC-32/ISO-HDLC"), 0xCBF4_3926);
        assert_eq!(value_of("CRC-32/MPEG-2"), 0x0376_E6E7);
        assert_eq!(value_of("CRC-8/MAXIM-DOW"), 0xA1);
        assert_eq!(value_of("CRC-8/GSM-B"), 0x94);
        assert_eq!(value_of("CRC-16/RIELLO"), 0x63D0);
    }

    #[test]
    fn kernels_are_the_distinct_ones_of_the_catalogue() {
        for crc in &CATALOGUE {
            assert_eq!(KERNELS.iter().filter(|kernel| kernel.belongs(crc)).count(), 1);
        }
    }
}
