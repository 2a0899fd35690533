//! Jobs with stepping.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::indexing_slicing, missing_docs)]

use std::collections::VecDeque;
use std::sync::{Arc, Mutex};
use std::time::Duration;

use counterpoint_kernel::control::{ChannelActivity, JobControl, StopSignal};
use counterpoint_kernel::dialog::answers::DialogValue;
use counterpoint_kernel::files::MemoryFiles;
use counterpoint_kernel::job::{Job, LogSink, ProgramSelection, RunEnd, Spec};
use counterpoint_kernel::log::builder::ResultsBuilder;
use counterpoint_kernel::log::event::Event;
use counterpoint_kernel::log::summary::{self, ChannelState, Summary};
use counterpoint_kernel::machine::{load, package};
use counterpoint_kernel::operator::{
    BreakLocation, Breakpoint, Console, Heard, StepCalls, StepCommand, StepReply, StepReport, Whom,
};
use counterpoint_kernel::options::JobOptions;

const S: i64 = 1_000_000_000;

#[derive(Default)]
struct Log(Vec<Event>);

impl LogSink for Log {
    fn events(&mut self, _first_seq: u64, batch: &[Event]) -> bool {
        self.0.extend_from_slice(batch);
        true
    }
}

/// The commands of the operator, each at a stop, and the answers.
#[derive(Default)]
struct Script {
    commands: Mutex<VecDeque<StepCommand>>,
    said: Mutex<Vec<StepReply>>,
    /// Ends the job when the commands are used up; otherwise the operator leaves.
    cancels: Option<StopSignal>,
}

impl Console for Script {
    fn has_news(&self) -> bool {
        false
    }

    fn poll(&self) -> Heard {
        Heard::Nothing
    }

    fn wait(&self, _at_most: Duration) -> Heard {
        match (self.commands.lock().unwrap().pop_front(), &self.cancels) {
            (Some(command), _) => Heard::Command(command),
            (None, Some(stop)) => {
                stop.ask();
                Heard::Nothing
            }
            (None, None) => Heard::Gone,
        }
    }

    fn say(&self, said: StepReply) {
        self.said.lock().unwrap().push(said);
    }
}

fn job(machine: &str, programs: &[&str], threads: u16) -> (Job, MemoryFiles) {
    // Its channels share the common variables.
    let text = format!(
        "extends = \"{machine}\"\n\n[ce]\nname = \"{machine}\"\n\n[variables]\nshared = [[100, 199], [500, 999]]\nchannel = []\n"
    );
    let mut own = MemoryFiles::default();
    own.insert("sharing/machine.toml", text);
    let machine = load(&package::Overlay::over_shipped(own), "sharing").machine.expect("a machine");
    let mut files = MemoryFiles::default();
    let mut list = Vec::new();
    for (index, text) in programs.iter().enumerate() {
        let name = format!("jobs/p{}.nc", index + 1);
        files.insert(name.clone(), text.as_bytes());
        list.push(ProgramSelection { file: name, number: None, section: None, channel: None });
    }
    let options = JobOptions { threads, ..JobOptions::default() };
    let spec = Spec { machine: machine.into(), programs: list, options };
    (Job::prepare(spec, &files).expect("a job that can run"), files)
}

fn ended(job: &Job, log: &Log, outcome: &RunEnd) -> Summary {
    let mut builder = ResultsBuilder::new(job.info());
    log.0.iter().for_each(|event| builder.event(event));
    builder.finish(outcome).summary
}

/// Runs a job as it is.
fn free(machine: &str, programs: &[&str]) -> Summary {
    let (job, files) = job(machine, programs, 0);
    let mut log = Log::default();
    let outcome = job.run(&files, &JobControl::new(job.info().channels.len()), &mut log);
    ended(&job, &log, &outcome)
}

