//! Tests of the toolpath.

use std::sync::Arc;

use super::*;
use crate::builder::ResultsBuilder;
use crate::testing::*;
use counterpoint_event::event::{Kind, Phase, ToolAction, ToolChange};

fn of(info: &Arc<Info>, motions: impl Iterator<Item = Motion>) -> Toolpath {
    let mut builder = ResultsBuilder::new(info);
    (1..).zip(motions).for_each(|(line, m)| builder.event(&at(1, line, 0, 1, Kind::Motion(m))));
    builder.finish(&outcome(1)).toolpath
}

/// All motions in one block.
fn block(info: &Arc<Info>, motions: &[Motion]) -> Toolpath {
    let mut builder = ResultsBuilder::new(info);
    motions.iter().for_each(|m| builder.event(&at(1, 1, 0, 1, Kind::Motion(*m))));
    builder.finish(&outcome(1)).toolpath
}

pub(super) fn toolpath(info: &Arc<Info>, motions: &[Motion]) -> Toolpath {
    of(info, motions.iter().copied())
}

pub(super) fn arc(kind: MotionKind, from: &[f64], to: &[f64], plane_axes: [u8; 2], center: [f64; 2]) -> Motion {
    Motion { center, plane_axes, ..motion(kind, from, to) }
}

#[test]
fn a_lathe_is_seen_by_z_and_radius() {
    let path = toolpath(
        &lathe(&["x"]),
        &[
            motion(MotionKind::Rapid, &[100.0, 50.0], &[20.0, 2.0]),
            motion(MotionKind::Linear, &[20.0, 2.0], &[20.0, 0.0]),
            motion(MotionKind::Linear, &[20.0, 0.0], &[20.0, -10.0]),
            arc(MotionKind::ArcCw, &[20.0, -10.0], &[30.0, -15.0], [1, 0], [-10.0, 30.0]),
            motion(MotionKind::Thread, &[30.0, -15.0], &[30.0, -20.00004]),
            motion(MotionKind::Rapid, &[40.0, 0.0], &[50.0, 0.0]),
        ],
    );
    assert_eq!(
        serde_json::to_string(&path).unwrap(),
        concat!(
            r#"{"unit":"mm","view":"zx","channels":[{"channel":1,"name":"UPPER","side":"upper","#,
            r#""tools":[{"tool":0,"name":""}],"truncated":false,"segments":["#,
            r#"{"kind":"rapid","points":[50.0,50.0,2.0,10.0],"tool":0,"file":"jobs/p1.nc","lines":[1]},"#,
            r#"{"kind":"feed","points":[2.0,10.0,0.0,10.0,-10.0,10.0],"tool":0,"file":"jobs/p1.nc","lines":[2,3]},"#,
            r#"{"kind":"arc_cw","points":[-10.0,10.0,-15.0,15.0],"plane":"zx","center":[-10.0,15.0],"turns":0,"#,
            r#""tool":0,"file":"jobs/p1.nc","lines":[4]},"#,
            r#"{"kind":"thread","points":[-15.0,15.0,-20.0,15.0],"tool":0,"file":"jobs/p1.nc","lines":[5]},"#,
            r#"{"kind":"rapid","points":[0.0,20.0,0.0,25.0],"tool":0,"file":"jobs/p1.nc","lines":[6]}],"#,
            r#""stop":{"state":"STOPPED","file":"jobs/p1.nc","line":6}}]}"#
        )
    );
}

#[test]
fn a_mill_is_seen_in_three_coordinates() {
    let path = toolpath(
        &mill("x"),
        &[
            motion(MotionKind::Linear, &[0.0, 0.0, 5.0], &[10.0, 0.0, 5.0]),
            arc(MotionKind::ArcCcw, &[10.0, 0.0, 5.0], &[10.0, 0.0, 5.0], [0, 1], [0.0, 0.0]),
        ],
    );
    let json = serde_json::to_value(&path).unwrap();
    assert_eq!(json["view"], "xyz");
    assert_eq!(json["channels"][0]["segments"][0]["points"], serde_json::json!([0.0, 0.0, 5.0, 10.0, 0.0, 5.0]));
    assert_eq!(json["channels"][0]["segments"][1]["plane"], "xy");
}

