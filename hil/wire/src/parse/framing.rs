//! The kind of frame, and what each kind alone declares.

use super::layout::{Layout, whole};
use crate::SequenceSpec;
use crate::framing::{Framing, Kind, Text};
use crate::{CheckSpec, FieldSpec, MAX_FIELDS, MAX_FRAME_LEN, MAX_LINE_LEN, MAX_SYNC_LEN};
use struna_settings::{Result, Table, Value};

const KINDS: [(&str, Kind); 4] = [
    ("fixed", Kind::Fixed),
    ("septet", Kind::Septet),
    ("cobs", Kind::Cobs),
    ("ascii", Kind::Ascii),
];
const SEPARATORS: [(&str, u8); 2] = [(" ", b' '), (",", b',')];
/// The marker of a septet frame, unless the file says otherwise.
const MARKER: u8 = 0x80;

pub(super) fn kind(table: &Table<'_>) -> Result<Kind> {
    table.required("kind")?.word(&KINDS)
}

/// Keys of `[frame]` that belong to this kind.
pub(super) const fn keys(kind: Kind) -> &'static [&'static str] {
    match kind {
        Kind::Fixed => &["sync", "sync_mask", "len"],
        Kind::Septet => &["sync", "len"],
        Kind::Cobs => &["len"],
        Kind::Ascii => &["sync", "separator", "columns"],
    }
}

/// The frame before anything is put into it.
pub(super) struct Frame {
    pub(super) sync: Vec<u8>,
    /// Empty when all bits of the sync word count.
    pub(super) mask: Vec<u8>,
    pub(super) len: usize,
    /// Separator and number of columns of a line.
    pub(super) text: Option<(u8, usize)>,
    pub(super) layout: Layout,
}

pub(super) fn frame(table: &Table<'_>, kind: Kind) -> Result<Frame> {
    if kind == Kind::Ascii {
        return line_of_text(table);
    }
    let len = table.required("len")?.integer_in(1..=MAX_FRAME_LEN)?;
    let mut layout = Layout::of_bytes(len);
    let (sync, mask) = match kind {
        Kind::Fixed => fixed_sync(table, &mut layout)?,
        Kind::Septet => (marker(table, &mut layout)?, Vec::new()),
        _ => (Vec::new(), Vec::new()),
    };
    Ok(Frame { sync, mask, len, text: None, layout })
}

fn line_of_text(table: &Table<'_>) -> Result<Frame> {
    let columns = table.required("columns")?.integer_in(1..=MAX_FIELDS)?;
    let separator = table.required("separator")?.word(&SEPARATORS)?;
    let sync = match table.optional("sync") {
        Some(value) => {
            let sync = hex(&value)?;
            let printable = |byte: &u8| byte.is_ascii_graphic() || *byte == separator;
            if !sync.iter().all(printable) || sync.contains(&b'*') {
                return Err(value.out_of_range("printable ASCII without \"*\", as \"24\" for $"));
            }
            // Else a column could pass for the beginning of a line.
            if sync[0].is_ascii_hexdigit() || b".- ,".contains(&sync[0]) {
                let expected = "first a character that no number holds, as \"24\" for $";
                return Err(value.out_of_range(expected));
            }
            sync
        }
        None => Vec::new(),
    };
    let (text, layout) = (Some((separator, columns)), Layout::of_columns(columns));
    Ok(Frame { sync, mask: Vec::new(), len: 8 * columns, text, layout })
}

fn fixed_sync(table: &Table<'_>, layout: &mut Layout) -> Result<(Vec<u8>, Vec<u8>)> {
    let value = table.required("sync")?;
    let sync = hex(&value)?;
    layout.within(&value, 0, sync.len())?;
    let mut footprint = whole(0, sync.len());
    let Some(mask_value) = table.optional("sync_mask") else {
        layout.claim(&value, footprint, None)?;
        return Ok((sync, Vec::new()));
    };
    let mask = hex(&mask_value)?;
    if mask.len() != sync.len() || mask[0] == 0 {
        let expected = format!("{} bytes like `sync`, with a bit set in the first", sync.len());
        return Err(mask_value.out_of_range(expected));
    }
    if let Some(at) = (0..sync.len()).find(|k| sync[*k] & !mask[*k] != 0) {
        let reason = format!("byte {at} of `sync` has bits set that do not count; clear them");
        return Err(mask_value.because(reason));
    }
    footprint[..mask.len()].copy_from_slice(&mask);
    layout.claim(&value, footprint, None)?;
    let all = mask.iter().all(|byte| *byte == 0xFF);
    Ok((sync, if all { Vec::new() } else { mask }))
}

fn marker(table: &Table<'_>, layout: &mut Layout) -> Result<Vec<u8>> {
    let Some(value) = table.optional("sync") else {
        layout.claim(&table.required("kind")?, whole(0, 1), None)?;
        return Ok(vec![MARKER]);
    };
    let sync = hex(&value)?;
    if sync.len() != 1 || sync[0] < 0x80 {
        return Err(value.out_of_range("one byte with bit 7 set, as \"80\""));
    }
    layout.claim(&value, whole(0, 1), None)?;
    Ok(sync)
}

fn hex(value: &Value<'_>) -> Result<Vec<u8>> {
    let refusal = || value.out_of_range(format!("1 to {MAX_SYNC_LEN} bytes in hex, as \"A5 5A\""));
    let is_byte = |word: &&str| word.len() == 2 && word.bytes().all(|c| c.is_ascii_hexdigit());
    let words: Vec<_> = value.text()?.split_ascii_whitespace().take(MAX_SYNC_LEN + 1).collect();
    if words.is_empty() || words.len() > MAX_SYNC_LEN || !words.iter().all(is_byte) {
        return Err(refusal());
    }
    words.iter().map(|word| u8::from_str_radix(word, 16).map_err(|_| refusal())).collect()
}

/// What the decoder needs to know of the kind, once the rest is read.
pub(super) fn framing(
    table: &Table<'_>,
    kind: Kind,
    mask: Vec<u8>,
    text: Option<(u8, usize)>,
    (sync, check, fields, sequence): (&[u8], &CheckSpec, &[FieldSpec], Option<SequenceSpec>),
) -> Result<Framing> {
    let (separator, columns) = match (kind, text) {
        (Kind::Ascii, Some(text)) => text,
        (Kind::Septet, _) => return Ok(Framing::Septet),
        (Kind::Cobs, _) => return Ok(Framing::Cobs),
        _ => return Ok(Framing::Fixed { mask }),
    };
    let text = Text::new(sync, separator, columns, check, (fields, sequence.as_ref()));
    if text.longest > MAX_LINE_LEN {
        return Err(table.required("columns")?.because(format!(
            "a line can have {} bytes, at most {MAX_LINE_LEN} are read; lower `digits` or \
             `columns`",
            text.longest
        )));
    }
    Ok(Framing::Ascii(text))
}