/// Runs a job with these commands; also returns the reports.
fn stepped(machine: &str, programs: &[&str], commands: Vec<StepCommand>, cancelled: bool) -> (Summary, Vec<StepReply>) {
    let (job, files) = job(machine, programs, 0);
    let stop = StopSignal::default();
    let script =
        Script { commands: Mutex::new(commands.into()), cancels: cancelled.then(|| stop.clone()), ..Script::default() };
    let script = Arc::new(script);
    let control = JobControl::new(job.info().channels.len()).with_stop(stop).with_console(script.clone());
    let mut log = Log::default();
    let outcome = job.run(&files, &control, &mut log);
    let said = std::mem::take(&mut *script.said.lock().unwrap());
    (ended(&job, &log, &outcome), said)
}

/// Lines of the channels at each stop, with its reason.
fn stops(said: &[StepReply]) -> Vec<(String, Vec<u32>)> {
    let stop = |said: &StepReply| match said {
        StepReply::Stopped(report) => {
            Some((report.reason.clone(), report.channels.iter().map(|one| one.line).collect()))
        }
        _ => None,
    };
    said.iter().filter_map(stop).collect()
}

fn reports(said: &[StepReply]) -> Vec<&StepReport> {
    let report = |said| match said {
        &StepReply::Stopped(ref report) | &StepReply::State(ref report) => Some(report),
        _ => None,
    };
    said.iter().filter_map(report).collect()
}

fn step(whom: Whom, blocks: u32) -> StepCommand {
    StepCommand::Step { whom, blocks, calls: StepCalls::Into }
}

fn at(spot: BreakLocation) -> StepCommand {
    StepCommand::Add(Breakpoint { id: 0, spot, count: 0, once: false })
}

fn line(file: &str, line: u32) -> BreakLocation {
    BreakLocation::Line { file: file.into(), line }
}

/// 2 s, a meeting, 1 s; 0.5 s, the meeting, 3 s.
const TWO: [&str; 2] = ["G4P2000\nM101\nG4P1000\nM30\n", "G4P500\nM101\nG4P3000\nM30\n"];

#[test]
fn blocks_of_one_channel_and_of_all() {
    let commands = vec![
        step(Whom::One(1), 1),
        step(Whom::One(1), 1),
        step(Whom::All, 1),
        step(Whom::Next, 1),
        step(Whom::One(2), 1),
        // The end of channel 2 comes after that of channel 1, with which the job ends.
        step(Whom::One(2), 1),
    ];
    let (summary, said) = stepped("fanuc-2path-lathe", &TWO, commands, false);
    assert_eq!(
        stops(&said),
        [
            ("step".into(), vec![1, 1]),
            // The dwell of channel 1 is over, channel 2 has not begun.
            ("step".into(), vec![2, 1]),
            ("channel 1 is waiting".into(), vec![2, 1]),
            // Channel 1 is within its block and channel 2 does one.
            ("step".into(), vec![2, 2]),
            // The meeting: both are at their third block.
            ("step".into(), vec![3, 3]),
            ("step".into(), vec![3, 4]),
        ]
    );
    assert_eq!(summary.log_digest, free("fanuc-2path-lathe", &TWO).log_digest);
    let first = reports(&said)[2];
    let one = &first.channels[0];
    assert_eq!((one.state, one.t_ns, one.in_block, &*one.block), (ChannelActivity::Waiting, 2 * S, true, "M101"));
    assert_eq!(&*one.wait.as_ref().unwrap().key, "M101");
    let two = &first.channels[1];
    assert_eq!((two.state, two.t_ns, two.in_block, &*two.block), (ChannelActivity::Running, 0, false, "G4P500"));
}

#[test]
fn a_block_under_way_is_the_first_of_a_step() {
    let commands = vec![
        at(BreakLocation::Wait(String::new())),
        StepCommand::Continue,
        step(Whom::One(2), 1),
        step(Whom::One(2), 1),
    ];
    let (_, said) = stepped("fanuc-2path-lathe", &TWO, commands, false);
    assert_eq!(
        stops(&said)[1..],
        [
            ("channel 2 reaches M101 (breakpoint 1)".into(), vec![2, 2]),
            ("channel 2 is waiting".into(), vec![2, 2]),
            // Channel 1 is needed, and stopped where it comes to the wait.
            ("channel 1 reaches M101 (breakpoint 1)".into(), vec![2, 2]),
        ]
    );
    let commands = vec![
        StepCommand::Add(Breakpoint { id: 0, spot: BreakLocation::Wait("M101".into()), count: 1, once: true }),
        StepCommand::Continue,
        step(Whom::One(2), 1),
        step(Whom::One(2), 1),
        step(Whom::Next, 1),
    ];
    let (_, said) = stepped("fanuc-2path-lathe", &TWO, commands, false);
    let after: Vec<(String, Vec<u32>)> = stops(&said)[3..].to_vec();
    assert_eq!(after, [("step".to_owned(), vec![3, 3]), ("step".to_owned(), vec![4, 3])]);
    assert_eq!(reports(&said)[4].channels[1].t_ns, 2 * S);
}

