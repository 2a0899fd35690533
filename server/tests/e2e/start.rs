//! The start of `counterpointd`: its log, and the reasons and exit codes of starts that fail.

use std::path::Path;
use std::process::Command;

/// Exit code and standard error of a server that does not start.
fn refused(folder: &Path, arguments: &[&str]) -> (Option<i32>, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_counterpointd"));
    command.args(["--listen", "127.0.0.1:0", "--data"]).arg(folder).args(arguments);
    let output = command.output().unwrap();
    (output.status.code(), String::from_utf8(output.stderr).unwrap())
}

/// The unit restarts the server after exit code 3 only.
#[test]
fn a_mistake_in_the_configuration_and_trouble_of_the_system_have_different_exit_codes() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("file");
    std::fs::write(&file, "quue = 3\n").unwrap();
    let path = file.to_str().unwrap();
    for mistake in [
        &["--config", path][..],
        &["--quue", "3"],
        &["--access", path],
        &["--tls-cert", path, "--tls-key", path],
        &["--metrics", "here"],
    ] {
        let (code, text) = refused(&folder.path().join("data"), mistake);
        assert_eq!(code, Some(2), "{mistake:?}: {text}");
    }
    let taken = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let address = taken.local_addr().unwrap().to_string();
    for (data, trouble) in [("data", &["--metrics", &address][..]), ("file", &[])] {
        let (code, text) = refused(&folder.path().join(data), trouble);
        assert_eq!(code, Some(3), "{data} {trouble:?}: {text}");
    }
}
