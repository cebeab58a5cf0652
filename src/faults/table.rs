//! The table for people, and the same for programs.

use super::matrix::{Ablation, Matrix, Row, StreamMatrix};
use std::fmt;
use std::io::{self, Write};
use struna_harness::monitor::{Detector, Observability};
use struna_kernel::RAD_PER_DEG;

/// A precision below this is marked.
const PRECISION_MARKED: f64 = 0.95;
/// A recall below this is no recall worth printing.
const RECALL_SHOWN: f64 = 0.005;

impl fmt::Display for Matrix {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for stream in &self.streams {
            write!(f, "{stream}")?;
        }
        ablation(f, self)?;
        write!(
            f,
            "\nRecall of each detector; a dot is none, * a precision below {PRECISION_MARKED:.2}. \
             Delay: median, of the quickest that finds\nnine in ten. \"not observable\" says that \
             one gyro cannot show the fault, never that there is none."
        )
    }
}

impl fmt::Display for StreamMatrix {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}: {}", self.stream.name(), self.stream.describe())?;
        self.write_limits(f)?;
        write!(f, "{:<27}", "fault")?;
        for detector in Detector::ALL {
            write!(f, "{:>6} ", detector.name())?;
        }
        writeln!(f, "{:>9}", "delay")?;
        let mut notes = Vec::new();
        for row in &self.rows {
            write_row(f, row, &mut notes)?;
        }
        for (k, note) in notes.iter().enumerate() {
            writeln!(f, "  ({}) not observable: {note}", letter(k))?;
        }
        self.write_clean(f)?;
        writeln!(f)
    }
}

impl StreamMatrix {
    fn write_limits(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let limits = &self.limits;
        let deg_s = |rad_s: f64| rad_s / RAD_PER_DEG;
        let stuck = limits.stuck_samples.map_or("none".to_owned(), |samples| samples.to_string());
        writeln!(
            f,
            "limits: stuck {stuck} samples, step {:.2} deg/s, innovation {:.2} deg/s \
             ({:.1} sigma), variance {:.0}, rest {:.3} deg/s",
            deg_s(limits.step_rad_s),
            deg_s(limits.innovation_rad_s),
            limits.innovation_rad_s / limits.innovation_sigma_rad_s,
            limits.variance,
            deg_s(limits.rest_rad_s),
        )
    }

    fn write_clean(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let clean = &self.clean;
        if clean.hours <= 0.0 {
            return Ok(());
        }
        write!(f, "clean, {} h: ", clean.hours)?;
        let raised = Detector::ALL.into_iter().filter(|d| clean.alarms[d.index()] > 0);
        let raised: Vec<_> = raised
            .map(|d| {
                let alarms = clean.alarms[d.index()];
                format!("{} {alarms} (at most {:.2}/h)", d.name(), clean.bound_per_hour(d))
            })
            .collect();
        let none = format!("at most {:.3}/h with 95 %", 3.0 / clean.hours);
        if raised.is_empty() {
            return writeln!(f, "no alarm of any detector; {none} each");
        }
        writeln!(f, "{}; no other alarm, {none} each", raised.join(", "))
    }
}

fn letter(k: usize) -> char {
    char::from(b'a' + u8::try_from(k % 26).unwrap_or(0))
}

fn write_row(f: &mut fmt::Formatter<'_>, row: &Row, notes: &mut Vec<&'static str>) -> fmt::Result {
    let note = match row.observability {
        Observability::Observable => None,
        Observability::NotObservable(reason) => {
            let at = notes.iter().position(|note| *note == reason).unwrap_or_else(|| {
                notes.push(reason);
                notes.len() - 1
            });
            Some(letter(at))
        }
    };
    let name = format!("{} {}", row.case.kind.name(), row.case.size);
    write!(f, "{:<27}", name.trim_end())?;
    for detector in Detector::ALL {
        write!(f, "{} ", cell(row, detector))?;
    }
    match (note, row.quickest()) {
        (Some(note), _) => writeln!(f, "  not o.({note})"),
        (None, Some((_, delay_s))) => writeln!(f, "{:>6.0} ms", delay_s * 1e3),
        (None, None) => writeln!(f, "{:>9}", "-"),
    }
}

