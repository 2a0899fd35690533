//! `cargo xtask TASK`: the chores of the repository, each in one command.

use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

use xtask::package::{self, Plan};
use xtask::{deny, tidy};

const HELP: &str = "\
Usage: cargo xtask TASK

  ci      Run everything a change must pass (.ci/run)
  spec    Run the specification pages and scenarios only; spec FILTER those whose name contains it
  bench   Run the benchmarks of the kernel
  tidy    Check floors, circles, sizes, names, wording and repeats; --update rewrites the list of exceptions
  deny    Check licences, banned crates and sources of everything that is built (deny.toml)
  doc     Build the documentation of the code, with warnings as errors
  package Make the Debian package and the .tar.gz of both programs in target/package; package FOLDER takes the programs
          of a folder, otherwise they are built for release
";

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().map(Path::to_path_buf).unwrap_or_default()
}

fn run(program: &str, arguments: &[&str], variable: Option<(&str, &str)>) -> bool {
    let mut command = Command::new(program);
    command.args(arguments).current_dir(root()).envs(variable);
    match command.status() {
        Ok(status) => status.success(),
        Err(error) => {
            complain(&format!("'{program}' cannot be started: {error}"));
            false
        }
    }
}

fn cargo(arguments: &[&str]) -> bool {
    run("cargo", arguments, None)
}

#[allow(clippy::print_stderr, reason = "a command line tool")]
fn complain(text: &str) {
    eprintln!("{text}");
}

/// The pages of all kinds. All are run, so that `UPDATE=1` writes all of them.
fn spec(filter: &[&str]) -> bool {
    let pages: [&[&str]; 3] = [
        &["counterpoint-tests", "--test", "emulator", "--test", "tables_spec", "--test", "scenarios"],
        &["counterpoint-lang", "--test", "spec"],
        &["counterpoint-cli", "--test", "tutorial"],
    ];
    let run = |pages: &&[&str]| cargo(&[&["test", "--no-fail-fast", "--package"], *pages, filter].concat());
    pages.iter().filter(|pages| !run(pages)).count() == 0
}

/// Makes the packages of the programs in a folder, or of those that it builds for release.
fn package(programs: Option<&str>) -> bool {
    let build = ["build", "--release", "--package", "counterpoint-server", "--package", "counterpoint-cli", "--bins"];
    if programs.is_none() && !cargo(&build) {
        return false;
    }
    let programs = programs.map_or_else(|| root().join("target/release"), PathBuf::from);
    let plan = Plan { programs, out: root().join("target/package"), debian: cfg!(target_os = "linux"), level: 9 };
    match package::make(&root(), &plan) {
        Ok(made) => made.iter().for_each(|path| complain(&path.display().to_string())),
        Err(error) => {
            complain(&error);
            return false;
        }
    }
    true
}

/// Prints the findings of a check; returns whether there are none.
fn is_clean(findings: Result<Vec<String>, String>) -> bool {
    match findings {
        Ok(findings) => {
            findings.iter().for_each(|finding| complain(finding));
            findings.is_empty()
        }
        Err(error) => {
            complain(&error);
            false
        }
    }
}

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let done = match words[..] {
        ["ci"] => run("bash", &[".ci/run"], None),
        ["spec"] => spec(&[]),
        ["spec", filter] => spec(&[filter]),
        ["bench"] => cargo(&["bench", "--package", "counterpoint-kernel"]),
        ["tidy"] => is_clean(tidy::check(&root(), false)),
        ["tidy", "--update"] => is_clean(tidy::check(&root(), true)),
        ["deny"] => is_clean(deny::check(&root())),
        ["package"] => package(None),
        ["package", programs] => package(Some(programs)),
        ["doc"] => run("cargo", &["doc", "--workspace", "--no-deps"], Some(("RUSTDOCFLAGS", "-D warnings"))),
        _ => {
            complain(HELP);
            matches!(words[..], ["--help" | "-h" | "help"])
        }
    };
    if done { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}
