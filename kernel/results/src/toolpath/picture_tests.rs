//! Tests of the picture: circles out of their plane, and labels.

use super::tests::{arc, toolpath, view_of};
use crate::testing::*;
use counterpoint_event::event::MotionKind;

/// The points of a line from the first `M` of a view, px.
fn points(view: &str) -> Vec<[f64; 2]> {
    let d = view.split("<path d=\"M").nth(1).and_then(|d| d.split('"').next()).expect("a move");
    let (start, steps) = d.split_once('l').expect("a line");
    let numbers = |text: &str| -> Vec<f64> {
        let text = text.replace('-', " -");
        text.split_whitespace().map(|number| number.parse().unwrap()).collect()
    };
    let (mut at, mut points) = ([0.0; 2], Vec::new());
    for step in [numbers(start), numbers(steps)].concat().chunks(2) {
        at = [at[0] + step[0], at[1] + step[1]];
        points.push(at);
    }
    points
}

/// Seen in space a circle is an ellipse without visible corners.
#[test]
fn a_circle_in_space_has_no_corners() {
    let circle = arc(MotionKind::ArcCcw, &[100.0, 0.0, 0.0], &[100.0, 0.0, 0.0], [0, 1], [0.0, 0.0]);
    let svg = toolpath(&mill("x"), &[circle]).svg();
    let points = points(view_of(&svg, 2));
    let directions: Vec<f64> = points.windows(2).map(|p| (p[1][1] - p[0][1]).atan2(p[1][0] - p[0][0])).collect();
    let turn = |pair: &[f64]| (pair[1] - pair[0]).sin().abs();
    let sharpest = directions.windows(2).map(turn).fold(0.0, f64::max);
    assert!(sharpest < 0.2, "a corner of {sharpest} rad, {} points", points.len());
    assert!(points.len() < 400, "{} points", points.len());
}
