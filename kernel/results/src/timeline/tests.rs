//! Tests of the timeline.

use std::sync::Arc;

use super::*;
use crate::testing::*;
use counterpoint_event::event::{CarriedMove, Dwell, Event, Kind, MotionKind, Phase, ToolAction, ToolChange};

const S: i64 = 1_000_000_000;

fn timeline(info: &Arc<Info>, events: &[Event]) -> Timeline {
    results(info, events, &outcome(events.len())).timeline
}

#[test]
fn neighbours_of_one_kind_are_one_bar() {
    let line = |line, t, kind| at(1, line, t * S, S, Kind::Motion(motion(kind, &[0.0], &[1.0])));
    let events = [
        line(1, 0, MotionKind::Linear),
        line(2, 1, MotionKind::ArcCw),
        line(3, 2, MotionKind::Rapid),
        at(1, 4, 3 * S, S, Kind::Tool(ToolChange { action: ToolAction::Load, tool: 1, offset: 1 })),
        at(1, 5, 4 * S, S, Kind::Dwell(Dwell)),
        wait(1, 6, 5 * S, "M101", &[1, 2]),
        release(1, 6, 5 * S, 7 * S, "M101", 1),
        line(7, 7, MotionKind::Thread),
        line(8, 9, MotionKind::Thread),
        life(1, 10 * S, Phase::ProgramEnd),
    ];
    let timeline = timeline(&lathe(&["x"]), &events);
    let json = serde_json::to_value(&timeline).unwrap();
    let bar = |kind: &str, t: i64, dur: i64, line: u32, end: u32| {
        serde_json::json!({
            "kind": kind, "t_ns": t * S, "dur_ns": dur * S, "file": "jobs/p1.nc", "line": line, "end_line": end
        })
    };
    let mut wait = bar("wait", 5, 2, 6, 6);
    wait["label"] = "M101".into();
    let bars = [
        bar("feed", 0, 2, 1, 2),
        bar("rapid", 2, 1, 3, 3),
        bar("tool", 3, 1, 4, 4),
        bar("dwell", 4, 1, 5, 5),
        wait,
        bar("feed", 7, 1, 7, 7),
        bar("feed", 9, 1, 8, 8),
    ];
    assert_eq!(json["channels"][0]["bars"], serde_json::Value::from(bars.to_vec()));
    assert_eq!((json["unit"].as_str(), json["makespan_ns"].as_i64()), (Some("ns"), Some(10 * S)));
    assert_eq!(json["waits"][0]["release_ns"], 7 * S);
    assert_eq!(json.as_object().unwrap().len(), 4);
    assert_eq!(json["channels"][0].as_object().unwrap().len(), 4);
    let tools = serde_json::json!([
        {"tool": 1, "operation": "", "t_ns": 3 * S, "end_ns": 10 * S, "file": "jobs/p1.nc", "line": 4}
    ]);
    assert_eq!(json["channels"][0]["tools"], tools);
}

#[test]
fn a_slave_moves_below_its_wait_and_on_the_path() {
    let carried = |t: i64| {
        let (from, to) = (Box::new(position(&[40.0, -35.0])), Box::new(position(&[40.0, -65.0])));
        let carried = CarriedMove { from, to, axes: "Z2 with Z1".into() };
        at(2, 10, t * S, 0, Kind::coupling("synchronous off Z1 Z2 z=-65".into(), Some(carried)))
    };
    let events = [
        at(2, 9, 0, S, Kind::Motion(motion(MotionKind::Linear, &[40.0, 0.0], &[40.0, -35.0]))),
        wait(2, 10, S, "G50.4 Q203", &[1, 2]),
        release(2, 10, S, 4 * S, "G50.4 Q203", 1),
        carried(4),
        at(2, 11, 4 * S, S, Kind::Motion(motion(MotionKind::Rapid, &[40.0, -65.0], &[40.0, 0.0]))),
        // Another wait that took no time: nothing moved during it.
        carried(5),
        life(2, 5 * S, Phase::ProgramEnd),
    ];
    let info = lathe(&["x", "y"]);
    let results = results(&info, &events, &outcome(events.len()));
    let svg = results.timeline.svg();
    let json = serde_json::to_value(&results.timeline).unwrap();
    let bars = &json["channels"][1]["bars"];
    assert_eq!((bars[0]["carried"].as_str(), bars[1]["carried"].as_str()), (None, Some("Z2 with Z1")));
    assert_eq!((bars[1]["kind"].as_str(), bars[2]["carried"].as_str()), (Some("wait"), None));
    assert!(svg.contains("<title>moves Z2 with Z1 meanwhile</title>"), "{svg}");
    let path = serde_json::to_value(&results.toolpath).unwrap();
    let feed = &path["channels"][1]["segments"][0];
    assert_eq!(feed["points"], serde_json::json!([0.0, 20.0, -35.0, 20.0, -65.0, 20.0]));
    assert_eq!(feed["lines"], serde_json::json!([9, 10]));
}