#[test]
fn a_circle_out_of_sight_is_chords_with_its_extremes() {
    // In a plane of Z and an axis that is not seen: half a turn about the origin, by way of Z10.
    let side = arc(MotionKind::ArcCcw, &[40.0, 0.0, -10.0], &[40.0, 0.0, 10.0], [1, 2], [0.0, 0.0]);
    let json = serde_json::to_value(toolpath(&lathe(&["x"]), &[side])).unwrap();
    let points = json["channels"][0]["segments"][0]["points"].as_array().unwrap();
    let along: Vec<f64> = points.iter().step_by(2).map(|z| z.as_f64().unwrap()).collect();
    assert!(points.iter().skip(1).step_by(2).all(|x| x.as_f64() == Some(20.0)), "{points:?}");
    assert!(along.len() > 60 && along.contains(&10.0), "{along:?}");
    assert_eq!((along[0], along[along.len() - 1]), (0.0, 0.0));
}

#[test]
fn a_circle_in_space_is_chords_with_its_extremes() {
    // From X10 to X-10 over the top: along the chord u is −Z, so the middle is at −10 u.
    let over = Motion { center: [-10.0, 0.0], ..motion(MotionKind::ArcSpace, &[10.0, 0.0, 0.0], &[-10.0, 0.0, 0.0]) };
    let json = serde_json::to_value(toolpath(&mill("x"), &[over])).unwrap();
    let segment = &json["channels"][0]["segments"][0];
    let points: Vec<f64> = segment["points"].as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect();
    let points: Vec<&[f64]> = points.chunks(3).collect();
    assert_eq!(segment["kind"], "feed");
    assert!(points.len() > 60 && points.contains(&&[0.0, 0.0, 10.0][..]), "{points:?}");
    assert!(points.iter().all(|p| (p[0].hypot(p[2]) - 10.0).abs() < 1e-3 && p[1] == 0.0), "{points:?}");
    assert_eq!(points.last(), Some(&&[-10.0, 0.0, 0.0][..]));
}

/// The `d` of the paths drawn in the first view.
fn drawn(svg: &str) -> Vec<&str> {
    let group = svg.split("url(#view0)").nth(1).and_then(|g| g.split("<text").next()).expect("a view");
    group.split(" d=\"").skip(1).filter_map(|d| d.split('"').next()).collect()
}

#[test]
fn arcs_are_arcs_and_turn_the_right_way() {
    // With Z right and X up, clockwise from left to right goes over the top.
    let over = arc(MotionKind::ArcCw, &[0.0, -10.0], &[0.0, 10.0], [1, 0], [0.0, 0.0]);
    let d = drawn(&toolpath(&lathe(&["x"]), &[over]).svg())[0].to_owned();
    assert!(d.contains(" 0 0 1 ") && !d.contains(" 0 0 0") && d.matches('a').count() == 2, "{d}");
    let under = Motion { kind: MotionKind::ArcCcw, ..over };
    let d = drawn(&toolpath(&lathe(&["x"]), &[under]).svg())[0].to_owned();
    assert!(d.contains(" 0 0 0 ") && !d.contains(" 0 0 1"), "{d}");
    let circle = Motion { turns: 3, ..arc(MotionKind::ArcCw, &[20.0, 0.0], &[20.0, 0.0], [1, 0], [0.0, 0.0]) };
    let d = drawn(&toolpath(&lathe(&["x"]), &[circle]).svg())[0].to_owned();
    assert!((2..=5).contains(&d.matches('a').count()), "{d}");
}

#[test]
fn points_on_a_line_are_not_drawn_but_corners_are() {
    let mut motions: Vec<Motion> = (0..1000_u32)
        .map(|n| f64::from(n) * 0.1)
        .map(|x| motion(MotionKind::Linear, &[x, 0.0], &[x + 0.1, 0.0]))
        .collect();
    motions.push(motion(MotionKind::Linear, &[100.0, 0.0], &[100.0, 50.0]));
    motions.push(motion(MotionKind::Linear, &[100.0, 50.0], &[100.0, 20.0]));
    let svg = block(&mill("x"), &motions).svg();
    let d = drawn(&svg)[0];
    let numbers = d.split(|c: char| !(c.is_ascii_digit() || c == '.')).filter(|n| !n.is_empty()).count();
    assert_eq!(numbers, 8, "{d}");
}

