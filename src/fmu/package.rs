//! Wrapping a shared library and a model description into an `.fmu` file.

use std::env::consts::{ARCH, DLL_EXTENSION, DLL_PREFIX, OS};
use std::fs::{self, Permissions};
use std::io::{self, Seek, Write};
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use struna_fmi_export::{FmiVersion, ModelType};
use zip::result::ZipResult;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, ZipWriter};

/// Environment variable that names the shared library, for programs moved away from it.
const LIBRARY_VARIABLE: &str = "STRUNA_FMU_LIBRARY";

/// Why an FMU could not be written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PackageError {
    /// There is no such model.
    #[error("no model is called {name:?}; there are {}", known.join(", "))]
    UnknownModel {
        /** The name asked for. */
        name: String,
        /** The names that exist. */
        known: Vec<&'static str>,
    },
    /// The shared library was not found.
    #[error(
        "the FMU library was not found at {}; build it with `cargo build -p struna-fmu-library`, \
         or name it in {LIBRARY_VARIABLE}",
        searched.iter().map(|p| p.display().to_string()).collect::<Vec<_>>().join(", ")
    )]
    LibraryNotFound {
        /** Where it was looked for. */
        searched: Vec<PathBuf>,
    },
    /// The shared library was built from another variable table.
    #[error(
        "{} does not hold this version of {model}: its variable table has changed since; build it \
         again with `cargo build -p struna-fmu-library`",
        library.display()
    )]
    StaleLibrary {
        /** The library. */
        library: PathBuf,
        /** The model looked for. */
        model: &'static str,
    },
    /// A file could not be read or written.
    #[error("{}: {source}", path.display())]
    File {
        /** The file. */
        path: PathBuf,
        /** What happened. */
        source: io::Error,
    },
}

/// Finds the shared library of the exported models.
///
/// Looked for in `STRUNA_FMU_LIBRARY` alone when that is set, else where Cargo puts it: `deps`
/// beside this program, beside this program (which is where test programs find it), and the same
/// two one folder up.
///
/// # Errors
/// [`PackageError::LibraryNotFound`] tells where it was looked for and how to build it.
pub fn find_library() -> Result<PathBuf, PackageError> {
    let candidates = match std::env::var_os(LIBRARY_VARIABLE) {
        Some(named) => vec![PathBuf::from(named)],
        None => beside_this_program(),
    };
    match candidates.iter().find(|path| path.is_file()) {
        Some(found) => Ok(found.clone()),
        None => Err(PackageError::LibraryNotFound { searched: candidates }),
    }
}

fn beside_this_program() -> Vec<PathBuf> {
    let Ok(program) = std::env::current_exe() else { return Vec::new() };
    let name = format!("{DLL_PREFIX}struna_fmu_library.{DLL_EXTENSION}");
    let folders = program.ancestors().skip(1).take(2);
    folders.flat_map(|folder| [folder.join("deps").join(&name), folder.join(&name)]).collect()
}

/// Writes `<model>_fmi2.fmu` or `<model>_fmi3.fmu` into `folder` and gives its path.
///
/// The same library gives the same bytes: entries carry a fixed time. The file appears whole or not
/// at all. An FMU made on one platform runs on that platform only.
///
/// # Errors
/// [`PackageError::StaleLibrary`] when `library` was built from another variable table,
/// [`PackageError::File`] when a file cannot be read or written.
pub fn package(
    model: &ModelType,
    version: FmiVersion,
    library: &Path,
    folder: &Path,
) -> Result<PathBuf, PackageError> {
    let name = model.description().name();
    let binary = fs::read(library).map_err(|source| file_error(library, source))?;
    let token = model.instantiation_token().as_bytes();
    // The token is a constant of the library, so an up-to-date one holds it as plain bytes.
    if !binary.windows(token.len()).any(|window| window == token) {
        return Err(PackageError::StaleLibrary { library: library.to_owned(), model: name });
    }
    let suffix = match version {
        FmiVersion::Fmi2 => "fmi2",
        FmiVersion::Fmi3 => "fmi3",
    };
    let path = folder.join(format!("{name}_{suffix}.fmu"));
    let entries = [
        ("modelDescription.xml".to_owned(), model.model_description_xml(version).into_bytes()),
        (format!("binaries/{}/{name}.{DLL_EXTENSION}", platform(version, ARCH, OS)), binary),
    ];
    write_whole(&path, |file| write_zip(file, &entries)).map_err(|e| file_error(&path, e))?;
    Ok(path)
}