#[test]
fn a_blocked_channel_has_no_bar_for_its_stand_and_a_stop_cuts() {
    let events = [
        at(1, 1, 0, 3 * S, Kind::Dwell(Dwell)),
        at(2, 1, 0, S, Kind::Dwell(Dwell)),
        wait(2, 2, S, "M101", &[1, 2]),
        at(1, 2, 3 * S, 9 * S, Kind::Motion(motion(MotionKind::Linear, &[0.0], &[1.0]))),
        life(0, 5 * S, Phase::MachineEnd),
    ];
    let timeline = timeline(&lathe(&["x", "y"]), &events);
    assert_eq!(timeline.makespan_ns, 5 * S);
    assert_eq!(timeline.channels[0].bars.iter().map(|b| b.dur_ns).collect::<Vec<_>>(), [3 * S, 2 * S]);
    assert_eq!((timeline.channels[1].bars.len(), timeline.channels[1].state), (1, ChannelState::Blocked));
    assert!(timeline.svg().contains("waits at M101"));
}

#[test]
fn the_lines_of_a_bar_are_those_of_its_blocks_in_any_order() {
    let line = |line, t| at(1, line, t * S, S, Kind::Motion(motion(MotionKind::Linear, &[0.0], &[1.0])));
    let events = [line(5, 0), line(9, 1), line(3, 2), line(7, 3), life(1, 4 * S, Phase::ProgramEnd)];
    let bars = timeline(&lathe(&["x"]), &events).channels.remove(0).bars;
    assert_eq!(bars.iter().map(|b| (b.line, b.end_line, b.dur_ns)).collect::<Vec<_>>(), [(3, 9, 4 * S)]);
}

#[test]
fn the_number_of_bars_is_bounded_and_their_time_kept() {
    let mut events = Vec::new();
    let mut t = 0;
    for n in 0..100_000_u32 {
        let dur = if n % 1000 == 0 { S } else { 1000 + i64::from(n % 7) };
        let kind = if n % 2 == 0 { MotionKind::Linear } else { MotionKind::Rapid };
        events.push(at(1, n, t, dur, Kind::Motion(motion(kind, &[0.0], &[1.0]))));
        t += dur;
    }
    events.push(life(1, t, Phase::ProgramEnd));
    let timeline = timeline(&lathe(&["x"]), &events);
    let bars = &timeline.channels[0].bars;
    assert!(bars.len() <= bars::MOST && bars.len() > 1000, "{}", bars.len());
    assert_eq!(bars.iter().map(|b| b.dur_ns).sum::<i64>(), t);
    assert!(bars.windows(2).all(|w| w[0].end_ns() == w[1].t_ns));
    assert!(timeline.svg().len() < 40_000, "{}", timeline.svg().len());
}

#[test]
fn texts_in_the_picture_are_escaped() {
    let mut info = Arc::into_inner(lathe(&["x", "y"])).unwrap();
    info.machine = "<a&b>".into();
    info.channels[0].name = "\"U\u{1}\"".into();
    let events = [
        wait(1, 1, 0, "<M1>", &[1, 2]),
        wait(2, 1, S, "<M1>", &[1, 2]),
        release(1, 1, 0, S, "<M1>", 1),
        release(2, 1, S, S, "<M1>", 1),
    ];
    let svg = timeline(&Arc::new(info), &events).svg();
    assert!(svg.contains("&lt;a&amp;b&gt;") && svg.contains("&lt;M1&gt;") && !svg.contains("<M1>"));
    assert!(svg.ends_with("</svg>\n"));
}

#[test]
fn a_job_without_time_is_still_a_picture() {
    assert!(timeline(&lathe(&["x"]), &[]).svg().contains("cycle time 0.000 s"));
}

/// `x`, width, text and `y` of the marks of sync points.
fn marks(svg: &str) -> Vec<(f64, f64, String, f64)> {
    let of = |rect: &str, key: &str| rect.split(key).nth(1).and_then(|r| r.split('"').next()).unwrap().parse().unwrap();
    let all = svg.split("<rect ").skip(1).filter(|rect| rect.contains("rx=\"3\""));
    all.map(|rect| {
        let text = rect.split("</text>").next().and_then(|r| r.rsplit('>').next()).unwrap_or_default();
        (of(rect, "x=\""), of(rect, "width=\""), text.to_owned(), of(rect, "y=\""))
    })
    .collect()
}

