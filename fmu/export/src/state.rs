//! Everything about an instance that evolves, and its two forms as bytes.
//!
//! A snapshot (the body) lives inside the instance; the serialized form wraps it in a mark, the
//! model's token, a length and a checksum, for it will have been in strange hands.

use crate::instance::{Experiment, Phase};
use crate::model::{ModelType, Running};
use crate::sha256::{Digest, Sha256};
use crate::slots::Handle;
use crate::status::{BadState, Reason, Refusal};
use crate::values::Values;
use std::collections::BTreeMap;
use std::ptr::without_provenance_mut;
use std::sync::atomic::{AtomicUsize, Ordering};

/// What a saved state brings back.
#[derive(Debug)]
pub(crate) struct State {
    pub(crate) phase: Phase,
    /// None until the importer has set it up.
    pub(crate) experiment: Option<Experiment>,
    /// The model, from the end of initialisation on.
    pub(crate) running: Option<Box<dyn Running>>,
    pub(crate) values: Values,
    /// The outputs on demand are still those of an earlier step.
    pub(crate) owed: bool,
}

impl State {
    /// The state after instantiation.
    pub(crate) fn fresh(model_type: &ModelType) -> Self {
        let values = Values::starting(model_type.description.variables);
        Self { phase: Phase::Instantiated, experiment: None, running: None, values, owed: false }
    }

    /// Brings the outputs on demand up to the last step.
    #[cold]
    pub(crate) fn settle(&mut self) {
        if let (true, Some(running)) = (self.owed, &self.running) {
            running.write_outputs_on_demand(&mut self.values);
        }
        self.owed = false;
    }

    /// The body: phase, experiment, values, and the model's own bytes to the end. No output may
    /// be owed: a restored model need not know how it came to its outputs.
    pub(crate) fn to_body(&self) -> Vec<u8> {
        debug_assert!(!self.owed, "outputs on demand are saved before they are settled");
        let experiment = self.experiment.unwrap_or(Experiment { start_s: 0.0, stop_s: 0.0 });
        let mut body = vec![self.phase as u8, u8::from(self.experiment.is_some())];
        body.extend(experiment.start_s.to_le_bytes());
        body.extend(experiment.stop_s.to_le_bytes());
        body.extend(self.values.all_bits().iter().flat_map(|bits| bits.to_le_bytes()));
        if let Some(running) = &self.running {
            running.save(&mut body);
        }
        body
    }

    pub(crate) fn from_body(model_type: &ModelType, body: &[u8]) -> Result<Self, Refusal> {
        let mut rest = body;
        let [phase, experiment_known] = take(&mut rest)?;
        let start_s = f64::from_le_bytes(take(&mut rest)?);
        let stop_s = f64::from_le_bytes(take(&mut rest)?);
        let mut state = Self::fresh(model_type);
        for bits in state.values.all_bits_mut() {
            *bits = u64::from_le_bytes(take(&mut rest)?);
        }
        state.experiment = (experiment_known != 0).then_some(Experiment { start_s, stop_s });
        state.phase = match phase {
            0 => Phase::Instantiated,
            1 => Phase::Initialization,
            2 => Phase::Step,
            3 => Phase::Terminated,
            _ => return Err(BadState::Content.into()),
        };
        if state.phase >= Phase::Step {
            state.running = Some((model_type.restore)(&state.values, rest)?);
        } else if !rest.is_empty() {
            return Err(BadState::Content.into());
        }
        Ok(state)
    }
}

fn take<const N: usize>(rest: &mut &[u8]) -> Result<[u8; N], BadState> {
    let (head, tail) = rest.split_first_chunk().ok_or(BadState::Content)?;
    *rest = tail;
    Ok(*head)
}

/// The states that an instance has saved, by ticket. A ticket is given out once in the life of the
/// library, so a freed one, or one of another instance, is recognised.
#[derive(Debug, Default)]
pub(crate) struct Snapshots(BTreeMap<usize, Vec<u8>>);

static TICKETS: AtomicUsize = AtomicUsize::new(1);

impl Snapshots {
    /// Keeps `body` under the ticket `at`, or under a new one when `at` is null.
    pub(crate) fn keep(&mut self, at: Handle, body: Vec<u8>) -> Result<Handle, Refusal> {
        if at.is_null() {
            let ticket = TICKETS.fetch_add(1, Ordering::Relaxed);
            self.0.insert(ticket, body);
            return Ok(without_provenance_mut(ticket));
        }
        *self.0.get_mut(&at.addr()).ok_or(Reason::UnknownState)? = body;
        Ok(at)
    }

    pub(crate) fn body(&self, at: Handle) -> Result<&[u8], Refusal> {
        Ok(self.0.get(&at.addr()).ok_or(Reason::UnknownState)?)
    }

    /// Forgets a state; null is fine.
    pub(crate) fn free(&mut self, at: Handle) -> Result<(), Refusal> {
        if at.is_null() || self.0.remove(&at.addr()).is_some() {
            return Ok(());
        }
        Err(Reason::UnknownState.into())
    }
}

/// What every serialized state begins with; the last byte is the version of the layout.
const MARK: &[u8; 8] = b"STRUNA\0\x01";
const TOKEN_LEN: usize = 64;
const HEADER_LEN: usize = MARK.len() + TOKEN_LEN + size_of::<u64>();

/// The length of [`serialize`]'s result for a body of `body_len` bytes.
pub(crate) fn serialized_len(body_len: usize) -> usize {
    HEADER_LEN + body_len + size_of::<Digest>()
}

/// Mark, token, body length, body, checksum over all before it.
pub(crate) fn serialize(model_type: &ModelType, body: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(serialized_len(body.len()));
    bytes.extend(MARK);
    bytes.extend(model_type.token);
    bytes.extend((body.len() as u64).to_le_bytes());
    bytes.extend(body);
    bytes.extend(Sha256::of(&bytes));
    bytes
}

/// The body within `bytes`, once all that wraps it has been found right.
pub(crate) fn deserialize<'a>(
    model_type: &ModelType,
    bytes: &'a [u8],
) -> Result<&'a [u8], Refusal> {
    let mut rest = bytes.strip_prefix(MARK).ok_or(BadState::Mark)?;
    if take::<TOKEN_LEN>(&mut rest).map_err(|_| BadState::Mark)? != model_type.token {
        return Err(BadState::OtherModel.into());
    }
    let declared = u64::from_le_bytes(take(&mut rest).map_err(|_| BadState::Mark)?);
    let body = rest.split_last_chunk::<{ size_of::<Digest>() }>();
    let Some((body, checksum)) = body.filter(|(body, _)| body.len() as u64 == declared) else {
        return Err(BadState::Length { given: bytes.len(), declared }.into());
    };
    if Sha256::of(&bytes[..HEADER_LEN + body.len()]) != *checksum {
        return Err(BadState::Checksum.into());
    }
    Ok(body)
}
