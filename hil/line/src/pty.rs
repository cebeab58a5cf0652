//! Pseudo-terminals: the two ends of a serial line that exists in software.

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::fd::OwnedFd;
use rustix::io::{Errno, ioctl_fionbio, ioctl_fionread};
use rustix::pty::{OpenptFlags, grantpt, ioctl_tiocgptpeer, openpt, ptsname, unlockpt};
use rustix::termios::{OptionalActions, tcgetattr, tcsetattr};
use std::ffi::OsString;
use std::os::unix::ffi::OsStringExt;
use std::path::PathBuf;

pub(crate) const NO_WAIT: Timespec = Timespec { tv_sec: 0, tv_nsec: 0 };
const FLAGS: OpenptFlags = OpenptFlags::RDWR.union(OpenptFlags::NOCTTY).union(OpenptFlags::CLOEXEC);

/// Both ends in raw mode, the device's without blocking.
#[derive(Debug)]
pub(crate) struct Pair {
    /// The device's end.
    pub(crate) master: OwnedFd,
    /// The host's end.
    pub(crate) slave: OwnedFd,
    /// The node under which anybody can open the host's end.
    pub(crate) path: PathBuf,
}

impl Pair {
    /// Makes a pair; `baud` is what the host's end is set to until somebody sets it otherwise.
    pub(crate) fn open(baud: Option<u32>) -> Result<Self, Errno> {
        let master = openpt(FLAGS)?;
        grantpt(&master)?;
        unlockpt(&master)?;
        let name = ptsname(&master, Vec::new())?;
        let slave = peer(&master)?;
        let mut termios = tcgetattr(&slave)?;
        termios.make_raw();
        if let Some(baud) = baud {
            termios.set_speed(baud)?;
        }
        tcsetattr(&slave, OptionalActions::Now, &termios)?;
        ioctl_fionbio(&master, true)?;
        let path = PathBuf::from(OsString::from_vec(name.into_bytes()));
        Ok(Self { master, slave, path })
    }
}

/// Opens the host's end of `master` once more.
pub(crate) fn peer(master: &OwnedFd) -> Result<OwnedFd, Errno> {
    ioctl_tiocgptpeer(master, FLAGS)
}

/// Whether bytes wait in the host's end.
pub(crate) fn has_unread_bytes(slave: &OwnedFd) -> Result<bool, Errno> {
    if ioctl_fionread(slave)? > 0 {
        return Ok(true);
    }
    // Unlike the count, this moves queued bytes along before it answers.
    let mut readable = [PollFd::new(slave, PollFlags::IN)];
    Ok(ignore_interruption(poll(&mut readable, Some(&NO_WAIT)))? > 0)
}

/// An interrupted wait is answered like one that saw something: the caller looks again.
pub(crate) fn ignore_interruption(outcome: Result<usize, Errno>) -> Result<usize, Errno> {
    match outcome {
        Err(Errno::INTR) => Ok(1),
        other => other,
    }
}
