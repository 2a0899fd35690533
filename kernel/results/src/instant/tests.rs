//! Lines written by hand, and the resulting state.

use super::*;
use crate::builder::ResultsBuilder;
use crate::jsonl;
use crate::testing::{lathe, motion};
use counterpoint_event::RunEnd;
use counterpoint_event::event::{
    AxesLaw, Event, FrameShift, Kind, MAX_AXES, MotionKind, Phase, Primitive, Release, SourcePlace, ToolAction,
    ToolChange, UnknownLaw, WaitArrival,
};
use counterpoint_motion::law::AxisRamp;

const S: i64 = 1_000_000_000;

fn at(channel: u16, t_ns: i64, dur_ns: i64, line: u32, kind: Kind) -> Event {
    Event { t_ns, micro: 0, dur_ns, channel, file: channel - 1, line, caller: SourcePlace::NONE, kind }
}

fn wait(channel: u16, t_ns: i64, line: u32) -> Event {
    let arrival = WaitArrival {
        key: "M101".into(),
        primitive: Primitive::Barrier,
        participants: [1, 2].into(),
        mark: "101".into(),
        acts: false,
    };
    at(channel, t_ns, 0, line, Kind::Wait(arrival.into()))
}

fn release(channel: u16, t_ns: i64, since_ns: i64, line: u32) -> Event {
    let kind =
        Release { key: "M101".into(), primitive: Primitive::Barrier, since_ns, meeting: 1, mark: "101".into(), by: 2 };
    at(channel, t_ns, 0, line, Kind::Release(kind))
}

/// Two channels: channel 1 moves for 2 s and then waits; channel 2 cuts from 1 s to 5 s and then arrives.
fn events() -> Vec<Event> {
    let rapid = motion(MotionKind::Rapid, &[40.0, 0.0], &[20.0, 100.0]);
    let axes = [AxisRamp { arrives: 0.5, ramp: 0.0 }, AxisRamp { arrives: 2.0, ramp: 0.0 }];
    let cut = motion(MotionKind::Linear, &[50.0, 0.0], &[50.0, -40.0]);
    let mut shift = [0.0; MAX_AXES];
    shift[1] = 10.0;
    let mut events = vec![
        at(1, 0, 0, 0, Kind::Lifecycle(Phase::ProgramStart)),
        at(2, 0, 0, 0, Kind::Lifecycle(Phase::ProgramStart)),
        at(1, 0, 0, 3, Kind::Motion(rapid)),
        at(1, 0, 0, 3, Kind::Law(MotionLaw::Axes(AxesLaw::new(axes.into_iter())))),
        at(2, 0, S, 5, Kind::Tool(ToolChange { action: ToolAction::Load, tool: 7, offset: 2 })),
        at(2, S, 4 * S, 6, Kind::Motion(cut)),
        at(2, S, 4 * S, 6, Kind::Law(MotionLaw::Unknown(UnknownLaw::Jerk))),
        wait(1, 2 * S, 4),
        wait(2, 5 * S, 7),
        release(1, 5 * S, 2 * S, 4),
        release(2, 5 * S, 5 * S, 7),
        at(1, 5 * S, 0, 5, Kind::Frame(FrameShift { shift: Box::new(shift) })),
        at(1, 6 * S, 0, 6, Kind::Lifecycle(Phase::ProgramEnd)),
        at(2, 6 * S, 0, 8, Kind::Lifecycle(Phase::ProgramEnd)),
    ];
    for event in events.iter_mut().skip(2).take(2) {
        event.dur_ns = 2 * S;
    }
    events
}

fn state(t_ns: i64) -> Instant {
    let info = lathe(&["x", "y"]);
    let mut builder = ResultsBuilder::new(&info);
    events().iter().for_each(|event| builder.event(event));
    let summary = builder.finish(&RunEnd { events: 14, cancelled: false, sink_failed: false }).summary;
    let mut instant = InstantBuilder::new(&summary, t_ns);
    for (seq, event) in (1..).zip(events()) {
        let mut line = Vec::new();
        jsonl::write_event(&info, seq, &event, &mut line);
        if !instant.line(&line).unwrap() {
            break;
        }
    }
    instant.finish()
}

fn place(channel: &ChannelInstant) -> Option<Vec<f64>> {
    channel.position.as_ref().map(|position| position.0.iter().map(|(_, value)| *value).collect())
}

#[test]
fn between_the_ends_the_law_counts() {
    let Instant { channels, makespan_ns, .. } = state(S);
    assert_eq!(makespan_ns, 6 * S);
    let [one, two] = &channels[..] else { panic!("{channels:?}") };
    // X has arrived after 0.5 s, Z is half way after 1 s.
    assert_eq!(place(one), Some(vec![20.0, 50.0, 0.0]));
    assert_eq!((one.state, one.line, one.file.as_str()), (ChannelActivity::Running, 3, "jobs/p1.nc"));
    assert_eq!(two.tool, [7, 2]);
    // The start of a motion is known even without a law.
    assert_eq!(place(two), Some(vec![50.0, 0.0]));
}

#[test]
fn a_wait_names_the_channels_that_are_missing() {
    let Instant { channels, .. } = state(3 * S);
    let [one, two] = &channels[..] else { panic!("{channels:?}") };
    let wait = one.wait.as_ref().unwrap();
    assert_eq!((wait.key.as_str(), wait.since_ns, wait.missing.as_slice()), ("M101", 2 * S, &[2][..]));
    assert_eq!((one.state, place(one)), (ChannelActivity::Waiting, Some(vec![20.0, 100.0, 0.0])));
    let action = two.action.as_ref().unwrap();
    assert_eq!((action.kind.as_str(), action.unknown, action.until_ns), ("linear", Some("jerk"), 5 * S));
    assert_eq!(place(two), None);
}

#[test]
fn a_new_frame_changes_the_programmed_position() {
    let Instant { channels, .. } = state(5 * S);
    let [one, two] = &channels[..] else { panic!("{channels:?}") };
    assert!(one.wait.is_none() && two.wait.is_none());
    // Z100 without a shift is Z90 with a shift of 10.
    assert_eq!(place(one), Some(vec![20.0, 90.0, 0.0]));
    assert_eq!(place(two), Some(vec![50.0, -40.0]));
    let Instant { channels, .. } = state(6 * S);
    assert!(channels.iter().all(|channel| channel.state == ChannelActivity::Ended));
}

#[test]
fn a_line_that_is_no_event_is_an_error_and_unknown_kinds_are_not() {
    let info = lathe(&["x"]);
    let summary =
        ResultsBuilder::new(&info).finish(&RunEnd { events: 0, cancelled: false, sink_failed: false }).summary;
    let mut instant = InstantBuilder::new(&summary, S);
    assert!(instant.line(b"{\"seq\":1}").is_err() && instant.line(b"x").is_err());
    let later = br#"{"seq":1,"t_ns":0,"dur_ns":0,"channel":1,"kind":"other","file":"p.nc","line":9,"new":[1]}"#;
    assert!(instant.line(later).unwrap());
    assert_eq!(instant.finish().channels[0].line, 9);
}
