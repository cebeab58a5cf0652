//! The one door through which C enters.
//!
//! Every exported function that takes an instance passes here: the handle is checked, a panic is
//! stopped before it can unwind into the importer, and whatever is refused is logged.
//!
//! **Architecture Invariant:** no exported function touches an instance except through [`enter`]
//! and [`leave`].

use crate::instance::{Instance, Phase};
use crate::log::LogCategory;
use crate::slots::{self, Handle};
use crate::status::{ERROR, FATAL, OK, Reason, Refusal, Status};
use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};

/// Runs one call on the instance behind `handle`.
///
/// # Safety
/// No other thread may be inside a call with the same handle.
#[inline]
pub(crate) unsafe fn enter(
    handle: Handle,
    function: &'static str,
    call: impl FnOnce(&mut Instance) -> Result<(), Refusal>,
) -> Status {
    // SAFETY: promised by the caller.
    let Some(mut claim) = (unsafe { slots::claim(handle) }) else { return ERROR };
    let instance = &mut *claim;
    if instance.phase() == Phase::Fatal {
        return refuse_for_ever(instance, function);
    }
    match catch_unwind(AssertUnwindSafe(|| call(instance))) {
        Ok(Ok(())) => OK,
        Ok(Err(refusal)) => log_refusal(instance, function, &refusal),
        Err(payload) => poison(instance, function, payload),
    }
}

/// Ends the instance behind `handle`; anything that is not an instance is ignored.
///
/// # Safety
/// No other thread may be inside a call with the same handle.
pub(crate) unsafe fn leave(handle: Handle) {
    // SAFETY: promised by the caller.
    let Some(claim) = (unsafe { slots::claim(handle) }) else { return };
    let instance = claim.dismiss();
    if let Err(payload) = catch_unwind(AssertUnwindSafe(|| drop(instance))) {
        std::mem::forget(payload); // see `poison`
    }
}

/// Refuses a function that no model here supports.
///
/// # Safety
/// No other thread may be inside a call with the same handle.
#[doc(hidden)]
#[must_use]
pub unsafe fn refuse(handle: Handle, function: &'static str, reason: &'static str) -> Status {
    // SAFETY: promised by the caller.
    unsafe { enter(handle, function, |_| Err(Reason::Unsupported { reason }.into())) }
}

/// Stops a panic outside any instance, which has only a null handle to answer with.
pub(crate) fn or_null(call: impl FnOnce() -> Option<Handle>) -> Handle {
    match catch_unwind(AssertUnwindSafe(call)) {
        Ok(handle) => handle.unwrap_or(std::ptr::null_mut()),
        Err(payload) => {
            std::mem::forget(payload); // see `poison`
            std::ptr::null_mut()
        }
    }
}

#[cold]
fn log_refusal(instance: &Instance, function: &'static str, refusal: &Refusal) -> Status {
    instance.log().write(LogCategory::Error, function, &refusal.to_string());
    ERROR
}

#[cold]
fn refuse_for_ever(instance: &Instance, function: &'static str) -> Status {
    let message = "the instance was lost in an earlier panic and can only be freed";
    instance.log().write(LogCategory::Fatal, function, message);
    FATAL
}

#[cold]
fn poison(instance: &mut Instance, function: &'static str, payload: Box<dyn Any + Send>) -> Status {
    instance.poison();
    let said = payload
        .downcast_ref::<&str>()
        .copied()
        .or_else(|| payload.downcast_ref::<String>().map(String::as_str))
        .unwrap_or("no message");
    instance.log().write(LogCategory::Fatal, function, &format!("the model panicked: {said}"));
    // A payload may panic again when dropped, and nothing would stop that one.
    std::mem::forget(payload);
    FATAL
}
