//! Tests of the log's fingerprint.

use std::sync::Arc;

use super::*;
use counterpoint_event::SourcePlace;
use counterpoint_event::event::{
    BlockEvent, Coolant, Diagnostic, DiagnosticOrigin, Dwell, FrameShift, OperatorMessage, Outlet, Phase, Primitive,
    Release, Return, SpindleChange, SpindleDirection, StopCode, SubprogramEntry, TimedFunction, ToolAction, ToolChange,
    ToolData, Verdict, VerdictKind, VerdictMember, WaitArrival,
};

fn event(kind: Kind) -> Event {
    Event { t_ns: 7, micro: 1, dur_ns: 3, channel: 2, file: 1, line: 40, caller: SourcePlace::NONE, kind }
}

fn motion() -> Motion {
    Motion {
        kind: MotionKind::Linear,
        moving: 3,
        from: [0.0; MAX_AXES],
        to: [1.0, 2.5, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        center: [0.0; 2],
        plane_axes: [255; 2],
        turns: 0,
        feed: 0.2,
        feed_unit: FeedUnit::PerRevolution,
        length: 2.6,
    }
}

fn digest(events: &[Event]) -> String {
    let mut digest = Digest::new();
    events.iter().for_each(|e| digest.event(e));
    log(std::iter::once((events.first().map_or(0, |e| e.channel), digest)))
}

#[test]
fn an_empty_log_has_the_digest_of_no_bytes() {
    assert_eq!(digest(&[]), blake3::hash(b"").to_hex().to_string());
}

fn form(events: &[Event]) -> Vec<u8> {
    let mut form = Digest::new().form;
    for event in events {
        if !form.expected(event) {
            form.event(event, &mut [0; MOST]);
        }
    }
    form.close();
    form.out
}

fn words(events: &[Event]) -> Vec<u64> {
    form(events).chunks(8).map(|c| u64::from_le_bytes(c.try_into().unwrap())).collect()
}

#[test]
fn the_form_is_fixed() {
    let block = event(Kind::Block(BlockEvent { number: 258, unit_named: false }));
    // Kind 1, no flags; then time, duration, microstep, file, line, number.
    assert_eq!(words(std::slice::from_ref(&block)), [1, 7, 3, 1, 1, 40, 258]);
    // The next event follows in the same place (1 + 2 + 8 + 16) and takes no time (4).
    let message =
        Event { t_ns: 10, dur_ns: 0, ..event(Kind::Message(OperatorMessage { text: "ab".into(), printed: false })) };
    let both = form(&[block.clone(), message]);
    assert_eq!(both.get(form(&[block]).len()..), Some(&[13, 31, 0, 0, 0, 0, 0, 0, 2, 0, 0, 0, b'a', b'b'][..]));
}

#[test]
fn expected_blocks_are_counted() {
    let block = |number, line| Event {
        t_ns: 10,
        dur_ns: 0,
        line,
        ..event(Kind::Block(BlockEvent { number, unit_named: false }))
    };
    let first = event(Kind::Block(BlockEvent { number: 1, unit_named: false }));
    let dwell = Event { t_ns: 10, dur_ns: 0, line: 42, ..event(Kind::Dwell(Dwell)) };
    let counted = words(&[first.clone(), block(2, 41), block(3, 42), dwell]);
    assert_eq!(counted[7..], [3 | 31 << 8 | 2 << 32]);
    assert_eq!(words(&[first.clone(), block(2, 41)])[7..], [255 | 1 << 32]);
    // A block number, a line or a time that is not expected is written.
    for odd in [block(3, 41), block(2, 43), Event { t_ns: 11, ..block(2, 41) }, Event { micro: 0, ..block(2, 41) }] {
        assert!(words(&[first.clone(), odd.clone()]).len() > 8, "{odd:?}");
    }
}

#[test]
fn a_motion_gives_the_axes_that_change() {
    let on = Motion { from: motion().to, to: [1.0, 4.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0], ..motion() };
    let both = words(&[event(Kind::Motion(motion())), Event { t_ns: 10, ..event(Kind::Motion(on)) }]);
    // Where it was, feed and facts as before (1 + 2 + 8 + 16 + 32 + 64), the second axis of the end; duration, value,
    // length.
    assert_eq!(both[both.len() - 4..], [2 | 123 << 8 | 2 << 24, 3, 4.0_f64.to_bits(), 2.6_f64.to_bits()]);
}

#[test]
fn minus_zero_counts_as_zero() {
    let mut other = motion();
    other.from[1] = -0.0;
    other.center = [-0.0, -0.0];
    assert_eq!(digest(&[event(Kind::Motion(motion()))]), digest(&[event(Kind::Motion(other))]));
}

#[test]
fn every_field_counts() {
    let spindle = SpindleChange {
        spindle: 1,
        direction: SpindleDirection::Clockwise,
        css: false,
        speed: 900.0,
        limit: f64::INFINITY,
        angle: 0.0,
    };
    let member = VerdictMember { channel: 1, file: 0, line: 3, waiting_for: vec![2] };
    let verdict = Verdict { kind: VerdictKind::Cycle, at_ns: 1, text: "t".into(), members: vec![member.clone()] };
    let wait = WaitArrival {
        key: "M101".into(),
        primitive: Primitive::Barrier,
        participants: [1, 2].into(),
        mark: "101".into(),
        acts: false,
    };
    let release = Release {
        key: "M101".into(),
        primitive: Primitive::Barrier,
        since_ns: 5,
        meeting: 1,
        mark: "101".into(),
        by: 1,
    };
    let motions = [
        motion(),
        Motion { kind: MotionKind::Thread, ..motion() },
        Motion { moving: 1, ..motion() },
        Motion { from: [0.5; MAX_AXES], ..motion() },
        Motion { to: [0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0], ..motion() },
        Motion { center: [1.0, 0.0], ..motion() },
        Motion { plane_axes: [0, 1], ..motion() },
        Motion { turns: 256, ..motion() },
        Motion { turns: 1, ..motion() },
        Motion { feed: 0.3, ..motion() },
        Motion { feed_unit: FeedUnit::PerMinute, ..motion() },
        Motion { length: 2.7, ..motion() },
    ];
    let said = Diagnostic { number: 1, severity: 4, text: "t".into(), ..Diagnostic::default() };
    let mut kinds: Vec<Kind> = motions.into_iter().map(Kind::Motion).collect();
    kinds.extend([
        Kind::Lifecycle(Phase::MachineStart),
        Kind::Lifecycle(Phase::ProgramEnd),
        Kind::Dwell(Dwell),
        Kind::Tool(ToolChange { action: ToolAction::Load, tool: 1, offset: 1 }),
        Kind::Tool(ToolChange { action: ToolAction::Select, tool: 1, offset: 1 }),
        Kind::Tool(ToolChange { action: ToolAction::Load, tool: 2, offset: 1 }),
        Kind::Tool(ToolChange { action: ToolAction::Load, tool: 1, offset: 2 }),
        Kind::ToolData(Box::new(ToolData { tool: 1, radius: Some(0.0), ..ToolData::default() })),
        Kind::ToolData(Box::new(ToolData { tool: 1, diameter: Some(0.0), ..ToolData::default() })),
        Kind::ToolData(Box::new(ToolData { tool: 1, place: 1, ..ToolData::default() })),
        Kind::Spindle(spindle),
        Kind::Spindle(SpindleChange { spindle: 2, ..spindle }),
        Kind::Spindle(SpindleChange { direction: SpindleDirection::Off, ..spindle }),
        Kind::Spindle(SpindleChange { css: true, ..spindle }),
        Kind::Spindle(SpindleChange { speed: 901.0, ..spindle }),
        Kind::Spindle(SpindleChange { limit: 2000.0, ..spindle }),
        Kind::Coolant(Coolant { on: true, fluid: 4, outlet: Outlet::Main }),
        Kind::Coolant(Coolant { on: false, fluid: 0, outlet: Outlet::Side }),
        Kind::Coolant(Coolant { on: true, fluid: 0, outlet: Outlet::Device(9) }),
        Kind::Function(TimedFunction { letter: 'M', value: 8.0 }),
        Kind::Function(TimedFunction { letter: 'N', value: 8.0 }),
        Kind::Function(TimedFunction { letter: 'M', value: 9.0 }),
        Kind::mode("plane zx"),
        Kind::Frame(FrameShift { shift: Box::new([0.0; MAX_AXES]) }),
        Kind::Frame(FrameShift { shift: Box::new([1.0; MAX_AXES]) }),
        Kind::Stop(StopCode::End),
        Kind::Stop(StopCode::Rewind),
        Kind::Call(SubprogramEntry { program: "O1".into(), level: 1 }),
        Kind::Call(SubprogramEntry { program: "O1".into(), level: 2 }),
        Kind::Return(Return { level: 1 }),
        Kind::Message(OperatorMessage { text: "plane zx".into(), printed: false }),
        Kind::Wait(Arc::new(wait.clone())),
        Kind::Wait(Arc::new(WaitArrival { participants: [1, 3].into(), ..wait.clone() })),
        Kind::Wait(Arc::new(WaitArrival { primitive: Primitive::Join, ..wait })),
        Kind::Release(release.clone()),
        Kind::Release(Release { since_ns: 6, ..release.clone() }),
        Kind::Release(Release { meeting: 2, ..release }),
        Kind::Diagnostic(Box::new(Diagnostic { severity: 4, ..said.clone() })),
        Kind::Diagnostic(Box::new(Diagnostic { severity: 8, ..said.clone() })),
        Kind::Diagnostic(Box::new(Diagnostic { origin: Some(Box::default()), ..said.clone() })),
        Kind::Diagnostic(Box::new(Diagnostic {
            origin: Some(Box::new(DiagnosticOrigin { line: 1, ..DiagnosticOrigin::default() })),
            ..said
        })),
        Kind::Verdict(Box::new(verdict.clone())),
        Kind::Verdict(Box::new(Verdict { members: vec![], ..verdict.clone() })),
        Kind::Verdict(Box::new(Verdict { members: vec![VerdictMember { waiting_for: vec![3], ..member }], ..verdict })),
    ]);
    let mut events: Vec<Event> = kinds.into_iter().map(event).collect();
    let base = event(Kind::Dwell(Dwell));
    events.extend([
        Event { t_ns: 8, ..base.clone() },
        Event { micro: 2, ..base.clone() },
        Event { dur_ns: 4, ..base.clone() },
        Event { channel: 3, ..base.clone() },
        Event { file: 2, ..base.clone() },
        Event { line: 41, ..base },
    ]);
    let mut digests: Vec<String> = events.iter().map(|e| digest(std::slice::from_ref(e))).collect();
    let count = digests.len();
    digests.sort();
    digests.dedup();
    assert_eq!(digests.len(), count);
}

#[test]
fn chunking_does_not_show() {
    let events: Vec<Event> = (0..9000).map(|n| Event { t_ns: n, ..event(Kind::Motion(motion())) }).collect();
    let bytes = form(&events);
    assert!(bytes.len() > 4 * CHUNK);
    let lane = blake3::hash(&bytes);
    let whole = blake3::hash(&[&[2, 0], &lane.as_bytes()[..]].concat());
    assert_eq!(digest(&events), whole.to_hex().to_string());
}
