//! Files that are no FMU, and what is said about them.

#![expect(clippy::unwrap_used, reason = "a failed unwrap fails the test")]

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use struna_fmi_import::{ImportError, open};
use zip::ZipWriter;
use zip::write::SimpleFileOptions;

fn archive(folder: &Path, entries: &[(&str, &str)]) -> PathBuf {
    let path = folder.join("x.fmu");
    let mut zip = ZipWriter::new(fs::File::create(&path).unwrap());
    for (name, text) in entries {
        zip.start_file(*name, SimpleFileOptions::default()).unwrap();
        zip.write_all(text.as_bytes()).unwrap();
    }
    zip.finish().unwrap();
    path
}

fn refusal(entries: &[(&str, &str)]) -> ImportError {
    let folder = tempfile::tempdir().unwrap();
    open(&archive(folder.path(), entries)).unwrap_err()
}

#[test]
fn a_missing_file_is_named() {
    let error = open(Path::new("no/such.fmu")).unwrap_err();
    assert!(matches!(error, ImportError::Read { .. }), "{error:?}");
    assert!(error.to_string().contains("no/such.fmu"), "{error}");
}

#[test]
fn a_file_that_is_no_zip_is_refused_with_a_remedy() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("x.fmu");
    for content in ["", "not a zip", "PK\u{3}\u{4} and then nothing of the kind"] {
        fs::write(&path, content).unwrap();
        let error = open(&path).unwrap_err();
        assert!(matches!(error, ImportError::NotAnFmu { .. }), "{error:?}");
        assert!(error.to_string().contains("struna fmu build"), "{error}");
    }
}

#[test]
fn a_zip_without_model_description_is_refused() {
    let error = refusal(&[("readme.txt", "hello")]);
    assert!(error.to_string().contains("modelDescription.xml"), "{error}");
}

#[test]
fn a_broken_model_description_is_refused() {
    for xml in ["", "<", "<fmiModelDescription", "<other/>", "\u{0}"] {
        let error = refusal(&[("modelDescription.xml", xml)]);
        assert!(matches!(error, ImportError::NotAnFmu { .. }), "{xml:?}: {error:?}");
    }
}

#[test]
fn another_version_of_fmi_is_refused_by_name() {
    let xml = r#"<fmiModelDescription fmiVersion="1.0" modelName="old"/>"#;
    let error = refusal(&[("modelDescription.xml", xml)]);
    let ImportError::Version { version, .. } = &error else { panic!("{error:?}") };
    assert_eq!(version, "1.0");
}

#[test]
fn an_fmu_without_co_simulation_is_refused() {
    let xml = r#"<?xml version="1.0"?>
        <fmiModelDescription fmiVersion="3.0" modelName="m" instantiationToken="t">
        <ModelVariables><Float64 name="time" valueReference="0" causality="independent"
        variability="continuous"/></ModelVariables><ModelStructure/></fmiModelDescription>"#;
    let error = refusal(&[("modelDescription.xml", xml)]);
    assert!(matches!(error, ImportError::NotCoSimulation { .. }), "{error:?}");
}

#[test]
fn an_fmu_whose_library_is_missing_or_no_library_is_refused_when_instantiated() {
    let xml = r#"<?xml version="1.0"?>
        <fmiModelDescription fmiVersion="3.0" modelName="m" instantiationToken="t">
        <CoSimulation modelIdentifier="m"/>
        <ModelVariables><Float64 name="time" valueReference="0" causality="independent"
        variability="continuous"/></ModelVariables><ModelStructure/></fmiModelDescription>"#;
    for binary in [None, Some(("binaries/x86_64-linux/m.so", "not a library"))] {
        let folder = tempfile::tempdir().unwrap();
        let mut entries = vec![("modelDescription.xml", xml)];
        entries.extend(binary);
        let importer = open(&archive(folder.path(), &entries)).unwrap();
        let error = importer.instantiate("x").unwrap_err();
        assert!(matches!(error, ImportError::Load { .. }), "{error:?}");
    }
}
