//! A virtual port that behaves as the port of a real device.

use crate::link::DeviceLink;
use crate::port::{DRAIN_CHECK, EMPTY_LOOKS, STOP_CHECK, refused};
use crate::pty::{NO_WAIT, Pair, has_unread_bytes, ignore_interruption, peer};
use crate::receiver::{CharacterFormat, ReceiverErrors, UartReceiver};
use crate::{StopFlag, VirtualPortError};
use rustix::event::{PollFd, PollFlags, poll};
use rustix::fd::OwnedFd;
use rustix::io::Errno;
use rustix::termios::{QueueSelector, tcflush, tcgetattr};
use std::path::{Path, PathBuf};
use struna_kernel::SimTime;

const NS_PER_S: f64 = 1e9;
/// Two clocks that differ by no more read each other: half of what a receiver stands.
const BAUD_TOLERANCE: f64 = 0.02;
/// Commands that a client has sent are taken and dropped in pieces of this size, and in one tick
/// at most so many: a client that talks without end must not hold up the device.
const COMMAND_BYTES: usize = 256;
const COMMAND_READS_MAX: usize = 16;
/// Looks at a client that is still reading, one a millisecond, before its port goes away.
const LINGER_LOOKS: u32 = 2000;

/// The device's own side of the line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DeviceSettings {
    /// Its baud rate. Positive.
    pub baud: u32,
    /// How its bytes stand on the line.
    pub format: CharacterFormat,
}

/// Who listens.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Client {
    /// The device is not plugged in.
    Unplugged,
    /// Nobody has the port open.
    #[default]
    Absent,
    /// Somebody has.
    Present {
        /** The baud rate to which the client has set the port. */
        baud: u32,
        /** Whether that is the device's, near enough to read it. */
        agrees: bool,
    },
}

impl Client {
    /// Whether somebody has the port open.
    #[must_use]
    pub const fn is_present(self) -> bool {
        matches!(self, Self::Present { .. })
    }
}

/// Where every byte of the device went: `sent` is the sum of `passed`, `unheard`, `skipped`,
/// `overrun` and `garbled`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct PortCounts {
    /// Bytes the device put on the line.
    pub sent: u64,
    /// Bytes that lie in the client's input queue or have been read from it, as they were sent.
    pub passed: u64,
    /// Bytes that nobody had the port open for.
    pub unheard: u64,
    /// Bytes before the place at which a client that had just come was let in.
    pub skipped: u64,
    /// Bytes that a client at the right baud rate had no room for.
    pub overrun: u64,
    /// Bytes sent while the client listened at a wrong baud rate.
    pub garbled: u64,
    /// Bytes the client received instead of those.
    pub garbage: u64,
    /// What its receiver found wrong with them.
    pub errors: ReceiverErrors,
    /// Bytes the client sent; the device does not listen.
    pub commands: u64,
    /// How often a client came.
    pub clients: u64,
}

/// A virtual port that neither waits for its reader nor keeps bytes for one that is not there.
///
/// It differs from a [`VirtualPort`](crate::VirtualPort) in what it does with bytes that cannot
/// pass. Nobody has the port open: they are gone, and a client that comes starts with an empty
/// queue. The client does not read and its queue of some 20 kB is full: the newest are gone, as in
/// a receiver that overruns. The client has set another baud rate: a [`UartReceiver`] at that rate
/// decides what it reads. All of it is counted.
///
/// The far end is not held open here; that is how a closed one is noticed, once in each
/// [`Self::send`]. A client that closes and opens again between two of them is taken for one that
/// stayed, and may find the bytes it had not read. Of the client's settings the kernel keeps the
/// baud rate alone for a pseudo-terminal; its parity is taken to be the device's.
#[derive(Debug)]
pub struct DevicePort {
    settings: DeviceSettings,
    link: Option<PathBuf>,
    plugged: Option<Plugged>,
    client: Client,
    /// Whether the client has been let into the stream.
    joined: bool,
    receiver: Option<UartReceiver>,
    /// End of what was last put on the line.
    line_free: SimTime,
    garbage: Vec<u8>,
    counts: PortCounts,
}