#[test]
fn breakpoints_at_waits_lines_times_and_writes() {
    let programs = ["G4P1000\n#500=7\nM101\n#500=8\nM30\n", "#1=3\nG50X50.Z2.\nG4P500\nM101\n#501=#500\nM30\n"];
    let commands = vec![
        at(BreakLocation::Time(400_000_000)),
        at(line("p1.nc", 2)),
        at(BreakLocation::Wait("101".into())),
        at(BreakLocation::Write("#500".into())),
        at(line("p1.nc", 9)),
        StepCommand::Remove(5),
        StepCommand::Continue,
        StepCommand::Continue,
        StepCommand::Continue,
        StepCommand::Continue,
        StepCommand::Continue,
        StepCommand::Continue,
        StepCommand::Continue,
    ];
    let (summary, said) = stepped("fanuc-2path-lathe", &programs, commands, false);
    let reasons: Vec<String> = stops(&said).into_iter().skip(1).map(|(reason, _)| reason).collect();
    assert_eq!(
        reasons,
        [
            // The first block that begins at 0.4 s or later, in the order of simulated time.
            "channel 2 reaches jobs/p2.nc:4 (breakpoint 1)",
            "channel 2 reaches M101 (breakpoint 3)",
            "channel 1 reaches jobs/p1.nc:2 (breakpoint 2)",
            "channel 1 has written #500=7 (breakpoint 4)",
            "channel 1 reaches M101 (breakpoint 3)",
            "channel 1 has written #500=8 (breakpoint 4)",
        ]
    );
    assert_eq!(summary.log_digest, free("fanuc-2path-lathe", &programs).log_digest);
    assert_eq!(summary.state, summary::JobOutcome::Succeeded);
    let stopped: Vec<&StepReport> = reports(&said).into_iter().filter(|report| !report.reason.is_empty()).collect();
    let written = stopped[4];
    assert_eq!(written.variables, [("#500".to_owned(), DialogValue::Number(7.0))]);
    assert!(written.channels[0].in_block && written.channels[0].line == 2);
    let of_two = &written.channels[1];
    assert_eq!(of_two.variables[..1], [("#1".to_owned(), DialogValue::Number(3.0))]);
    assert_eq!(of_two.positions, [("X".to_owned(), 50.0), ("Z".to_owned(), 2.0)]);
    assert_eq!((of_two.state, of_two.line), (ChannelActivity::Waiting, 4));
    let ids: Vec<u32> = written.breakpoints.iter().map(|breakpoint| breakpoint.id).collect();
    assert_eq!(ids, [2, 3, 4], "the time is over, the fifth one was deleted");
}

#[test]
fn feed_hold_lets_the_others_run_and_takes_no_simulated_time() {
    let commands = vec![StepCommand::Hold(1), StepCommand::Continue, StepCommand::Resume(0), StepCommand::Continue];
    let (summary, said) = stepped("fanuc-2path-lathe", &TWO, commands, false);
    let free = free("fanuc-2path-lathe", &TWO);
    assert_eq!(stops(&said)[1..], [("no channel can continue; on feed hold: 1".to_owned(), vec![1, 2])]);
    let held = &reports(&said)[2].channels;
    assert_eq!((held[0].held, held[0].t_ns, held[1].held, held[1].state), (true, 0, false, ChannelActivity::Waiting));
    assert_eq!((summary.log_digest, summary.makespan_ns), (free.log_digest, 5 * S));
}

