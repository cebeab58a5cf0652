//! Once made, a listener allocates nothing, whatever the bytes and whenever they come.

use struna_harness::monitor::{AlarmChange, Declared, Listener};
use struna_kernel::SimTime;
use struna_wire::{Encoder, FrameSpec};

fn allocations(during: impl FnOnce()) -> u64 {
    allocation_counter::measure(during).count_total
}

#[test]
fn a_listener_allocates_nothing_while_it_listens() {
    let spec = FrameSpec::from_toml(include_str!("../../../frames/vg910d.toml")).unwrap();
    let declared = Declared {
        sample_rate_hz: 300.0,
        frame_len: 11,
        counter_modulus: Some(256),
        rate_max_rad_s: 3.5,
        lsb_rad_s: 5e-7,
        noise_sigma_rad_s: 3.5e-4,
        noise_bandwidth_hz: None,
        acceleration_max_rad_s2: 4.0,
        bias_max_rad_s: 1e-4,
    };
    let (mut bytes, mut encoder) = (Vec::new(), Encoder::new(&spec));
    for k in 0..3000 {
        // Values that jump, repeat and saturate, frames that are missing, and false starts.
        let raw = if k % 500 < 20 { 6_553_600 } else { (k % 7) * 40_000 };
        let from = bytes.len();
        encoder.encode(&[raw, 0, 1], &mut bytes).unwrap();
        if k % 97 == 0 {
            bytes.truncate(from);
            bytes.extend_from_slice(&[0xA5, 0x5A, 0xA5]);
        }
    }
    let mut listener = Listener::new(spec, &declared).unwrap();
    let mut raised = 0_u32;
    listener.monitor().declare_rest(true);
    let made = allocations(|| {
        for (k, chunk) in (0..).zip(bytes.chunks(53)) {
            let arrival = SimTime::from_ns(k * 16_000_000 + (k / 100) * 90_000_000);
            listener.push(arrival, chunk, &mut |change| {
                raised += u32::from(matches!(change, AlarmChange::Raised(_)));
            });
        }
    });
    assert_eq!(made, 0);
    assert!(allocations(|| drop(vec![raised])) > 0, "the counter is dead");
    assert!(raised > 20, "{raised} alarms");
}