#[derive(Debug)]
struct Plugged {
    // Before the descriptor: a link must be gone before its device number can be given again.
    _link: Option<DeviceLink>,
    master: OwnedFd,
    path: PathBuf,
}

impl DevicePort {
    /// Makes a port, plugged in, set to the device's baud rate and in raw mode. With `link`, its
    /// node has that second, stable name: a symbolic link that may replace one that leads nowhere,
    /// and nothing else.
    ///
    /// # Errors
    /// [`VirtualPortError::Open`] when the system has no pseudo-terminal to give,
    /// [`VirtualPortError::Link`] when the link cannot be made.
    pub fn open(settings: DeviceSettings, link: Option<&Path>) -> Result<Self, VirtualPortError> {
        let mut port = Self {
            settings,
            link: link.map(Path::to_owned),
            plugged: None,
            client: Client::Unplugged,
            joined: false,
            receiver: None,
            line_free: SimTime::ZERO,
            garbage: Vec::new(),
            counts: PortCounts::default(),
        };
        port.plug()?;
        Ok(port)
    }

    /// The device node to open, such as `/dev/pts/3`; none while unplugged.
    #[must_use]
    pub fn path(&self) -> Option<&Path> {
        self.plugged.as_ref().map(|plugged| plugged.path.as_path())
    }

    /// Who listened when it was last looked at.
    #[must_use]
    pub const fn client(&self) -> Client {
        self.client
    }

    /// Where the bytes went.
    #[must_use]
    pub fn counts(&self) -> PortCounts {
        let mut counts = self.counts;
        if let Some(receiver) = &self.receiver {
            counts.errors = sum(counts.errors, receiver.errors());
        }
        counts
    }

    /// Pulls the plug: the client's reads fail from now on, what it has not read is gone, node and
    /// link disappear.
    pub fn unplug(&mut self) {
        self.plugged = None;
        self.leave(Client::Unplugged);
    }

    /// Plugs the device in again: a new node, the same link. A device that is plugged in stays so.
    ///
    /// # Errors
    /// As [`Self::open`]; the device stays unplugged.
    pub fn plug(&mut self) -> Result<(), VirtualPortError> {
        if self.plugged.is_some() {
            return Ok(());
        }
        let Pair { master, slave, path } = Pair::open(Some(self.settings.baud))
            .map_err(|errno| VirtualPortError::Open { source: errno.into() })?;
        // Only a far end that was open once and is closed shows as such.
        drop(slave);
        let link = match &self.link {
            None => None,
            Some(link) => Some(DeviceLink::create(link, &path).map_err(|source| {
                let link = link.clone();
                VirtualPortError::Link { link, source }
            })?),
        };
        self.plugged = Some(Plugged { _link: link, master, path });
        self.client = Client::Absent;
        Ok(())
    }

    /// The device sends `bytes`, without a pause, the last symbol ending at `end`. Never waits.
    ///
    /// A client that has just come is let in at byte `entry` of them; with none it has to wait for
    /// later ones. That way the caller, who knows frames, decides where in one a client starts.
    ///
    /// # Errors
    /// As [`Self::look`].
    pub fn send(
        &mut self,
        end: SimTime,
        bytes: &[u8],
        entry: Option<usize>,
    ) -> Result<(), VirtualPortError> {
        self.look()?;
        self.counts.sent += bytes.len() as u64;
        let gap_symbols = self.occupy_line(end, bytes.len());
        if !self.client.is_present() {
            self.counts.unheard += bytes.len() as u64;
            return Ok(());
        }
        let skipped = match entry {
            _ if self.joined => 0,
            Some(entry) => entry.min(bytes.len()),
            None => bytes.len(),
        };
        self.joined |= entry.is_some();
        self.counts.skipped += skipped as u64;
        match &mut self.receiver {
            None => self.pass(&bytes[skipped..]),
            Some(receiver) => {
                let gap = gap_symbols + skipped as f64 * f64::from(self.settings.format.symbols());
                receiver.receive(gap, &bytes[skipped..], &mut self.garbage);
                self.counts.garbled += (bytes.len() - skipped) as u64;
                self.pass_garbage()
            }
        }
    }