#[test]
fn a_reset_ends_one_channel() {
    let commands = vec![step(Whom::All, 1), StepCommand::Reset(2), StepCommand::Continue];
    let (summary, said) = stepped("fanuc-2path-lathe", &TWO, commands, false);
    assert_eq!(summary.state, summary::JobOutcome::Failed);
    assert_eq!(summary.channels[1].state, ChannelState::Alarmed);
    assert_eq!(summary.channels[1].end_ns, S / 2);
    let numbers: Vec<u32> = summary.diagnostics.iter().map(|diagnostic| diagnostic.number).collect();
    assert!(numbers.contains(&2_900_370), "{numbers:?}");
    assert_eq!(summary.channels[0].state, ChannelState::Blocked, "its partner is missing: {said:?}");
}

#[test]
fn what_cannot_be_done_is_refused() {
    let commands = vec![
        step(Whom::One(3), 1),
        StepCommand::Hold(3),
        StepCommand::Reset(0),
        StepCommand::Remove(1),
        StepCommand::Hold(2),
        step(Whom::One(2), 1),
        StepCommand::Resume(2),
        step(Whom::One(2), 2),
        StepCommand::Reset(2),
        StepCommand::Pause,
        StepCommand::Continue,
    ];
    let (summary, said) = stepped("fanuc-2path-lathe", &TWO, commands, false);
    let refused: Vec<&str> = said
        .iter()
        .filter_map(|said| match said {
            StepReply::Refused(text) => Some(text.as_str()),
            _ => None,
        })
        .collect();
    assert_eq!(
        refused,
        [
            "the job has no channel 3; it has 1, 2",
            "the job has no channel 3; it has 1, 2",
            "a reset is for one channel: reset 1",
            "there is no breakpoint 1",
            "channel 2 is on feed hold: resume it first",
            "channel 2 is waiting; reset it after its partner has arrived, before its next block",
        ]
    );
    assert_eq!(summary.state, summary::JobOutcome::Succeeded);
}

#[test]
fn the_only_channel_of_a_job_is_stepped_through_as_well() {
    let programs = ["#1=1\nWHILE[#1LT4]DO1\n#1=#1+1\nG4P100\nEND1\n#500=#1\nM30\n"];
    let commands = vec![
        step(Whom::Next, 3),
        StepCommand::Hold(1),
        StepCommand::Continue,
        StepCommand::Resume(1),
        at(BreakLocation::Write("#500".into())),
        StepCommand::Continue,
    ];
    let (summary, said) = stepped("fanuc-mill", &programs, commands, false);
    assert_eq!(
        stops(&said),
        [
            ("step".into(), vec![1]),
            ("step".into(), vec![4]),
            ("no channel can continue; on feed hold: 1".into(), vec![4]),
            ("channel 1 has written #500=4 (breakpoint 1)".into(), vec![6]),
        ]
    );
    assert_eq!(summary.log_digest, free("fanuc-mill", &programs).log_digest);
    assert_eq!(summary.makespan_ns, 300_000_000);
}

#[test]
fn a_cancel_ends_a_run_that_stands() {
    let (summary, said) = stepped("fanuc-2path-lathe", &TWO, vec![step(Whom::All, 1)], true);
    assert_eq!(summary.state, summary::JobOutcome::Cancelled);
    assert_eq!(stops(&said).len(), 2);
}

/// Three turrets that meet in pairs, share variables, poll and call.
fn busy() -> Vec<String> {
    let path = |own: u32| {
        let mut text = format!("O{own}\n#1=0\n");
        for round in 0..6_u32 {
            text += &format!("G4P{}\n#{}=#{}+{own}\n", 100 * own + 10 * round, 500 + round % 3, 500 + (round + 1) % 3);
            match round % 3 {
                0 => text += "M110P123\n",
                1 if own != 3 => text += "M111P12\n",
                2 if own != 1 => text += "M112P23\n",
                _ => text += "G4P7\n",
            }
        }
        text + if own == 1 { "#520=1\nM30\n" } else { "WHILE[#520NE1]DO1\nEND1\nM30\n" }
    };
    let preset = "#500=1\n#501=2\n#502=3\n#520=0\nM110P123\n";
    (1..=3)
        .map(|own| if own == 1 { preset.to_owned() + &path(1) } else { "M110P123\n".to_owned() + &path(own) })
        .collect()
}