#[test]
fn a_path_is_bounded() {
    let step = |n: u32| {
        let at = |n: u32| (f64::from(n) * 0.01).sin_cos();
        let ((a, b), (c, d)) = (at(n), at(n + 1));
        motion(MotionKind::Linear, &[a, b, 0.0], &[c, d, 0.0])
    };
    let path = of(&mill("x"), (0..700_000).map(step));
    assert!(path.channels[0].path.moves.len() <= store::MOST);
    let zigzag = |n: u32| {
        let kind = if n.is_multiple_of(2) { MotionKind::Rapid } else { MotionKind::Linear };
        let (from, to) = (f64::from(n % 2) * 100.0, f64::from((n + 1) % 2) * 100.0);
        motion(kind, &[from, 0.0], &[to, 0.0])
    };
    let path = of(&mill("x"), (0..600_000).map(zigzag));
    assert!(path.channels[0].path.truncated && path.channels[0].path.moves.len() <= store::MOST);
    let svg = path.svg();
    assert!(svg.contains("not to its end") && svg.len() < 20_000, "{}", svg.len());
}

#[test]
fn without_a_path_the_rest_is_the_same() {
    let info = mill("x");
    let ends = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 2.0, 0.0], [5.0, 2.0, -1.0]];
    let motions = ends.array_windows().map(|[from, to]| motion(MotionKind::Linear, from, to));
    let events: Vec<_> = (1..).zip(motions).map(|(line, m)| at(1, line, 0, 1, Kind::Motion(m))).collect();
    let mut without = ResultsBuilder::new(&info).without_toolpath();
    events.iter().for_each(|event| without.event(event));
    let (without, with) = (without.finish(&outcome(3)), results(&info, &events, &outcome(3)));
    assert_eq!(without.summary, with.summary);
    assert_eq!(format!("{:?}", without.timeline), format!("{:?}", with.timeline));
    let moves = |path: &Toolpath| path.channels.iter().map(|channel| channel.path.moves.len()).collect::<Vec<_>>();
    assert_eq!((moves(&without.toolpath), moves(&with.toolpath)), (vec![0], vec![4]));
}

#[test]
fn nothing_to_draw_is_still_a_picture() {
    assert!(toolpath(&mill("x"), &[]).svg().ends_with("</svg>\n"));
    let svg = toolpath(&lathe(&["x"]), &[motion(MotionKind::Rapid, &[1.0], &[1.0])]).svg();
    assert!(!svg.contains("NaN") && !svg.contains("inf"));
}

#[test]
fn a_cut_that_goes_in_and_out_on_one_line_is_drawn() {
    let groove = [
        motion(MotionKind::Linear, &[44.0, -38.0], &[34.0, -38.0]),
        motion(MotionKind::Linear, &[34.0, -38.0], &[44.0, -38.0]),
        motion(MotionKind::Linear, &[44.0, -38.0], &[44.0, -42.0]),
        motion(MotionKind::Linear, &[44.0, -42.0], &[36.0, -42.0]),
        motion(MotionKind::Linear, &[36.0, -42.0], &[44.0, -42.0]),
    ];
    let depth = |d: &str| {
        let numbers = d.split(|c: char| !(c.is_ascii_digit() || matches!(c, '.' | '-'))).filter(|n| !n.is_empty());
        numbers.filter_map(|n| n.rsplit('-').next()?.parse::<f64>().ok()).fold(0.0, f64::max)
    };
    for svg in [block(&lathe(&["x"]), &groove).svg(), toolpath(&lathe(&["x"]), &groove).svg()] {
        // The view is five times as wide as a groove is deep.
        let deep: f64 = drawn(&svg).iter().map(|d| depth(d.split('l').nth(1).unwrap_or_default())).fold(0.0, f64::max);
        assert!(deep > 300.0, "{deep} {:?}", drawn(&svg));
    }
    let hole = [
        motion(MotionKind::Linear, &[0.0, 0.0, 5.0], &[0.0, 0.0, -20.0]),
        motion(MotionKind::Linear, &[0.0, 0.0, -20.0], &[0.0, 0.0, 5.0]),
    ];
    let svg = block(&mill("x"), &hole).svg();
    let side = svg.split("url(#view1)").nth(1).unwrap();
    assert!(side.contains(" d=\"M"), "the hole is seen from the front: {side}");
}