/// Six columns.
fn cell(row: &Row, detector: Detector) -> String {
    let recall = row.recall(detector);
    let precision = row.cells[detector.index()].precision();
    let mark = if precision.is_some_and(|p| p < PRECISION_MARKED) { '*' } else { ' ' };
    match recall {
        r if r < RECALL_SHOWN && mark == ' ' => format!("{:>5} ", "·"),
        r if r > 0.995 => format!("{:>5}{mark}", "1.00"),
        r => format!("{:>5}{mark}", format!("{r:.2}").trim_start_matches('0')),
    }
}

fn ablation(f: &mut fmt::Formatter<'_>, matrix: &Matrix) -> fmt::Result {
    writeln!(
        f,
        "Without a part of the set, these are lost (found before, by how many of a hundred after):"
    )?;
    for (k, (part, _)) in Ablation::PARTS.iter().enumerate() {
        let mut lost = Vec::new();
        for stream in &matrix.streams {
            for row in &stream.rows {
                if row.ablation.is_lost_without(k, row.events) {
                    let share = f64::from(row.ablation.without[k]) / f64::from(row.events.max(1));
                    let name = row.case.kind.name();
                    lost.push(format!("{name} on {} {:.0}", stream.stream.name(), share * 100.0));
                }
            }
        }
        let lost = if lost.is_empty() { "nothing".to_owned() } else { lost.join(", ") };
        writeln!(f, "{}", wrapped(&format!("  {part}: {lost}")))?;
    }
    Ok(())
}

/// Breaks a line at its commas so that it stays within the terminal.
fn wrapped(line: &str) -> String {
    let mut out = String::new();
    let mut columns = 0;
    for part in line.split_inclusive(", ") {
        if columns + part.len() > 118 {
            out.truncate(out.trim_end().len());
            out.push_str("\n      ");
            columns = 6;
        }
        out.push_str(part);
        columns += part.len();
    }
    out
}

/// Writes every cell of `matrix` as CSV, one line each.
///
/// # Errors
/// What the writer says.
pub fn write_csv(matrix: &Matrix, out: &mut dyn Write) -> io::Result<()> {
    writeln!(
        out,
        "stream,fault,size,observable,detector,events,found,recall,alarms,true_alarms,precision,\
         delay_median_s"
    )?;
    for stream in &matrix.streams {
        for row in &stream.rows {
            for detector in Detector::ALL {
                let cell = &row.cells[detector.index()];
                let number = |x: Option<f64>| x.map_or(String::new(), |x| x.to_string());
                let seen = row.observability == Observability::Observable;
                writeln!(
                    out,
                    "{},{},{},{seen},{},{},{},{},{},{},{},{}",
                    stream.stream.name(),
                    row.case.kind.name(),
                    row.case.size,
                    detector.name(),
                    row.events,
                    cell.found,
                    row.recall(detector),
                    cell.alarms,
                    cell.true_alarms,
                    number(cell.precision()),
                    number(cell.delay_s),
                )?;
            }
        }
    }
    write_clean(matrix, out)
}

/// Clean time, as a fault without a name of which every alarm is false.
fn write_clean(matrix: &Matrix, out: &mut dyn Write) -> io::Result<()> {
    for stream in &matrix.streams {
        for detector in Detector::ALL {
            let alarms = stream.clean.alarms[detector.index()];
            let (name, hours) = (stream.stream.name(), stream.clean.hours);
            writeln!(out, "{name},none,{hours} h,,{},0,0,,{alarms},0,,", detector.name())?;
        }
    }
    Ok(())
}
