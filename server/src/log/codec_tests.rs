//! The hand-written codec against the generated types.

use std::sync::{Arc, OnceLock};

use bytes::Bytes;
use counterpoint_kernel::log::digest::{self, Digest};
use counterpoint_kernel::log::event::*;
use counterpoint_kernel::log::info::{Info, JobAxis, JobChannel, JobFile, MachineUnit, ResultBudget};
use counterpoint_kernel::log::jsonl;
use counterpoint_motion::arc::PlaneArc;
use counterpoint_motion::driven_speed::{DrivenSpeed, RadiusProgress};
use counterpoint_motion::law::{FeedSchedule, PathLaw, SpeedRamp, SpindleRotation};
use counterpoint_motion::surface_speed::SurfaceSpeed;
use counterpoint_motion::thread::Lead;
use counterpoint_proto::v1;
use prost::Message as _;

use super::{decode, encode};

fn release(key: &str, primitive: Primitive, since_ns: i64, meeting: u64, mark: &str, by: u16) -> Kind {
    Kind::Release(Release { key: key.into(), primitive, since_ns, meeting, mark: mark.into(), by })
}

const SURFACE: SurfaceSpeed = SurfaceSpeed { surface: 180_000.0, max: f64::INFINITY, min: 20.0 };
const RAMP: SpeedRamp = SpeedRamp { length: 12.5, entry: 3.0, top: 50.0, exit: 0.0, acceleration: f64::INFINITY };

fn law(schedule: FeedSchedule, ramp: Option<SpeedRamp>) -> Kind {
    Kind::Law(MotionLaw::Path(PathLaw { ramp, schedule }))
}

fn turning(spindle: SpindleRotation) -> Kind {
    let lead = Lead { start: 0.2, change: -0.001 };
    law(FeedSchedule::Turning { lead, way: 33.0, radii: [25.0, -1.0], spindle }, Some(RAMP))
}

fn driven(progress: RadiusProgress) -> DrivenSpeed {
    DrivenSpeed { speed: SURFACE, radii: [20.0, 4.0], minutes: 0.75, progress }
}

fn surface_arc(radial: usize) -> Kind {
    // The axial coordinate of the centre is not stored; the radial coordinate is read in its place.
    let arc = PlaneArc { center: [7.0; 2], radius: 3.0, start_angle: 0.5, sweep: -1.25 };
    law(FeedSchedule::SurfaceArc { arc, radial, speed: SURFACE }, None)
}

