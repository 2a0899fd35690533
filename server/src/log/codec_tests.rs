//! The hand-written codec against the generated types.

use std::sync::Arc;

use bytes::Bytes;
use counterpoint_kernel::log::event::*;
use counterpoint_proto::v1;
use prost::Message as _;

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
    let plain = Motion { kind: MotionKind::Rapid, center: [0.0; 2], plane_axes: [255; 2], turns: 0, ..motion };
    vec![
        Kind::Lifecycle(Phase::Blocked),
        Kind::Block { number: 1 << 40 },
        Kind::Motion(motion),
        Kind::Motion(plain),
        Kind::Dwell,
        Kind::Tool { action: ToolAction::Load, tool: 12, offset: 0 },
        Kind::Spindle(Spindle {
            spindle: 1,
            direction: Direction::Clockwise,
            css: true,
            speed: 180.0,
            limit: f64::INFINITY,
            angle: 90.0,
        }),
        Kind::Coolant(Coolant { on: true, fluid: 4, outlet: Outlet::Main }),
        Kind::Coolant(Coolant { on: false, fluid: 0, outlet: Outlet::Side }),
        Kind::Coolant(Coolant { on: true, fluid: 0, outlet: Outlet::Device(9) }),
        Kind::Function { letter: 'M', value: 0.0 },
        Kind::Mode { text: "plane zx".into() },
        Kind::Frame { shift: Box::new(from) },
        Kind::Stop(Stop::Rewind),
        Kind::Call { program: "O9001".into(), level: 2 },
        Kind::Return { level: 2 },
        Kind::Message { text: "é".repeat(9000).into(), printed: false },
        Kind::Message { text: "printed".into(), printed: true },
        Kind::Wait(Arc::new(Wait {
            key: "M101".into(),
            primitive: Primitive::Order,
            participants: [1, 2, 300].into(),
        })),
        Kind::Release(Release { key: "M101".into(), primitive: Primitive::Barrier, since_ns: 5, meeting: 3 }),
        Kind::Diagnostic(Box::new(Diagnostic {
            number: 1201,
            severity: 9,
            text: "no such register".into(),
            operation: "ROUGH".into(),
            kernel: "TURRET".into(),
            origin: None,
        })),
        Kind::Verdict(Box::new(Verdict {
            kind: VerdictKind::PartnerEnded,
            at_ns: 99,
            text: "channel 1 waits".into(),
            members: vec![
                Member { channel: 1, file: 0, line: 7, waiting_for: vec![2] },
                Member { channel: 2, file: 1, line: 0, waiting_for: vec![] },
            ],
        })),
        Kind::Trace { letter: 'C', text: "  code_rapid".into() },
        Kind::Motion(Motion { kind: MotionKind::ArcSpace, center: [-3.5, 0.25], ..plain }),
        Kind::Diagnostic(Box::new(Diagnostic {
            number: 2_910_090,
            origin: Some(Box::new(Origin {
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
    ]
}

fn events() -> Vec<Event> {
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
            kind,
        })
        .collect()
}

fn batch(events: &[Event], axes: usize) -> Vec<u8> {
    let mut out = Vec::new();
    events.iter().zip(1..).for_each(|(event, seq)| super::numbers::event(&mut out, seq, event, axes));
    out
}

#[test]
fn decoding_gives_the_same_events_bit_for_bit() {
    let events = events();
    let bytes = batch(&events, MAX_AXES);
    let back: Vec<_> = super::events(&bytes).map(|e| super::event(e).unwrap()).collect();
    assert_eq!(back.len(), events.len());
    for ((seq, back), (event, expected)) in back.iter().zip(events.iter().zip(1..)) {
        assert_eq!((*seq, back), (expected, event));
        assert_eq!(format!("{back:?}"), format!("{event:?}"), "signs of zero too");
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
    let verdict = verdicts.next_back().unwrap();
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
    assert_eq!(v1::EventBatch::decode(batch.encode_to_vec().as_slice()).unwrap(), batch);
}

#[test]
fn damage_is_no_panic() {
    let bytes = batch(&events(), 4);
    for cut in 0..bytes.len() {
        super::events(&bytes[..cut]).for_each(|e| drop(super::event(e)));
    }
    for at in 0..bytes.len().min(2000) {
        let mut bad = bytes.clone();
        bad[at] ^= 0x55;
        super::events(&bad).for_each(|e| drop(super::event(e)));
    }
    drop(Bytes::from(bytes));
}
