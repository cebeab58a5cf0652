//! The emulated device's end of a virtual serial line.

use crate::StopFlag;
use crate::link::DeviceLink;
use crate::pty::{Pair, has_unread_bytes, ignore_interruption};
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::io::Errno;
use std::io;
use std::path::{Path, PathBuf};

/// How long a wait lasts before the stop flag is looked at again. Only how soon a cancelled run
/// ends depends on it.
pub(crate) const STOP_CHECK: Timespec = Timespec { tv_sec: 0, tv_nsec: 20_000_000 };
/// How long draining waits between two looks: the kernel announces no "empty".
pub(crate) const DRAIN_CHECK: Timespec = Timespec { tv_sec: 0, tv_nsec: 1_000_000 };
/// Looks at an empty line that prove it empty, see [`VirtualPort::drain`].
pub(crate) const EMPTY_LOOKS: u32 = 32;

/// Why a virtual port could not be made or used.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum VirtualPortError {
    /// The system gave no pseudo-terminal.
    #[error(
        "cannot make a pseudo-terminal: {source}; check that /dev/pts is mounted and that \
         /proc/sys/kernel/pty/max is not reached"
    )]
    Open {
        /** What the system said. */
        source: io::Error,
    },
    /// The link to the port could not be made.
    #[error("cannot make the link {}: {source}; give a free path in an existing directory that \
         you may write", link.display())]
    Link {
        /** The link asked for. */
        link: PathBuf,
        /** What went wrong. */
        source: io::Error,
    },
    /// The run was stopped while the port waited for its reader.
    #[error("stopped while waiting for the reader of the virtual port; {done} bytes had passed")]
    Stopped {
        /** Bytes of this call that had passed by then. */
        done: usize,
    },
    /// The system refused to move bytes.
    #[error("the virtual port failed: {source}")]
    Transfer {
        /** What the system said. */
        source: io::Error,
    },
}

/// A serial port that exists in software: a pseudo-terminal with a device node to open.
///
/// The writer is held back when the reader is slow, as no real line could do, so that a run as
/// fast as possible loses nothing. The port keeps the far side open itself: bytes written before
/// the reader arrives wait for it, and a reader may close and open again. The price is that a
/// reader which dies is not noticed; a [`StopFlag`] ends the wait then.
///
/// Dropping the port unplugs it: unread bytes are gone ([`Self::drain`] first), the reader's next
/// read fails, and the device node disappears.
#[derive(Debug)]
pub struct VirtualPort {
    // Before the descriptors: a link must be gone before its device number can be given again.
    links: Vec<DeviceLink>,
    pair: Pair,
}

impl VirtualPort {
    /// Makes a port in raw mode: all 256 byte values pass, nothing is echoed.
    ///
    /// # Errors
    /// [`VirtualPortError::Open`] when the system has no pseudo-terminal to give.
    pub fn open() -> Result<Self, VirtualPortError> {
        let pair =
            Pair::open(None).map_err(|errno| VirtualPortError::Open { source: errno.into() })?;
        Ok(Self { links: Vec::new(), pair })
    }

    /// The device node to open, such as `/dev/pts/3`.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.pair.path
    }

    /// Gives the device node a second, stable name: a symbolic link that replaces a dangling one
    /// atomically and is removed with the port, unless it points elsewhere by then.
    ///
    /// # Errors
    /// [`VirtualPortError::Link`] when something else is in the way, a link to anything that
    /// exists included, or the directory cannot be written.
    pub fn link_at(&mut self, link: &Path) -> Result<(), VirtualPortError> {
        let made = DeviceLink::create(link, &self.pair.path)
            .map_err(|source| VirtualPortError::Link { link: link.to_owned(), source })?;
        self.links.push(made);
        Ok(())
    }

    /// Sends all of `bytes`, waiting for the reader whenever the line is full. `stop` is looked
    /// at only when there is something to wait for.
    ///
    /// # Errors
    /// [`VirtualPortError::Stopped`] when `stop` was thrown during a wait;
    /// [`VirtualPortError::Transfer`] when the system refuses.
    pub fn write_all(&mut self, bytes: &[u8], stop: &StopFlag) -> Result<(), VirtualPortError> {
        let mut done = 0;
        while done < bytes.len() {
            match rustix::io::write(&self.pair.master, &bytes[done..]) {
                Ok(written) => done += written,
                Err(Errno::INTR) => {}
                Err(Errno::AGAIN) => self.wait_for(PollFlags::OUT, stop, done)?,
                Err(errno) => return Err(refused(errno)),
            }
        }
        Ok(())
    }

    /// Takes what the reader's side has sent, a command for the gyro perhaps; waits for at least
    /// one byte and returns how many came. An empty `buffer` gets none.
    ///
    /// # Errors
    /// As [`Self::write_all`].
    pub fn receive(
        &mut self,
        buffer: &mut [u8],
        stop: &StopFlag,
    ) -> Result<usize, VirtualPortError> {
        loop {
            match rustix::io::read(&self.pair.master, &mut *buffer) {
                Ok(received) => return Ok(received),
                Err(Errno::INTR) => {}
                Err(Errno::AGAIN) => self.wait_for(PollFlags::IN, stop, 0)?,
                Err(errno) => return Err(refused(errno)),
            }
        }
    }

    /// Waits until the reader has taken every byte.
    ///
    /// On Linux the bytes lie in two places: up to 64 KiB in a queue and 4 KiB in the line
    /// discipline, which is refilled from the queue at the end of a read. One look can fall
    /// between the reader's taking and the refill and find nothing though the queue is full. But
    /// each look here first waits for a read in progress to end (the kernel counts the unread
    /// bytes under the lock that a read holds), so a next mistaken look needs another 4 KiB taken
    /// from the queue; after 32 empty looks in a row nothing can be left.
    ///
    /// # Errors
    /// As [`Self::write_all`].
    pub fn drain(&mut self, stop: &StopFlag) -> Result<(), VirtualPortError> {
        let mut empty_looks = 0;
        while empty_looks < EMPTY_LOOKS {
            if !has_unread_bytes(&self.pair.slave).map_err(refused)? {
                empty_looks += 1;
                continue;
            }
            empty_looks = 0;
            if stop.is_stopped() {
                return Err(VirtualPortError::Stopped { done: 0 });
            }
            ignore_interruption(poll(&mut [], Some(&DRAIN_CHECK))).map_err(refused)?;
        }
        Ok(())
    }

    /// Waits a while for `flags` on the master; the caller tries again in any case, so a lost
    /// wake-up costs one period of the stop check and nothing more.
    fn wait_for(
        &self,
        flags: PollFlags,
        stop: &StopFlag,
        done: usize,
    ) -> Result<(), VirtualPortError> {
        if stop.is_stopped() {
            return Err(VirtualPortError::Stopped { done });
        }
        let mut master = [PollFd::new(&self.pair.master, flags)];
        ignore_interruption(poll(&mut master, Some(&STOP_CHECK))).map_err(refused)?;
        Ok(())
    }
}

pub(crate) fn refused(errno: Errno) -> VirtualPortError {
    VirtualPortError::Transfer { source: errno.into() }
}