#[test]
fn marks_of_meetings_stay_inside_and_off_each_other() {
    let info = lathe(&["x", "y"]);
    let long = "MEET_AT_A_VERY_LONG_NAME_OF_A_MARK_THAT_NO_PICTURE_HAS_ROOM_FOR";
    // The first at the very begin, two next to each other, the last at the very end.
    let meetings = [(0, "M100 P12"), (50, "M101 P12"), (51, "M102 P12"), (70, long), (100, "M199 P12")];
    let mut events = Vec::new();
    for (number, (t, key)) in (1..).zip(meetings) {
        for channel in [1, 2] {
            events.push(wait(channel, number, t * S, key, &[1, 2]));
            events.push(release(channel, number, t * S, t * S, key, u64::from(number)));
        }
    }
    events.extend([life(1, 100 * S, Phase::ProgramEnd), life(2, 100 * S, Phase::ProgramEnd)]);
    let svg = timeline(&info, &events).svg();
    let marks = marks(&svg);
    let texts: Vec<&str> = marks.iter().map(|(_, _, text, _)| text.as_str()).collect();
    assert_eq!(texts[..3], ["M100 P12", "M101 P12", "M102 P12"], "{texts:?}");
    assert!(texts.len() == 5 && texts[3].starts_with("MEET_AT_A_") && texts[3].ends_with('…'), "{texts:?}");
    assert!(marks.iter().all(|(x, width, ..)| *x >= 0.0 && x + width <= 1200.0), "{marks:?}");
    assert!(apart(&marks), "{marks:?}");
    assert!(
        svg.contains("<title>M102 P12, 51.000 s; UPPER jobs/p1.nc line 3; LOWER jobs/p2.nc line 3</title>"),
        "{svg}"
    );
}

#[test]
fn a_wait_that_another_channel_ends_joins_both_and_one_passed_alone_has_a_mark() {
    let by = |mut event: Event, channel: u16| {
        if let Kind::Release(release) = &mut event.kind {
            release.by = channel;
        }
        event
    };
    let events = [
        wait(1, 2, 10 * S, "P15", &[1]),
        by(release(1, 2, 10 * S, 10 * S, "P15", 1), 1),
        wait(2, 3, 20 * S, "P25", &[2]),
        by(release(2, 3, 20 * S, 40 * S, "P25", 2), 1),
        life(1, 50 * S, Phase::ProgramEnd),
        life(2, 50 * S, Phase::ProgramEnd),
    ];
    let svg = timeline(&lathe(&["x", "y"]), &events).svg();
    let dots = |key: &str| svg.split("<circle ").filter(|dot| dot.contains(&format!("<title>{key},"))).count();
    assert_eq!((dots("P15"), dots("P25")), (1, 2), "{svg}");
    let texts: Vec<String> = marks(&svg).into_iter().map(|(_, _, text, _)| text).collect();
    assert_eq!(texts, ["P15", "P25"]);
}

/// Whether no mark lies over another one.
fn apart(marks: &[(f64, f64, String, f64)]) -> bool {
    let over = |one: &(f64, f64, String, f64), other: &(f64, f64, String, f64)| {
        one.0 < other.0 + other.1 && other.0 < one.0 + one.1 && (one.3 - other.3).abs() < 16.0
    };
    (1..marks.len()).all(|index| marks[..index].iter().all(|other| !over(&marks[index], other)))
}

/// Two channels that meet at these times, s, by these marks.
fn meeting(meetings: &[(i64, &str)], end: i64) -> String {
    let mut events = Vec::new();
    for (number, (t, key)) in (1..).zip(meetings) {
        for channel in [1, 2] {
            events.push(wait(channel, number, t * S, key, &[1, 2]));
            events.push(release(channel, number, t * S, t * S, key, u64::from(number)));
        }
    }
    events.extend([life(1, end * S, Phase::ProgramEnd), life(2, end * S, Phase::ProgramEnd)]);
    timeline(&lathe(&["x", "y"]), &events).svg()
}

#[test]
fn all_marks_of_one_instant_can_be_read() {
    let balance = ["M101", "G68", "G68 cut", "G68 cut", "G68 cut", "M102", "G51.4", "M103", "M104 P12"];
    let svg = meeting(&balance.map(|key| (50, key)), 100);
    let texts = marks(&svg).into_iter().map(|(_, _, text, _)| text).collect::<Vec<_>>().join(", ");
    assert_eq!(texts, "M101, G68, G68 cut ×3, M102, G51.4, M103, M104 P12");
    assert!(apart(&marks(&svg)));
}

