use std::f64::consts::{PI, TAU};

use super::super::area::{OpenRing, size};
use super::super::combine::tests::{Dice, circle, square};
use super::super::element::plus;
use super::super::near::{at, to_piece};
use super::*;

fn area(rings: &[ClosedContour]) -> ClearingArea {
    let mut area = ClearingArea::default();
    for ring in rings {
        area.add(ring.elements()).unwrap();
    }
    area
}

#[test]
fn no_way_and_no_cut_comes_nearer_than_its_distance() {
    let mut dice = Dice(7);
    let (mut plain, mut narrow) = (0, 0);
    for round in 0..400 {
        let count = 3 + (dice.next() * 8.0) as usize;
        let corner = |number: usize, dice: &mut Dice| {
            let turn = TAU * number as f64 / count as f64;
            plus([0.0; 2], [libm::cos(turn), libm::sin(turn)], 10.0 + 30.0 * dice.next())
        };
        let mut corners: Vec<Spot> = (0..count).map(|number| corner(number, &mut dice)).collect();
        corners.extend(corners.first().copied());
        if dice.next() < 0.5 {
            corners.reverse();
        }
        let rim = corners.windows(2).map(|pair| Element { from: pair[0], to: pair[1], arc: None }).collect();
        let mut rings = vec![ClosedContour::open(rim)];
        if dice.next() < 0.7 {
            rings.push(circle([4.0 * dice.next(), 4.0 * dice.next()], 1.0 + 2.0 * dice.next()));
        }
        let is_blank = round % 3 == 0;
        let by = 0.5 + 4.0 * dice.next();
        let mut area = area(&rings);
        if is_blank {
            area.leave(by + 1.0);
        }
        let Some(clearing) = Clearing::of(&area, by) else { continue };
        let walls = if is_blank { &rings[1..] } else { &rings[..] };
        if super::plain(&area.rings, &rings, by).is_some() {
            plain += 1
        } else {
            narrow += 1
        }
        let free = |spot: Spot| {
            let pieces = walls.iter().flat_map(ClosedContour::elements);
            pieces.map(|piece| to_piece(piece, spot)).fold(f64::MAX, f64::min)
        };
        let rows = clearing.rows(1.5 * by, 1000);
        for row in rows.iter().chain(&clearing.ways(&rows)) {
            for pair in row.windows(2) {
                assert!(distance(pair[0].to, pair[1].from) < 1e-5, "{round} {pair:?}");
            }
            for piece in row {
                for share in (0..=20).map(|number| f64::from(number) / 20.0) {
                    assert!(free(at(piece, share)) > by - 1e-3, "{round} {piece:?} of {rings:?} by {by}");
                }
            }
        }
    }
    assert!(plain > 100 && narrow > 30, "{plain} {narrow}");
}

#[test]
fn a_square_with_a_round_island() {
    let clearing = Clearing::of(&area(&[square(0.0, 0.0, 40.0), circle([20.0, 20.0], 5.0)]), 3.0).unwrap();
    // From Y3 to Y37 in steps of 17: the line through the middle is cut by the island.
    let rows = clearing.rows(17.0, 100);
    assert_eq!(
        rows.iter().map(|row| (row[0].from, row[0].to)).collect::<Vec<_>>(),
        [([3.0, 20.0], [12.0, 20.0]), ([28.0, 20.0], [37.0, 20.0])]
    );
    // Both paths begin where the first cut touches them; islands turn clockwise, with the radius and the distance.
    let ways = clearing.ways(&rows);
    assert_eq!((ways[0][0].from, ways[1][0].from), ([3.0, 20.0], [12.0, 20.0]));
    assert!(ways[1].iter().all(|piece| piece.arc.is_some_and(|arc| arc.radius == 8.0 && arc.sweep < 0.0)));
    assert_eq!(clearing.plunges(&rows), [[3.0, 20.0], [28.0, 20.0]]);
    // With seven lines the third one is the first that meets the island: the cuts on its left continue, those on the
    // right are a row of their own.
    let rows = clearing.rows(34.0 / 8.0, 100);
    let right = [20.0 + (64.0_f64 - 4.25 * 4.25).sqrt(), 15.75];
    assert_eq!((rows.len(), rows[0][0].from), (2, [3.0, 7.25]));
    assert!(distance(rows[1][0].from, right) < 1e-9);
    let mut open = ClearingArea::default();
    assert_eq!(open.add(&square(0.0, 0.0, 1.0).elements()[..3]), Err(OpenRing));
}

#[test]
fn a_passage_that_is_too_narrow_is_left() {
    // Between island and rim there are 5 for a tool of 6.
    let rings = [square(0.0, 0.0, 40.0), circle([7.5, 20.0], 2.5)];
    let clearing = Clearing::of(&area(&rings), 3.0).unwrap();
    assert_eq!(clearing.ways(&[]).len(), 1);
    // The room is the square of 34 without the circle of 5.5 as far as it lies within: to X3 from the middle 7.5 it is
    // cut at 4.5.
    let angle = libm::acos(4.5 / 5.5);
    let cut = 5.5 * 5.5 * (angle - libm::sin(angle) * libm::cos(angle));
    let room: f64 = clearing.ways(&[]).iter().map(|way| size(way)).sum();
    assert!((room - (34.0 * 34.0 - 5.5 * 5.5 * PI + cut)).abs() < 1e-6, "{room}");
    assert!(Clearing::of(&area(&[square(0.0, 0.0, 5.0)]), 3.0).is_none());
}

#[test]
fn a_spigot_is_reached_from_outside_of_its_blank() {
    let mut area = area(&[square(0.0, 0.0, 40.0), square(15.0, 15.0, 10.0)]);
    area.leave(6.0);
    let clearing = Clearing::of(&area, 5.0).unwrap();
    let rows = clearing.rows(8.0, 100);
    // All rows begin outside.
    assert!(rows.iter().all(|row| row[0].from[0] < 0.0 || row[0].from[0] > 40.0), "{rows:?}");
    assert_eq!(clearing.ways(&rows).len(), 1);
    // After a tool of 8 there is nothing left beside a square; a smaller one clears between two spigots that are 12
    // apart.
    area.follow(8.0, 0.0);
    assert!(Clearing::of(&area, 5.0).unwrap().ways(&[]).is_empty());
    let mut pair = super::tests::area(&[square(0.0, 0.0, 40.0), square(2.0, 15.0, 12.0), square(26.0, 15.0, 12.0)]);
    pair.leave(6.0);
    pair.follow(8.0, 0.0);
    let left = Clearing::of(&pair, 5.0).unwrap();
    assert_eq!(left.ways(&[]).len(), 1);
    assert_eq!(pair.add(&square(0.0, 0.0, 1.0).elements()[..3]), Err(OpenRing));
}