fn kinds() -> Vec<Kind> {
    let mut from = [0.0; MAX_AXES];
    from[0] = -0.0;
    from[1] = 12.5;
    let motion = Motion {
        kind: MotionKind::ArcCcw,
        moving: 3,
        from,
        to: [1.0, -2.0, f64::MAX, 0.0, 0.0, 0.0, 0.0, 0.0],
        center: [0.0, 7.25],
        plane_axes: [2, 0],
        turns: 2,
        feed: 0.1,
        feed_unit: FeedUnit::PerRevolution,
        length: 3.5,
    };
    let spindle = SpindleChange {
        spindle: 2,
        direction: SpindleDirection::Off,
        css: false,
        speed: 0.1,
        limit: 3000.0,
        angle: 12.5,
    };
    let verdict = |kind| {
        let members = vec![VerdictMember { channel: 3, file: 2, line: 70_000, waiting_for: vec![1, 2] }];
        Kind::Verdict(Box::new(Verdict { kind, at_ns: -5, text: "é".into(), members }))
    };
    let plain = Motion { kind: MotionKind::Rapid, center: [0.0; 2], plane_axes: [255; 2], turns: 0, ..motion };
    vec![
        Kind::Lifecycle(Phase::Blocked),
        Kind::Block(BlockEvent { number: 1 << 40, unit_named: false }),
        Kind::Motion(motion),
        Kind::Motion(plain),
        Kind::Dwell(Dwell),
        Kind::Tool(ToolChange { action: ToolAction::Load, tool: 12, offset: 0 }),
        Kind::Spindle(SpindleChange {
            spindle: 1,
            direction: SpindleDirection::Clockwise,
            css: true,
            speed: 180.0,
            limit: f64::INFINITY,
            angle: 90.0,
        }),
        Kind::Coolant(Coolant { on: true, fluid: 4, outlet: Outlet::Main }),
        Kind::Coolant(Coolant { on: false, fluid: 0, outlet: Outlet::Side }),
        Kind::Coolant(Coolant { on: true, fluid: 0, outlet: Outlet::Device(9) }),
        Kind::Function(TimedFunction { letter: 'M', value: 0.0 }),
        Kind::mode("plane zx"),
        Kind::Frame(FrameShift { shift: Box::new(from) }),
        Kind::Stop(StopCode::Rewind),
        Kind::Call(SubprogramEntry { program: "O9001".into(), level: 2 }),
        Kind::Return(Return { level: 2 }),
        Kind::Message(OperatorMessage { text: "é\"".repeat(90).into(), printed: false }),
        Kind::Message(OperatorMessage { text: "printed".into(), printed: true }),
        Kind::Wait(Arc::new(WaitArrival {
            key: "M101".into(),
            primitive: Primitive::Order,
            participants: [1, 2, 300].into(),
            mark: "".into(),
            acts: false,
        })),
        release("M101", Primitive::Barrier, 5, 3, "", 0),
        Kind::Diagnostic(Box::new(Diagnostic {
            number: 1201,
            severity: 9,
            text: "no such register".into(),
            operation: "ROUGH".into(),
            kernel: "TURRET".into(),
            origin: None,
            unrecognised: None,
            race: None,
        })),
        Kind::Verdict(Box::new(Verdict {
            kind: VerdictKind::PartnerEnded,
            at_ns: 99,
            text: "channel 1 waits".into(),
            members: vec![
                VerdictMember { channel: 1, file: 0, line: 7, waiting_for: vec![2] },
                VerdictMember { channel: 2, file: 1, line: 0, waiting_for: vec![] },
            ],
        })),
        Kind::trace('C', "  code_rapid"),
        Kind::Motion(Motion { kind: MotionKind::ArcSpace, center: [-3.5, 0.25], ..plain }),
        Kind::Diagnostic(Box::new(Diagnostic {
            number: 2_910_090,
            origin: Some(Box::new(DiagnosticOrigin {
                name: "Motion Event Macro".into(),
                file: "tern/collet.mac".into(),
                line: 3,
                statement: "ERROR/8,'no'".into(),
            })),
            ..Diagnostic::default()
        })),
        Kind::Diagnostic(Box::new(Diagnostic { origin: Some(Box::default()), ..Diagnostic::default() })),
        Kind::ToolData(Box::new(ToolData {
            tool: 3,
            name: "ROUGH 80".into(),
            diameter: Some(0.0),
            radius: Some(0.8),
            length: None,
            place: 2,
        })),
        Kind::Lifecycle(Phase::MachineStart),
        Kind::Lifecycle(Phase::ProgramStart),
        Kind::Lifecycle(Phase::NotStarted),
        Kind::Lifecycle(Phase::ProgramEnd),
        Kind::Lifecycle(Phase::Alarmed),
        Kind::Lifecycle(Phase::Stopped),
        Kind::Lifecycle(Phase::MachineEnd),
        Kind::Stop(StopCode::Program),
        Kind::Stop(StopCode::Optional),
        Kind::Stop(StopCode::End),
        Kind::Tool(ToolChange { action: ToolAction::Select, tool: 7, offset: 300 }),
        Kind::Tool(ToolChange { action: ToolAction::Offset, tool: 7, offset: 300 }),
        Kind::Spindle(SpindleChange { direction: SpindleDirection::Off, ..spindle }),
        Kind::Spindle(SpindleChange { direction: SpindleDirection::CounterClockwise, ..spindle }),
        Kind::Spindle(SpindleChange { direction: SpindleDirection::Oriented, ..spindle }),
        Kind::Spindle(SpindleChange { direction: SpindleDirection::Locked, ..spindle }),
        Kind::Spindle(SpindleChange { direction: SpindleDirection::Neutral, ..spindle }),
        Kind::Spindle(SpindleChange { direction: SpindleDirection::Oriented, angle: 0.0, ..spindle }),
        Kind::Motion(Motion { kind: MotionKind::Linear, feed_unit: FeedUnit::PerMinute, ..plain }),
        Kind::Motion(Motion { kind: MotionKind::Thread, feed_unit: FeedUnit::InverseTime, ..plain }),
        Kind::Motion(Motion { kind: MotionKind::ArcCw, feed_unit: FeedUnit::Rapid, ..plain }),
        Kind::Motion(Motion { kind: MotionKind::ArcCw, plane_axes: [0, 1], ..plain }),
        Kind::Motion(Motion { length: f64::NAN, feed: f64::INFINITY, ..motion }),
        release("", Primitive::Flag, -1, 1 << 40, "", 0),
        release("", Primitive::Order, -1, 1 << 40, "", 0),
        release("", Primitive::Count, -1, 1 << 40, "", 0),
        release("", Primitive::Signal, -1, 1 << 40, "", 0),
        release("", Primitive::Join, -1, 1 << 40, "", 0),
        verdict(VerdictKind::Cycle),
        verdict(VerdictKind::Mismatch),
        verdict(VerdictKind::PartnerAlarmed),
        verdict(VerdictKind::PartnerNeverStarted),
        verdict(VerdictKind::PartnerSpinning),
        verdict(VerdictKind::LeaseCycle),
        verdict(VerdictKind::Limit),
        Kind::Message(OperatorMessage { text: "".into(), printed: false }),
        Kind::Message(OperatorMessage { text: "".into(), printed: true }),
        Kind::Function(TimedFunction { letter: 'é', value: -0.0 }),
        Kind::Function(TimedFunction { letter: '"', value: f64::NAN }),
        Kind::mode(""),
        Kind::compensation("comp length n=3", OffsetKind::Length, 3.0),
        Kind::compensation("comp diam left n=3", OffsetKind::Diameter, 3.0),
        Kind::compensation("comp diam vector n=3 pqr=1,0,0", OffsetKind::Diameter, 3.0),
        Kind::Trace(Trace { letter: 'A', text: "      | dwell rev=2".into(), listing: None, instead: true }),
        Kind::listing(Listing::On),
        Kind::listing(Listing::Off),
        Kind::listing(Listing::Lines(3)),
        Kind::listing(Listing::Block("G1 X2".into())),
        Kind::Law(MotionLaw::Unknown(UnknownLaw::Jerk)),
        Kind::Law(MotionLaw::Axes(AxesLaw { arrives: from, ramps: [0.5; MAX_AXES] })),
        law(FeedSchedule::Steady, None),
        law(FeedSchedule::Steady, Some(RAMP)),
        turning(SpindleRotation::Fixed(900.0)),
        turning(SpindleRotation::Surface(SURFACE)),
        turning(SpindleRotation::Driven(driven(RadiusProgress::ByTime), 0.125)),
        turning(SpindleRotation::Driven(driven(RadiusProgress::ByRevolution), 0.0)),
        surface_arc(0),
        surface_arc(1),
        Kind::ToolData(Box::default()),
        Kind::ToolData(Box::new(ToolData { tool: 1, length: Some(-0.5), ..ToolData::default() })),
        Kind::Diagnostic(Box::default()),
        Kind::Diagnostic(Box::new(Diagnostic { kernel: "TURRET".into(), ..Diagnostic::default() })),
        Kind::Diagnostic(Box::new(Diagnostic { operation: "BORE".into(), ..Diagnostic::default() })),
        Kind::Call(SubprogramEntry { program: "\u{1}".into(), level: u16::MAX }),
        Kind::Wait(Arc::new(WaitArrival {
            key: "M101".into(),
            primitive: Primitive::Barrier,
            participants: [1, 2].into(),
            mark: "101".into(),
            acts: false,
        })),
        release("M101", Primitive::Barrier, 5, 3, "101", 0),
        Kind::Diagnostic(Box::new(Diagnostic {
            unrecognised: Some(Box::new(Unrecognised { text: "Q7".into(), place: "'G1 Q7'".into() })),
            ..Diagnostic::default()
        })),
        release("M101", Primitive::Flag, 5, 3, "101", 2),
        Kind::Diagnostic(Box::new(Diagnostic {
            number: 2_900_440,
            race: Some(Box::new(RaceWith { variable: "#100".into(), channel: 2, line: 7 })),
            ..Diagnostic::default()
        })),
        Kind::coupling(
            "synchronous off Z1 Z2 z=5".into(),
            Some(CarriedMove { from: Box::new(from), to: Box::new([7.5; MAX_AXES]), axes: "Z2 with Z1".into() }),
        ),
        Kind::Wait(Arc::new(WaitArrival {
            key: "G68".into(),
            primitive: Primitive::Barrier,
            participants: [1, 2].into(),
            mark: "G68".into(),
            acts: true,
        })),
    ]
}

