//! Times by the revolutions of a shared spindle do not depend on the numbers of the channels.
//!
//! One random program drives the spindle of a two-path lathe under constant surface speed, the other feeds, dwells and
//! cuts threads by its revolutions; both leave the same waits, so moves begin at the same instants. The programs run
//! as channels 1 and 2, and exchanged: every block takes the same time in both runs, with the same warnings.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::indexing_slicing, missing_docs)]

use std::collections::BTreeMap;

use counterpoint_kernel::log::event::Kind;
use counterpoint_kernel::options::JobOptions;
use counterpoint_tests::{Work, machine};
use proptest::prelude::*;

/// Blocks of the channel that drives the spindle.
fn drives() -> impl Strategy<Value = String> {
    prop_oneof![
        4 => (0_u32..60, 1_u32..4).prop_map(|(x, feed)| format!("G1 X{x}. F0.{feed}")),
        2 => (0_u32..60).prop_map(|x| format!("G98 G1 X{x}. F600.\nG99")),
        1 => (0_u32..60).prop_map(|x| format!("G0 X{x}.")),
        1 => (1_u32..9).prop_map(|tenths| format!("G4 X0.{tenths}")),
        1 => (10_u32..25).prop_map(|speed| format!("G96 S{speed}0")),
        1 => (5_u32..25).prop_map(|speed| format!("G97 S{speed}00")),
        1 => (15_u32..30).prop_map(|speed| format!("G50 S{speed}00")),
    ]
}

/// Blocks of the channel that follows the spindle.
fn follows() -> impl Strategy<Value = String> {
    prop_oneof![
        4 => (1_u32..30, 1_u32..4).prop_map(|(z, feed)| format!("G1 Z-{z}. F0.{feed}")),
        2 => (1_u32..30).prop_map(|z| format!("G32 Z-{z}. F1.5")),
        1 => Just("G0 Z2.".to_owned()),
        1 => (1_u32..9).prop_map(|tenths| format!("G4 X0.{tenths}")),
        1 => (1_u32..9).prop_map(|tenths| format!("G98 G1 Z-{tenths}. F500.\nG99")),
    ]
}

/// Sections of both channels, each of which begins at a wait, and whether they cut in balance.
fn sections() -> impl Strategy<Value = Vec<(Vec<String>, Vec<String>, bool)>> {
    let section = (prop::collection::vec(drives(), 1..4), prop::collection::vec(follows(), 1..4), any::<bool>());
    prop::collection::vec(section, 1..4)
}

fn program(head: &str, sections: &[(Vec<String>, bool)]) -> String {
    let mut text = String::from(head);
    for (at, (blocks, balance)) in sections.iter().enumerate() {
        text += &format!("M{} P12\n", 101 + at);
        // Both channels have the same number of cuts: one.
        if *balance {
            text += "G68\nG1 W-1. F0.3\nG69\n";
        }
        text += &(blocks.join("\n") + "\n");
    }
    text + "M150 P12\nM30\n"
}

/// Start and time of every line with a move or a dwell, and the lines with warnings, by program.
type Times = BTreeMap<(bool, u32, usize), (i64, i64)>;

fn run(programs: [&str; 2], exchanged: bool) -> (Times, Vec<(bool, u32, u32)>) {
    let texts = if exchanged { [programs[1], programs[0]] } else { programs };
    let work = Work::texts(machine("fanuc-2path-lathe", ""), &texts, JobOptions::default());
    let done = work.run(None).expect("a job");
    let second = |channel: u16| (channel == 2) != exchanged;
    let mut times = Times::new();
    for event in &done.events {
        if matches!(event.kind, Kind::Motion(_) | Kind::Dwell(_)) {
            let many = times.range((second(event.channel), event.line, 0)..(second(event.channel), event.line + 1, 0));
            let key = (second(event.channel), event.line, many.count());
            times.insert(key, (event.t_ns, event.dur_ns));
        }
    }
    let diagnostics = done.summary.diagnostics.iter();
    let mut diagnostics: Vec<_> = diagnostics.map(|one| (second(one.channel), one.line, one.number)).collect();
    diagnostics.sort_unstable();
    (times, diagnostics)
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: counterpoint_tests::cases(120), failure_persistence: None, ..ProptestConfig::default()
    })]

    #[test]
    fn times_do_not_depend_on_the_numbers_of_the_channels(sections in sections()) {
        let driver: Vec<_> = sections.iter().map(|(blocks, _, balance)| (blocks.clone(), *balance)).collect();
        let follower: Vec<_> = sections.iter().map(|(_, blocks, balance)| (blocks.clone(), *balance)).collect();
        let driver = program("G21 G99 G0 X60. Z5.\nG50 S2500\nG96 S200 M3\n", &driver);
        let follower = program("G21 G99 G0 X0 Z5.\n", &follower);
        let [one, other] = [false, true].map(|exchanged| run([&driver, &follower], exchanged));
        prop_assert!(one.0.len() > 2, "{driver}\n{follower}{:?}", one.1);
        prop_assert_eq!(one, other, "{}\n{}", driver, follower);
    }
}

/// A move per revolution waits at its end for the spindle, with its event kept back, while the other channel makes more
/// events than may be on the way to the log.
#[test]
fn a_long_move_per_revolution_does_not_hold_up_the_log() {
    let driver = "G21 G0 X100. Z5.\nG50 S2500\nG96 S200 M3\nM101 P12\n#1=0\nWHILE [#1 LT 4000] DO1\n#1=#1+1\n#2=#1\nEND1\n\
                  G1 X0 F0.2\nM102 P12\nM30\n";
    let follower = "G21 G0 X0 Z5.\nG99\nM101 P12\nG1 Z-28. F0.15\nM102 P12\nM30\n";
    for (texts, threads) in [([driver, follower], 0), ([follower, driver], 0), ([driver, follower], 1)] {
        let options = JobOptions { threads, ..JobOptions::default() };
        let work = Work::texts(machine("fanuc-2path-lathe", ""), &texts, options);
        let done = work.run(None).expect("a job");
        let blocks: u64 = done.summary.channels.iter().map(|channel| channel.blocks).sum();
        assert!(blocks > 12_000 && done.summary.verdict.is_none(), "{blocks} blocks, {:?}", done.summary.verdict);
        assert!(done.events.is_sorted_by_key(|event| (event.t_ns, event.micro)), "the log is in order");
    }
}
