//! What the two C interfaces do alike. The modules `fmi2` and `fmi3` only translate to it.

use crate::access::Element;
use crate::barrier::{enter, or_null};
use crate::c_array::{CInput, COutput};
use crate::instance::Instance;
use crate::log::{Log, LogCallback, LogCategory};
use crate::model::ModelType;
use crate::slots::{CAPACITY, Handle, admit};
use crate::status::{Reason, Refusal, Status};
use crate::variable::ValueReference;
use std::ffi::{CStr, CString, c_char};

/// What an importer asks for when it instantiates.
#[derive(Debug)]
pub(crate) struct Request {
    pub(crate) function: &'static str,
    pub(crate) instance_name: *const c_char,
    pub(crate) token: *const c_char,
    pub(crate) callback: LogCallback,
    pub(crate) logging_on: bool,
    /// What of the request is not supported, if anything.
    pub(crate) unsupported: Option<&'static str>,
}

/// Makes an instance of the model that the token picks; null and a log line if that is refused.
///
/// # Safety
/// The texts must be null or terminated, the callback null or callable.
pub(crate) unsafe fn instantiate(models: &'static [ModelType], request: &Request) -> Handle {
    or_null(|| {
        // SAFETY: promised by the caller.
        let (name, token) = unsafe { (text(request.instance_name), text(request.token)) };
        let picked = pick(models, name.as_deref(), token.as_deref(), request.unsupported);
        let log = Log::new(name.unwrap_or_default(), request.callback, request.logging_on);
        let refuse = |log: &Log, refusal: &Refusal| {
            log.write(LogCategory::Error, request.function, &refusal.to_string());
        };
        match picked {
            Ok(model_type) => admit(Box::new(Instance::new(model_type, log)))
                .map_err(|i| refuse(i.log(), &Reason::NoVacancy { capacity: CAPACITY }.into()))
                .ok(),
            Err(refusal) => {
                refuse(&log, &refusal);
                None
            }
        }
    })
}

fn pick(
    models: &'static [ModelType],
    name: Option<&CStr>,
    token: Option<&CStr>,
    unsupported: Option<&'static str>,
) -> Result<&'static ModelType, Refusal> {
    if let Some(asked) = unsupported {
        return Err(Reason::UnsupportedRequest { asked }.into());
    }
    if name.unwrap_or_default().to_bytes().trim_ascii().is_empty() {
        return Err(Reason::NoInstanceName.into());
    }
    let token = token.ok_or(Reason::NullPointer { argument: "instantiation token" })?;
    models.iter().find(|m| m.token == token.to_bytes()).ok_or_else(|| {
        let describe =
            |m: &ModelType| format!("{} {}", m.description.name, m.instantiation_token());
        let known = models.iter().map(describe).collect::<Vec<_>>().join(", ");
        Reason::UnknownToken { given: token.to_string_lossy().into_owned(), known }.into()
    })
}

/// A copy of a C text.
///
/// # Safety
/// `text` must be null or terminated.
unsafe fn text(text: *const c_char) -> Option<CString> {
    // SAFETY: not null, so terminated by the caller's promise.
    (!text.is_null()).then(|| unsafe { CStr::from_ptr(text) }.to_owned())
}

/// Reads variables of one type.
///
/// # Safety
/// The arrays must be null or hold that many elements; and as for [`enter`].
#[inline]
pub(crate) unsafe fn get<E: Element>(
    function: &'static str,
    handle: Handle,
    references: (*const ValueReference, usize),
    values: (*mut E::C, usize),
) -> Status {
    // SAFETY: promised by the caller.
    unsafe {
        enter(handle, function, |instance| {
            let references = CInput::new(references.0, references.1, "the value reference array")?;
            let values = COutput::new(values.0, values.1, "the value array")?;
            instance.get::<E>(references, values)
        })
    }
}

/// Writes variables of one type.
///
/// # Safety
/// As for [`get`].
#[inline]
pub(crate) unsafe fn set<E: Element>(
    function: &'static str,
    handle: Handle,
    references: (*const ValueReference, usize),
    values: (*const E::C, usize),
) -> Status {
    // SAFETY: promised by the caller.
    unsafe {
        enter(handle, function, |instance| {
            let references = CInput::new(references.0, references.1, "the value reference array")?;
            let values = CInput::new(values.0, values.1, "the value array")?;
            instance.set::<E>(references, values)
        })
    }
}