/// A block of a shipped cycle, with the block of the user's program that called it.
fn called() -> Event {
    Event {
        t_ns: 5,
        micro: 0,
        dur_ns: 0,
        channel: 1,
        file: 4,
        line: 3,
        caller: SourcePlace::new(1, 70_000),
        kind: Kind::Block(BlockEvent { number: 9, unit_named: false }),
    }
}

/// A block after one that has selected the unit.
fn after_a_unit() -> Event {
    Event { kind: Kind::Block(BlockEvent { number: 10, unit_named: true }), ..called() }
}

pub(super) fn events() -> Vec<Event> {
    kinds()
        .into_iter()
        .zip(0..)
        .map(|(kind, i)| Event {
            t_ns: i64::from(i) * 1_000_000_007,
            micro: i % 3,
            dur_ns: i64::from(i % 2) * 77,
            channel: (i % 4) as u16,
            file: (i % 5) as u16,
            line: i * 100_000,
            caller: SourcePlace::NONE,
            kind,
        })
        .chain([called(), after_a_unit()])
        .collect()
}

/// A job with a channel for each of the numbers that the events have.
fn info() -> Info {
    let axis = |name: &str| JobAxis { name: name.into(), rotary: name == "C", diameter: name == "X" };
    let channel = |number: u16| JobChannel {
        number,
        name: format!("CH{number}"),
        program: "a.nc".into(),
        lines: (1, 9),
        file: 0,
        axes: ["X", "Y", "Z", "C"].iter().take(2 + usize::from(number)).map(|name| axis(name)).collect(),
        lower: false,
        inch: false,
        unit_words: "G20/G21".into(),
    };
    let file = |name: &str| JobFile {
        name: name.into(),
        stored: false,
        resident: false,
        text: OnceLock::new(),
        sections: Vec::new(),
    };
    Info {
        machine: "m".into(),
        machine_number: 1,
        machine_revision: 1,
        machine_created: String::new(),
        machine_file: String::new(),
        parameters: String::new(),
        unit: MachineUnit::Mm,
        trace: Default::default(),
        room: ResultBudget { path: 1 << 20, bars: 1 << 20, waiting: 1 << 20 },
        channels: (1..4).map(channel).collect(),
        files: ["a.nc", "b.nc", "c.nc"].map(file).into(),
    }
}

