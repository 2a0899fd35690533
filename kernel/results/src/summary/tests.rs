//! Tests of the summary: hand-made logs and small real jobs.

use super::*;
use crate::testing::*;
use counterpoint_event::RunEnd;
use counterpoint_event::event::{
    BlockEvent, Diagnostic as LogDiagnostic, Dwell, Event, Kind, MotionKind, Phase, RaceWith, TimedFunction,
    Verdict as LogVerdict, VerdictMember as LogMember,
};

const S: i64 = 1_000_000_000;

fn summary(info: &Arc<Info>, events: &[Event]) -> Summary {
    summary_of(info, events, &outcome(events.len()))
}

fn summary_of(info: &Arc<Info>, events: &[Event], outcome: &RunEnd) -> Summary {
    results(info, events, outcome).summary
}

fn times(channel: &ChannelSummary) -> [i64; 5] {
    [channel.end_ns, channel.feed_ns, channel.rapid_ns, channel.misc_ns, channel.wait_ns].map(|ns| ns / 1_000_000)
}

#[test]
fn the_json_is_the_documented_one() {
    let info = lathe(&["G1 X10.", "G0 X2."]);
    let events = [
        life(2, 0, Phase::NotStarted),
        life(1, 0, Phase::ProgramStart),
        at(1, 1, 0, 0, Kind::Block(BlockEvent { number: 1, unit_named: false })),
        at(1, 1, 0, 3 * S, Kind::Motion(motion(MotionKind::Linear, &[0.0], &[10.0]))),
        diagnostic(1, 1, 3 * S, 2_001_005, 4, "no \"Q\""),
        life(1, 3 * S, Phase::ProgramEnd),
    ];
    let mut summary = summary(&info, &events);
    summary.log_digest = "d".into();
    let json = serde_json::to_string(&summary).unwrap();
    assert_eq!(
        json,
        concat!(
            r#"{"state":"SUCCEEDED","unit":"mm","highest_severity":4,"makespan_ns":3000000000,"log_digest":"d","#,
            r#""coordinates":{"text":"no G20/G21: coordinates read in mm, the unit in which machine lathe2 begins","#,
            r#""channels":[{"channel":1,"selected":false,"units":[{"unit":"mm","file":"","line":0}]}]},"channels":["#,
            r#"{"channel":1,"name":"UPPER","program":"jobs/p1.nc","state":"ENDED","blocks":1,"end_ns":3000000000,"#,
            r#""feed_ns":3000000000,"rapid_ns":0,"misc_ns":0,"wait_ns":0,"#,
            r#""axes":[{"name":"X","diameter":true},{"name":"Z"},{"name":"C","rotary":true}]},"#,
            r#"{"channel":2,"name":"LOWER","program":"jobs/p2.nc","state":"NOT_STARTED","blocks":0,"end_ns":0,"#,
            r#""feed_ns":0,"rapid_ns":0,"misc_ns":0,"wait_ns":0,"#,
            r#""axes":[{"name":"X","diameter":true},{"name":"Z"}]}],"waits":[],"verdict":null,"diagnostics":["#,
            r#"{"number":2001005,"name":"text-not-recognised","severity":4,"channel":1,"file":"jobs/p1.nc","line":1,"block":"G1 X10.","#,
            r#""text":"no \"Q\"","t_ns":3000000000}]}"#
        )
    );
    assert_eq!(serde_json::from_str::<Summary>(&json).unwrap(), summary);
}

#[test]
fn a_stop_cuts_durations_and_waits() {
    let info = lathe(&["a\nb", "c\nd", "e\nM9"]);
    let verdict = LogVerdict { kind: VerdictKind::Limit, at_ns: 4 * S, text: "limit".into(), members: vec![] };
    let events = [
        at(1, 1, 0, 10 * S, Kind::Motion(motion(MotionKind::Rapid, &[0.0], &[10.0]))),
        at(2, 1, 0, S, Kind::Dwell(Dwell)),
        wait(2, 2, S, "M101", &[1, 2]),
        at(3, 1, 0, 4 * S, Kind::Function(TimedFunction { letter: 'M', value: 8.0 })),
        at(0, 0, 4 * S, 0, Kind::Verdict(Box::new(verdict))),
    ];
    let limited = summary(&info, &events);
    let states: Vec<_> = limited.channels.iter().map(|c| c.state).collect();
    assert_eq!(states, [ChannelState::Stopped, ChannelState::Blocked, ChannelState::Stopped]);
    let all: Vec<_> = limited.channels.iter().map(times).collect();
    assert_eq!(all, [[4000, 0, 4000, 0, 0], [1000, 0, 0, 1000, 0], [4000, 0, 0, 4000, 0]]);
    let cancelled = summary_of(&info, &events, &RunEnd { cancelled: true, ..outcome(5) });
    assert_eq!((cancelled.state, cancelled.channels[1].state), (JobOutcome::Cancelled, ChannelState::Stopped));
    assert_eq!(times(&cancelled.channels[1]), [4000, 0, 0, 1000, 3000]);
}

