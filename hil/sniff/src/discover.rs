//! The steps in order: length, check, phase, counter, fields.

use crate::check::{self, Place, doubles_of};
use crate::counter;
use crate::field;
use crate::frames::Frames;
use crate::layout::{Check, CheckKind, Coding, Counter, Field, Kind, Layout, Role};
use crate::length::{self, Framing, LEN_MIN, as_f64};
use crate::motion::Motion;
use crate::rate::{self, Moved};
use crate::septet;

/// Lengths looked at for a check when the likeliest has none.
const LENGTHS_TRIED: usize = 4;
/// A sync word is looked for no longer than this.
const SYNC_MAX: usize = 4;

/// A layout and what speaks for it.
#[derive(Debug, Clone)]
pub(crate) struct Discovery {
    pub(crate) layout: Layout,
    /// Where frames of this length were seen, at any phase.
    pub(crate) framing: Framing,
    /// Clean frames found, checked ones if there is a check.
    pub(crate) frames: usize,
    /// Share of the capture's bytes in such frames.
    pub(crate) share: f64,
    /// Bytes at the start that never changed.
    pub(crate) constant_run: usize,
    /// Other bytes that never changed.
    pub(crate) constant_elsewhere: Vec<usize>,
    /// Every check that fits equally, the chosen one first.
    pub(crate) checks: Vec<Check>,
    pub(crate) counter: Option<counter::Found>,
    pub(crate) motion: Motion,
    /// Excursion of the field that moves most but for the rate, as a share of full scale.
    pub(crate) next_excursion: f64,
    /// The rate's top byte never changed.
    pub(crate) constant_top: bool,
    /// Lowest bytes of the rate that are noise throughout.
    pub(crate) noisy_bytes: usize,
}

/// The likeliest layout of `bytes`.
pub(crate) fn discover(bytes: &[u8]) -> Option<Discovery> {
    if let Some(framing) = septet::framing(bytes) {
        return discover_in(bytes, &framing, Kind::Septet);
    }
    let candidates = length::candidates(bytes);
    let likeliest = length::widen(bytes, candidates.first()?.len)?;
    let places = places_in(bytes, &likeliest, false);
    if !places.is_empty() {
        let (framing, places) = shortest(bytes, likeliest, places);
        return describe(bytes, &framing, Kind::Fixed, &places);
    }
    // A check at another length proves more than columns that merely save bits.
    for other in candidates.iter().skip(1).take(LENGTHS_TRIED) {
        let Some(framing) = length::widen(bytes, other.len) else { continue };
        let places = places_in(bytes, &framing, false);
        // In several frames taken for one, counters and what follows them add up to one another.
        let width = if other.len.is_multiple_of(likeliest.len) { 2 } else { 1 };
        let proves = |place: &Place| place.share > 0.8 && place.kind.bytes() >= width;
        if places.first().is_some_and(proves) {
            return describe(bytes, &framing, Kind::Fixed, &places);
        }
    }
    describe(bytes, &likeliest, Kind::Fixed, &[])
}

/// The likeliest layout of frames of this length.
pub(crate) fn discover_at(bytes: &[u8], len: usize) -> Option<Discovery> {
    discover_in(bytes, &length::widen(bytes, len)?, Kind::Fixed)
}

/// The layout of frames that are known, of `bytes` that may be a part of the capture.
pub(crate) fn discover_in(bytes: &[u8], framing: &Framing, kind: Kind) -> Option<Discovery> {
    let places = places_in(bytes, framing, kind == Kind::Septet);
    describe(bytes, framing, kind, &places)
}

fn places_in(bytes: &[u8], framing: &Framing, seven_bits: bool) -> Vec<Place> {
    let constant = rows_of(bytes, framing, 8).constant(None);
    check::search(bytes, framing, &constant, seven_bits)
}

fn rows_of<'a>(bytes: &'a [u8], framing: &Framing, digit_bits: u32) -> Frames<'a> {
    Frames::new(bytes, framing.len, framing.starts.clone(), digit_bits, false)
}

/// Two short frames look like a long one: a half, third or quarter with the same check is it.
fn shortest(bytes: &[u8], framing: Framing, places: Vec<Place>) -> (Framing, Vec<Place>) {
    for part in [4, 3, 2] {
        if !framing.len.is_multiple_of(part) || framing.len / part < LEN_MIN {
            continue;
        }
        if !length::may_be(bytes, framing.len / part, framing.len) {
            continue;
        }
        let Some(shorter) = length::widen(bytes, framing.len / part) else { continue };
        let again = places_in(bytes, &shorter, false);
        // The covered half of a frame would do; but where is the sync word then?
        if !rows_of(bytes, &shorter, 8).constant(None).contains(&true) {
            continue;
        }
        let same = |place: &Place| places.iter().any(|long| long.kind == place.kind);
        if shorter.saved > 0.8 * framing.saved && again.first().is_some_and(same) {
            return (shorter, again);
        }
    }
    (framing, places)
}

