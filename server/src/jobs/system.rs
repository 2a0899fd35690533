//! Commands of the operating system for macros.
//!
//! A command runs in a temporary folder with the files of its job, in a process group of its own that is ended when the
//! time is over or the job is cancelled. Invariant: nothing is started unless the server's owner has allowed it; files
//! of the server are never in that folder, though the command has the rights of the server.

use std::collections::BTreeMap;
use std::io::{self, Read as _};
use std::path::{Path, PathBuf};
use std::process::{Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

use counterpoint_kernel::files::Bytes;
use counterpoint_kernel::system::{CommandOutcome, System, SystemCommand};
use process_wrap::std::{ChildWrapper, CommandWrap};

/// Status of a command that could not be started or was ended.
const FAILED: i32 = 5;
/// Bytes of output that are kept.
const MOST_OUTPUT: u64 = 64 << 10;
/// Bytes in all files that are taken back.
const MOST_BYTES: u64 = 64 << 20;
/// Files that are looked at afterwards.
const MOST_FILES: usize = 10_000;
/// Time between two looks at a running command.
const LOOK: Duration = Duration::from_millis(5);

/// The shell of the system.
#[derive(Debug)]
pub(crate) struct Shell {
    folder: PathBuf,
    patience: Duration,
}

impl Shell {
    /// Commands get temporary folders below `folder` and that many seconds.
    pub(crate) fn new(folder: PathBuf, seconds: u64) -> Self {
        Self { folder, patience: Duration::from_secs(seconds) }
    }

    fn try_run(&self, call: &SystemCommand<'_>, cancelled: &dyn Fn() -> bool) -> io::Result<CommandOutcome> {
        let place = tempfile::Builder::new().prefix("system-").tempdir_in(&self.folder)?;
        // The shell starts elsewhere, so relative names of the data folder would not do. Not the canonical path: the
        // shell of Windows cannot start in one.
        let root = std::path::absolute(place.path())?;
        let (job, storage, said) = (root.join("job"), root.join("storage"), root.join("output"));
        lay_out(&job, &call.files)?;
        lay_out(&storage, &call.storage)?;
        let folder = job.join(call.folder);
        std::fs::create_dir_all(&folder)?;
        let output = std::fs::File::create(&said)?;
        let mut shell = shell(&with_storage(call.command, &storage));
        clear_environment(&mut shell, &root);
        shell.current_dir(&folder).stdin(Stdio::null()).stderr(output.try_clone()?).stdout(output);
        let mut command = CommandWrap::from(shell);
        #[cfg(unix)]
        command.wrap(process_wrap::std::ProcessGroup::leader());
        #[cfg(windows)]
        command.wrap(process_wrap::std::JobObject);
        let mut child = command.spawn()?;
        drop(command);
        let (status, note) = match self.wait(&mut *child, cancelled)? {
            Some(status) => (status.code().unwrap_or(FAILED), String::new()),
            None => (FAILED, format!("the command was ended after {} s\n", self.patience.as_secs())),
        };
        let mut bytes = Vec::new();
        std::fs::File::open(&said)?.take(MOST_OUTPUT).read_to_end(&mut bytes)?;
        let output = String::from_utf8_lossy(&bytes).into_owned() + &note;
        let mut answer = CommandOutcome { status, output, ..CommandOutcome::default() };
        changes(&job, &call.files, &mut answer)?;
        Ok(answer)
    }

    /// Waits for the end; none if the command had to be ended.
    fn wait(&self, child: &mut dyn ChildWrapper, cancelled: &dyn Fn() -> bool) -> io::Result<Option<ExitStatus>> {
        let begin = Instant::now();
        loop {
            if let Some(status) = child.try_wait()? {
                return Ok(Some(status));
            }
            if begin.elapsed() >= self.patience || cancelled() {
                child.kill()?;
                return Ok(None);
            }
            std::thread::sleep(LOOK);
        }
    }
}

impl System for Shell {
    fn run(&self, call: &SystemCommand<'_>, cancelled: &dyn Fn() -> bool) -> CommandOutcome {
        tracing::info!(command = call.command, "a macro starts a command");
        self.try_run(call, cancelled).unwrap_or_else(|error| CommandOutcome {
            status: FAILED,
            output: format!("the command could not be run: {error}"),
            ..CommandOutcome::default()
        })
    }
}

/// Gives a command the variables for finding programs, and nothing else of the server's environment.
fn clear_environment(command: &mut Command, root: &Path) {
    command.env_clear();
    #[cfg(not(windows))]
    command.env("PATH", "/usr/local/bin:/usr/bin:/bin").env("HOME", root).env("TMPDIR", root);
    #[cfg(windows)]
    for name in ["PATH", "PATHEXT", "SystemRoot", "ComSpec"] {
        command.envs(std::env::var_os(name).map(|value| (name, value)));
    }
    #[cfg(windows)]
    command.env("TEMP", root).env("TMP", root);
}

#[cfg(not(windows))]
fn shell(text: &str) -> Command {
    let mut command = Command::new("sh");
    command.args(["-c", text]);
    command
}

#[cfg(windows)]
fn shell(text: &str) -> Command {
    let mut command = Command::new("cmd");
    command.args(["/C", text]);
    command
}

/// The command with real paths in place of those of the storage.
fn with_storage(command: &str, storage: &Path) -> String {
    const ROOT: &str = "//icamfs/";
    let lower = command.to_ascii_lowercase();
    let mut out = String::new();
    let mut rest = 0;
    for (at, _) in lower.match_indices(ROOT) {
        out.push_str(command.get(rest..at).unwrap_or_default());
        out.push_str(&storage.display().to_string());
        out.push('/');
        rest = at + ROOT.len();
    }
    out.push_str(command.get(rest..).unwrap_or_default());
    out
}

/// Writes files; their paths have been checked when they came in.
fn lay_out(folder: &Path, files: &[(String, Bytes)]) -> io::Result<()> {
    std::fs::create_dir_all(folder)?;
    for (path, content) in files {
        let place = folder.join(path);
        if let Some(parent) = place.parent() {
            std::fs::create_dir_all(parent)?;
        }
        std::fs::write(&place, content)?;
        #[cfg(unix)]
        if content.starts_with(b"#!") || content.starts_with(b"\x7fELF") {
            use std::os::unix::fs::PermissionsExt as _;
            std::fs::set_permissions(&place, std::fs::Permissions::from_mode(0o700))?;
        }
    }
    Ok(())
}

/// Looks for new and changed files, and for those that are gone. Links are not followed.
fn changes(folder: &Path, before: &[(String, Bytes)], answer: &mut CommandOutcome) -> io::Result<()> {
    let mut gone: BTreeMap<&str, &Bytes> = before.iter().map(|(path, content)| (path.as_str(), content)).collect();
    let (mut bytes, mut count) = (0, 0);
    let mut folders = vec![(folder.to_owned(), String::new())];
    while let Some((folder, prefix)) = folders.pop() {
        for entry in std::fs::read_dir(&folder)? {
            let entry = entry?;
            let kind = entry.file_type()?;
            let Ok(name) = entry.file_name().into_string() else { continue };
            let path = format!("{prefix}{name}");
            count += 1;
            if count > MOST_FILES {
                return Err(io::Error::other(format!("it left more than {MOST_FILES} files")));
            }
            if kind.is_dir() {
                folders.push((entry.path(), format!("{path}/")));
                continue;
            }
            if !kind.is_file() {
                continue;
            }
            bytes += entry.metadata()?.len();
            if bytes > MOST_BYTES {
                return Err(io::Error::other(format!("its files have more than {MOST_BYTES} bytes")));
            }
            let content = std::fs::read(entry.path())?;
            if gone.remove(path.as_str()).is_none_or(|old| **old != *content) {
                answer.written.push((path, String::from_utf8_lossy(&content).into_owned()));
            }
        }
    }
    answer.written.sort_unstable();
    answer.removed = gone.into_keys().map(str::to_owned).collect();
    Ok(())
}

#[cfg(test)]
#[cfg(unix)]
mod tests {
    use super::*;

    fn run(command: &str, seconds: u64) -> CommandOutcome {
        let folder = tempfile::tempdir().unwrap();
        let file = |path: &str, text: &str| (path.to_owned(), Bytes::copy_from_slice(text.as_bytes()));
        let call = SystemCommand {
            command,
            folder: "sub",
            files: vec![file("a.txt", "one\n"), file("sub/b.txt", "two\n")],
            storage: vec![file("tool.sh", "#!/bin/sh\necho stored $1\n")],
        };
        Shell::new(folder.path().to_owned(), seconds).run(&call, &|| false)
    }

    #[test]
    fn a_command_works_on_the_files_of_the_job() {
        let answer = run("cat ../a.txt b.txt; echo new > c.txt; rm b.txt; echo changed > ../a.txt; exit 3", 30);
        let written = [("a.txt", "changed\n"), ("sub/c.txt", "new\n")];
        let written = written.map(|(path, text)| (path.to_owned(), text.to_owned())).to_vec();
        let removed = vec!["sub/b.txt".to_owned()];
        assert_eq!(answer, CommandOutcome { status: 3, output: "one\ntwo\n".to_owned(), written, removed });
    }

    #[test]
    fn files_of_the_machine_can_be_started_and_links_are_not_followed() {
        let answer = run("//ICAMFS/tool.sh 7; ln -s /etc/passwd link; echo oops >&2", 30);
        assert_eq!((answer.status, answer.output.as_str()), (0, "stored 7\noops\n"));
        assert_eq!((answer.written, answer.removed), (vec![], vec![]));
    }

    #[test]
    fn a_command_sees_nothing_of_the_servers_environment() {
        let answer = run("env", 30);
        let names: Vec<&str> = answer.output.lines().filter_map(|line| Some(line.split_once('=')?.0)).collect();
        let allowed = ["HOME", "PATH", "PWD", "OLDPWD", "SHLVL", "TMPDIR", "_"];
        assert!(names.contains(&"PATH") && names.iter().all(|name| allowed.contains(name)), "{names:?}");
    }

    #[test]
    fn a_command_that_does_not_end_is_ended_with_all_it_started() {
        let answer = run("sleep 600 & sleep 600", 0);
        assert_eq!((answer.status, answer.output.as_str()), (FAILED, "the command was ended after 0 s\n"));
    }
}