/// Switches log categories.
///
/// # Safety
/// `names` must be null or hold that many texts, each null or terminated; and as for [`enter`].
pub(crate) unsafe fn set_debug_logging(
    function: &'static str,
    handle: Handle,
    on: bool,
    names: (*const *const c_char, usize),
) -> Status {
    // SAFETY: promised by the caller.
    unsafe {
        enter(handle, function, |instance| {
            let names = CInput::new(names.0, names.1, "the category array")?;
            let read = |name| text(name).ok_or(Reason::NullPointer { argument: "a category" });
            let names = names.iter().map(read).collect::<Result<Vec<_>, _>>()?;
            let names = names.iter().map(|n| n.to_string_lossy().into_owned());
            instance.set_debug_logging(on, &names.collect::<Vec<_>>())
        })
    }
}

/// Runs `call` with the FMU state that `target` points at and writes the result back.
unsafe fn with_state(
    function: &'static str,
    handle: Handle,
    target: *mut Handle,
    call: impl FnOnce(&mut Instance, Handle) -> Result<Handle, Refusal>,
) -> Status {
    // SAFETY: promised by the caller; `target` is read and written only if it is not null.
    unsafe {
        enter(handle, function, |instance| {
            if target.is_null() {
                return Err(Reason::NullPointer { argument: "the FMU state pointer" }.into());
            }
            target.write_unaligned(call(instance, target.read_unaligned())?);
            Ok(())
        })
    }
}

/// Saves the state.
///
/// # Safety
/// `target` must be null, or point at null or a state; and as for [`enter`].
pub(crate) unsafe fn get_state(
    function: &'static str,
    handle: Handle,
    target: *mut Handle,
) -> Status {
    // SAFETY: promised by the caller.
    unsafe { with_state(function, handle, target, Instance::save_state) }
}

/// Restores a saved state.
///
/// # Safety
/// As for [`enter`].
pub(crate) unsafe fn set_state(function: &'static str, handle: Handle, state: Handle) -> Status {
    // SAFETY: promised by the caller.
    unsafe { enter(handle, function, |instance| instance.restore_state(state)) }
}

/// Frees a saved state and makes its pointer null. A null pointer is fine.
///
/// # Safety
/// As for [`get_state`].
pub(crate) unsafe fn free_state(
    function: &'static str,
    handle: Handle,
    target: *mut Handle,
) -> Status {
    let free = |instance: &mut Instance, state| {
        instance.free_state(state)?;
        Ok(std::ptr::null_mut())
    };
    let mut nothing = std::ptr::null_mut();
    let target = if target.is_null() { &raw mut nothing } else { target };
    // SAFETY: promised by the caller.
    unsafe { with_state(function, handle, target, free) }
}

/// Tells how many bytes a serialized state takes.
///
/// # Safety
/// `size` must be null or writable; and as for [`enter`].
pub(crate) unsafe fn serialized_state_size(
    function: &'static str,
    handle: Handle,
    state: Handle,
    size: *mut usize,
) -> Status {
    // SAFETY: promised by the caller.
    unsafe {
        enter(handle, function, |instance| {
            let mut size = COutput::new(size, 1, "the size pointer")?;
            size.fill(std::iter::once(instance.serialized_state_len(state)?));
            Ok(())
        })
    }
}

/// Writes a serialized state.
///
/// # Safety
/// `bytes` must be null or hold that many bytes; and as for [`enter`].
pub(crate) unsafe fn serialize_state(
    function: &'static str,
    handle: Handle,
    state: Handle,
    bytes: (*mut u8, usize),
) -> Status {
    // SAFETY: promised by the caller.
    unsafe {
        enter(handle, function, |instance| {
            let mut buffer = COutput::new(bytes.0, bytes.1, "the buffer")?;
            let serialized = instance.serialize_state(state)?;
            if buffer.len() < serialized.len() {
                let (given, needed) = (buffer.len(), serialized.len());
                return Err(Reason::BufferTooSmall { given, needed }.into());
            }
            buffer.fill(serialized.into_iter());
            Ok(())
        })
    }
}

/// Reads a serialized state back.
///
/// # Safety
/// `bytes` must be null or hold that many bytes, which nobody writes to during the call; `target`
/// as for [`get_state`]; and as for [`enter`].
pub(crate) unsafe fn deserialize_state(
    function: &'static str,
    handle: Handle,
    bytes: (*const u8, usize),
    target: *mut Handle,
) -> Status {
    let read = |instance: &mut Instance, state| {
        if bytes.0.is_null() {
            return Err(Reason::NullPointer { argument: "the serialized state" }.into());
        }
        // No object is longer than this; a longer claim would break the promise of a slice.
        let len = bytes.1.min(isize::MAX.cast_unsigned());
        // SAFETY: promised by the caller.
        let bytes = unsafe { std::slice::from_raw_parts(bytes.0, len) };
        instance.deserialize_state(bytes, state)
    };
    // SAFETY: promised by the caller.
    unsafe { with_state(function, handle, target, read) }
}
