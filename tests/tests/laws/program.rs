//! Random programs without a notation: steps on a grid whose values are exact in millimetres and in inches.
//!
//! *Invariant:* the end of a step follows from its start alone, so each notation can write it absolute or incremental.

use fastrand::Rng;

/// A point on the grid.
pub type Place = [i32; 3];

/// Hundredths of an inch: 0.254 mm.
pub const GRID_MM: f64 = 0.254;
/// The grid in inches.
pub const GRID_INCH: f64 = 0.01;

/// Z of all programs before and after a hole.
pub const CLEAR: i32 = 200;

/// A step of a program.
#[derive(Debug, Clone)]
pub enum Step {
    Rapid(Place),
    /// A straight move at feed, in tens of inches a minute.
    Feed(Place, i32),
    /// Quarters of a circle about a centre that lies this far from the start, along X or along Y.
    Circle {
        radius: i32,
        along_x: bool,
        quarters: u8,
        clockwise: bool,
    },
    /// At most half a circle by its radius.
    ByRadius {
        radius: i32,
        along_x: bool,
        half: bool,
        clockwise: bool,
    },
    /// A hole from the clearance plane.
    Hole {
        at: [i32; 2],
        bottom: i32,
    },
    /// A contour with the radius of the tool on one side; it begins and ends straight.
    Contour {
        left: bool,
        points: Vec<[i32; 2]>,
    },
    /// A subprogram that moves by increments.
    Call(u8),
    /// A jump over a move.
    Jump(Place),
    /// Seconds.
    Dwell(u8),
    Coolant(bool),
    Speed(u16),
}

/// The move of the subprogram in X and Y on each pass.
pub const BY_CALL: [i32; 2] = [7, -4];

/// A program of up to twelve steps.
pub fn random(rng: &mut Rng) -> Vec<Step> {
    (0..rng.usize(1..=12)).map(|_| step(rng)).collect()
}

fn step(rng: &mut Rng) -> Step {
    let place = |rng: &mut Rng| [rng.i32(-300..=300), rng.i32(-300..=300), rng.i32(-100..=300)];
    match rng.u8(0..14) {
        0 | 1 => Step::Rapid(place(rng)),
        2..=4 => Step::Feed(place(rng), rng.i32(1..=9)),
        5 | 6 => Step::Circle {
            radius: if rng.bool() { rng.i32(5..=80) } else { -rng.i32(5..=80) },
            along_x: rng.bool(),
            quarters: rng.u8(1..=4),
            clockwise: rng.bool(),
        },
        7 => Step::ByRadius {
            radius: if rng.bool() { rng.i32(5..=80) } else { -rng.i32(5..=80) },
            along_x: rng.bool(),
            half: rng.bool(),
            clockwise: rng.bool(),
        },
        8 => Step::Hole { at: [rng.i32(-300..=300), rng.i32(-300..=300)], bottom: -rng.i32(1..=40) },
        9 => Step::Contour { left: rng.bool(), points: contour(rng) },
        10 => Step::Call(rng.u8(1..=3)),
        11 => Step::Jump(place(rng)),
        12 => Step::Dwell(rng.u8(1..=5)),
        _ if rng.bool() => Step::Coolant(rng.bool()),
        _ => Step::Speed(rng.u16(5..=50) * 100),
    }
}

/// Corners of a contour of long lines in X and Y; successive corners differ.
fn contour(rng: &mut Rng) -> Vec<[i32; 2]> {
    let mut points: Vec<[i32; 2]> = Vec::new();
    while points.len() < 5 {
        let point = [rng.i32(-6..=6) * 50, rng.i32(-6..=6) * 50];
        if points.last() != Some(&point) {
            points.push(point);
        }
    }
    points
}

/// The centre of a circle and its end.
pub fn circle(from: Place, radius: i32, along_x: bool, quarters: u8, clockwise: bool) -> ([i32; 2], Place) {
    let center = if along_x { [from[0] + radius, from[1]] } else { [from[0], from[1] + radius] };
    let mut spoke = [from[0] - center[0], from[1] - center[1]];
    for _ in 0..quarters {
        spoke = if clockwise { [spoke[1], -spoke[0]] } else { [-spoke[1], spoke[0]] };
    }
    (center, [center[0] + spoke[0], center[1] + spoke[1], from[2]])
}
