//! Programs that a test builds and runs.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// Root of the repository.
pub(crate) fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// Runs a command that must succeed; returns its output.
pub(crate) fn done(command: &mut Command) -> String {
    let Output { status, stdout, stderr } = command.output().unwrap_or_else(|error| panic!("{command:?}: {error}"));
    let text = String::from_utf8_lossy(&[stdout, stderr].concat()).into_owned();
    assert!(status.success(), "{command:?}: {text}");
    text
}

/// Folder of both programs: `COUNTERPOINT_PROGRAMS`, otherwise that of this test, where they are built.
pub(crate) fn programs() -> PathBuf {
    if let Some(folder) = std::env::var_os("COUNTERPOINT_PROGRAMS") {
        return PathBuf::from(folder);
    }
    let folder = std::env::current_exe().unwrap().parent().unwrap().parent().unwrap().to_path_buf();
    let mut cargo = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    cargo.args(["build", "--bins", "--package", "counterpoint-server", "--package", "counterpoint-cli"]);
    if folder.file_name().is_some_and(|name| name == "release") {
        cargo.arg("--release");
    }
    done(cargo.current_dir(root()));
    folder
}
