//! `--port auto`: the port that speaks the frame.

use super::serial::{SerialSource, WallClock};
use anyhow::{Result, bail};
use std::path::PathBuf;
use struna_harness::live::{ByteSource, HostClock, SourceRead};
use struna_kernel::SimTime;
use struna_line::{PortAccess, PortInfo, PortKind, ports};
use struna_wire::{Decoder, FrameSpec};

/// How long each port is listened to.
const LISTENED: SimTime = SimTime::from_ns(2_000_000_000);
/// Good frames after which a port is the one. No noise passes that many checks.
const FRAMES: u64 = 3;
/// Ports that are listened to at most.
const PORTS_MAX: usize = 16;

/// The only port there is, or else the only one that speaks `frame` at `baud`.
///
/// # Errors
/// When there is none, or several, with what was found of each.
pub fn port(frame: &FrameSpec, baud: u32) -> Result<PathBuf> {
    let all = ports(&[]);
    let free = candidates(&all);
    match free.as_slice() {
        [] => bail!("no port is free{}; see `struna ports`", list(&all, &[])),
        [only] => return Ok(only.name.clone()),
        _ => {}
    }
    let heard: Vec<_> = free
        .iter()
        .take(PORTS_MAX)
        .map(|port| match SerialSource::open(&port.name, baud) {
            Ok(mut source) => frames(frame, &mut source, &mut WallClock::start()),
            Err(_) => 0,
        })
        .collect();
    let speaking: Vec<_> =
        free.iter().zip(&heard).filter(|(_, frames)| **frames >= FRAMES).collect();
    match speaking.as_slice() {
        [(port, _)] => Ok(port.name.clone()),
        [] => bail!("no port speaks {}{}; name one", frame.name(), list(&free, &heard)),
        _ => bail!("several ports speak {}{}; name one", frame.name(), list(&free, &heard)),
    }
}

/// Those that may be the gyro: USB and virtual ones, or any if there are no such.
fn candidates(all: &[PortInfo]) -> Vec<PortInfo> {
    let free = |port: &&PortInfo| port.access == PortAccess::Free;
    let likely = |port: &&PortInfo| port.kind != PortKind::Other;
    let best: Vec<_> = all.iter().filter(free).filter(likely).cloned().collect();
    if best.is_empty() { all.iter().filter(free).cloned().collect() } else { best }
}

fn list(ports: &[PortInfo], heard: &[u64]) -> String {
    let line = |(k, port): (usize, &PortInfo)| {
        let frames = heard.get(k).map_or(String::new(), |frames| format!(", {frames} frames"));
        format!("\n  {} ({}{frames})", port.name.display(), port.access)
    };
    let lines: String = ports.iter().enumerate().map(line).collect();
    if lines.is_empty() { lines } else { format!(":{lines}\n") }
}

/// Good frames heard within [`LISTENED`]; no more than needed.
fn frames(frame: &FrameSpec, source: &mut dyn ByteSource, clock: &mut dyn HostClock) -> u64 {
    let mut decoder = Decoder::new(frame.clone());
    let mut buffer = [0; 4096];
    let end = clock.now().as_ns().saturating_add(LISTENED.as_ns());
    while clock.now().as_ns() < end && decoder.counters().ok < FRAMES {
        match source.read(&mut buffer) {
            SourceRead::Bytes(n) => decoder.push(&buffer[..n], &mut |_| {}),
            SourceRead::Idle => {}
            SourceRead::Lost(_) => break,
        }
    }
    decoder.counters().ok
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;
    use struna_wire::Encoder;

    /// Gives the same bytes over and over, 20 ms apart.
    struct Script(Vec<u8>);

    impl ByteSource for Script {
        fn read(&mut self, buffer: &mut [u8]) -> SourceRead {
            buffer[..self.0.len()].copy_from_slice(&self.0);
            if self.0.is_empty() { SourceRead::Idle } else { SourceRead::Bytes(self.0.len()) }
        }

        fn reopen(&mut self) -> bool {
            true
        }
    }

    /// Goes on by 20 ms each time it is looked at.
    struct Steps(i64);

    impl HostClock for Steps {
        fn now(&mut self) -> SimTime {
            self.0 += 20_000_000;
            SimTime::from_ns(self.0)
        }

        fn wait(&mut self, _span: SimTime) {}
    }

    fn spec() -> FrameSpec {
        FrameSpec::from_toml(&super::super::setup::frame_text("struna/vg910d@1").unwrap()).unwrap()
    }

    #[test]
    fn frames_are_told_from_noise_and_silence() {
        let frame = spec();
        let mut encoder = Encoder::new(&frame);
        let mut bytes = Vec::new();
        (0..4).for_each(|_| encoder.encode(&[0; 3], &mut bytes).unwrap());
        assert!(frames(&frame, &mut Script(bytes), &mut Steps(0)) >= FRAMES);
        assert_eq!(frames(&frame, &mut Script(vec![0xA5, 0x5A, 1]), &mut Steps(0)), 0);
        assert_eq!(frames(&frame, &mut Script(Vec::new()), &mut Steps(0)), 0);
    }

    #[test]
    fn usb_and_virtual_ports_come_before_those_on_the_board() {
        let port = |name: &str, kind, access| PortInfo {
            name: Path::new(name).to_owned(),
            device: Path::new(name).to_owned(),
            kind,
            access,
        };
        let board = port("/dev/ttyS0", PortKind::Other, PortAccess::Free);
        let pty = port("/run/struna/vg910d", PortKind::Virtual, PortAccess::Free);
        let denied =
            port("/run/struna/other", PortKind::Virtual, PortAccess::Denied { group: None });
        let all = [board.clone(), pty.clone(), denied];
        assert_eq!(candidates(&all), [pty]);
        assert_eq!(candidates(&all[..1]), [board]);
    }
}
