//! `counterpoint run --step` as its user sees it: commands on standard input, stops on standard output.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::indexing_slicing)]

use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

const UPPER: &str = "O1\nG4P2000\n#500=7\nM101\nG4P1000\nM30\n";
const LOWER: &str = "O2\nG4P500\nM101\nG4P3000\nM30\n";

/// A folder with two programs.
struct Folder(tempfile::TempDir);

impl Folder {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("upper.nc"), UPPER).unwrap();
        std::fs::write(folder.path().join("lower.nc"), LOWER).unwrap();
        Self(folder)
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// Runs both, with these options and this input.
    fn run(&self, options: &[&str], input: &str) -> Output {
        let mut command = Command::new(env!("CARGO_BIN_EXE_counterpoint"));
        command
            .args(["run", "--no-timeline", "--machine", "fanuc-2path-lathe", "--set", "shared=500-999"])
            .args(options);
        command.args([self.path("upper.nc"), self.path("lower.nc")]).env_remove("COUNTERPOINT_SERVER");
        let command = command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut child = command.spawn().expect("it starts");
        child.stdin.take().unwrap().write_all(input.as_bytes()).unwrap();
        child.wait_with_output().unwrap()
    }
}

fn text(output: &Output) -> (String, String) {
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    (text(&output.stdout), text(&output.stderr))
}

fn read(folder: &Path, name: &str) -> String {
    std::fs::read_to_string(folder.join(name)).unwrap()
}

#[test]
fn a_script_steps_through_two_channels_and_changes_nothing() {
    let folder = Folder::new();
    let (free, out) = (folder.path("free"), folder.path("stepped"));
    assert_eq!(folder.run(&["--out", free.to_str().unwrap()], "").status.code(), Some(0));
    let script = "\
step 1 x2               ; the dwell of channel 1
step all
until wait M101
break write #500
break time 2.5
continue
show
clear
hold 2
continue
resume
";
    let output = folder.run(&["--step", "--out", out.to_str().unwrap()], script);
    let (said, status) = text(&output);
    assert_eq!(output.status.code(), Some(0), "{said}{status}");
    let expected = "\
stop: step
  1  00:00.000    before  upper.nc:1  O1
  2  00:00.000    before  lower.nc:1  O2
stop: step
  1  00:02.000    before  upper.nc:3  #500=7
  2  00:00.000    before  lower.nc:1  O2
";
    assert!(said.starts_with(expected), "{said}");
    let reasons: Vec<&str> = said.lines().filter_map(|line| line.strip_prefix("stop: ")).collect();
    assert_eq!(
        reasons,
        [
            "step",
            "step",
            "step",
            "channel 2 reaches M101 (breakpoint 1)",
            "channel 1 has written #500=7 (breakpoint 2)",
            "no channel can continue; on feed hold: 2",
        ]
    );
    assert!(said.contains("shared variables: #500=7\n") && said.contains("breakpoint 3: time 2.5\n"), "{said}");
    assert!(said.contains("SUCCEEDED"), "the report follows: {said}");
    for name in ["events.jsonl", "summary.json", "timeline.json", "upper.lce"] {
        assert_eq!(read(&out, name), read(&free, name), "{name}");
    }
}

#[test]
fn a_reset_fails_the_job_and_says_so() {
    let folder = Folder::new();
    let output = folder.run(&["--step"], "step all x2\nreset 2\nquit\n");
    let (said, status) = text(&output);
    assert_eq!(output.status.code(), Some(1), "{said}{status}");
    assert!(said.contains("2900370") && said.contains("channel 2 is reset by the operator before 'M101'"), "{said}");
}

#[test]
fn what_is_no_command_ends_a_script_with_its_line() {
    let folder = Folder::new();
    let output = folder.run(&["--step"], "step\n\njump 3\n");
    let (said, status) = text(&output);
    assert_eq!(output.status.code(), Some(2), "{said}{status}");
    assert!(status.contains("line 3 of the commands: 'jump 3' is not a command; help lists the commands"), "{status}");
    for option in ["--json", "--quiet", "--attend"] {
        let output = folder.run(&["--step", option], "");
        assert_eq!(output.status.code(), Some(2));
        assert!(text(&output).1.contains("it goes without --attend, --json and --quiet"));
    }
}

#[test]
fn a_command_that_is_not_possible_is_said_and_the_script_goes_on() {
    let folder = Folder::new();
    let output = folder.run(&["--step"], "step 9\nhold 1\nstep 1\nhelp\n");
    let (said, status) = text(&output);
    assert_eq!(output.status.code(), Some(0), "{said}{status}");
    assert!(status.contains("the job has no channel 9; it has 1, 2"), "{status}");
    assert!(
        status.contains("channel 1 is on feed hold: resume it first") && status.contains("run one block"),
        "{status}"
    );
    assert!(said.contains("SUCCEEDED"), "{said}");
}

#[test]
fn a_breakpoint_that_no_channel_can_reach_is_refused() {
    let folder = Folder::new();
    let script =
        "break write TEMPERATURE\nbreak write #1\nbreak line upper.nc:99\nbreak line none.nc:1\nbreak write #500\n";
    let output = folder.run(&["--step"], script);
    let (said, status) = text(&output);
    assert_eq!(output.status.code(), Some(0), "{said}{status}");
    for part in [
        "no program or macro of this job has a variable 'TEMPERATURE'",
        "#1 belongs to each channel",
        "there is no line 99",
        "the job has no file 'none.nc'",
    ] {
        assert!(status.contains(part), "{part} in {status}");
    }
}