#[test]
fn any_commands_give_the_log_of_a_free_run() {
    let texts = busy();
    let programs: Vec<&str> = texts.iter().map(String::as_str).collect();
    let free = free("fanuc-3path-lathe", &programs);
    assert_eq!(free.state, summary::JobOutcome::Succeeded, "{:?}", free.diagnostics);
    let mut x = 0x2545_f491_4f6c_dd1d_u64;
    let mut next = |below: u64| {
        x ^= x << 13;
        x ^= x >> 7;
        x ^= x << 17;
        x % below
    };
    for run in 0..60 {
        let mut commands = Vec::new();
        for _ in 0..next(60) {
            let channel = next(4) as u16;
            let blocks = 1 + next(4) as u32;
            commands.push(match next(9) {
                0..=2 => step(Whom::One(channel.max(1)), blocks),
                3 => step(Whom::All, blocks),
                4 => step(Whom::Next, blocks),
                5 => StepCommand::Hold(channel),
                6 => StepCommand::Resume(channel),
                7 => StepCommand::Add(Breakpoint {
                    id: 0,
                    spot: match next(4) {
                        0 => BreakLocation::Wait(["", "110", "M111"][next(3) as usize].into()),
                        1 => BreakLocation::Write(format!("#{}", 500 + next(3))),
                        2 => line("", 1 + next(20) as u32),
                        _ => BreakLocation::Time(next(4 * S as u64) as i64),
                    },
                    count: blocks,
                    once: next(2) == 0,
                }),
                _ => StepCommand::Continue,
            });
        }
        let (summary, said) = stepped("fanuc-3path-lathe", &programs, commands, false);
        assert_eq!(summary.log_digest, free.log_digest, "run {run}: {:?}", stops(&said));
    }
}

#[test]
fn steps_go_over_shipped_cycles_and_stop_in_one_at_a_breakpoint() {
    let text = "G0 Z50\nT1 D1 M6\nS1000 M3 F200\nHOLES1(0,0,0,5,10,2)\nX50\nM30\n";
    let steps = vec![step(Whom::Next, 1); 6];
    let (summary, said) = stepped("siemens-mill", &[text], steps, false);
    assert_eq!(summary.state, summary::JobOutcome::Succeeded, "{:?}", summary.diagnostics);
    let lines: Vec<u32> = stops(&said).into_iter().flat_map(|(_, lines)| lines).collect();
    assert_eq!(lines[..6], [1, 2, 3, 4, 5, 6]);

    let inside = || line("holes1.spf", 15);
    let commands = vec![at(inside()), StepCommand::Continue, step(Whom::Next, 1)];
    let (_, said) = stepped("siemens-mill", &[text], commands, false);
    let files: Vec<(String, u32)> =
        reports(&said).iter().map(|report| (report.channels[0].file.clone(), report.channels[0].line)).collect();
    assert!(files.contains(&("//ICAMFS/cst.dir/holes1.spf".to_owned(), 15)), "{files:?}");
    assert_eq!(files.last().map(|(file, line)| (file.as_str(), *line)), Some(("jobs/p1.nc", 5)));
}

fn calls(calls: StepCalls, whom: Whom, blocks: u32) -> StepCommand {
    StepCommand::Step { whom, blocks, calls }
}

/// Lines of the only channel at each stop after the first.
fn lines_of(machine: &str, text: &str, commands: Vec<StepCommand>) -> Vec<u32> {
    let (summary, said) = stepped(machine, &[text], commands, false);
    assert_eq!(summary.log_digest, free(machine, &[text]).log_digest, "{:?}", summary.diagnostics);
    stops(&said).into_iter().skip(1).flat_map(|(_, lines)| lines).collect()
}

