//! docs/tutorial-control.md is true: its files are written and its commands are run from top to bottom.
//!
//! Fences of the page: a language and a file name write a file (`more` at its end, `first` at its beginning, `after
//! KEY` after the line of a key), and the name is in bold above the fence; `console` holds commands after `$`, each
//! with its output, standard output first. The resulting folder is the shipped machine, and the programs are those of
//! the examples.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::indexing_slicing)]

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode, Stdio};

use counterpoint_mdspec::{Check, Example, Fences, Role, Suite};

/// Languages of files, and commands.
const FENCES: Fences = &[
    ("toml", Role::Program),
    ("macro", Role::Program),
    ("nc", Role::Program),
    ("text", Role::Program),
    ("console", Role::Program),
];

fn project() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap().to_owned()
}

/// The output of a command of the page.
fn run(folder: &Path, command: &str) -> String {
    let words: Vec<&str> = command.split(' ').collect();
    let printed = match words.as_slice() {
        ["cat", file] => std::fs::read_to_string(folder.join(file)).unwrap(),
        ["counterpoint", arguments @ ..] => {
            let mut program = Command::new(env!("CARGO_BIN_EXE_counterpoint"));
            program.args(arguments).current_dir(folder).env_remove("COUNTERPOINT_SERVER").stdin(Stdio::null());
            let output = program.output().unwrap();
            let [out, talk] = [output.stdout, output.stderr].map(|bytes| String::from_utf8(bytes).unwrap());
            out + &talk
        }
        _ => panic!("the page may not run '{command}'"),
    };
    printed.trim_end().lines().fold(String::new(), |mut text, line| {
        let _ = writeln!(text, "{}", line.trim_end());
        text
    })
}

/// Writes a file of the page, or changes one.
fn write(folder: &Path, name: &str, how: &[&str], text: &str) {
    let path = folder.join(name);
    std::fs::create_dir_all(path.parent().unwrap()).unwrap();
    let old = std::fs::read_to_string(&path).unwrap_or_default();
    let text = match how {
        [] => text.to_owned(),
        ["more"] => old + text,
        ["first"] => text.to_owned() + &old,
        ["after", key] => {
            let begin = format!("{key} =");
            let at = old.lines().position(|line| line.starts_with(&begin)).expect(key);
            let lines: Vec<&str> = old.lines().collect();
            let (before, behind) = lines.split_at(at + 1);
            format!("{}\n{text}{}\n", before.join("\n"), behind.join("\n"))
        }
        other => panic!("no file is written like {other:?}"),
    };
    std::fs::write(path, text).unwrap();
}

/// Files below a folder, by path, with their texts.
fn files(folder: &Path) -> Vec<(PathBuf, String)> {
    let mut found = Vec::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(next) = folders.pop() {
        for entry in std::fs::read_dir(next).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else {
                let name = path.strip_prefix(folder).unwrap().to_owned();
                found.push((name, std::fs::read_to_string(path).unwrap()));
            }
        }
    }
    found.sort();
    found
}

/// Writes the files of the page and runs its commands, from top to bottom.
fn steps(examples: &[Example], check: &mut Check<'_>) {
    let folder = tempfile::tempdir().unwrap();
    let (mut line, mut steps) = (1, 0);
    for fence in examples.iter().flat_map(|example| &example.fences) {
        line = fence.line;
        if fence.kind == "console" {
            steps += 1;
            let mut found = String::new();
            for command in fence.body.text.lines().filter_map(|line| line.strip_prefix("$ ")) {
                let _ = write!(found, "$ {command}\n{}", run(folder.path(), command));
            }
            check.outcome(fence, &found);
            continue;
        }
        let mut words = fence.words.split(' ');
        let name = words.next().unwrap_or_default();
        if !fence.above.starts_with(&format!("**{name}**")) {
            check.wrong(fence.line, &format!("no name above the fence of {name}"));
        }
        write(folder.path(), name, &words.collect::<Vec<_>>(), &fence.body.text);
    }
    assert!(steps >= 9, "{steps}");
    let mut same = |what: &str, same: bool| {
        if !same {
            check.wrong(line, &format!("what the page has written is not {what}"));
        }
    };
    same(
        "machines/tern-bar-lathe",
        files(&folder.path().join("tern")) == files(&project().join("machines/tern-bar-lathe")),
    );
    for (name, text) in files(&project().join("examples/bar-part")) {
        let written = std::fs::read_to_string(folder.path().join(&name)).unwrap_or_default();
        same(&format!("examples/bar-part/{}", name.display()), text == written);
    }
}

fn the_shipped_machine_runs_its_example() -> Result<(), String> {
    let example = project().join("examples/bar-part");
    let [program, answers] = ["pin.nc", "answers.toml"].map(|name| example.join(name).display().to_string());
    let machine = ["run", "--machine", "tern-bar-lathe", "--answers", &answers, "--no-timeline", &program];
    let output = Command::new(env!("CARGO_BIN_EXE_counterpoint")).args(machine).stdin(Stdio::null()).output().unwrap();
    let out = String::from_utf8_lossy(&output.stdout);
    if output.status.success() && out.starts_with("SUCCEEDED") { Ok(()) } else { Err(out.into_owned()) }
}

fn main() -> ExitCode {
    let mut suite = Suite::whole(&project().join("docs/tutorial-control.md"), FENCES, steps);
    suite.test("the_shipped_machine_runs_its_example", the_shipped_machine_runs_its_example);
    suite.run()
}
