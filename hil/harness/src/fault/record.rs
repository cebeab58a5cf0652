//! The truth about what was done.

use super::FaultKind;
use std::io::{self, Write};
use struna_kernel::SimTime;

/// One event that was injected.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FaultRecord {
    /// Number of the event in the run, from 0, in the order in which events began.
    pub id: u64,
    /// Which fault of the plan, from 0.
    pub fault: usize,
    /// What it was.
    pub kind: FaultKind,
    /// Gyro time of the first sample it took hold of.
    pub start: SimTime,
    /// Gyro time of the first sample that was free of it; of a fault of one sample, its start.
    pub end: SimTime,
    /// Index of the first sample it took hold of.
    pub first_sample: u64,
    /// And of the last.
    pub last_sample: u64,
    /// The bytes concerned, as places in the stream that a sound gyro would have sent: first, and
    /// one past the last. Faults of single bytes name those; all others whole frames.
    pub clean_bytes: (u64, u64),
    /// The place in the stream as sent at which it begins, and at which it has ended.
    pub sent_bytes: (u64, u64),
    /// Its size in the unit of [`FaultKind::magnitude`]: as planned or, where chance decides, as
    /// drawn (bit, counts, bytes left over).
    pub magnitude: f64,
}

/// Writes `records` as CSV.
///
/// # Errors
/// What the writer says.
pub fn write_fault_csv(records: &[FaultRecord], out: &mut dyn Write) -> io::Result<()> {
    writeln!(
        out,
        "id,fault,kind,stage,start_s,end_s,first_sample,last_sample,clean_first_byte,\
         clean_end_byte,sent_first_byte,sent_end_byte,magnitude,magnitude_unit"
    )?;
    for r in records {
        writeln!(
            out,
            "{},{},{},{},{},{},{},{},{},{},{},{},{},{}",
            r.id,
            r.fault,
            r.kind.name(),
            r.kind.stage().name(),
            r.start.as_s(),
            r.end.as_s(),
            r.first_sample,
            r.last_sample,
            r.clean_bytes.0,
            r.clean_bytes.1,
            r.sent_bytes.0,
            r.sent_bytes.1,
            r.magnitude,
            r.kind.magnitude().1,
        )?;
    }
    Ok(())
}