/// Two channels, the second one below the axis, each with a tool.
fn turrets() -> Toolpath {
    let info = lathe(&["O1\nT0101 (OD ROUGH)\nG1 X20.\nG1 Z-10.\n", "O2\nT0202\nG1 Z-10.\n"]);
    let mut builder = ResultsBuilder::new(&info);
    let load = |channel: u16, tool| {
        at(channel, 2, 0, 0, Kind::Tool(ToolChange { action: ToolAction::Load, tool, offset: tool }))
    };
    let cut = |channel: u16, line, from: &[f64], to: &[f64]| {
        at(channel, line, 0, 1, Kind::Motion(motion(MotionKind::Linear, from, to)))
    };
    for event in [
        load(1, 1),
        cut(1, 3, &[30.0, 0.0], &[20.0, 0.0]),
        cut(1, 4, &[20.0, 0.0], &[20.0, -10.0]),
        load(2, 2),
        cut(2, 3, &[40.0, 0.0], &[40.0, -10.0]),
        life(1, 5, Phase::ProgramEnd),
        life(2, 5, Phase::ProgramEnd),
    ] {
        builder.event(&event);
    }
    builder.finish(&outcome(5)).toolpath
}

#[test]
fn tools_have_colours_names_and_lines() {
    let toolpath = turrets();
    let json = serde_json::to_value(&toolpath).unwrap();
    let [upper, lower] = [0, 1].map(|index| &json["channels"][index]);
    assert_eq!((&upper["side"], &lower["side"]), (&"upper".into(), &"lower".into()));
    assert_eq!(upper["tools"], serde_json::json!([{"tool": 1, "name": "OD ROUGH"}]));
    assert_eq!(upper["segments"][0]["lines"], serde_json::json!([3, 4]));
    assert_eq!((&lower["segments"][0]["tool"], &lower["segments"][0]["points"][1]), (&2.into(), &20.0.into()));
    let svg = toolpath.svg();
    assert!(svg.contains(">1 UPPER T1 OD ROUGH</text>") && svg.contains(">2 LOWER T2</text>"), "{svg}");
    assert!(svg.contains("<title>UPPER T1, jobs/p1.nc line 4: G1 Z-10.</title>"), "{svg}");
    let colors: Vec<&str> = svg.split("<g stroke=\"").skip(1).filter_map(|g| g.split('"').next()).collect();
    assert!(colors.len() == 2 && colors[0] != colors[1], "{colors:?}");
}

#[test]
fn the_lower_turret_is_below_the_axis_and_scales_show_diameters() {
    let svg = turrets().svg();
    let axis: f64 = svg.split("stroke-dasharray=\"14 3 3 3\" d=\"").nth(1).unwrap().split('M').nth(2).unwrap()[..]
        .split([' ', 'H'])
        .nth(1)
        .unwrap()
        .parse()
        .unwrap();
    let top = |d: &str| d.split(['M', ' ', 'l', '-']).nth(2).unwrap().parse::<f64>().unwrap();
    let paths = drawn(&svg);
    assert!(top(paths[0]) < axis && top(paths[2]) > axis, "{axis} {paths:?}");
    assert!(svg.contains(">X (diameter) / mm, lower turret below the axis</text>"), "{svg}");
    let labels = svg.matches("text-anchor=\"end\" fill=\"#66727f\">40</text>").count();
    let negative = svg.contains("text-anchor=\"end\" fill=\"#66727f\">-");
    assert!(labels >= 1 && !negative, "diameters count in both directions: {svg}");
}

