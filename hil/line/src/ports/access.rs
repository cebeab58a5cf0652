//! Whether a device can be opened, found out without opening it.

use rustix::fs::{Access, AtFlags, CWD, accessat};
use std::fmt;
use std::fs;
use std::os::unix::fs::MetadataExt;
use std::path::Path;

/// Whether this user can open a port.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub enum PortAccess {
    /// Yes.
    Free,
    /// Somebody has it open for himself.
    InUse {
        /** Who: a process and its name. */
        by: String,
    },
    /// This user may not.
    Denied {
        /** The group that may. */
        group: Option<String>,
    },
    /// It has gone meanwhile.
    Gone,
}

impl fmt::Display for PortAccess {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Free => write!(f, "free"),
            Self::InUse { by } => write!(f, "in use by {by}"),
            Self::Denied { group: Some(group) } => write!(f, "not allowed: join group {group}"),
            Self::Denied { group: None } => write!(f, "not allowed"),
            Self::Gone => write!(f, "gone"),
        }
    }
}

/// Whether `device` can be opened.
pub(super) fn of(device: &Path) -> PortAccess {
    let Ok(meta) = fs::metadata(device) else { return PortAccess::Gone };
    // By the effective user, as opening would be judged.
    let may = accessat(CWD, device, Access::READ_OK | Access::WRITE_OK, AtFlags::EACCESS);
    if may.is_err() {
        return PortAccess::Denied { group: group_with_access(device) };
    }
    let locks = fs::read_to_string("/proc/locks").unwrap_or_default();
    match holder(&locks, meta.dev(), meta.ino()) {
        Some(process) => PortAccess::InUse { by: named(process) },
        None => PortAccess::Free,
    }
}

/// The group that may read and write `device`, by name or else by number.
pub(crate) fn group_with_access(device: &Path) -> Option<String> {
    let meta = fs::metadata(device).ok()?;
    let may = meta.mode() & 0o060 == 0o060;
    let groups = fs::read_to_string("/etc/group").unwrap_or_default();
    may.then(|| group_name(&groups, meta.gid()).unwrap_or_else(|| meta.gid().to_string()))
}

fn group_name(groups: &str, gid: u32) -> Option<String> {
    let entry = |line: &str| {
        let mut parts = line.split(':');
        let (name, _, number) = (parts.next()?, parts.next()?, parts.next()?);
        (number.parse() == Ok(gid)).then(|| name.to_owned())
    };
    groups.lines().find_map(entry)
}

/// The process that holds a lock on the file, by the kernel's list of locks.
///
/// Programs that open a serial port for themselves lock it, this one among them. The list gives
/// the device in hexadecimal, major and minor number, and the file's number.
fn holder(locks: &str, dev: u64, ino: u64) -> Option<u32> {
    let (major, minor) = (rustix::fs::major(dev), rustix::fs::minor(dev));
    let file = format!("{major:02x}:{minor:02x}:{ino}");
    let entry = |line: &str| {
        let words: Vec<_> = line.split_whitespace().collect();
        let at = words.iter().position(|word| *word == file)?;
        words.get(at.checked_sub(1)?)?.parse().ok()
    };
    locks.lines().filter(|line| !line.contains("->")).find_map(entry)
}

fn named(process: u32) -> String {
    match fs::read_to_string(format!("/proc/{process}/comm")) {
        Ok(name) => format!("{} (process {process})", name.trim_end()),
        Err(_) => format!("process {process}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_kernels_list_of_locks_names_the_holder() {
        let locks = "1: POSIX  ADVISORY  WRITE 812 00:1a:3 0 EOF\n\
                     2: FLOCK  ADVISORY  WRITE 4711 00:18:3 0 EOF\n\
                     2: -> FLOCK  ADVISORY  WRITE 4712 00:18:3 0 EOF\n";
        let dev = rustix::fs::makedev(0, 0x18);
        assert_eq!(holder(locks, dev, 3), Some(4711));
        assert_eq!(holder(locks, dev, 4), None);
        assert_eq!(holder("nonsense\n00:18:3\n", dev, 3), None);
    }

    #[test]
    fn a_group_is_named_by_its_number() {
        let groups = "root:x:0:\nbroken\ndialout:x:20:ann,bob\n";
        assert_eq!(group_name(groups, 20).as_deref(), Some("dialout"));
        assert_eq!(group_name(groups, 21), None);
    }

    #[test]
    fn what_is_not_there_is_gone() {
        assert_eq!(of(Path::new("/dev/no-such-port")), PortAccess::Gone);
    }
}
