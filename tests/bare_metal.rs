//! The estimators run where there is no operating system: they compile for every target without a
//! standard library that is installed here.

use std::path::Path;
use std::process::Command;

/// Targets without a standard library: microcontrollers with and without a floating-point unit.
const BARE: [&str; 5] = [
    "thumbv7em-none-eabihf",
    "thumbv8m.main-none-eabihf",
    "thumbv6m-none-eabi",
    "riscv32imac-unknown-none-elf",
    "aarch64-unknown-none",
];

#[test]
fn the_estimators_compile_without_a_standard_library() {
    let installed: Vec<_> = BARE.into_iter().filter(|target| is_installed(target)).collect();
    if installed.is_empty() {
        println!("no bare target is installed; `rustup target add {}` gives one", BARE[0]);
    }
    for target in installed {
        let compiled = Command::new(env!("CARGO"))
            .args(["check", "--quiet", "--package", "struna-estimator", "--lib", "--offline"])
            .args([
                "--target",
                target,
                "--target-dir",
                concat!(env!("CARGO_TARGET_TMPDIR"), "/bare"),
            ])
            .current_dir(env!("CARGO_MANIFEST_DIR"))
            // Flags meant for the host would not be understood.
            .env_remove("RUSTFLAGS")
            .output()
            .expect("cargo runs this test, so it is there");
        assert!(
            compiled.status.success(),
            "{target}: {}",
            String::from_utf8_lossy(&compiled.stderr)
        );
        println!("compiled for {target}");
    }
}

/// Whether the libraries of `target` are there.
fn is_installed(target: &str) -> bool {
    let said =
        Command::new("rustc").args(["--print", "target-libdir", "--target", target]).output();
    said.is_ok_and(|said| {
        let folder = String::from_utf8_lossy(&said.stdout);
        Path::new(folder.trim()).read_dir().is_ok_and(|mut files| files.next().is_some())
    })
}
