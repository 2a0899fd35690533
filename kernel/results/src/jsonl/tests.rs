//! Tests of the JSON lines.

use super::write_event;
use crate::testing::*;
use counterpoint_event::event::{
    Diagnostic, DiagnosticOrigin, FrameShift, Kind, Motion, MotionKind, OperatorMessage, SpindleChange,
    SpindleDirection, TimedFunction, ToolData, Verdict, VerdictKind, VerdictMember,
};

fn line(event: &counterpoint_event::event::Event) -> String {
    let mut out = Vec::new();
    write_event(&lathe(&["G2 X1.", "M101"]), 7, event, &mut out);
    let text = String::from_utf8(out).unwrap();
    assert!(text.ends_with("}\n") && text.matches('\n').count() == 1, "{text}");
    serde_json::from_str::<serde_json::Value>(&text).unwrap_or_else(|e| panic!("{e}: {text}"));
    text.trim_end().to_owned()
}

#[test]
fn an_arc_names_its_axes() {
    let arc = Motion {
        center: [-5.0, 20.0],
        plane_axes: [1, 0],
        turns: 2,
        length: 7.5,
        ..motion(MotionKind::ArcCw, &[10.0, -0.0, 0.1], &[20.5, -5.0, 0.1])
    };
    assert_eq!(
        line(&at(1, 1, 5, 30, Kind::Motion(arc))),
        concat!(
            r#"{"seq":7,"t_ns":5,"dur_ns":30,"channel":1,"kind":"motion","file":"jobs/p1.nc","line":1,"#,
            r#""motion":"arc_cw","from":{"X":10,"Z":0,"C":0.1},"to":{"X":20.5,"Z":-5,"C":0.1},"#,
            r#""center":{"Z":-5,"X":20},"feed":100,"feed_unit":"per_minute","length":7.5,"turns":2}"#
        )
    );
    let rapid = line(&at(2, 1, 5, 30, Kind::Motion(motion(MotionKind::Rapid, &[0.0], &[1.0]))));
    assert!(!rapid.contains("center") && !rapid.contains("turns") && rapid.contains(r#""to":{"X":1,"Z":0}"#));
}

#[test]
fn a_circle_in_space_tells_its_centre_and_its_middle() {
    // From radius 5 at Z0 to radius 5 at Z-10 over radius 10 at Z-5: about radius 5 at Z-5, along the chord v is −X.
    let over = Motion { center: [0.0, -5.0], ..motion(MotionKind::ArcSpace, &[10.0, 0.0], &[10.0, -10.0]) };
    let text = line(&at(1, 1, 5, 30, Kind::Motion(over)));
    assert!(text.contains(r#""motion":"arc_space""#) && text.contains(r#""center":{"X":10,"Z":-5}"#), "{text}");
    assert!(text.contains(r#""middle":{"X":20,"Z":-5}"#), "{text}");
}

#[test]
fn odd_texts_and_numbers_stay_valid() {
    let text = line(&at(1, 1, 0, 0, Kind::Message(OperatorMessage { text: "a\"b\\c\n\u{1}ä".into(), printed: false })));
    assert!(text.ends_with(r#""text":"a\"b\\c\n\u0001ä"}"#), "{text}");
    let spindle = SpindleChange {
        spindle: 1,
        direction: SpindleDirection::Clockwise,
        css: true,
        speed: f64::NAN,
        limit: f64::INFINITY,
        angle: 0.0,
    };
    let text = line(&at(1, 1, 0, 0, Kind::Spindle(spindle)));
    assert!(text.ends_with(r#""direction":"clockwise","css":true,"speed":null,"limit":null}"#), "{text}");
    let text = line(&at(1, 1, 0, 0, Kind::Function(TimedFunction { letter: '"', value: 1e300 })));
    assert!(text.contains(r#""letter":"\"","value":1e300"#) || text.contains("1e+300"), "{text}");
    line(&at(99, 3, 0, 0, Kind::Frame(FrameShift { shift: Box::new([1.0; 8]) })));
}

#[test]
fn waits_and_verdicts() {
    let text = line(&wait(2, 1, 9, "M101 P12", &[1, 2]));
    assert!(text.ends_with(
        r#""kind":"wait","file":"jobs/p2.nc","line":1,"key":"M101 P12","primitive":"BARRIER","participants":[1,2]}"#
    ));
    let text = line(&release(2, 1, 4, 9, "M101", 3));
    assert!(text.ends_with(r#""key":"M101","primitive":"BARRIER","since_ns":4,"meeting":3}"#));
    let members = vec![
        VerdictMember { channel: 1, file: 0, line: 1, waiting_for: vec![2] },
        VerdictMember { channel: 2, file: 0, line: 0, waiting_for: vec![] },
    ];
    let verdict = Verdict { kind: VerdictKind::PartnerNeverStarted, at_ns: 9, text: "no program".into(), members };
    let text = line(&at(0, 0, 9, 0, Kind::Verdict(Box::new(verdict))));
    assert!(text.starts_with(r#"{"seq":7,"t_ns":9,"dur_ns":0,"channel":0,"kind":"verdict","file":"","line":0,"verdict":"PARTNER_NEVER_STARTED","at_ns":9"#), "{text}");
    assert!(text.ends_with(r#""members":[{"channel":1,"file":"jobs/p1.nc","line":1,"waiting_for":[2]},{"channel":2,"file":"","line":0,"waiting_for":[]}]}"#), "{text}");
}

#[test]
fn what_is_not_known_of_a_tool_and_no_macro_leave_their_fields_out() {
    let data = ToolData { tool: 3, name: "END \"12\"".into(), diameter: Some(12.0), ..ToolData::default() };
    let text = line(&at(1, 1, 0, 0, Kind::ToolData(Box::new(data))));
    assert!(
        text.ends_with(
            r#""kind":"tool_data","file":"jobs/p1.nc","line":1,"tool":3,"name":"END \"12\"","diameter":12}"#
        ),
        "{text}"
    );
    let origin = DiagnosticOrigin { name: "Fence".into(), file: "m/f.mac".into(), line: 2, statement: "A=1/0".into() };
    let known = Diagnostic { number: 2_019_001, severity: 8, text: "t".into(), ..Diagnostic::default() };
    let text = line(&at(1, 1, 0, 0, Kind::Diagnostic(Box::new(known))));
    assert!(text.ends_with(r#""number":2019001,"severity":8,"text":"t","name":"no-feed"}"#), "{text}");
    let raised = Diagnostic { number: 7, severity: 8, origin: Some(Box::new(origin)), ..Diagnostic::default() };
    let text = line(&at(1, 1, 0, 0, Kind::Diagnostic(Box::new(raised))));
    assert!(
        text.ends_with(r#""text":"","origin":{"macro":"Fence","file":"m/f.mac","line":2,"statement":"A=1/0"}}"#),
        "{text}"
    );
}
