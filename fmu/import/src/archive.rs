//! A look into the archive before anything is unpacked.

use crate::error::{ImportError, not_an_fmu};
use std::fs::File;
use std::path::Path;

const ENTRIES_MAX: usize = 10_000;
const UNPACKED_BYTES_MAX: u64 = 1 << 30;

/// Refuses what is no zip, has no model description, or would unpack to an absurd size.
pub(crate) fn inspect(path: &Path) -> Result<(), ImportError> {
    let file =
        File::open(path).map_err(|source| ImportError::Read { path: path.to_owned(), source })?;
    let mut archive = zip::ZipArchive::new(file).map_err(|e| not_an_fmu(path, &e))?;
    if archive.len() > ENTRIES_MAX {
        return Err(not_an_fmu(path, &format!("it has more than {ENTRIES_MAX} entries")));
    }
    if archive.index_for_name("modelDescription.xml").is_none() {
        return Err(not_an_fmu(path, &"it holds no modelDescription.xml"));
    }
    let mut total: u64 = 0;
    for index in 0..archive.len() {
        let entry = archive.by_index_raw(index).map_err(|e| not_an_fmu(path, &e))?;
        total = total.saturating_add(entry.size());
    }
    if total > UNPACKED_BYTES_MAX {
        let reason = format!("it would unpack to {total} bytes, more than {UNPACKED_BYTES_MAX}");
        return Err(not_an_fmu(path, &reason));
    }
    Ok(())
}