/// Turns the circle of columns into a frame with a beginning, and names what is in it.
fn describe(bytes: &[u8], framing: &Framing, kind: Kind, places: &[Place]) -> Option<Discovery> {
    let digit_bits = if kind == Kind::Septet { 7 } else { 8 };
    let rows = rows_of(bytes, framing, digit_bits);
    let phase = match (kind, places.first()) {
        (Kind::Septet, _) => 0,
        (_, Some(place)) => phase_after(&rows.constant(None), place),
        (_, None) => phase_by_constants(&rows),
    };
    let checks = checks_at(places, framing.len, phase, kind);
    let mut frames = frames_at(bytes, framing, phase, digit_bits, checks.first());
    if frames.count() < 8 {
        return None;
    }
    let constant = frames.constant(checks.first());
    let constant_run = constant.iter().take_while(|constant| **constant).count();
    let sync_len =
        if kind == Kind::Septet { 1 } else { sync_length(&frames, constant_run, &checks) };
    let sync: Vec<u8> = (0..sync_len).map(|column| frames.mode(column).0).collect();

    let synced = |start: &usize| bytes[*start..].starts_with(&sync);
    frames.starts.retain(synced);
    let mut free: Vec<bool> = constant.iter().map(|constant| !constant).collect();
    if let Some(check) = checks.first() {
        free[check.at..check.at + check.kind.bytes()].fill(false);
    }
    let counter = counter::find(&frames, &free);
    if let Some(Counter { at, bytes, .. }) = counter.map(|found| found.counter) {
        free[at..at + bytes].fill(false);
    }
    let windows = field::split(&frames, &free);
    let mut moved = rate::name_fields(&frames, &windows);
    let constant_top = extend_sign(&frames, &mut moved, &constant, sync_len);
    let (motion, next_excursion) = motions(&moved);
    let noisy_bytes =
        moved.iter().find(|m| m.field.role == Role::Rate).map_or(0, Moved::noisy_bytes);
    let mut fields: Vec<Field> = moved.iter().map(|moved| moved.field).collect();
    fields.sort_by_key(|field| (field.at, field.role));

    let layout = Layout {
        kind,
        len: framing.len,
        sync,
        check: checks.first().copied(),
        counter: counter.map(|found| found.counter),
        fields,
    };
    Some(Discovery {
        frames: frames.count(),
        share: share_of(bytes, framing, &layout, frames.count()),
        framing: framing.clone(),
        constant_run,
        constant_elsewhere: (constant_run..framing.len).filter(|c| constant[*c]).collect(),
        checks,
        counter,
        motion,
        next_excursion,
        constant_top,
        noisy_bytes,
        layout,
    })
}

fn share_of(bytes: &[u8], framing: &Framing, layout: &Layout, frames: usize) -> f64 {
    if layout.check.is_some() {
        as_f64(frames * layout.len) / as_f64(bytes.len())
    } else {
        framing.coverage
    }
}

/// With a check the frame begins at the first constant column behind it; with none, right there.
fn phase_after(constant: &[bool], place: &Place) -> usize {
    let len = constant.len();
    let end = place.at(len) + place.kind.bytes();
    let skipped = (0..len).position(|k| constant[(end + k) % len]).unwrap_or(0);
    let before_range = (place.start + 2 * len - end) % len;
    if skipped <= before_range { (end + skipped) % len } else { end % len }
}

/// Without a check: the longest run of constant columns, in which 00 and FF count little. They
/// are more often the resting top bytes of a number than part of a sync word.
fn phase_by_constants(rows: &Frames<'_>) -> usize {
    let (len, constant) = (rows.len, rows.constant(None));
    let dull = |column: usize| matches!(rows.mode(column).0, 0x00 | 0xFF);
    let weight = |start: &usize| {
        let run = (0..len).map(|k| (start + k) % len).take_while(|column| constant[*column]);
        run.map(|column| if dull(column) { 0.1 } else { 1.0 }).sum::<f64>()
    };
    let starts = (0..len).filter(|start| constant[*start] && !constant[(start + len - 1) % len]);
    let best = starts.max_by(|a, b| weight(a).total_cmp(&weight(b)).then(b.cmp(a))).unwrap_or(0);
    let skipped =
        (0..len).take_while(|k| constant[(best + k) % len] && dull((best + k) % len)).count();
    let lies_in_run = constant[(best + skipped) % len];
    if lies_in_run { (best + skipped) % len } else { best }
}

