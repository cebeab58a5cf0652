//! Which ports there are, real and virtual, and whether this user can have them.
//!
//! No port is opened to find out: opening a USB adapter raises its control lines, which restarts
//! many a board.

mod access;

pub use access::PortAccess;
pub(crate) use access::group_with_access;

use serialport::SerialPortType;
use std::collections::BTreeMap;
use std::fs;
use std::os::unix::fs::FileTypeExt;
use std::path::{Path, PathBuf};

/// Where Linux keeps names of serial devices that outlive replugging.
const BY_ID: &str = "/dev/serial/by-id";
/// Entries of one directory that are looked at.
const ENTRIES_MAX: usize = 1000;

/// What a port is.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub enum PortKind {
    /// A USB adapter.
    Usb {
        /** Vendor. */
        vid: u16,
        /** Product. */
        pid: u16,
        /** Serial number, if it has one. */
        serial: Option<String>,
        /** Its own name, if it has one. */
        product: Option<String>,
    },
    /// A pseudo-terminal behind a link.
    Virtual,
    /// Anything else: on the board, Bluetooth, PCI.
    Other,
}

/// A port.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PortInfo {
    /// The name to open it by: the one that stays the same when the device is plugged in again.
    pub name: PathBuf,
    /// The device node behind the name at present.
    pub device: PathBuf,
    /// What it is.
    pub kind: PortKind,
    /// Whether it can be opened.
    pub access: PortAccess,
}

/// The directory in which emulators leave links to their ports, when the system has a place for
/// it.
#[must_use]
pub fn link_directory() -> Option<PathBuf> {
    let runtime = std::env::var_os("XDG_RUNTIME_DIR").filter(|path| !path.is_empty())?;
    Some(Path::new(&runtime).join("struna"))
}

/// The ports of this machine: what the system lists, and links to pseudo-terminals, which it does
/// not list, in [`link_directory`] and in `directories`.
///
/// What cannot be read is not there: the list is as good as this user's rights.
#[must_use]
pub fn ports(directories: &[PathBuf]) -> Vec<PortInfo> {
    let mut found = BTreeMap::new();
    let stable = stable_names(Path::new(BY_ID));
    for port in serialport::available_ports().unwrap_or_default() {
        let device = PathBuf::from(port.port_name);
        let name = stable.get(&device).unwrap_or(&device).clone();
        let port =
            PortInfo { access: access::of(&device), kind: kind(port.port_type), name, device };
        found.insert(port.name.clone(), port);
    }
    for directory in link_directory().iter().chain(directories) {
        for (name, device) in links(directory) {
            let is_pseudo = device.starts_with("/dev/pts");
            let kind = if is_pseudo { PortKind::Virtual } else { PortKind::Other };
            let access = access::of(&device);
            found.entry(name.clone()).or_insert(PortInfo { name, device, kind, access });
        }
    }
    found.into_values().collect()
}

/// The port that `path` leads to.
#[must_use]
pub fn port_at(path: &Path) -> Option<PortInfo> {
    let device = fs::canonicalize(path).ok()?;
    let listed = ports(&[]).into_iter().find(|port| port.device == device);
    let kind = match listed {
        Some(port) => port.kind,
        None if device.starts_with("/dev/pts") => PortKind::Virtual,
        None => PortKind::Other,
    };
    let access = access::of(&device);
    Some(PortInfo { name: path.to_owned(), device, kind, access })
}

fn kind(listed: SerialPortType) -> PortKind {
    match listed {
        SerialPortType::UsbPort(usb) => PortKind::Usb {
            vid: usb.vid,
            pid: usb.pid,
            serial: usb.serial_number,
            product: usb.product,
        },
        _ => PortKind::Other,
    }
}

/// Stable names by device node.
fn stable_names(directory: &Path) -> BTreeMap<PathBuf, PathBuf> {
    links(directory).into_iter().map(|(name, device)| (device, name)).collect()
}

/// Symbolic links in `directory` that lead to character devices, and the devices.
fn links(directory: &Path) -> Vec<(PathBuf, PathBuf)> {
    let Ok(entries) = fs::read_dir(directory) else { return Vec::new() };
    let is_link = |path: &PathBuf| path.is_symlink();
    let leads_to = |link: PathBuf| {
        let device = fs::canonicalize(&link).ok()?;
        let is_device = fs::metadata(&device).is_ok_and(|meta| meta.file_type().is_char_device());
        is_device.then_some((link, device))
    };
    let paths = entries.take(ENTRIES_MAX).filter_map(|entry| Some(entry.ok()?.path()));
    let mut found: Vec<_> = paths.filter(is_link).filter_map(leads_to).collect();
    found.sort();
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{SerialReader, VirtualPort};
    use std::os::unix::fs::symlink;

    #[test]
    fn a_link_to_a_pseudo_terminal_is_a_port_and_other_files_are_none() {
        let folder = tempfile::tempdir().unwrap();
        let mut port = VirtualPort::open().unwrap();
        let link = folder.path().join("gyro");
        port.link_at(&link).unwrap();
        fs::write(folder.path().join("notes.txt"), "no port").unwrap();
        symlink("/dev/pts/no-such", folder.path().join("dangling")).unwrap();
        symlink(folder.path().join("notes.txt"), folder.path().join("to-a-file")).unwrap();
        let found = links(folder.path());
        assert_eq!(found, [(link.clone(), port.path().to_owned())]);
        let listed = ports(&[folder.path().to_owned()]);
        let listed = listed.iter().find(|port| port.name == link).unwrap();
        assert_eq!((&listed.kind, &listed.access), (&PortKind::Virtual, &PortAccess::Free));
    }

    #[test]
    fn a_port_that_is_read_is_in_use_until_its_reader_goes() {
        let port = VirtualPort::open().unwrap();
        let access = || port_at(port.path()).unwrap().access;
        assert_eq!(access(), PortAccess::Free);
        let reader = SerialReader::open(port.path(), 115_200).unwrap();
        let PortAccess::InUse { by } = access() else { panic!("{:?}", access()) };
        assert!(by.contains(&std::process::id().to_string()), "{by}");
        drop(reader);
        assert_eq!(access(), PortAccess::Free);
    }

    #[test]
    fn a_stable_name_belongs_to_its_device() {
        let folder = tempfile::tempdir().unwrap();
        let port = VirtualPort::open().unwrap();
        let name = folder.path().join("usb-FTDI_FT232R_A1-if00-port0");
        symlink(port.path(), &name).unwrap();
        assert_eq!(stable_names(folder.path()).get(port.path()), Some(&name));
    }
}