/// All written forms of an event: JSON, wire with four axes, digest of a log with this event only.
fn forms(seq: u64, event: &Event) -> String {
    let (mut json, mut wire, mut digest) = (Vec::new(), Vec::new(), Digest::new());
    jsonl::write_event(&info(), seq, event, &mut json);
    encode::event(&mut wire, seq, event, 4);
    digest.event(event);
    let wire: String = wire.iter().map(|byte| format!("{byte:02x}")).collect();
    let digest = digest::log([(event.channel, digest)].into_iter());
    format!("{}{wire}\n{digest}\n", String::from_utf8_lossy(&json))
}

/// `UPDATE=1` writes the file anew: only when a form is meant to change.
#[test]
fn every_kind_is_written_as_it_always_was() {
    let all: String = (1..).zip(&events()).map(|(seq, event)| forms(seq, event)).collect();
    if std::env::var_os("UPDATE").is_some() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/src/log/forms.txt");
        std::fs::write(path, &all).unwrap();
        return;
    }
    for (line, expected) in all.lines().zip(include_str!("forms.txt").lines()) {
        assert_eq!(line, expected);
    }
    assert_eq!(all.lines().count(), include_str!("forms.txt").lines().count());
}

fn batch(events: &[Event], axes: usize) -> Vec<u8> {
    let mut out = Vec::new();
    events.iter().zip(1..).for_each(|(event, seq)| encode::event(&mut out, seq, event, axes));
    out
}

