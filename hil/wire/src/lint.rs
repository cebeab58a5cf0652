//! What a layout can and cannot do, judged before any byte is seen.

use crate::check::Algorithm;
use crate::evidence::BELIEF_BITS;
use crate::framing::Framing;
use crate::{CheckKind, Coding, Crc, FrameSpec, Kind, MAX_FRAME_LEN, parse};
use struna_settings::{Result, Table};

/// Rates that serial ports and their bridges offer, baud.
const COMMON_BAUDS: [u32; 13] = [
    4800, 9600, 19_200, 38_400, 57_600, 115_200, 230_400, 250_000, 460_800, 500_000, 614_400,
    921_600, 1_000_000,
];

/// A frame file that can be decoded, and what is to be known of it.
#[derive(Debug, Clone, PartialEq)]
pub struct Lint {
    /// The layout.
    pub spec: FrameSpec,
    /// The share of the line that frames take, at common rates and at the declared one.
    pub loads: Vec<Load>,
    /// False frames in an hour of uniform noise at the declared rate of the line.
    pub false_frames_per_hour: f64,
    /// What the check does not see.
    pub undetected: Undetected,
    /// What cannot be seen on this line, one sentence each.
    pub blind_spots: Vec<String>,
    /// What is allowed but may not be meant, one sentence each.
    pub warnings: Vec<String>,
}

/// Frames on a line of some speed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Load {
    /// Rate of the line, baud.
    pub baud: u32,
    /// Share of it that the frames take at the greatest frame rate within the tolerance; the line
    /// cannot carry them when this is above 1.
    pub share: f64,
}

/// The least damage that a check does not see, as a class.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Undetected {
    /// Any: there is no check.
    Anything,
    /// Some patterns of so many wrong bits, and none of fewer.
    WrongBits(u32),
    /// No pattern of fewer than so many wrong bits; more was not looked at.
    AtLeast(u32),
}

impl Lint {
    /// Judges a frame file.
    ///
    /// # Errors
    /// What [`FrameSpec::from_toml`] refuses, and layouts that are consistent but cannot be decoded
    /// uniquely: nothing tells the start of a frame from its middle, or too little tells a frame
    /// from noise. Each names line, key, value and remedy.
    pub fn of(text: &str) -> Result<Self> {
        struna_settings::read(text, |root| {
            let spec = parse::from_root(root)?;
            let frame = root.required("frame")?.table()?;
            refuse_ambiguous(&frame, &spec)?;
            refuse_weak(&frame, &spec)?;
            let bytes_per_s = f64::from(spec.line().baud) / f64::from(spec.line().bits_per_byte());
            Ok(Self {
                loads: loads(&spec),
                false_frames_per_hour: 3600.0
                    * bytes_per_s
                    * spec.evidence().false_accepts_per_byte(),
                undetected: undetected(&spec),
                blind_spots: blind_spots(&spec),
                warnings: warnings(&spec),
                spec,
            })
        })
    }
}

fn loads(spec: &FrameSpec) -> Vec<Load> {
    let fastest = spec.bits_per_s() * (1.0 + spec.timing().rate_tolerance);
    let mut bauds = COMMON_BAUDS.to_vec();
    bauds.push(spec.line().baud);
    bauds.sort_unstable();
    bauds.dedup();
    bauds.into_iter().map(|baud| Load { baud, share: fastest / f64::from(baud) }).collect()
}

/// Refuses a layout whose frames look like frames from another byte on as well, whatever they
/// hold, when no check can tell the two apart.
fn refuse_ambiguous(frame: &Table<'_>, spec: &FrameSpec) -> Result<()> {
    let Some(shift) = false_start(spec) else { return Ok(()) };
    if spec.check().kind() != CheckKind::None {
        return Ok(());
    }
    Err(frame.required("sync")?.because(format!(
        "every frame holds this sync word at byte {shift} as well, and no check tells the two \
         apart; choose another word, or declare a check"
    )))
}

