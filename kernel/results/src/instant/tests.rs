//! Lines written by hand, and the resulting state.

use super::*;
use crate::builder::ResultsBuilder;
use crate::jsonl;
use crate::testing::{lathe, motion};
use counterpoint_event::RunEnd;
use counterpoint_event::event::{
    AxesLaw, CarriedMove, Event, FrameShift, Kind, MAX_AXES, MotionKind, Phase, Primitive, Release, SourcePlace,
    SpindleChange, ToolAction, ToolChange, UnknownLaw, WaitArrival,
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
    read(&lathe(&["x", "y"]), &events(), t_ns)
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

fn read(info: &std::sync::Arc<counterpoint_event::info::Info>, events: &[Event], t_ns: i64) -> Instant {
    let mut builder = ResultsBuilder::new(info);
    events.iter().for_each(|event| builder.event(event));
    let summary = builder.finish(&RunEnd { events: 9, cancelled: false, sink_failed: false }).summary;
    let mut instant = InstantBuilder::new(&summary, t_ns);
    for (seq, event) in (1..).zip(events) {
        let mut line = Vec::new();
        jsonl::write_event(info, seq, event, &mut line);
        if !instant.line(&line).unwrap() {
            break;
        }
    }
    instant.finish()
}

#[test]
fn modal_states_spindles_and_moves_that_others_cause() {
    let info = lathe(&["x", "y"]);
    let speed = |speed| SpindleChange {
        spindle: 1,
        direction: SpindleDirection::Clockwise,
        css: false,
        speed,
        limit: f64::INFINITY,
        angle: 0.0,
    };
    let mut to = Box::new([0.0; MAX_AXES]);
    to[1] = 80.0;
    let carried = CarriedMove { from: Box::new([0.0; MAX_AXES]), to, axes: "Z2 with Z1".into() };
    let mut events = vec![
        at(1, 0, 0, 0, Kind::Lifecycle(Phase::ProgramStart)),
        at(2, 0, 0, 0, Kind::Lifecycle(Phase::ProgramStart)),
        at(1, 0, 0, 1, Kind::Spindle(speed(900.0))),
        at(2, 0, S, 1, Kind::Motion(motion(MotionKind::Rapid, &[0.0, 0.0], &[0.0, 90.0]))),
        at(1, 0, 0, 2, Kind::mode("comp workp n=2")),
        at(1, 0, 0, 2, Kind::mode("comp length n=4")),
        at(1, S, 0, 3, Kind::mode("comp length off")),
        at(2, S, 0, 2, Kind::Spindle(speed(1000.0))),
        at(2, 2 * S, 0, 3, Kind::coupling("synchronous off Z1 Z2 z=80".into(), Some(carried))),
        at(2, 3 * S, 0, 4, Kind::mode("tilt off")),
        at(2, 4 * S, 0, 5, Kind::Motion(motion(MotionKind::Rapid, &[0.0, 7.0], &[0.0, 8.0]))),
    ];
    events.push(at(1, 9 * S, 0, 9, Kind::Lifecycle(Phase::ProgramEnd)));
    let state = read(&info, &events, 2 * S);
    let texts: Vec<&str> = state.channels[0].modes.values().map(String::as_str).collect();
    assert_eq!(texts, ["comp length off", "comp workp n=2"]);
    let spindles: Vec<_> = state.spindles.iter().map(|of| (of.spindle, of.channel, of.speed)).collect();
    assert_eq!(spindles, [(1, 2, 1000.0)], "the newest command of any channel");
    assert_eq!(place(&state.channels[1]), Some(vec![0.0, 80.0]));
    assert_eq!(place(&read(&info, &events, 3 * S).channels[1]), None, "until the next motion");
    assert_eq!(place(&read(&info, &events, 4 * S).channels[1]), Some(vec![0.0, 8.0]));
}

#[test]
fn lines_of_another_job_are_refused() {
    let info = lathe(&["x"]);
    let events =
        [at(1, 0, S, 1, Kind::Lifecycle(Phase::ProgramStart)), at(1, S, 0, 2, Kind::Lifecycle(Phase::ProgramEnd))];
    let mut builder = ResultsBuilder::new(&info);
    events.iter().for_each(|event| builder.event(event));
    let summary = builder.finish(&RunEnd { events: 2, cancelled: false, sink_failed: false }).summary;
    let line = |t_ns: i64, channel: u16| {
        format!(r#"{{"seq":1,"t_ns":{t_ns},"dur_ns":0,"channel":{channel},"kind":"x","file":"p.nc","line":9}}"#)
    };
    let mut instant = InstantBuilder::new(&summary, S);
    assert!(!instant.has_lines());
    assert!(instant.line(line(5, 1).as_bytes()).unwrap() && instant.has_lines());
    for (t_ns, channel) in [(4, 1), (5, 7), (2 * S, 1)] {
        assert!(instant.line(line(t_ns, channel).as_bytes()).is_err(), "{t_ns} {channel}");
    }
}

#[test]
fn a_line_that_is_no_event_is_an_error_and_unknown_kinds_are_not() {
    let info = lathe(&["x"]);
    let summary =
        ResultsBuilder::new(&info).finish(&RunEnd { events: 0, cancelled: false, sink_failed: false }).summary;
    let mut instant = InstantBuilder::new(&summary, 0);
    assert!(instant.line(b"{\"seq\":1}").is_err() && instant.line(b"x").is_err());
    let later = br#"{"seq":1,"t_ns":0,"dur_ns":0,"channel":1,"kind":"other","file":"p.nc","line":9,"new":[1]}"#;
    assert!(instant.line(later).unwrap());
    assert_eq!(instant.finish().channels[0].line, 9);
}
