//! `struna ports`.

use super::Outcome;
use crate::cli::Ports;
use anyhow::Result;
use serde::Serialize;
use std::collections::BTreeSet;
use std::io::{self, Write};
use struna_line::{PortAccess, PortInfo, PortKind, link_directory, ports};

const HEADINGS: [&str; 4] = ["port", "device", "what", "access"];

pub(super) fn execute(args: &Ports) -> Result<Outcome> {
    let found = ports(&args.directories);
    let text = if args.json {
        let listed: Vec<_> = found.iter().map(Listed::of).collect();
        serde_json::to_string_pretty(&listed)? + "\n"
    } else if found.is_empty() {
        none(args)
    } else {
        table(&found)
    };
    let mut out = io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        // A reader that has seen enough may leave early.
        Err(error) if error.kind() == io::ErrorKind::BrokenPipe => Ok(Outcome::Complete),
        written => Ok(written.map(|()| Outcome::Complete)?),
    }
}

fn none(args: &Ports) -> String {
    let places: Vec<_> = link_directory()
        .iter()
        .chain(&args.directories)
        .map(|place| place.display().to_string())
        .collect();
    let looked = if places.is_empty() {
        "XDG_RUNTIME_DIR is not set, so no virtual ports were looked for; name a place with --dir"
            .to_owned()
    } else {
        format!("no virtual one in {}", places.join(", "))
    };
    format!("no serial port is present; {looked}\n")
}

fn table(ports: &[PortInfo]) -> String {
    let cells = |port: &PortInfo| {
        let (name, device) = (port.name.display(), port.device.display());
        [name.to_string(), device.to_string(), what(&port.kind), port.access.to_string()]
    };
    let rows: Vec<_> =
        std::iter::once(HEADINGS.map(str::to_owned)).chain(ports.iter().map(cells)).collect();
    let width = |k: usize| rows.iter().map(|row| row[k].chars().count()).max().unwrap_or(0);
    let widths: [usize; 4] = std::array::from_fn(width);
    let line = |row: &[String; 4]| {
        let padded = row.iter().zip(widths).map(|(cell, width)| format!("{cell:<width$}  "));
        padded.collect::<String>().trim_end().to_owned() + "\n"
    };
    let mut text: String = rows.iter().map(line).collect();
    for group in missing_groups(ports) {
        text += &format!(
            "\nto open ports of group {group}: sudo usermod -aG {group} $USER, then log in again\n"
        );
    }
    text
}

fn missing_groups(ports: &[PortInfo]) -> BTreeSet<&str> {
    let mut groups = BTreeSet::new();
    for port in ports {
        if let PortAccess::Denied { group: Some(group) } = &port.access {
            groups.insert(group.as_str());
        }
    }
    groups
}

fn what(kind: &PortKind) -> String {
    match kind {
        PortKind::Usb { vid, pid, serial, product } => {
            let product = product.as_deref().unwrap_or("USB adapter");
            let serial = serial.as_ref().map_or(String::new(), |serial| format!(", {serial}"));
            format!("{product} ({vid:04x}:{pid:04x}{serial})")
        }
        PortKind::Virtual => "virtual".to_owned(),
        _ => "serial".to_owned(),
    }
}

/// A port for other programs.
#[derive(Debug, Serialize)]
struct Listed<'a> {
    name: String,
    device: String,
    kind: &'static str,
    vid: Option<u16>,
    pid: Option<u16>,
    serial: Option<&'a str>,
    product: Option<&'a str>,
    access: &'static str,
    in_use_by: Option<&'a str>,
    missing_group: Option<&'a str>,
}

impl<'a> Listed<'a> {
    fn of(port: &'a PortInfo) -> Self {
        let (kind, usb) = match &port.kind {
            PortKind::Usb { vid, pid, serial, product } => {
                ("usb", Some((*vid, *pid, serial.as_deref(), product.as_deref())))
            }
            PortKind::Virtual => ("virtual", None),
            _ => ("other", None),
        };
        let (access, in_use_by, missing_group) = match &port.access {
            PortAccess::Free => ("free", None, None),
            PortAccess::InUse { by } => ("in-use", Some(by.as_str()), None),
            PortAccess::Denied { group } => ("denied", None, group.as_deref()),
            _ => ("gone", None, None),
        };
        Self {
            name: port.name.display().to_string(),
            device: port.device.display().to_string(),
            kind,
            vid: usb.map(|(vid, ..)| vid),
            pid: usb.map(|(_, pid, ..)| pid),
            serial: usb.and_then(|(_, _, serial, _)| serial),
            product: usb.and_then(|(.., product)| product),
            access,
            in_use_by,
            missing_group,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::PathBuf;

    fn adapter() -> PortInfo {
        PortInfo {
            name: PathBuf::from("/dev/serial/by-id/usb-FTDI_A1-if00-port0"),
            device: PathBuf::from("/dev/ttyUSB0"),
            kind: PortKind::Usb {
                vid: 0x0403,
                pid: 0x6001,
                serial: Some("A1".to_owned()),
                product: Some("FT232R USB UART".to_owned()),
            },
            access: PortAccess::Denied { group: Some("dialout".to_owned()) },
        }
    }

    #[test]
    fn the_table_names_adapter_and_missing_group_once() {
        let text = table(&[adapter(), adapter()]);
        assert!(text.contains("FT232R USB UART (0403:6001, A1)"), "{text}");
        assert!(text.contains("not allowed: join group dialout"), "{text}");
        assert_eq!(text.matches("sudo usermod -aG dialout $USER").count(), 1, "{text}");
    }

    #[test]
    fn the_json_holds_every_part() {
        let port = adapter();
        let json = serde_json::to_value(Listed::of(&port)).unwrap();
        assert_eq!(json["vid"], 0x0403);
        assert_eq!(json["serial"], "A1");
        assert_eq!(
            (json["access"].as_str(), json["missing_group"].as_str()),
            (Some("denied"), Some("dialout"))
        );
    }
}