/// Refuses a layout that noise imitates too easily, however many frames are asked to agree.
fn refuse_weak(frame: &Table<'_>, spec: &FrameSpec) -> Result<()> {
    let evidence = spec.evidence();
    let asked =
        frame.optional("plausible").and_then(|value| value.table().ok()?.optional("confirm"));
    if asked.is_some() || evidence.row_bits() >= BELIEF_BITS {
        return Ok(());
    }
    Err(frame.required("check")?.because(format!(
        "sync and check are {:.1} bits, and even {} frames in a row are {:.0} of the {BELIEF_BITS} \
         bits that tell frames from noise; lengthen `sync`, declare a check or a counter",
        evidence.frame_bits(),
        evidence.confirm,
        evidence.row_bits()
    )))
}

/// The byte from which every frame looks like the start of a frame, if there is one.
fn false_start(spec: &FrameSpec) -> Option<usize> {
    let Framing::Fixed { mask } = &spec.framing else { return None };
    let (known, value) = constants(spec, mask);
    let len = spec.len;
    (1..len).find(|shift| {
        spec.sync.iter().enumerate().all(|(k, sync)| {
            let counts = mask.get(k).copied().unwrap_or(0xFF);
            // Beyond the end the next frame begins.
            let at = (shift + k) % len;
            known[at] & counts == counts && value[at] & counts == *sync
        })
    })
}

/// The bits that are alike in all frames, as a mask, and their values: the sync word, and zero
/// where nothing was declared.
fn constants(spec: &FrameSpec, mask: &[u8]) -> ([u8; MAX_FRAME_LEN], [u8; MAX_FRAME_LEN]) {
    let mut known = [0xFF; MAX_FRAME_LEN];
    let mut value = [0; MAX_FRAME_LEN];
    let mut varies = |footprint: [u8; MAX_FRAME_LEN]| {
        for (known, bits) in known.iter_mut().zip(footprint) {
            *known &= !bits;
        }
    };
    for field in &spec.fields {
        varies(field.place.footprint());
    }
    if let Some(sequence) = &spec.sequence {
        varies(sequence.place.footprint());
    }
    if spec.check.kind() != CheckKind::None {
        varies(spec.check.place.footprint());
    }
    for (k, sync) in spec.sync.iter().enumerate() {
        value[k] = sync & mask.get(k).copied().unwrap_or(0xFF);
    }
    (known, value)
}

/// The least damage inside the range of the check that it does not see.
fn undetected(spec: &FrameSpec) -> Undetected {
    match &spec.check.algorithm {
        Algorithm::None => Undetected::Anything,
        // Two wrong bits cancel: in the parity always, in an exclusive or when they have the same
        // place in their bytes, in a sum when one goes up and the other down.
        Algorithm::Parity { .. } | Algorithm::Xor | Algorithm::Sum { .. } => {
            Undetected::WrongBits(2)
        }
        Algorithm::Crc(crc) => {
            let (first, last) = spec.check.range();
            hamming_distance(crc, last - first + 1)
        }
    }
}

/// Smallest number of wrong bits in `bytes` bytes and their CRC that cancel, found by looking at
/// all of up to four.
fn hamming_distance(crc: &Crc, bytes: usize) -> Undetected {
    let mut message = vec![0; bytes];
    let clean = crc.checksum(&message);
    // What each single wrong bit does to the difference between stored and calculated check.
    let mut effects: Vec<u32> = (0..crc.params().width).map(|bit| 1 << bit).collect();
    for at in 0..bytes {
        for bit in 0..8 {
            message[at] = 1 << bit;
            effects.push(crc.checksum(&message) ^ clean);
        }
        message[at] = 0;
    }
    effects.sort_unstable();
    if effects[0] == 0 {
        return Undetected::WrongBits(1);
    }
    if effects.windows(2).any(|pair| pair[0] == pair[1]) {
        return Undetected::WrongBits(2);
    }
    let mut pairs: Vec<u32> = Vec::with_capacity(effects.len() * (effects.len() - 1) / 2);
    for (k, one) in effects.iter().enumerate() {
        pairs.extend(effects[k + 1..].iter().map(|other| one ^ other));
    }
    if pairs.iter().any(|pair| effects.binary_search(pair).is_ok()) {
        return Undetected::WrongBits(3);
    }
    pairs.sort_unstable();
    if pairs.windows(2).any(|two| two[0] == two[1]) {
        return Undetected::WrongBits(4);
    }
    Undetected::AtLeast(5)
}

