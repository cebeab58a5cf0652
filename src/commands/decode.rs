//! `struna decode`.

use super::Outcome;
use crate::cli::Decode;
use crate::frames::frame_named_or_file;
use crate::output::write_whole;
use crate::progress::Progress;
use anyhow::{Context, Result, bail};
use std::fs::File;
use std::io::{self, Read, Write};
use std::path::Path;
use struna_wire::{Counters, Decoder, Frame, FrameSpec};

/// Bytes read at a time.
const PIECE: usize = 1 << 16;
/// Of a stream of these frames at least this share of the bytes belongs to frames.
const FRAME_SHARE_MIN: f64 = 0.1;

/// Goes through the file twice, so that nothing is written of one that holds something else.
pub(super) fn execute(args: &Decode) -> Result<Outcome> {
    let spec = frame_named_or_file(&args.frame)?;
    let unreadable = || format!("cannot read {}; check the path", args.file.display());
    let counters = decode(&args.file, &spec, "search", &mut |_| Ok(())).with_context(unreadable)?;
    refuse_another(&args.file, &spec, &counters)?;
    let rate_hz = args.rate_hz.unwrap_or(spec.timing().rate_hz);
    match args.csv.as_deref() {
        Some(csv) if csv == Path::new("-") => {
            let written = write_csv(&args.file, &spec, rate_hz, &mut io::stdout().lock());
            match written {
                // A reader that has seen enough may leave early.
                Err(error) if error.kind() == io::ErrorKind::BrokenPipe => (),
                written => written.with_context(unreadable)?,
            }
            complain(&told(&spec, &counters));
        }
        Some(csv) => {
            write_whole(csv, |out| write_csv(&args.file, &spec, rate_hz, out))?;
            println!(
                "{}\n{} frames written to {}",
                told(&spec, &counters),
                counters.ok,
                csv.display()
            );
        }
        None => println!("{}", told(&spec, &counters)),
    }
    Ok(Outcome::Complete)
}

#[expect(clippy::print_stderr, reason = "standard output holds the CSV")]
fn complain(text: &str) {
    eprintln!("{text}");
}

/// Decodes the whole file.
fn decode(
    path: &Path,
    spec: &FrameSpec,
    what: &str,
    sink: &mut dyn FnMut(&Frame) -> io::Result<()>,
) -> io::Result<Counters> {
    let mut file = File::open(path)?;
    let mut progress = Progress::of_length(file.metadata()?.len(), what);
    let mut decoder = Decoder::new(spec.clone());
    let mut piece = vec![0; PIECE];
    let mut outcome = Ok(());
    loop {
        let length = match file.read(&mut piece) {
            Ok(0) => break,
            Ok(length) => length,
            Err(error) if error.kind() == io::ErrorKind::Interrupted => continue,
            Err(error) => return Err(error),
        };
        decoder.push(&piece[..length], &mut |frame| {
            if outcome.is_ok() {
                outcome = sink(frame);
            }
        });
        std::mem::replace(&mut outcome, Ok(()))?;
        progress.reach(decoder.counters().bytes);
    }
    progress.finish();
    Ok(decoder.finish())
}

fn write_csv(file: &Path, spec: &FrameSpec, rate_hz: f64, out: &mut dyn Write) -> io::Result<()> {
    let mut csv = csv::Writer::from_writer(out);
    csv.write_record(header(spec)).map_err(io::Error::from)?;
    let mut row = Vec::new();
    decode(file, spec, "write", &mut |frame| {
        row.clear();
        cells(spec, frame, rate_hz, &mut row);
        csv.write_record(&row).map_err(io::Error::from)
    })?;
    csv.flush()
}

fn header(spec: &FrameSpec) -> Vec<String> {
    let mut header = ["index", "time_s"].map(str::to_owned).to_vec();
    for field in spec.fields() {
        header.push(format!("{}{}", field.name(), field.unit().si_suffix()));
    }
    for flag in spec.flags() {
        let taken = header.iter().any(|name| name == flag.name());
        header.push(format!("{}{}", flag.name(), if taken { "_flag" } else { "" }));
    }
    header.push("lost_before".to_owned());
    header
}

fn cells(spec: &FrameSpec, frame: &Frame, rate_hz: f64, row: &mut Vec<String>) {
    row.push(frame.index.to_string());
    row.push((frame.index as f64 / rate_hz).to_string());
    for (k, field) in spec.fields().iter().enumerate() {
        let value = frame.has(k).then(|| field.to_si(frame.raw()[k]).to_string());
        row.push(value.unwrap_or_default());
    }
    row.extend((0..spec.flags().len()).map(|k| u8::from(frame.flag(k)).to_string()));
    row.push(frame.lost_before.to_string());
}

/// Refuses a file of which next to nothing is such frames, and says what it holds.
fn refuse_another(path: &Path, spec: &FrameSpec, counters: &Counters) -> Result<()> {
    let file = path.display();
    if counters.bytes == 0 {
        bail!("{file} is empty; give a file of bytes as they came off the line");
    }
    let share = counters.frame_bytes as f64 / counters.bytes as f64;
    if counters.ok > 0 && share >= FRAME_SHARE_MIN {
        return Ok(());
    }
    let failed =
        counters.bad_check + counters.bad_sequence + counters.implausible + counters.unconfirmed;
    let good = counters.ok + counters.duplicates + counters.backward;
    let per_kb = |count: u64| 1e3 * count as f64 / counters.bytes as f64;
    bail!(
        "{file} holds no stream of {} frames: {} places in {} bytes look like the start of one, \
         {:.2} per kB against {:.2} expected, and {good} of them are good; try another frame \
         (`struna frame list`), or find the layout with `struna frame sniff`",
        spec.name(),
        failed + good,
        counters.bytes,
        per_kb(failed + good),
        1e3 / spec.wire_len() as f64
    )
}

/// What became of every byte and every frame.
fn told(spec: &FrameSpec, counters: &Counters) -> String {
    let Counters {
        bytes,
        ok,
        frame_bytes,
        bad_check,
        bad_sequence,
        implausible,
        unconfirmed,
        skipped_bytes,
        resyncs,
        locks,
        unlocks,
        sequence_gaps,
        lost,
        duplicates,
        backward,
    } = *counters;
    let losses = match spec.sequence() {
        Some(_) => format!(
            "lost            {lost} in {sequence_gaps} gaps, {duplicates} duplicates, {backward} \
             out of order"
        ),
        None => "lost            not observable: the frame has no counter".to_owned(),
    };
    format!(
        "{}\n\
         frames          {ok} of {bytes} bytes\n\
         {losses}\n\
         refused         {bad_check} by check, {bad_sequence} by counter, {implausible} \
         implausible, {unconfirmed} unconfirmed\n\
         bytes           {frame_bytes} in frames, {skipped_bytes} skipped\n\
         stream          found {locks} times, lost {unlocks} times, {resyncs} resynchronisations",
        spec.name()
    )
}
