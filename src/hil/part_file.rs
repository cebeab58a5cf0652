//! Files that grow for hours and must survive whatever ends the run.

use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// Bytes gathered before the disk is asked.
const BUFFER: usize = 1 << 16;

/// A file under a temporary name beside its place, `.NAME.part`, renamed by [`Self::keep`].
///
/// It is made of entries. When the disk refuses, the file is cut back to the last whole entry, so
/// what came until then can be kept and read.
#[derive(Debug)]
pub struct PartFile {
    file: File,
    part: PathBuf,
    path: PathBuf,
    buffer: Vec<u8>,
    /// Bytes of whole entries on disk.
    whole: u64,
    /// What ends an entry; without it each byte is one.
    ends: Option<u8>,
    refused: bool,
}

impl PartFile {
    /// A file of lines.
    ///
    /// # Errors
    /// What the system says.
    pub fn of_lines(path: &Path) -> io::Result<Self> {
        Self::create(path, Some(b'\n'))
    }

    /// A file of bytes, each an entry.
    ///
    /// # Errors
    /// What the system says.
    pub fn of_bytes(path: &Path) -> io::Result<Self> {
        Self::create(path, None)
    }

    fn create(path: &Path, ends: Option<u8>) -> io::Result<Self> {
        let name = path.file_name().ok_or(io::ErrorKind::InvalidInput)?;
        let part = path.with_file_name(format!(".{}.part", name.display()));
        let file = File::create(&part)?;
        let buffer = Vec::with_capacity(2 * BUFFER);
        Ok(Self { file, part, path: path.to_owned(), buffer, whole: 0, ends, refused: false })
    }

    /// Its place.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Where to append whole entries; [`Self::settle`] has to follow.
    pub fn entries(&mut self) -> &mut Vec<u8> {
        &mut self.buffer
    }

    /// Hands entries to the system when enough have gathered.
    ///
    /// # Errors
    /// What the system says, once; the file is cut back to its last whole entry then, and takes no
    /// more.
    pub fn settle(&mut self) -> io::Result<()> {
        if self.buffer.len() < BUFFER { Ok(()) } else { self.flush() }
    }

    /// Hands all entries to the system.
    ///
    /// # Errors
    /// As [`Self::settle`].
    pub fn flush(&mut self) -> io::Result<()> {
        let mut taken = 0;
        while taken < self.buffer.len() && !self.refused {
            match self.file.write(&self.buffer[taken..]) {
                Ok(0) => return self.refuse(taken, io::ErrorKind::WriteZero.into()),
                Ok(n) => taken += n,
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                Err(error) => return self.refuse(taken, error),
            }
        }
        self.whole += taken as u64;
        self.buffer.clear();
        Ok(())
    }

    fn refuse(&mut self, taken: usize, error: io::Error) -> io::Result<()> {
        self.refused = true;
        self.whole += whole_entries(&self.buffer[..taken], self.ends) as u64;
        self.buffer.clear();
        // Cutting needs no space; if even that fails, a reader meets half a line at the end.
        let _ = self.file.set_len(self.whole);
        Err(error)
    }

    /// Gives the file its name.
    ///
    /// # Errors
    /// What the system says. The file has its name nevertheless, with what could be written.
    pub fn keep(mut self) -> io::Result<()> {
        let flushed = self.flush();
        fs::rename(&self.part, &self.path)?;
        flushed
    }

    /// Removes the file.
    pub fn discard(self) {
        // A part that cannot be removed is overwritten by the next run.
        let _ = fs::remove_file(&self.part);
    }
}

/// Bytes of `taken` up to the end of its last whole entry.
fn whole_entries(taken: &[u8], ends: Option<u8>) -> usize {
    match ends {
        None => taken.len(),
        Some(end) => taken.iter().rposition(|byte| *byte == end).map_or(0, |at| at + 1),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::os::unix::fs::symlink;

    #[test]
    fn only_whole_lines_count() {
        assert_eq!(whole_entries(b"a,b\n1,2\n3,", Some(b'\n')), 8);
        assert_eq!(whole_entries(b"half", Some(b'\n')), 0);
        assert_eq!(whole_entries(b"half", None), 4);
    }

    #[test]
    fn a_file_has_its_name_when_it_is_kept_and_not_before() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("record.csv");
        let mut file = PartFile::of_lines(&path).unwrap();
        file.entries().extend(b"1\n2\n");
        file.flush().unwrap();
        assert!(!path.exists());
        file.entries().extend(b"3\n");
        file.keep().unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"1\n2\n3\n");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[test]
    fn a_full_disk_is_told_once() {
        let folder = tempfile::tempdir().unwrap();
        symlink("/dev/full", folder.path().join(".record.csv.part")).unwrap();
        let mut file = PartFile::of_lines(&folder.path().join("record.csv")).unwrap();
        file.entries().extend(b"1\n");
        file.settle().expect("nothing is written yet");
        let refused = file.flush().unwrap_err();
        assert_eq!(refused.kind(), io::ErrorKind::StorageFull);
        file.entries().extend(b"2\n");
        file.flush().expect("it was told");
        assert_eq!(file.whole, 0);
    }
}