fn blind_spots(spec: &FrameSpec) -> Vec<String> {
    let mut said = Vec::new();
    match spec.sequence() {
        None => said.push(
            "no counter: lost, swapped and duplicated frames are not observable; only the time \
             between arrivals tells of gaps"
                .to_owned(),
        ),
        Some(sequence) => said.push(format!(
            "the counter has {} values: longer gaps, {:.3} s, are told by the time between \
             arrivals alone",
            sequence.modulus(),
            sequence.modulus() as f64 / spec.timing().rate_hz
        )),
    }
    if spec.check().kind() == CheckKind::None {
        said.push("no check: damage to the payload is not observable".to_owned());
    } else if spec.kind() != Kind::Ascii {
        said.extend(unprotected(spec));
    }
    let confirm = spec.evidence().confirm;
    if confirm > 1 {
        said.push(format!(
            "one frame is weak evidence: after start or loss {confirm} in a row, {:.3} s, must \
             agree",
            confirm as f64 / spec.timing().rate_hz
        ));
    }
    said
}

/// Fields that reach outside the bytes that the check covers.
fn unprotected(spec: &FrameSpec) -> Option<String> {
    let (first, last) = spec.check().range();
    let outside = |at: usize, bytes: usize| at < first || at + bytes - 1 > last;
    let mut names: Vec<_> = spec
        .fields()
        .iter()
        .filter(|field| outside(field.at(), field.bytes()))
        .map(|field| field.name().to_owned())
        .collect();
    names.extend(
        spec.sequence().filter(|seq| outside(seq.at(), seq.bytes())).map(|_| "seq".to_owned()),
    );
    (!names.is_empty()).then(|| {
        format!("damage to {} is not observable: the check does not cover it", names.join(", "))
    })
}