#[test]
fn a_long_path_has_a_bounded_number_of_pieces() {
    // Rapid and feed in turn, a tool change every ten blocks.
    let mut builder = ResultsBuilder::new(&mill("x"));
    for n in 0..100_000_u32 {
        if n % 10 == 0 {
            builder.event(&at(
                1,
                n,
                0,
                0,
                Kind::Tool(ToolChange { action: ToolAction::Load, tool: n / 10 + 1, offset: 0 }),
            ));
        }
        let kind = if n % 2 == 0 { MotionKind::Rapid } else { MotionKind::Linear };
        let place = |n: u32| [f64::from(n % 317), f64::from(n / 317), f64::from(n % 7)];
        builder.event(&at(1, n + 1, 0, 1, Kind::Motion(motion(kind, &place(n), &place(n + 1)))));
    }
    let svg = builder.finish(&outcome(1)).toolpath.svg();
    assert!(svg.matches("<title>").count() < 20_000, "{}", svg.matches("<title>").count());
    assert!(svg.len() < 6_000_000, "{}", svg.len());
    assert!(svg.contains(" more tools</text>"));
}

/// The pieces of a view, by the number of the view.
pub(super) fn view_of(svg: &str, index: usize) -> &str {
    svg.split(&format!("url(#view{index})")).nth(1).unwrap_or_default()
}

#[test]
fn holes_have_marks_and_pockets_have_none() {
    let hole = |x: f64| {
        [
            motion(MotionKind::Rapid, &[x, 0.0, 5.0], &[x, 0.0, 2.0]),
            motion(MotionKind::Linear, &[x, 0.0, 2.0], &[x, 0.0, -5.0]),
            motion(MotionKind::Rapid, &[x, 0.0, -5.0], &[x, 0.0, 2.0]),
            motion(MotionKind::Linear, &[x, 0.0, 2.0], &[x, 0.0, -9.5]),
            motion(MotionKind::Rapid, &[x, 0.0, -9.5], &[x, 0.0, 5.0]),
            motion(MotionKind::Rapid, &[x, 0.0, 5.0], &[x + 10.0, 0.0, 5.0]),
        ]
    };
    let pocket = [
        motion(MotionKind::Linear, &[20.0, 0.0, 5.0], &[20.0, 0.0, -5.0]),
        motion(MotionKind::Linear, &[20.0, 0.0, -5.0], &[20.0, 20.0, -5.0]),
        motion(MotionKind::Rapid, &[20.0, 20.0, -5.0], &[20.0, 20.0, 5.0]),
    ];
    let motions: Vec<Motion> = hole(0.0).into_iter().chain(hole(10.0)).chain(pocket).collect();
    let svg = toolpath(&mill("x"), &motions).svg();
    assert_eq!(svg.matches("hole to Z-9.500").count(), 2, "one mark for a hole, however often it is pecked");
    assert_eq!(svg.matches("hole to Z").count(), 2, "a pocket is no hole");
    assert!(view_of(&svg, 0).contains("line 4: hole to Z-9.500"), "{svg}");
    assert!(svg.contains(">hole</text>"), "the legend names the mark");
}