#[test]
fn decoding_gives_the_same_events_bit_for_bit() {
    let events = events();
    let bytes = batch(&events, MAX_AXES);
    let back: Vec<_> = decode::events(&bytes).map(|e| decode::event(e).unwrap()).collect();
    assert_eq!(back.len(), events.len());
    for ((seq, back), (event, expected)) in back.iter().zip(events.iter().zip(1..)) {
        // As text: signs of zero too, and NaN.
        assert_eq!((*seq, format!("{back:?}")), (expected, format!("{event:?}")));
    }
}

#[test]
fn generated_types_see_the_same_content() {
    let events = events();
    let bytes = batch(&events, 3);
    let batch = v1::EventBatch::decode(bytes.as_slice()).unwrap();
    assert_eq!(batch.events.len(), events.len());
    for (wire, event) in batch.events.iter().zip(&events) {
        assert_eq!(
            (wire.t_ns, wire.micro, wire.dur_ns, wire.channel, wire.file, wire.line),
            (event.t_ns, event.micro, event.dur_ns, u32::from(event.channel), u32::from(event.file), event.line)
        );
        assert!(wire.kind.is_some(), "{event:?}");
    }
    let Some(v1::event::Kind::Motion(motion)) = &batch.events[2].kind else { panic!() };
    assert_eq!(motion.kind(), v1::MotionKind::ArcCcw);
    assert_eq!((motion.start.as_slice(), motion.end.as_slice()), (&[0.0, 12.5, 0.0][..], &[1.0, -2.0, f64::MAX][..]));
    assert_eq!((motion.center.as_slice(), motion.plane.as_slice()), (&[0.0, 7.25][..], &[2, 0][..]));
    assert_eq!(
        (motion.turns, motion.feed, motion.feed_unit(), motion.length),
        (2, 0.1, v1::FeedUnit::PerRevolution, 3.5)
    );
    let mut verdicts = batch.events.iter().filter_map(|event| match &event.kind {
        Some(v1::event::Kind::Verdict(verdict)) => Some(verdict),
        _ => None,
    });
    let verdict = verdicts.next().unwrap();
    assert_eq!(verdict.kind(), v1::VerdictKind::PartnerEnded);
    assert_eq!((verdict.members.len(), verdict.members[0].waiting_for.as_slice()), (2, &[2][..]));
    let mut waits = batch.events.iter().filter_map(|event| match &event.kind {
        Some(v1::event::Kind::Wait(wait)) => Some(wait),
        _ => None,
    });
    let wait = waits.next().unwrap();
    assert_eq!(
        (wait.key.as_str(), wait.primitive(), wait.participants.as_slice()),
        ("M101", v1::Primitive::Order, &[1, 2, 300][..])
    );
    // Encoding again with the generated types changes nothing but the sign of zero, which proto3 leaves out.
    let again = batch.encode_to_vec();
    assert!(v1::EventBatch::decode(again.as_slice()).unwrap().encode_to_vec() == again);
}

#[test]
fn damage_is_no_panic() {
    let bytes = batch(&events(), 4);
    for cut in 0..bytes.len() {
        decode::events(&bytes[..cut]).for_each(|e| drop(decode::event(e)));
    }
    for at in 0..bytes.len().min(2000) {
        let mut bad = bytes.clone();
        bad[at] ^= 0x55;
        decode::events(&bad).for_each(|e| drop(decode::event(e)));
    }
    drop(Bytes::from(bytes));
}