    /// Looks who listens: notices a client that has come, gone or changed its baud rate, and takes
    /// what it has sent.
    ///
    /// # Errors
    /// As [`Self::plug`], for a client may leave the port useless; [`VirtualPortError::Transfer`]
    /// when the system refuses.
    pub fn look(&mut self) -> Result<Client, VirtualPortError> {
        let Some(Plugged { master, .. }) = &self.plugged else { return Ok(Client::Unplugged) };
        let seen = listener(master, self.settings.baud).map_err(refused)?;
        match (self.client, seen) {
            (before, now) if before == now => {}
            (Client::Present { .. }, Client::Present { baud, agrees }) => {
                self.set_receiver(baud, agrees);
            }
            (_, Client::Present { baud, agrees }) => {
                self.counts.clients += 1;
                self.set_receiver(baud, agrees);
            }
            (_, gone) => {
                let forgotten = forget_unread(master).map_err(refused)?;
                self.leave(gone);
                if !forgotten {
                    self.unplug();
                    self.plug()?;
                }
            }
        }
        self.client = seen;
        if seen.is_present() {
            self.take_commands()?;
        }
        Ok(seen)
    }

    /// Waits until somebody has opened the port; false when `stop` was thrown before that.
    ///
    /// # Errors
    /// As [`Self::look`].
    pub fn wait_for_client(&mut self, stop: &StopFlag) -> Result<bool, VirtualPortError> {
        while !self.look()?.is_present() {
            if stop.is_stopped() {
                return Ok(false);
            }
            // The kernel announces a closed far end, but not an opened one.
            ignore_interruption(poll(&mut [], Some(&STOP_CHECK))).map_err(refused)?;
        }
        Ok(true)
    }

    /// Gives a client that is reading the time to read what has been sent: two seconds at most.
    /// Dropping the port discards the rest, as unplugging does.
    ///
    /// # Errors
    /// As [`Self::look`].
    pub fn linger(&mut self, stop: &StopFlag) -> Result<(), VirtualPortError> {
        let mut empty_looks = 0;
        for _ in 0..LINGER_LOOKS {
            if stop.is_stopped() || !self.look()?.is_present() {
                return Ok(());
            }
            while empty_looks < EMPTY_LOOKS && self.all_read().map_err(refused)? {
                empty_looks += 1;
            }
            if empty_looks == EMPTY_LOOKS {
                return Ok(());
            }
            empty_looks = 0;
            ignore_interruption(poll(&mut [], Some(&DRAIN_CHECK))).map_err(refused)?;
        }
        Ok(())
    }

    /// Whether nothing waits for the client, as far as can be seen: a client that has the port for
    /// itself alone bars this look as well, unless the program may do anything.
    fn all_read(&self) -> Result<bool, Errno> {
        let Some(Plugged { master, .. }) = &self.plugged else { return Ok(true) };
        match peer(master) {
            Ok(slave) => Ok(!has_unread_bytes(&slave)?),
            Err(Errno::BUSY) => Ok(false),
            Err(errno) => Err(errno),
        }
    }

    /// Puts a burst on the line and returns how long the line was idle before it, symbols.
    fn occupy_line(&mut self, end: SimTime, bytes: usize) -> f64 {
        let symbol_ns = NS_PER_S / f64::from(self.settings.baud);
        let idle_ns = end.as_ns().saturating_sub(self.line_free.as_ns()) as f64;
        self.line_free = end;
        idle_ns / symbol_ns - bytes as f64 * f64::from(self.settings.format.symbols())
    }

    fn set_receiver(&mut self, baud: u32, agrees: bool) {
        self.keep_errors();
        let DeviceSettings { baud: own, format } = self.settings;
        self.receiver =
            (!agrees).then(|| UartReceiver::new(format, f64::from(own), f64::from(baud)));
    }

    fn leave(&mut self, client: Client) {
        self.keep_errors();
        self.client = client;
        self.joined = false;
    }

