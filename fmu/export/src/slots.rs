//! Where instances live, and the tickets by which C knows them.
//!
//! The handle given to C is a ticket (place and generation), never an address. A null, freed or
//! made-up handle is therefore refused by comparing two numbers, and nothing that C may have
//! corrupted is ever followed. On the good path this costs two loads and a compare.

use crate::instance::Instance;
use std::ops::{Deref, DerefMut};
use std::ptr::{null_mut, without_provenance_mut};
use std::sync::atomic::{AtomicBool, AtomicPtr, AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

const PLACE_BITS: u32 = 14;
pub(crate) const CAPACITY: usize = 1 << PLACE_BITS;
/// No ticket: generations start higher.
const VACANT: usize = 0;
/// Where generations start: a small number that C made up is then never the ticket of an instance.
const FIRST_GENERATION: usize = 1 << 16;

struct Slot {
    ticket: AtomicUsize,
    /// A call is under way. Guards against an importer that calls back from its log callback.
    busy: AtomicBool,
    instance: AtomicPtr<Instance>,
}

static SLOTS: [Slot; CAPACITY] = [const {
    Slot {
        ticket: AtomicUsize::new(VACANT),
        busy: AtomicBool::new(false),
        instance: AtomicPtr::new(null_mut()),
    }
}; CAPACITY];

/// Which places are free, and how many tickets have been given out.
struct Vacancies {
    freed: Vec<usize>,
    never_used: usize,
    generation: usize,
}

static VACANCIES: Mutex<Vacancies> =
    Mutex::new(Vacancies { freed: Vec::new(), never_used: 0, generation: FIRST_GENERATION });

/// An opaque handle in C's hands.
pub(crate) type Handle = *mut std::ffi::c_void;

/// Takes an instance in and gives its ticket, or the instance back when all places are taken.
pub(crate) fn admit(instance: Box<Instance>) -> Result<Handle, Box<Instance>> {
    let mut vacancies = VACANCIES.lock().unwrap_or_else(PoisonError::into_inner);
    let place = match vacancies.freed.pop() {
        Some(place) => place,
        None if vacancies.never_used < CAPACITY => {
            vacancies.never_used += 1;
            vacancies.never_used - 1
        }
        None => return Err(instance),
    };
    vacancies.generation += 1;
    let ticket = (vacancies.generation << PLACE_BITS) | place;
    let slot = &SLOTS[place];
    slot.instance.store(Box::into_raw(instance), Ordering::Relaxed);
    slot.busy.store(false, Ordering::Relaxed);
    slot.ticket.store(ticket, Ordering::Release);
    Ok(without_provenance_mut(ticket))
}

/// The instance behind a handle, for the length of one call.
pub(crate) struct Claim {
    slot: &'static Slot,
    instance: *mut Instance,
}

/// Finds the instance behind `handle`; none if the handle is null, freed, made up, or in use by a
/// call further up the stack.
///
/// # Safety
/// No other thread may be inside a call with the same handle, as the FMI standard demands.
#[inline]
pub(crate) unsafe fn claim(handle: Handle) -> Option<Claim> {
    let ticket = handle.addr();
    let slot = &SLOTS[ticket & (CAPACITY - 1)];
    let known = slot.ticket.load(Ordering::Acquire) == ticket && ticket != VACANT;
    if !known || slot.busy.load(Ordering::Relaxed) {
        return None;
    }
    slot.busy.store(true, Ordering::Relaxed);
    Some(Claim { slot, instance: slot.instance.load(Ordering::Relaxed) })
}

impl Claim {
    /// Ends the instance: its ticket is void from now on.
    pub(crate) fn dismiss(self) -> Box<Instance> {
        let place = self.slot.ticket.swap(VACANT, Ordering::AcqRel) & (CAPACITY - 1);
        let instance = self.instance;
        std::mem::forget(self); // the place may have a new tenant before `self` would be dropped
        VACANCIES.lock().unwrap_or_else(PoisonError::into_inner).freed.push(place);
        // SAFETY: the pointer came from `Box::into_raw` in `admit`. Voiding the ticket above
        // makes this the only time that it is turned back.
        unsafe { Box::from_raw(instance) }
    }
}

impl Deref for Claim {
    type Target = Instance;

    #[inline]
    fn deref(&self) -> &Instance {
        // SAFETY: the slot's ticket was valid, so the box is alive; `busy` and the promise made to
        // `claim` keep every other call out.
        unsafe { &*self.instance }
    }
}

impl DerefMut for Claim {
    #[inline]
    fn deref_mut(&mut self) -> &mut Instance {
        // SAFETY: as for `deref`, and `self` is borrowed uniquely.
        unsafe { &mut *self.instance }
    }
}

impl Drop for Claim {
    #[inline]
    fn drop(&mut self) {
        self.slot.busy.store(false, Ordering::Relaxed);
    }
}
