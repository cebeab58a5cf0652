//! Who owns each bit of the frame.

use crate::MAX_FRAME_LEN;
use crate::field::When;
use struna_settings::{Result, SettingsError, Value};

/// The bits taken so far. In a line of text a column counts as a byte.
pub(super) struct Layout {
    len: usize,
    unit: &'static str,
    claims: Vec<Claim>,
}

struct Claim {
    owner: String,
    mask: [u8; MAX_FRAME_LEN],
    when: Option<When>,
}

impl Layout {
    pub(super) fn of_bytes(len: usize) -> Self {
        Self { len, unit: "byte", claims: Vec::new() }
    }

    pub(super) fn of_columns(len: usize) -> Self {
        Self { len, unit: "column", claims: Vec::new() }
    }

    pub(super) fn last(&self) -> usize {
        self.len - 1
    }

    /// Refuses a `value` that would reach byte `last`.
    pub(super) fn beyond(&self, value: &Value<'_>, last: usize) -> Box<SettingsError> {
        let (unit, end) = (self.unit, self.last());
        let key = if unit == "byte" { "frame.len" } else { "frame.columns" };
        value.because(format!(
            "reaches {unit} {last}, but the frame ends at {unit} {end}; move it or raise `{key}`"
        ))
    }

    /// Refuses a `value` whose `bytes` bytes from `at` would leave the frame.
    pub(super) fn within(&self, value: &Value<'_>, at: usize, bytes: usize) -> Result<()> {
        let last = at + bytes - 1;
        if last > self.last() { Err(self.beyond(value, last)) } else { Ok(()) }
    }

    /// Gives the bits of `mask` to the thing whose place `value` states. Two things may share bits
    /// only when no frame carries both.
    pub(super) fn claim(
        &mut self,
        value: &Value<'_>,
        mask: [u8; MAX_FRAME_LEN],
        when: Option<When>,
    ) -> Result<()> {
        for claim in &self.claims {
            let apart = match (claim.when, when) {
                (Some(theirs), Some(ours)) => !theirs.meets(&ours),
                _ => false,
            };
            let shared = claim.mask.iter().zip(&mask).position(|(theirs, ours)| theirs & ours != 0);
            if let Some(at) = shared.filter(|_| !apart) {
                return Err(value.because(self.twice(claim, at, &mask, when)));
            }
        }
        let path = value.path();
        let owner = path.strip_suffix(".at").or(path.strip_suffix(".column")).unwrap_or(path);
        self.claims.push(Claim { owner: owner.to_owned(), mask, when });
        Ok(())
    }

    fn twice(&self, claim: &Claim, at: usize, mask: &[u8], when: Option<When>) -> String {
        let (unit, owner) = (self.unit, &claim.owner);
        let whole = claim.mask[at] == 0xFF && mask[at] == 0xFF;
        let bits = if whole || unit == "column" { "" } else { "bits of " };
        let remedy = match (claim.when, when) {
            (Some(_), Some(_)) => "move one of them, or let their `when` exclude each other",
            _ => "move one of them",
        };
        format!(
            "{bits}{unit} {at} already belong{} to {owner}; {remedy}",
            if bits.is_empty() { "s" } else { "" }
        )
    }

    /// The first bit of bytes `first` to `last` that nobody owns, as byte and bit; the highest bit
    /// of a byte comes first.
    pub(super) fn free_bit(&self, first: usize, last: usize) -> Option<(usize, u32)> {
        (first..=last).find_map(|at| {
            let taken = self.claims.iter().fold(0, |taken, claim| taken | claim.mask[at]);
            (taken != 0xFF).then(|| (at, 7 - (!taken).leading_zeros()))
        })
    }
}

/// Bytes `at` to `at + bytes - 1`, whole.
pub(super) fn whole(at: usize, bytes: usize) -> [u8; MAX_FRAME_LEN] {
    let mut mask = [0; MAX_FRAME_LEN];
    mask[at..at + bytes].fill(0xFF);
    mask
}
