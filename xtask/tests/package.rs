//! The packages of the programs: their contents, installation and removal, which keeps the data of the server.

#![allow(missing_docs, clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::print_stderr)]

mod built;

use std::path::PathBuf;
use std::process::{Command, Output};
use std::sync::OnceLock;

use built::{done, programs, root};
use xtask::package::{Plan, make};

/// The packages, built once for all tests in a folder beside the programs.
fn packages() -> &'static [PathBuf] {
    static MADE: OnceLock<Vec<PathBuf>> = OnceLock::new();
    MADE.get_or_init(|| {
        let programs = programs();
        let out = programs.join("package");
        make(&root(), &Plan { programs, out, debian: cfg!(target_os = "linux"), level: 0 }).unwrap()
    })
}

#[test]
fn the_archive_has_programs_that_run_and_all_licences() {
    let folder = tempfile::tempdir().unwrap();
    let made = packages();
    done(Command::new("tar").arg("-xzf").arg(&made[0]).arg("-C").arg(folder.path()));
    let name = made[0].file_name().unwrap().to_string_lossy().into_owned();
    let unpacked = folder.path().join(name.strip_suffix(".tar.gz").unwrap());
    for program in ["counterpoint", "counterpointd"] {
        let version = done(Command::new(unpacked.join("usr/bin").join(program)).arg("--version"));
        assert!(version.contains(env!("CARGO_PKG_VERSION")), "{version}");
    }
    for path in [
        "usr/share/man/man1/counterpoint-run.1.gz",
        "usr/share/man/man8/counterpointd.8.gz",
        "usr/share/man/man8/counterpointd-token-new.8.gz",
        "usr/share/bash-completion/completions/counterpoint",
        "usr/share/zsh/vendor-completions/_counterpoint",
        "usr/share/fish/vendor_completions.d/counterpoint.fish",
        "usr/lib/systemd/system/counterpointd.service",
        "etc/counterpoint/counterpointd.toml",
        "usr/share/doc/counterpoint/LICENSE-MIT",
        "usr/share/doc/counterpoint/docs/operations.md",
        "usr/share/doc/counterpoint/docs/security.md",
        "usr/share/doc/counterpoint/docs/diagnostics/README.md",
        "usr/share/doc/counterpoint/deploy/README.md",
        "usr/share/doc/counterpoint/deploy/prometheus/rules.yaml",
        "usr/share/doc/counterpoint/proto/counterpoint/v1/jobs.proto",
        "usr/share/doc/counterpoint/clients/python/pyproject.toml",
    ] {
        assert!(unpacked.join(path).is_file(), "{path}");
    }
    let text = |path: &str| std::fs::read_to_string(unpacked.join("usr/share/doc/counterpoint").join(path)).unwrap();
    let example = text("counterpointd.toml.example");
    assert!(example.contains("# Maximum size of a blob, bytes\nmax_blob_bytes = "), "{example}");
    assert!(example.contains("\ndata = \"/var/lib/counterpoint\"\n"), "{example}");
    let instructions = text("deploy/README.md");
    assert!(instructions.contains("useradd --system") && instructions.contains("counterpoint-VERSION-linux"));
    let licences = text("copyright");
    for part in ["\ntokio 1.", "\ntonic 0.", "Permission is hereby granted", "Apache License", "standard library"] {
        assert!(licences.contains(part), "{part}");
    }
    assert!(!licences.contains("\nprost-reflect 0."), "crates of tests only are not in the programs");
}

/// Installs the package in a throwaway layer over this system, with a `/tmp` of its own.
#[cfg(target_os = "linux")]
#[test]
fn the_debian_package_installs_runs_and_keeps_the_data() {
    let folder = tempfile::tempdir().unwrap();
    let made = packages();
    for (tool, argument) in [("dpkg-deb", "--info"), ("dpkg-deb", "--contents")] {
        match Command::new(tool).arg(argument).arg(&made[1]).output() {
            Ok(output) => assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr)),
            Err(error) => return eprintln!("skipped: {tool}: {error}"),
        }
    }
    let layers = folder.path().join("layers");
    std::fs::create_dir(&layers).unwrap();
    let mut inside = Command::new("unshare");
    inside.args(["--mount", "--pid", "--fork", "--kill-child", "sh", "-e", "-c"]);
    inside.arg(
        "mount -t tmpfs tmpfs \"$1\"; mkdir \"$1\"/upper \"$1\"/work \"$1\"/tree
        mount -t overlay overlay -o \"lowerdir=/,upperdir=$1/upper,workdir=$1/work\" \"$1\"/tree
        mount --bind /dev \"$1\"/tree/dev; mount -t proc proc \"$1\"/tree/proc; mount -t tmpfs tmpfs \"$1\"/tree/run
        mkdir -p \"$1\"/tree/tmp; mount -t tmpfs tmpfs \"$1\"/tree/tmp
        cp \"$2\" \"$1\"/tree/run/counterpoint.deb; cp \"$3\" \"$1\"/tree/run/inside.sh
        cp \"$4\" \"$1\"/tree/run/security.md
        command -v dpkg >/dev/null; chroot \"$1\"/tree true; echo ready",
    );
    inside.arg("sh").arg(&layers).arg(&made[1]).arg(root().join("xtask/tests/installed.sh"));
    inside.arg(root().join("docs/security.md"));
    let probe = inside.output();
    let ready = |output: &Output| output.status.success() && String::from_utf8_lossy(&output.stdout).contains("ready");
    match probe {
        Ok(output) if ready(&output) => {}
        Ok(output) => {
            return eprintln!("skipped: no layer over this system: {}", String::from_utf8_lossy(&output.stderr));
        }
        Err(error) => return eprintln!("skipped: unshare: {error}"),
    }
    let script = inside.get_args().map(|part| part.to_string_lossy().into_owned()).collect::<Vec<_>>();
    let mut whole = Command::new("unshare");
    whole.args(&script[..7]).arg(format!("{}; chroot \"$1\"/tree sh -e /run/inside.sh", script[7]));
    let text = done(whole.args(&script[8..]));
    let parts = ["installed", "ran a job", "guarded", "kept on remove", "kept on purge"];
    for part in parts.into_iter().chain(["removed as asked", "removed when empty"]) {
        assert!(text.contains(&format!("ok: {part}")), "{part}: {text}");
    }
}