/// The places as checks of a frame that begins at `phase`; those that would wrap are dropped.
fn checks_at(places: &[Place], len: usize, phase: usize, kind: Kind) -> Vec<Check> {
    let turned = |column: usize| (column + len - phase) % len;
    let check = |place: &Place| {
        let (first, at) = (turned(place.start), turned(place.at(len)));
        let fits = first < at && at + place.kind.bytes() <= len;
        fits.then(|| Check {
            kind: place.kind,
            first,
            last: at - 1,
            at,
            big_endian: place.big_endian,
            seven_bits: kind == Kind::Septet,
        })
    };
    places.iter().filter_map(check).collect()
}

/// Frames to look for numbers in: all that pass the check, or those that neighbours vouch for.
fn frames_at<'a>(
    bytes: &'a [u8],
    framing: &Framing,
    phase: usize,
    digit_bits: u32,
    check: Option<&Check>,
) -> Frames<'a> {
    let rows = rows_of(bytes, framing, digit_bits);
    let len = framing.len;
    let constant = rows.constant(None);
    let mode = |k: usize| rows.mode((phase + k) % len).0;
    let run = (0..len).take_while(|k| constant[(phase + k) % len]).count();
    let Some(check) = check else {
        let sync: Vec<u8> = (0..run.min(SYNC_MAX)).map(mode).collect();
        let mut starts = doubles_of(framing);
        if phase == 0 {
            starts.clone_from(&framing.starts);
        }
        let turned = starts.into_iter().map(|start| start + phase);
        let kept = turned.filter(|start| bytes[*start..].starts_with(&sync)).collect();
        return Frames::new(bytes, len, kept, digit_bits, false);
    };
    // A wide check needs no sync word to be trusted, and a status byte may have been taken for
    // part of one.
    let trusted = if check.kind.bytes() >= 2 { 0 } else { run.min(2) };
    let skeleton = Layout {
        kind: Kind::Fixed,
        len,
        sync: (0..trusted).map(mode).collect(),
        check: Some(*check),
        counter: None,
        fields: Vec::new(),
    };
    Frames::new(bytes, len, skeleton.scan(bytes), digit_bits, true)
}

/// How many of the constant bytes at the start are the sync word: those before the check's range
/// begins. Otherwise all, but two are enough where a wide check stands behind them, for the third
/// may be a status byte, and trailing 00 and FF more likely are something at rest.
fn sync_length(frames: &Frames<'_>, run: usize, checks: &[Check]) -> usize {
    let begins = checks.first().map_or(0, |check| check.first);
    if (1..=run.min(SYNC_MAX)).contains(&begins) {
        return begins;
    }
    let wide = checks.first().is_some_and(|check| check.kind.bytes() >= 2);
    let mut sync = run.min(if wide { 2 } else { SYNC_MAX });
    while sync > 1 && matches!(frames.mode(sync - 1).0, 0x00 | 0xFF) {
        sync -= 1;
    }
    sync
}

/// At rest the top byte of the rate is constant and looks like something else. It is taken back
/// when it is the sign of what follows. True when that happened.
fn extend_sign(
    frames: &Frames<'_>,
    moved: &mut [Moved],
    constant: &[bool],
    sync_len: usize,
) -> bool {
    let Some(rate) = moved.iter_mut().find(|moved| moved.field.role == Role::Rate) else {
        return false;
    };
    let field = &mut rate.field;
    let grown = field.bytes < 4 && frames.digit_bits == 8 && !field.only_channel_zero;
    let Some(top) =
        (if field.big_endian { field.at.checked_sub(1) } else { Some(field.at + field.bytes) })
    else {
        return false;
    };
    if !grown
        || field.coding != Coding::Twos
        || top < sync_len
        || !constant.get(top).is_some_and(|c| *c)
    {
        return false;
    }
    let sign = match frames.mode(top).0 {
        0x00 => false,
        0xFF => true,
        _ => return false,
    };
    let negative = |start: &usize| field.raw(frames.frame(*start), 8) < 0;
    if !frames.starts.iter().all(|start| negative(start) == sign) {
        return false;
    }
    field.at = field.at.min(top);
    field.bytes += 1;
    field.bits += 8;
    rate.motion.excursion /= 256.0;
    true
}

fn motions(moved: &[Moved]) -> (Motion, f64) {
    let of_rate = |moved: &&Moved| moved.field.role == Role::Rate;
    let rate = moved.iter().find(of_rate).map_or_else(Motion::default, |m| m.motion);
    let others = moved.iter().filter(|moved| !of_rate(moved) && moved.field.bytes > 1);
    (rate, others.map(|moved| moved.motion.excursion).fold(0.0, f64::max))
}

/// Whether the check is the catalogue's.
pub(crate) fn is_generic(check: &Check) -> bool {
    matches!(check.kind, CheckKind::Crc(crc) if crc.name == "generic")
}