#[test]
fn rapids_have_a_colour_that_no_tool_has() {
    let motions = [
        motion(MotionKind::Rapid, &[0.0, 0.0, 5.0], &[10.0, 0.0, 5.0]),
        motion(MotionKind::Linear, &[10.0, 0.0, 5.0], &[10.0, 10.0, 5.0]),
    ];
    let svg = toolpath(&mill("x"), &motions).svg();
    let view = view_of(&svg, 0);
    assert_eq!(view.matches(r##"<g stroke="#9aa5b1""##).count(), 3, "one in each view: {view}");
}

#[test]
fn a_rapid_there_and_back_is_drawn_once_and_a_change_of_frame_is_marked() {
    let cut = motion(MotionKind::Linear, &[0.0, 0.0, 5.0], &[40.0, 20.0, 5.0]);
    let there = motion(MotionKind::Rapid, &[40.0, 20.0, 5.0], &[10.0, 0.0, 5.0]);
    let back = motion(MotionKind::Rapid, &[10.0, 0.0, 5.0], &[40.0, 20.0, 5.0]);
    let part = motion(MotionKind::Rapid, &[40.0, 20.0, 5.0], &[25.0, 10.0, 5.0]);
    let rapids = |motions: &[Motion]| {
        let svg = toolpath(&mill("x"), motions).svg();
        let view = view_of(&svg, 0).to_owned();
        let group = view
            .split(r#"stroke-dasharray="2 2">"#)
            .nth(1)
            .unwrap_or_default()
            .split("</g>")
            .next()
            .unwrap()
            .to_owned();
        (group.matches("<path").count(), svg.contains(">change of frame</text>"))
    };
    // Dashed lines over dashed lines would look like a solid line.
    assert_eq!(rapids(&[cut, there]), (1, false));
    assert_eq!(rapids(&[cut, there, back, part]), (1, false));
    // If the next move starts elsewhere, without a move to that place, its coordinates have another frame.
    let elsewhere = motion(MotionKind::Rapid, &[-40.0, 5.0, 5.0], &[-40.0, 5.0, 50.0]);
    assert!(rapids(&[cut, there, elsewhere]).1);
}

#[test]
fn tools_beyond_a_dozen_and_of_other_turrets_have_colours_of_their_own() {
    let mut builder = ResultsBuilder::new(&lathe(&["x", "y"]));
    for channel in [1, 2] {
        for tool in 1..=15_u32 {
            let load = ToolChange { action: ToolAction::Load, tool, offset: tool };
            builder.event(&at(channel, tool, 0, 0, Kind::Tool(load)));
            let to = [20.0, -f64::from(tool)];
            builder.event(&at(channel, tool, 0, 1, Kind::Motion(motion(MotionKind::Linear, &[20.0, 0.0], &to))));
        }
    }
    let svg = builder.finish(&outcome(1)).toolpath.svg();
    let colors: std::collections::BTreeSet<&str> = view_of(&svg, 0)
        .split("<g stroke=\"")
        .skip(1)
        .filter_map(|g| g.split('"').next())
        .filter(|color| !["#ffffff", "#9aa5b1"].contains(color))
        .collect();
    assert_eq!(colors.len(), 30, "{colors:?}");
}

#[test]
fn mills_are_seen_in_space_too() {
    let svg = toolpath(&mill("x"), &[motion(MotionKind::Linear, &[0.0, 0.0, 0.0], &[10.0, 10.0, 0.0])]).svg();
    // X to the right and Y to the left rise alike: the diagonal goes straight up.
    let view = view_of(&svg, 2);
    let d = view.split("<path d=\"M").nth(1).and_then(|d| d.split('"').next()).expect("a move in space");
    let (_, step) = d.split_once('l').expect("a line");
    assert!(step.starts_with("0-"), "{d}");
}

#[test]
fn a_stop_is_marked_and_named() {
    let events = [
        at(1, 7, 0, 1, Kind::Motion(motion(MotionKind::Linear, &[20.0, 0.0], &[20.0, -10.0]))),
        diagnostic(1, 8, 1, 2_900_320, 12, "no G411"),
        life(1, 1, Phase::Alarmed),
    ];
    let toolpath = results(&lathe(&["x"]), &events, &outcome(3)).toolpath;
    let json = serde_json::to_value(&toolpath).unwrap();
    let stop = serde_json::json!({"state": "ALARMED", "file": "jobs/p1.nc", "line": 8});
    assert_eq!(json["channels"][0]["stop"], stop);
    let svg = toolpath.svg();
    assert!(svg.contains(">FAILED: alarm at jobs/p1.nc line 8</text>"), "{svg}");
    assert!(view_of(&svg, 0).contains("<title>UPPER: alarm at jobs/p1.nc line 8</title>"), "{svg}");
}

#[test]
fn programs_in_inches_are_shown_in_inches() {
    let path = |unit: &'static str| {
        let events = [
            at(1, 1, 0, 0, Kind::mode(unit)),
            at(1, 2, 0, 1, Kind::Motion(motion(MotionKind::Linear, &[0.0, 0.0, 0.0], &[254.0, 0.0, 0.0]))),
        ];
        results(&mill("x"), &events, &outcome(1)).toolpath
    };
    let inches = path("units inch");
    assert_eq!(serde_json::to_value(&inches).unwrap()["unit"], "mm", "data stay in the unit of the machine");
    let svg = inches.svg();
    assert!(svg.contains(">X / inch</text>") && svg.contains(">10</text>") && !svg.contains(">200</text>"), "{svg}");
    let svg = path("units mm").svg();
    assert!(svg.contains(">X / mm</text>") && svg.contains(">200</text>"), "{svg}");
}

/// A machine with CODE_UNITS_SECONDARY in `initial` begins in inches, and its programs select no unit.
#[test]
fn programs_of_a_machine_that_begins_in_inches_are_shown_in_inches() {
    let mut info = mill("x");
    let cut = [at(1, 2, 0, 1, Kind::Motion(motion(MotionKind::Linear, &[0.0, 0.0, 0.0], &[254.0, 0.0, 0.0])))];
    Arc::get_mut(&mut info).unwrap().channels[0].inch = true;
    let svg = results(&info, &cut, &outcome(1)).toolpath.svg();
    assert!(svg.contains("toolpath, inch") && svg.contains(">X / inch</text>") && svg.contains(">10</text>"), "{svg}");
    let select = [at(1, 1, 0, 0, Kind::mode("units mm")), cut[0].clone()];
    let svg = results(&info, &select, &outcome(1)).toolpath.svg();
    assert!(svg.contains("toolpath, mm") && svg.contains(">X / mm</text>"), "{svg}");
}

/// Live tools work where the part has been turned to: holes on a circle, a straight side by polar interpolation, an arc
/// by C.
#[test]
fn the_face_of_the_part_shows_the_work_of_live_tools() {
    let info = lathe(&["x"]);
    let load = |line, tool| at(1, line, 0, 0, Kind::Tool(ToolChange { action: ToolAction::Load, tool, offset: tool }));
    let cut = |line, motion: Motion| at(1, line, 0, 1, Kind::Motion(motion));
    let drill = |line, c: f64| {
        [
            cut(line, motion(MotionKind::Rapid, &[40.0, 5.0, c - 90.0], &[40.0, 5.0, c])),
            cut(line, motion(MotionKind::Linear, &[40.0, 5.0, c], &[40.0, -8.0, c])),
            cut(line, motion(MotionKind::Rapid, &[40.0, -8.0, c], &[40.0, 5.0, c])),
        ]
    };
    // From X20 Y-20 to X20 Y20 of the face: radius 28.2843, C from -45 to 45, a path of 40.
    let r = 2.0 * 800_f64.sqrt();
    let side = Motion { length: 40.0, ..motion(MotionKind::Linear, &[r, 5.0, -45.0], &[r, 5.0, 45.0]) };
    let round = Motion { length: 90.0, ..motion(MotionKind::Linear, &[r, 5.0, 45.0], &[r, 5.0, 135.0]) };
    let mut events =
        vec![load(1, 1), cut(2, motion(MotionKind::Linear, &[30.0, 2.0, 0.0], &[30.0, -20.0, 0.0])), load(3, 2)];
    events.extend(drill(4, 90.0).into_iter().chain(drill(5, 180.0)));
    events.extend([load(6, 3), cut(7, side), cut(8, round), life(1, 9, Phase::ProgramEnd)]);
    let toolpath = results(&info, &events, &outcome(9)).toolpath;
    let json = serde_json::to_value(&toolpath).unwrap();
    let face = json["channels"][0]["face"].as_array().expect("a face");
    let tools: Vec<u64> = face.iter().map(|segment| segment["tool"].as_u64().unwrap()).collect();
    assert!(!tools.contains(&1) && tools.contains(&2) && tools.contains(&3), "turning leaves no trace: {tools:?}");
    let points = |segment: &serde_json::Value| -> Vec<[f64; 3]> {
        let all: Vec<f64> = segment["points"].as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect();
        all.chunks(3).map(|p| [p[0], p[1], p[2]]).collect()
    };
    let milled: Vec<[f64; 3]> = face.iter().filter(|segment| segment["tool"] == 3).flat_map(points).collect();
    assert_eq!(milled[..2], [[20.0, -20.0, 5.0], [20.0, 20.0, 5.0]], "polar interpolation is straight");
    assert!(milled.len() > 20 && milled[2..].iter().all(|p| (p[0].hypot(p[1]) - r / 2.0).abs() < 1e-3), "{milled:?}");
    let svg = toolpath.svg();
    let holes = svg.matches("hole to Z-8.000").count();
    assert_eq!(holes, 2, "{svg}");
    assert!(svg.contains(">face: X (radius) / mm</text>"), "{svg}");
}

/// From X20 Y10 to X10 Y20 of the face about X10 Y10, a quarter of the radius 10; and a full circle about X15 Y0.
#[test]
fn arcs_of_polar_interpolation_have_their_own_centres() {
    let polar = |from: [f64; 2], to: [f64; 2], center, length| {
        let at = |[x, y]: [f64; 2]| [2.0 * x.hypot(y), -1.0, y.atan2(x).to_degrees()];
        Motion { center, plane_axes: [0, 2], length, ..motion(MotionKind::Linear, &at(from), &at(to)) }
    };
    let quarter = polar([20.0, 10.0], [10.0, 20.0], [10.0, 10.0], 5.0 * std::f64::consts::PI);
    let around = polar([20.0, 0.0], [20.0, 0.0], [15.0, 0.0], 10.0 * std::f64::consts::PI);
    let tool = Kind::Tool(ToolChange { action: ToolAction::Load, tool: 3, offset: 3 });
    for (motion, center, radius) in [(quarter, [10.0, 10.0], 10.0), (around, [15.0, 0.0], 5.0)] {
        let events =
            [at(1, 1, 0, 0, tool.clone()), at(1, 2, 0, 1, Kind::Motion(motion)), life(1, 3, Phase::ProgramEnd)];
        let json = serde_json::to_value(&results(&lathe(&["x"]), &events, &outcome(3)).toolpath).unwrap();
        let points = json["channels"][0]["face"][0]["points"].as_array().unwrap();
        let points: Vec<f64> = points.iter().map(|value| value.as_f64().unwrap()).collect();
        let away = |p: &[f64]| ((p[0] - center[0]).hypot(p[1] - center[1]) - radius).abs();
        assert!(points.len() > 60 && points.chunks(3).all(|p| away(p) < 1e-3), "{points:?}");
        let low = points.chunks(3).map(|p| p[1]).fold(f64::INFINITY, f64::min);
        assert!(radius == 5.0 || low > 10.0 - 1e-9, "the short way: {points:?}");
    }
}

/// A full circle ends where it began; Y moves on the way. A turned arc of X and Z is not work of a live tool.
#[test]
fn a_full_circle_of_a_y_axis_is_seen_on_the_face() {
    let circle = arc(MotionKind::ArcCw, &[30.0, -5.0, 0.0], &[30.0, -5.0, 0.0], [0, 2], [0.0, 0.0]);
    let json = serde_json::to_value(toolpath(&lathe_with_y("x"), &[circle])).unwrap();
    let points = json["channels"][0]["face"][0]["points"].as_array().unwrap();
    let points: Vec<f64> = points.iter().map(|value| value.as_f64().unwrap()).collect();
    assert!(points.len() > 60 && points.chunks(3).all(|p| (p[0].hypot(p[1]) - 15.0).abs() < 1e-3), "{points:?}");
    let turned = arc(MotionKind::ArcCw, &[30.0, -5.0, 0.0], &[40.0, -10.0, 0.0], [1, 0], [-10.0, 30.0]);
    let json = serde_json::to_value(toolpath(&lathe_with_y("x"), &[turned])).unwrap();
    assert!(json["channels"][0].get("face").is_none_or(serde_json::Value::is_null), "{json}");
}
