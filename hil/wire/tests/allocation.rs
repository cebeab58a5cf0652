//! Once warm, neither the encoder nor the decoder allocates, whatever the bytes.

#![expect(unsafe_code, reason = "a global allocator cannot be written without it")]

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use struna_wire::{Decoder, Encoder, FrameSpec};

struct Counting;

thread_local! {
    /// Per thread, so that the test harness's own threads do not disturb the count.
    static ALLOCATIONS: Cell<u64> = const { Cell::new(0) };
}

// SAFETY: every call is handed on unchanged to the system allocator, which keeps the contract;
// the counter is a plain thread-local cell that needs neither allocation nor destructor.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATIONS.set(ALLOCATIONS.get() + 1);
        // SAFETY: the caller's promise about `layout` is passed on.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: `pointer` came from `System` with this `layout`.
        unsafe { System.dealloc(pointer, layout) }
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        ALLOCATIONS.set(ALLOCATIONS.get() + 1);
        // SAFETY: `pointer` came from `System` with this `layout`, and `size` is the caller's.
        unsafe { System.realloc(pointer, layout, size) }
    }
}

#[global_allocator]
static GLOBAL: Counting = Counting;

fn allocations(during: impl FnOnce()) -> u64 {
    let before = ALLOCATIONS.get();
    during();
    ALLOCATIONS.get() - before
}

#[test]
fn a_warm_encoder_and_decoder_allocate_nothing() {
    let spec = FrameSpec::from_toml(include_str!("../../../frames/vg910d.toml")).unwrap();
    let mut encoder = Encoder::new(&spec);
    let mut decoder = Decoder::new(spec);
    let mut bytes = Vec::new();
    let round = |encoder: &mut Encoder, decoder: &mut Decoder, bytes: &mut Vec<u8>| {
        bytes.clear();
        for raw in 0..1000 {
            encoder.encode(&[raw, -raw, 1], bytes).unwrap();
            // Noise that looks like a start, so that the resynchronisation runs too.
            bytes.extend_from_slice(&[0xA5, 0x5A, 0xA5]);
        }
        for chunk in bytes.chunks(62) {
            decoder.push(chunk, &mut |frame| assert_eq!(frame.raw()[2], 1));
        }
    };
    assert!(allocations(|| round(&mut encoder, &mut decoder, &mut bytes)) > 0, "counter is dead");
    let warm = allocations(|| {
        for _ in 0..10 {
            round(&mut encoder, &mut decoder, &mut bytes);
        }
    });
    assert_eq!(warm, 0);
    assert_eq!(decoder.counters().ok, 11_000);
}
