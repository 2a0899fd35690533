//! Tests of the toolpath.

use std::sync::Arc;

use super::*;
use crate::log::event::Kind;
use crate::log::fold::Folds;
use crate::log::testing::*;

fn of(info: &Arc<Info>, motions: impl Iterator<Item = Motion>) -> Toolpath {
    let mut folds = Folds::new(info);
    motions.for_each(|m| folds.event(&at(1, 1, 0, 1, Kind::Motion(m))));
    folds.finish(&outcome(1)).toolpath
}

fn toolpath(info: &Arc<Info>, motions: &[Motion]) -> Toolpath {
    of(info, motions.iter().copied())
}

fn arc(kind: MotionKind, from: &[f64], to: &[f64], plane_axes: [u8; 2], center: [f64; 2]) -> Motion {
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
            r#"{"unit":"mm","view":"zx","channels":[{"channel":1,"name":"UPPER","truncated":false,"segments":["#,
            r#"{"kind":"rapid","points":[50.0,50.0,2.0,10.0]},"#,
            r#"{"kind":"feed","points":[2.0,10.0,0.0,10.0,-10.0,10.0]},"#,
            r#"{"kind":"arc_cw","points":[-10.0,10.0,-15.0,15.0],"plane":"zx","center":[-10.0,15.0],"turns":0},"#,
            r#"{"kind":"thread","points":[-15.0,15.0,-20.0,15.0]},"#,
            r#"{"kind":"rapid","points":[0.0,20.0,0.0,25.0]}]}]}"#
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
    let group = svg.split("<g ").nth(1).and_then(|g| g.split("</g>").next()).expect("a view");
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
    let svg = toolpath(&mill("x"), &motions).svg();
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
fn nothing_to_draw_is_still_a_picture() {
    assert!(toolpath(&mill("x"), &[]).svg().ends_with("</svg>\n"));
    let svg = toolpath(&lathe(&["x"]), &[motion(MotionKind::Rapid, &[1.0], &[1.0])]).svg();
    assert!(!svg.contains("NaN") && !svg.contains("inf"));
}