/// More marks than one plot has room for are drawn in parts of the time; each of them has a mark of its own there.
#[test]
fn sixty_and_six_hundred_marks_can_be_read() {
    for count in [60, 600] {
        let names: Vec<String> = (0..count).map(|n| format!("M{}", 100 + n)).collect();
        let meetings: Vec<(i64, &str)> = (1..).zip(&names).map(|(t, name)| (t * 10, name.as_str())).collect();
        let svg = meeting(&meetings, count * 10 + 10);
        let marks = marks(&svg);
        let shown = |name: &String| marks.iter().any(|(_, _, text, _)| text.split(", ").any(|shown| shown == name));
        let hidden: Vec<&String> = names.iter().filter(|name| !shown(name)).collect();
        assert!(hidden.is_empty(), "{hidden:?}");
        assert!(apart(&marks));
        assert!(svg.len() < 600_000, "{}", svg.len());
    }
}

#[test]
fn a_job_that_has_failed_says_so_in_its_title() {
    let svg = timeline(&lathe(&["x"]), &[life(1, 0, Phase::ProgramStart), life(1, S, Phase::Alarmed)]).svg();
    assert!(svg.contains(">FAILED, stopped after 1.000 s</text>"), "{svg}");
}

#[test]
fn tools_and_operations_are_above_the_bars_and_names_are_cut() {
    let mut info = Arc::into_inner(lathe(&["T0101 (OD ROUGH)\nG1 X1.\nT0202 (THE NEXT ONE)\nG1 X1.\n"])).unwrap();
    info.channels[0].name = "AN UPPER TURRET WITH A LONG NAME".into();
    let load =
        |line, t, tool| at(1, line, t * S, 0, Kind::Tool(ToolChange { action: ToolAction::Load, tool, offset: tool }));
    let cut = |line, t, dur| at(1, line, t * S, dur * S, Kind::Motion(motion(MotionKind::Linear, &[0.0], &[1.0])));
    let events = [load(1, 0, 1), cut(2, 0, 96), load(3, 96, 2), cut(4, 96, 4), life(1, 100 * S, Phase::ProgramEnd)];
    let svg = timeline(&Arc::new(info), &events).svg();
    assert!(
        svg.contains(">T1 OD ROUGH</text>") && svg.contains(">T2…</text>") || svg.contains(">T2 T…</text>"),
        "{svg}"
    );
    assert!(svg.contains("<title>T2 THE NEXT ONE, 4.000 s, jobs/p1.nc line 3</title>"), "{svg}");
    assert!(svg.contains("<title>feed, 100.000 s, lines 2 to 4, T1 OD ROUGH, T2 THE NEXT ONE</title>"), "{svg}");
    assert!(svg.contains(">1 AN UPPER TU…</text>") && !svg.contains("LONG NAME</text>"), "{svg}");
}

#[test]
fn a_channel_with_many_tools_and_meetings_is_a_small_picture() {
    let mut events = Vec::new();
    for n in 0..100_000_u32 {
        let t = i64::from(n) * S;
        events.push(at(1, n, t, 0, Kind::Tool(ToolChange { action: ToolAction::Load, tool: n % 20 + 1, offset: 0 })));
        events.push(at(1, n, t, S, Kind::Motion(motion(MotionKind::Linear, &[0.0], &[1.0]))));
        for channel in [1, 2] {
            events.push(wait(channel, n, t + S, "M101", &[1, 2]));
            events.push(release(channel, n, t + S, t + S, "M101", u64::from(n) + 1));
        }
    }
    let timeline = timeline(&lathe(&["x", "y"]), &events);
    let svg = timeline.svg();
    assert!(svg.len() < 400_000, "{}", svg.len());
    assert!(timeline.channels[0].tools.len() <= 10_000);
}

#[test]
fn plots_of_details_show_the_critical_path_and_the_marks_of_their_own_time() {
    let mut events = Vec::new();
    for n in 0..60_u32 {
        let t = i64::from(n) * S;
        for channel in [1, 2] {
            events.push(wait(channel, n, t + S, "M159", &[1, 2]));
            events.push(release(channel, n, t + S, t + S, "M159", u64::from(n) + 1));
        }
    }
    events.extend([life(1, 60 * S, Phase::ProgramEnd), life(2, 60 * S, Phase::ProgramEnd)]);
    let svg = timeline(&lathe(&["x", "y"]), &events).svg();
    assert!(svg.matches("<clipPath").count() > 1, "{svg}");
    let starts = svg.split(r#"stroke-width="2.5" d="M"#).skip(1).filter_map(|path| path.split(' ').next());
    let starts: Vec<f64> = starts.map(|x| x.parse().unwrap()).collect();
    assert!(starts.len() > 1 && starts.iter().all(|x| *x >= 150.0), "{starts:?}");
}