fn file_error(path: &Path, source: io::Error) -> PackageError {
    PackageError::File { path: path.to_owned(), source }
}

/// The folder of binaries: FMI 2.0 has its own names for PCs, FMI 3.0 says architecture and system.
fn platform(version: FmiVersion, arch: &str, os: &str) -> String {
    let system = if os == "macos" { "darwin" } else { os };
    match (version, arch, system) {
        (FmiVersion::Fmi2, "x86_64", "linux") => "linux64".into(),
        (FmiVersion::Fmi2, "x86_64", "darwin") => "darwin64".into(),
        _ => format!("{arch}-{system}"),
    }
}

/// Writes to a file beside `path` and moves it there once it is complete.
fn write_whole(path: &Path, write: impl FnOnce(&mut fs::File) -> ZipResult<()>) -> io::Result<()> {
    let folder = path.parent().unwrap_or(Path::new("."));
    fs::create_dir_all(folder)?;
    let readable_by_all = Permissions::from_mode(0o644);
    let mut file =
        tempfile::Builder::new().suffix(".tmp").permissions(readable_by_all).tempfile_in(folder)?;
    write(file.as_file_mut())?;
    file.persist(path)?;
    Ok(())
}

fn write_zip(file: impl Write + Seek, entries: &[(String, Vec<u8>)]) -> ZipResult<()> {
    let options = SimpleFileOptions::default()
        .compression_method(CompressionMethod::Deflated)
        .last_modified_time(DateTime::default())
        .unix_permissions(0o755);
    let mut zip = ZipWriter::new(file);
    for (name, content) in entries {
        zip.start_file(name, options)?;
        zip.write_all(content)?;
    }
    zip.finish()?.flush()?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fmu::models;
    use tempfile::tempdir;

    #[test]
    fn the_same_library_gives_the_same_bytes() {
        let library = find_library().unwrap();
        let (one, other) = (tempdir().unwrap(), tempdir().unwrap());
        for version in FmiVersion::ALL {
            let build = |folder: &Path| {
                fs::read(package(&models()[0], version, &library, folder).unwrap()).unwrap()
            };
            assert!(build(one.path()) == build(other.path()), "{version}");
        }
    }

    #[test]
    fn nothing_but_the_finished_file_is_left_in_the_folder() {
        let folder = tempdir().unwrap();
        let fmu = package(&models()[1], FmiVersion::Fmi3, &find_library().unwrap(), folder.path());
        let left: Vec<_> =
            fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().path()).collect();
        assert_eq!(left, [fmu.unwrap()]);
        assert!(left[0].ends_with("TorsionalOscillation_fmi3.fmu"));
    }

    #[test]
    fn a_library_without_the_models_token_is_refused() {
        let folder = tempdir().unwrap();
        let library = folder.path().join("old.so");
        fs::write(&library, b"built from an older variable table").unwrap();
        let refused = package(&models()[0], FmiVersion::Fmi2, &library, folder.path()).unwrap_err();
        assert!(matches!(refused, PackageError::StaleLibrary { .. }));
        assert!(refused.to_string().contains("cargo build -p struna-fmu-library"), "{refused}");
    }

    #[test]
    fn a_missing_library_is_reported_by_its_path() {
        let folder = tempdir().unwrap();
        let library = folder.path().join("missing.so");
        let refused = package(&models()[0], FmiVersion::Fmi2, &library, folder.path()).unwrap_err();
        assert!(refused.to_string().contains("missing.so"), "{refused}");
    }

    #[test]
    fn an_unknown_model_is_answered_with_the_known_ones() {
        let folder = tempdir().unwrap();
        let refused = crate::fmu::build("Pendulum", FmiVersion::Fmi2, folder.path()).unwrap_err();
        let said = refused.to_string();
        assert!(said.contains("PermanentRotation, TorsionalOscillation"), "{said}");
    }

    #[test]
    fn binaries_lie_where_each_version_of_the_standard_wants_them() {
        let on = |version| platform(version, "x86_64", "linux");
        assert_eq!(on(FmiVersion::Fmi2), "linux64");
        assert_eq!(on(FmiVersion::Fmi3), "x86_64-linux");
        assert_eq!(platform(FmiVersion::Fmi2, "aarch64", "linux"), "aarch64-linux");
        assert_eq!(platform(FmiVersion::Fmi3, "aarch64", "macos"), "aarch64-darwin");
    }
}
