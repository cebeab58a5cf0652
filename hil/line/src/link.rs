//! A stable name for a device node whose number changes from run to run.

use std::fs;
use std::io;
use std::os::unix::fs::symlink;
use std::path::{Path, PathBuf};

/// Temporary names tried before giving up; each could only be taken by a crashed run.
const ATTEMPTS: u32 = 16;

/// A symbolic link that goes away with its owner.
#[derive(Debug)]
pub(crate) struct DeviceLink {
    link: PathBuf,
    device: PathBuf,
}

impl DeviceLink {
    /// Points `link` at `device`. A link that leads nowhere, as a crashed run leaves behind, is
    /// replaced; anything else that is there belongs to somebody and is refused.
    ///
    /// The link is made under another name and renamed, so that whoever opens `link` meets either
    /// the old device or the new one, never nothing.
    pub(crate) fn create(link: &Path, device: &Path) -> io::Result<Self> {
        if let Some(reason) = in_the_way(link)? {
            return Err(io::Error::new(io::ErrorKind::AlreadyExists, reason));
        }
        let fresh = symlink_beside(link, device)?;
        fs::rename(&fresh, link).inspect_err(|_| {
            // Best effort: the error that matters is the rename's.
            drop(fs::remove_file(&fresh));
        })?;
        Ok(Self { link: link.to_owned(), device: device.to_owned() })
    }
}

/// What at `link` must not be replaced, in words.
fn in_the_way(link: &Path) -> io::Result<Option<String>> {
    match fs::symlink_metadata(link) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(None),
        Err(error) => Err(error),
        Ok(found) if !found.is_symlink() => {
            Ok(Some("something that is not a symbolic link is there".to_owned()))
        }
        Ok(_) => match fs::metadata(link) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(None),
            _ => Ok(Some(format!(
                "a link to {} is there; end the emulator that made it, or remove the link",
                fs::read_link(link)?.display()
            ))),
        },
    }
}

fn symlink_beside(link: &Path, device: &Path) -> io::Result<PathBuf> {
    let Some(name) = link.file_name() else {
        return Err(io::Error::new(io::ErrorKind::InvalidInput, "the path names no file"));
    };
    let process = std::process::id();
    let mut outcome = Err(io::ErrorKind::AlreadyExists.into());
    for attempt in 0..ATTEMPTS {
        let mut fresh_name = name.to_owned();
        fresh_name.push(format!(".{process}-{attempt}"));
        let fresh = link.with_file_name(fresh_name);
        outcome = symlink(device, &fresh).map(|()| fresh);
        match &outcome {
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
            _ => break,
        }
    }
    outcome
}

impl Drop for DeviceLink {
    /// Removes the link, unless somebody has pointed it elsewhere meanwhile.
    fn drop(&mut self) {
        if fs::read_link(&self.link).is_ok_and(|target| target == self.device) {
            // A link that cannot be removed dangles; the next run replaces it.
            drop(fs::remove_file(&self.link));
        }
    }
}