    fn keep_errors(&mut self) {
        if let Some(receiver) = self.receiver.take() {
            self.counts.errors = sum(self.counts.errors, receiver.errors());
        }
    }

    fn pass(&mut self, bytes: &[u8]) -> Result<(), VirtualPortError> {
        let passed = self.offer(bytes)?;
        self.counts.passed += passed as u64;
        self.counts.overrun += (bytes.len() - passed) as u64;
        Ok(())
    }

    fn pass_garbage(&mut self) -> Result<(), VirtualPortError> {
        let garbage = std::mem::take(&mut self.garbage);
        let passed = self.offer(&garbage)?;
        self.counts.garbage += passed as u64;
        self.garbage = garbage;
        self.garbage.clear();
        Ok(())
    }

    /// Hands over as many bytes as there is room for.
    fn offer(&self, bytes: &[u8]) -> Result<usize, VirtualPortError> {
        let Some(Plugged { master, .. }) = &self.plugged else { return Ok(0) };
        let mut passed = 0;
        while passed < bytes.len() {
            match rustix::io::write(master, &bytes[passed..]) {
                Ok(written) => passed += written,
                Err(Errno::INTR) => {}
                // AGAIN: the queue is full. IO: the client has closed since it was looked for.
                Err(Errno::AGAIN | Errno::IO) => break,
                Err(errno) => return Err(refused(errno)),
            }
        }
        Ok(passed)
    }

    fn take_commands(&mut self) -> Result<(), VirtualPortError> {
        let Some(Plugged { master, .. }) = &self.plugged else { return Ok(()) };
        let mut commands = [0; COMMAND_BYTES];
        for _ in 0..COMMAND_READS_MAX {
            match rustix::io::read(master, &mut commands) {
                Ok(taken) => self.counts.commands += taken as u64,
                Err(Errno::INTR) => {}
                Err(Errno::AGAIN | Errno::IO) => break,
                Err(errno) => return Err(refused(errno)),
            }
        }
        Ok(())
    }
}

/// Discards what a client that has gone did not read, or the next one would find it. Not possible
/// when it took the port for itself alone and crashed: nobody can open such a terminal again.
fn forget_unread(master: &OwnedFd) -> Result<bool, Errno> {
    // The bytes lie in two places, and each end empties one.
    tcflush(master, QueueSelector::OFlush)?;
    match peer(master) {
        Ok(slave) => tcflush(&slave, QueueSelector::IFlush).map(|()| true),
        Err(Errno::BUSY) => Ok(false),
        Err(errno) => Err(errno),
    }
}

/// Who has the far end of `master` open, beside a device at `own` baud.
fn listener(master: &OwnedFd, own: u32) -> Result<Client, Errno> {
    let mut state = [PollFd::new(master, PollFlags::empty())];
    ignore_interruption(poll(&mut state, Some(&NO_WAIT)))?;
    if state[0].revents().contains(PollFlags::HUP) {
        return Ok(Client::Absent);
    }
    // The output speed: drivers of real ports know no other, and old interfaces set it alone.
    match tcgetattr(master)?.output_speed() {
        // Zero baud means "hang up".
        0 => Ok(Client::Absent),
        baud => Ok(Client::Present { baud, agrees: agree(own, baud) }),
    }
}

fn agree(own: u32, client: u32) -> bool {
    (f64::from(client) / f64::from(own) - 1.0).abs() <= BAUD_TOLERANCE
}

fn sum(a: ReceiverErrors, b: ReceiverErrors) -> ReceiverErrors {
    ReceiverErrors { framing: a.framing + b.framing, parity: a.parity + b.parity }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bauds_agree_when_a_receiver_reads_them() {
        for (own, client, agrees) in [
            (115_200, 115_200, true),
            (115_200, 117_000, true),
            (115_200, 113_000, true),
            (230_400, 250_000, false),
            (115_200, 9600, false),
            (115_200, u32::MAX, false),
        ] {
            assert_eq!(agree(own, client), agrees, "{own} {client}");
        }
    }
}
