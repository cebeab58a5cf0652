//! Arguments of the commands about frames.

use super::positive;
use clap::{Args, Subcommand};
use std::path::PathBuf;

/// Frame commands.
#[derive(Debug, Subcommand)]
pub enum Frame {
    /// Propose the layout of an unknown gyro's frames from its bytes
    #[command(after_help = "Examples:
  struna frame sniff --port /dev/ttyUSB0
  struna frame sniff --port /dev/ttyUSB0 --baud 115200 --seconds 20 --out my-gyro.toml
  struna frame sniff --file capture.bin --seconds 8
  struna frame sniff --file monday.bin --second tuesday.bin --rate-hz 300 --out my-gyro.toml

Keep the gyro still for 3 s, then turn it by hand both ways for 5 s. A layout is \"confirmed\" only
when it has read bytes that it was not made from. Scale and sign are never in the bytes.")]
    Sniff(FrameSniff),
    /// List the shipped layouts
    #[command(after_help = "Example:
  struna frame list")]
    List,
    /// Tell what layouts can and cannot do; exit code 1 for one that cannot be decoded uniquely
    #[command(after_help = "Examples:
  struna frame lint struna/vg910d@1
  struna frame lint my-gyro.toml other-gyro.toml")]
    Lint(FrameLint),
}

/// Arguments of `struna frame lint`.
#[derive(Debug, Args)]
pub struct FrameLint {
    /// Frame files, or names of shipped layouts
    #[arg(value_name = "FILE|NAME", required = true)]
    pub frames: Vec<String>,
}

/// Arguments of `struna frame sniff`.
#[derive(Debug, Args)]
pub struct FrameSniff {
    /// Serial port to capture from
    #[arg(long, value_name = "PORT", required_unless_present = "file", conflicts_with = "file")]
    pub port: Option<PathBuf>,
    /// File of raw bytes
    #[arg(long, value_name = "CAPTURE")]
    pub file: Option<PathBuf>,
    /// Another capture of the same gyro, to test the proposal on
    #[arg(long, value_name = "FILE", conflicts_with = "port")]
    pub second: Option<PathBuf>,
    /// Baud rate of the port, or auto to try the usual ones
    #[arg(long, value_name = "auto|N", default_value = "auto", value_parser = baud)]
    pub baud: Baud,
    /// How long to capture [default: 8], or how long the file took
    #[arg(long, value_name = "S", value_parser = positive, conflicts_with = "rate_hz")]
    pub seconds: Option<f64>,
    /// Frame rate, if it is known
    #[arg(long, value_name = "F", value_parser = positive)]
    pub rate_hz: Option<f64>,
    /// Frame file to write; a capture from a port is put beside it [default: print, or
    /// out/sniffed.toml with --port]
    #[arg(long, value_name = "FRAME.toml")]
    pub out: Option<PathBuf>,
    /// Name of the layout
    #[arg(long, value_name = "NAME", default_value = "sniffed@1")]
    pub name: String,
}

/// Which baud rate to open a port at.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Baud {
    /// The usual one at which bytes make most sense.
    Auto,
    /// This one.
    At(u32),
}

fn baud(text: &str) -> Result<Baud, &'static str> {
    if text == "auto" {
        return Ok(Baud::Auto);
    }
    let number = text.parse().ok().filter(|baud| *baud > 0);
    number.map(Baud::At).ok_or("write auto or a whole number above 0")
}

/// Arguments of `struna decode`.
#[derive(Debug, Args)]
pub struct Decode {
    /// File of raw bytes
    #[arg(value_name = "FILE")]
    pub file: PathBuf,
    /// Frame file, or name of a shipped layout
    #[arg(long, value_name = "FILE|NAME")]
    pub frame: String,
    /// CSV file to write; - for standard output
    #[arg(long, value_name = "FILE")]
    pub csv: Option<PathBuf>,
    /// Frame rate for the column of times, in place of the layout's nominal one
    #[arg(long, value_name = "HZ", value_parser = positive)]
    pub rate_hz: Option<f64>,
}