fn warnings(spec: &FrameSpec) -> Vec<String> {
    let mut said = Vec::new();
    let evidence = spec.evidence();
    if evidence.row_bits() < BELIEF_BITS {
        said.push(format!(
            "`plausible.confirm` = {} asks for {:.0} bits of evidence; {BELIEF_BITS} are usual",
            evidence.confirm,
            evidence.row_bits()
        ));
    }
    if let Some(shift) = false_start(spec) {
        said.push(format!(
            "every frame holds the sync word at byte {shift} as well; the check alone tells the \
             two apart"
        ));
    }
    for field in spec.fields() {
        let beyond = field
            .clip
            .zip(field.code_range())
            .is_some_and(|(clip, code)| clip[0] < code[0] || clip[1] > code[1]);
        if beyond {
            said.push(format!("`clip` of {} reaches beyond its code", field.name()));
        }
        if field.coding() == Coding::Float && spec.check().kind() == CheckKind::None {
            said.push(format!(
                "{} is a float without a check: one wrong bit can mean anything",
                field.name()
            ));
        }
    }
    said
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::CrcParams;

    /// A frame of a sync word and sixteen bits from byte 2 on.
    fn file(sync: &str, len: usize, check: &str) -> String {
        format!(
            "[frame]\nname='x'\nkind='fixed'\nprovenance='unverified'\nsync='{sync}'\nlen={len}\n\
             [frame.check]\n{check}\n[[frame.field]]\nname='rate'\nat=2\nbits=16\nendian='be'\n\
             coding='twos'\nunit='counts'\n[line]\nbaud=115200\ndata=8\nparity='none'\nstop=1\n\
             [timing]\nrate_hz=100.0\nrate_tol=0.0\n"
        )
    }

    #[test]
    fn a_sync_word_that_constant_bytes_repeat_needs_a_check() {
        // 00 00 stands again behind the field, where undeclared bytes are zero.
        let text = file("00 00", 6, "kind='none'");
        let refusal = Lint::of(&text).unwrap_err();
        assert_eq!((refusal.key.as_str(), refusal.line), ("frame.sync", 5));
        assert!(refusal.to_string().contains("at byte 4 as well"), "{refusal}");
        let checked = Lint::of(&file("00 00", 7, "kind='sum8'\nrange=[2,3]\nat=6")).unwrap();
        assert!(checked.warnings.iter().any(|said| said.contains("byte 4")), "{checked:?}");
        assert!(Lint::of(&file("A5 5A", 6, "kind='none'")).is_ok());
        // Rotated: the last constant byte and the first of the next frame.
        let turned = file("00 A5", 5, "kind='none'").replace("00 A5", "A5 00");
        assert!(Lint::of(&turned).is_ok());
        let refusal = Lint::of(&file("00 00 00", 8, "kind='none'").replace("at=2", "at=3"));
        assert!(refusal.unwrap_err().to_string().contains("byte 5"));
    }

    #[test]
    fn too_little_evidence_is_refused_unless_the_file_insists() {
        let weak = file("01", 4, "kind='none'").replace("sync='01'", "sync='01'\nsync_mask='01'");
        let refusal = Lint::of(&weak).unwrap_err();
        assert_eq!(refusal.key, "frame.check");
        assert!(refusal.to_string().contains("24 frames in a row are 24 of the 32 bits"));
        let insisted = format!("{weak}[frame.plausible]\nconfirm=5\n");
        let lint = Lint::of(&insisted).unwrap();
        assert!(lint.warnings[0].contains("5 bits of evidence"), "{:?}", lint.warnings);
    }

    #[test]
    fn hamming_distances_are_those_published() {
        // Koopman and Chakravarty, Cyclic redundancy code polynomial selection for embedded
        // networks, 2004: CCITT-16 has distance 4 up to 32751 bits.
        let crc = |width, poly, refin| {
            Crc::new(CrcParams { width, poly, init: 0, refin, refout: refin, xorout: 0 })
        };
        assert_eq!(hamming_distance(&crc(16, 0x1021, false), 7), Undetected::WrongBits(4));
        // One wrong bit repeats its effect after the order of the polynomial: 127 for 0x07, which
        // 8 bits of check and 14.9 bytes reach.
        assert_eq!(hamming_distance(&crc(8, 0x07, false), 14), Undetected::WrongBits(4));
        assert_eq!(hamming_distance(&crc(8, 0x07, false), 15), Undetected::WrongBits(2));
        // All ones divide x^9 - 1: the effect comes again after nine bits.
        assert_eq!(hamming_distance(&crc(8, 0xFF, false), 1), Undetected::WrongBits(2));
        assert_eq!(hamming_distance(&crc(32, 0x04C1_1DB7, true), 8), Undetected::AtLeast(5));
    }

    #[test]
    fn what_the_line_cannot_show_is_said() {
        let bare = Lint::of(&file("A5 5A", 4, "kind='none'")).unwrap();
        assert_eq!(bare.undetected, Undetected::Anything);
        let said = bare.blind_spots.join("\n");
        for part in ["no counter: lost, swapped and duplicated", "no check: damage", "2 in a row"] {
            assert!(said.contains(part), "{said}");
        }
        let narrow = Lint::of(&file("A5 5A", 5, "kind='xor8'\nrange=[2,2]\nat=4")).unwrap();
        assert!(narrow.blind_spots[1].contains("damage to rate"), "{:?}", narrow.blind_spots);
        assert_eq!(narrow.undetected, Undetected::WrongBits(2));
        // 4 bytes of 10 bits, 100 times a second, on 4800 baud.
        let slow = bare.loads.iter().find(|load| load.baud == 4800).unwrap();
        assert!((slow.share - 4000.0 / 4800.0).abs() < 1e-12);
        // 2^-32 for each of 11520 bytes a second, for an hour.
        let expected = 11520.0 * 3600.0 / 2_f64.powi(32);
        assert!((bare.false_frames_per_hour / expected - 1.0).abs() < 1e-12);
    }
}