#[test]
fn steps_go_over_and_out_of_calls() {
    use StepCalls::{Into, Out, Over};
    // Line 2 calls the program in lines 5 to 9; line 7 calls the program in lines 10 to 12.
    let programs = [
        ("fanuc-mill", "O1\nM98 P2\nG4 X1.\nM30\nO2\nG4 X1.\nM98 P3\nG4 X1.\nM99\nO3\nG4 X1.\nM99\n"),
        (
            "heidenhain-mill",
            "BEGIN PGM A MM\nCALL LBL 1\nSTOP\nM30\nLBL 1\nSTOP\nCALL LBL 2\nSTOP\nLBL 0\nLBL 2\nSTOP\nLBL 0\nEND PGM A MM\n",
        ),
        ("okuma-mill", "O1\nCALL O2\nG4 F1\nM02\nO2\nG4 F1\nCALL O3\nG4 F1\nRTS\nO3\nG4 F1\nRTS\n"),
        (
            "siemens-mill",
            "%_N_A_MPF\nSUB1\nG4 F1\nM30\n%_N_SUB1_SPF\nG4 F1\nSUB2\nG4 F1\nM17\n%_N_SUB2_SPF\nG4 F1\nM17\n",
        ),
    ];
    for (machine, text) in programs {
        let next = |of, blocks| calls(of, Whom::Next, blocks);
        let until = |at| {
            [StepCommand::Add(Breakpoint { id: 0, spot: line("", at), count: 0, once: true }), StepCommand::Continue]
        };
        let all = lines_of(machine, text, vec![step(Whom::Next, 1); 20]);
        assert!(all.starts_with(&[2]) && [6, 11].iter().all(|line| all.contains(line)), "{machine}: {all:?}");
        let over = |from: u32, blocks| {
            let commands = until(from).into_iter().chain([next(Over, blocks)]).collect();
            lines_of(machine, text, commands)[1]
        };
        assert_eq!((over(2, 1), over(2, 2), over(7, 1), over(7, 2)), (3, 4, 8, 9), "{machine}");
        // After the end of the called program, the next block of the caller counts.
        assert_eq!(over(8, 2), 3, "{machine}");
        let out = |from: u32, count, whom| {
            let commands = until(from).into_iter().chain([calls(Out, whom, count)]).collect();
            lines_of(machine, text, commands)[1]
        };
        for whom in [Whom::Next, Whom::One(1), Whom::All] {
            assert_eq!(
                (out(11, 1, whom), out(11, 2, whom), out(6, 1, whom), out(6, 9, whom)),
                (8, 3, 3, 3),
                "{machine}"
            );
        }
        let (_, said) = stepped(machine, &[text], vec![next(Into, 1), next(Out, 1)], false);
        let refusals: Vec<_> = said.iter().filter(|said| matches!(said, StepReply::Refused(_))).collect();
        assert!(
            matches!(&refusals[..], [StepReply::Refused(text)] if text.contains("there is no call to leave")),
            "{machine}: {refusals:?}"
        );
    }
}

#[test]
fn steps_go_over_siemens_programs_that_hide_their_blocks() {
    let text = |head: &str, inside: &str| {
        format!("%_N_A_MPF\nEXTERN SUB1\nSUB1\nG4 F1\nM30\n%_N_SUB1_SPF\n{head}\nG4 F1\n{inside}\nG4 F1\nM17\n")
    };
    let lines = |head: &str, inside: &str| {
        let lines = lines_of("siemens-mill", &text(head, inside), vec![step(Whom::Next, 1); 12]);
        lines.into_iter().filter(|line| *line > 2).collect::<Vec<_>>()
    };
    assert_eq!(lines("PROC SUB1", "G4 F1"), [3, 6, 7, 8, 9, 10, 11, 4, 5]);
    assert_eq!(lines("PROC SUB1 SBLOF", "G4 F1"), [3, 4, 5]);
    assert_eq!(lines("; drills\nPROC SUB1 DISPLOF", "SBLON"), [3, 10, 11, 12, 4, 5]);
    assert_eq!(lines("PROC SUB1 SBLOF", "SBLON"), [3, 9, 10, 11, 4, 5]);
    assert_eq!(lines("PROC SUB1", "SBLOF"), [3, 6, 7, 8, 4, 5]);
}