#[test]
fn a_meeting_cut_between_its_releases_is_one_meeting() {
    let info = lathe(&["M101", "M101"]);
    let events = [wait(2, 1, 0, "M101", &[1, 2]), wait(1, 1, S, "M101", &[1, 2]), release(1, 1, S, S, "M101", 1)];
    let cut = summary(&info, &events);
    assert_eq!(cut.waits.len(), 1);
    assert_eq!(cut.waits[0].arrivals.iter().map(|a| a.channel).collect::<Vec<_>>(), [1, 2]);
    assert_eq!((cut.channels[1].state, cut.channels[1].wait_ns), (ChannelState::Stopped, S));
}

#[test]
fn waits_of_different_marks_stay_apart_and_alarmed_ones_count_to_the_alarm() {
    let info = lathe(&["M101", "M102"]);
    let member = |channel, other| LogMember { channel, file: channel - 1, line: 1, waiting_for: vec![other] };
    let members = vec![member(1, 2), member(2, 1)];
    let verdict = LogVerdict { kind: VerdictKind::Mismatch, at_ns: S, text: "PS0160".into(), members };
    let events = [
        wait(1, 1, 0, "M101", &[1, 2]),
        wait(2, 1, S, "M102", &[1, 2]),
        diagnostic(2, 1, S, 2_900_050, 12, "PS0160"),
        at(0, 1, S, 0, Kind::Verdict(Box::new(verdict))),
        life(2, S, Phase::Alarmed),
        life(1, S, Phase::Alarmed),
    ];
    let summary = summary(&info, &events);
    let keys: Vec<_> = summary.waits.iter().map(|w| (&*w.key, w.release_ns)).collect();
    assert_eq!(keys, [("M101", None), ("M102", None)]);
    assert_eq!(summary.channels.iter().map(|c| c.wait_ns).collect::<Vec<_>>(), [S, 0]);
    assert_eq!((summary.state, summary.highest_severity), (JobOutcome::Failed, 12));
}

#[test]
fn the_list_of_diagnostics_is_bounded() {
    let info = lathe(&["x"]);
    let events: Vec<Event> =
        (0..10_010).map(|n| diagnostic(1, 1, 0, 2_001_005, if n == 10_009 { 8 } else { 4 }, "t")).collect();
    let summary = summary(&info, &events);
    assert_eq!((summary.diagnostics.len(), summary.highest_severity), (MAX_DIAGNOSTICS, 8));
}

#[test]
fn races_are_in_the_analysis_with_both_lines() {
    let info = lathe(&["#100=1", "#101=#100"]);
    let race = |variable: &str, channel, line| RaceWith { variable: variable.into(), channel, line };
    let report = |t_ns, channel, line, race| {
        let race = Some(Box::new(race));
        let diagnostic = LogDiagnostic { number: 2_900_440, race, ..LogDiagnostic::default() };
        at(channel, line, t_ns, 0, Kind::Diagnostic(Box::new(diagnostic)))
    };
    let events = [
        report(S, 1, 2, race("#100", 2, 5)),
        report(2 * S, 2, 7, race("COUNT", 1, 4)),
        life(1, 2 * S, Phase::ProgramEnd),
        life(2, 3 * S, Phase::ProgramEnd),
    ];
    let expected = [("#100".into(), [(1, 2), (2, 5)].into()), ("COUNT".into(), [(1, 4), (2, 7)].into())];
    assert_eq!(summary(&info, &events).analysis.races, expected);
    let json = serde_json::to_value(&*summary(&info, &events).analysis).unwrap();
    assert_eq!(json["races"][0], serde_json::json!(["#100", {"1": 2, "2": 5}]));
}

/// A program with moves and codes of units; `units inch` is the mode event, `named` a code that changes nothing.
fn units(blocks: &[&str]) -> String {
    let info = lathe(&["a"]);
    let mut events = vec![life(1, 0, Phase::ProgramStart)];
    let mut unit_named = false;
    for (line, words) in (1..).zip(blocks) {
        events.push(at(1, line, 0, 0, Kind::Block(BlockEvent { number: u64::from(line), unit_named })));
        unit_named = words.contains("named") || words.contains("units");
        for word in words.split(", ") {
            events.push(match word {
                "move" => at(1, line, 0, S, Kind::Motion(motion(MotionKind::Linear, &[0.0], &[10.0]))),
                "units inch" => at(1, line, 0, 0, Kind::mode("units inch")),
                "units mm" => at(1, line, 0, 0, Kind::mode("units mm")),
                _ => continue,
            });
        }
    }
    summary(&info, &events).coordinates.map(|coordinates| coordinates.text).unwrap_or_default()
}

#[test]
fn the_unit_of_coordinates_is_named() {
    assert_eq!(units(&["named", "move", "end"]), "coordinates read in mm");
    assert_eq!(units(&["named, move", "end"]), "coordinates read in mm");
    assert_eq!(units(&["units inch", "move", "end"]), "coordinates read in inch");
    assert_eq!(units(&["move", "end"]), "no G20/G21: coordinates read in mm, the unit in which machine lathe2 begins");
    assert_eq!(
        units(&["units mm", "move", "units inch", "", "move", "end"]),
        "coordinates read in mm, from line 3 in inch"
    );
    assert_eq!(
        units(&["move", "units inch, move", "end"]),
        "coordinates read in mm, the unit in which machine lathe2 begins, from line 2 in inch"
    );
    assert_eq!(units(&["named", "end"]), "", "nothing has moved");
}
