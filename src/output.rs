//! Files that are either whole or absent.

use std::fs::{self, Permissions};
use std::io::{self, BufWriter, Write};
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};

/// A file or folder that could not be written.
#[derive(Debug, thiserror::Error)]
#[error(
    "cannot write {}: {source}; check that its folder exists and may be written, and that nothing \
     else has its place",
    path.display()
)]
pub struct OutputError {
    /// What was to be written.
    pub path: PathBuf,
    /// The system's reason.
    pub source: io::Error,
}

impl OutputError {
    fn at(path: &Path) -> impl FnOnce(io::Error) -> Self {
        let path = path.to_owned();
        move |source| Self { path, source }
    }
}

/// Makes `folder` and its parents.
///
/// # Errors
/// [`OutputError`] with the system's reason.
pub fn create_folder(folder: &Path) -> Result<(), OutputError> {
    fs::create_dir_all(folder).map_err(OutputError::at(folder))
}

/// Makes `folder` and tries whether files can be written into it; leaves none.
///
/// # Errors
/// [`OutputError`] with the system's reason.
pub fn prepare_folder(folder: &Path) -> Result<(), OutputError> {
    create_folder(folder)?;
    tempfile::tempfile_in(folder).map(drop).map_err(OutputError::at(folder))
}

/// Writes `path` through a temporary name beside it, renamed when complete: a reader never sees
/// half a file, and an older file survives a failure.
///
/// # Errors
/// [`OutputError`] with the system's reason; nothing of the new content is left behind then.
pub fn write_whole(
    path: &Path,
    fill: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> Result<(), OutputError> {
    let failed = || OutputError::at(path);
    let folder = match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    let mut file = tempfile::Builder::new()
        .prefix(".struna-")
        .suffix(".tmp")
        // What a plain create would give, less the umask.
        .permissions(Permissions::from_mode(0o666))
        .tempfile_in(folder)
        .map_err(failed())?;
    let mut buffer = BufWriter::new(&mut file);
    fill(&mut buffer).and_then(|()| buffer.flush()).map_err(failed())?;
    drop(buffer);
    file.persist(path).map_err(|e| failed()(e.error))?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_failed_write_leaves_the_old_file_and_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("record.csv");
        write_whole(&path, |out| out.write_all(b"old")).unwrap();
        let failure = write_whole(&path, |out| {
            out.write_all(b"half of the new")?;
            Err(io::Error::other("disk on fire"))
        });
        assert!(failure.unwrap_err().to_string().contains("disk on fire"));
        assert_eq!(fs::read(&path).unwrap(), b"old");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    }
}
