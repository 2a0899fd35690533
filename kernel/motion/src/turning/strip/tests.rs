//! Stock removal worked by hand. Contours and moves are written as programs write them: X as a diameter.

use super::super::tests::{Written, contour};
use super::{Removal, Strip, StripError};
use crate::contour::element::Element;
use crate::turning::{CycleMove, MoveSink};

const PLAIN: Strip = Strip {
    plunges: 0.0,
    rough: true,
    finish: false,
    face: false,
    inside: false,
    depth: 2.5,
    allowance: [0.0; 2],
    around: 0.0,
    lift: 1.0,
    rounds: true,
    pause: [0.0; 2],
    feeds: [0.0; 3],
    clearance: 0.0,
};

fn moves(points: &[(f64, f64, f64)], strip: Strip) -> Vec<String> {
    let shape = contour((100.0, 100.0), points);
    let mut written = Written::from([f64::NAN; 2]);
    Removal::new(&shape.elements, strip).unwrap().run(&mut written).unwrap();
    written.text
}

const STEPS: [(f64, f64, f64); 5] =
    [(20.0, 0.0, 0.0), (20.0, -20.0, 0.0), (30.0, -30.0, 0.0), (30.0, -50.0, 0.0), (40.0, -50.0, 0.0)];

const GROOVE: [(f64, f64, f64); 5] =
    [(20.0, 0.0, 0.0), (20.0, -10.0, 0.0), (14.0, -13.0, 0.0), (14.0, -20.0, 0.0), (30.0, -20.0, 0.0)];

#[test]
fn levels_go_up_along_the_contour() {
    let expected = [
        "R X42 Z1",
        "R X35",
        "F Z-50",
        "F X40",
        "R X42 Z-49",
        "R Z1",
        "R X30",
        "F Z-50",
        "F X35",
        "R X37 Z-49",
        "R Z1",
        "R X25",
        "F Z-25",
        "F X30 Z-30",
        "R X32 Z-29",
        "R Z1",
        "R X20",
        "F Z-20",
        "F X25 Z-25",
        "R X27 Z-24",
        "R Z1",
        "R X42",
    ];
    assert_eq!(moves(&STEPS, PLAIN), expected);
}

#[test]
fn without_rounding_corners_remain() {
    let strip = Strip { depth: 5.0, rounds: false, ..PLAIN };
    let expected =
        ["R X42 Z1", "R X30", "F Z-50", "R X32 Z-49", "R Z1", "R X20", "F Z-20", "R X22 Z-19", "R Z1", "R X42"];
    assert_eq!(moves(&STEPS, strip), expected);
}

#[test]
fn allowances_and_finishing() {
    // 0.5 along Z and 0.2 along X remain: the plateau of the slope's end is at X30.4, its walls half a millimetre
    // earlier.
    let strip = Strip { depth: 10.0, allowance: [0.5, 0.2], finish: true, ..PLAIN };
    let expected = [
        "R X42.4 Z1",
        "R X20.4",
        "F Z-19.5",
        "F X30.4 Z-29.5",
        "F Z-49.5",
        "F X40.4",
        "R X42.4 Z-48.5",
        "R Z1",
        "R X20 Z0",
        "F Z-20",
        "F X30 Z-30",
        "F Z-50",
        "F X40",
        "R X42.4",
        "R Z1",
    ];
    assert_eq!(moves(&STEPS, strip), expected);
}

#[test]
fn a_relief_cut_has_levels_of_its_own() {
    let expected = [
        "R X32 Z1",
        "R X26.6667",
        "F Z-20",
        "F X30",
        "R X32 Z-19",
        "R Z1",
        "R X23.3333",
        "F Z-20",
        "F X26.6667",
        "R X28.6667 Z-19",
        "R Z1",
        "R X20",
        "F Z-20",
        "F X23.3333",
        "R X25.3333 Z-19",
        "R Z1",
        "R X32",
        "R Z-10",
        "R X22",
        "F X20",
        "F X17 Z-11.5",
        "F Z-20",
        "F X20",
        "R X22 Z-19",
        "R Z-11.5",
        "R X19",
        "F X17",
        "F X14 Z-13",
        "F Z-20",
        "F X17",
        "R X19 Z-19",
        "R X32",
        "R Z1",
    ];
    assert_eq!(moves(&GROOVE, Strip { depth: 2.0, ..PLAIN }), expected);
}

#[test]
fn inside_and_along_x() {
    // A bore from X40 down to X20, cut from the middle outwards in two levels.
    let bore = [(40.0, 0.0, 0.0), (40.0, -10.0, 0.0), (20.0, -10.0, 0.0)];
    let strip = Strip { depth: 5.0, inside: true, ..PLAIN };
    let expected = [
        "R X18 Z1",
        "R X30",
        "F Z-10",
        "F X20",
        "R X18 Z-9",
        "R Z1",
        "R X40",
        "F Z-10",
        "F X30",
        "R X28 Z-9",
        "R Z1",
        "R X18",
    ];
    assert_eq!(moves(&bore, strip), expected);
    // A face from X40 Z-6 to X10 Z0.
    let face = [(40.0, -6.0, 0.0), (10.0, -6.0, 0.0), (10.0, 0.0, 0.0)];
    let strip = Strip { depth: 3.0, face: true, ..PLAIN };
    let expected = [
        "R X42 Z1",
        "R Z-3",
        "F X10",
        "F Z0",
        "R X12 Z1",
        "R X42",
        "R Z-6",
        "F X10",
        "F Z-3",
        "R X12 Z-2",
        "R X42",
        "R Z1",
    ];
    assert_eq!(moves(&face, strip), expected);
}

#[test]
fn an_allowance_square_to_the_contour() {
    // 1 from the slope of 45 degrees: its line begins 1.4142 earlier at its foot, 0.4142 after the plateau's new
    // height.
    let slope = [(20.0, 0.0, 0.0), (20.0, -20.0, 0.0), (40.0, -30.0, 0.0)];
    let strip = Strip { depth: 0.0, around: 1.0, ..PLAIN };
    let expected = ["R X43.4142 Z1", "R X22", "F Z-19.5858", "F X41.4142 Z-29.2929", "R X43.4142 Z-28.2929", "R Z1"];
    assert_eq!(moves(&slope, strip)[..6], expected);
}

#[test]
fn refusals() {
    let refused = |points: &[(f64, f64, f64)], strip| {
        Removal::new(&contour((100.0, 100.0), points).elements, strip).map(|_| ()).unwrap_err()
    };
    let back = [(20.0, 0.0, 0.0), (20.0, -20.0, 0.0), (30.0, -10.0, 0.0), (40.0, -30.0, 0.0)];
    assert_eq!(refused(&back, PLAIN), StripError::TurnsBack);
    assert_eq!(refused(&[(20.0, 0.0, 0.0)], PLAIN), StripError::Nothing);
    assert_eq!(refused(&GROOVE, Strip { clearance: 44.0, ..PLAIN }), StripError::Clearance);
    assert_eq!(refused(&GROOVE, Strip { allowance: [6.0, 0.0], ..PLAIN }), StripError::Narrow);
    assert!(Removal::new(&contour((100.0, 100.0), &GROOVE).elements, Strip { clearance: 45.0, ..PLAIN }).is_ok());
}

/// Keeps the straight moves as seen from the chuck: along −Z, X as a radius.
#[derive(Default)]
struct Kept(Vec<[f64; 2]>);

impl MoveSink for Kept {
    type Stop = ();

    fn pass(&mut self) -> Result<(), ()> {
        Ok(())
    }

    fn go(&mut self, to: CycleMove) -> Result<(), ()> {
        let (CycleMove::Rapid([z, x]) | CycleMove::Feed([z, x]) | CycleMove::Arc { to: [z, x], .. }) = to;
        self.0.push([-z, x]);
        Ok(())
    }
}

#[test]
fn no_move_goes_into_any_contour() {
    let mut seed = 7_u64;
    let mut random = |most: f64| {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 33) as f64 / f64::from(1_u32 << 31) * most
    };
    for _ in 0..3000 {
        let count = 3 + random(6.0) as usize;
        let (mut along, mut heights) = (0.0, Vec::new());
        for _ in 0..count {
            // Heights repeat, so that there are plateaus.
            heights.push([along, 5.0 + (random(5.0)).floor() * 2.0]);
            along += 0.5 + random(5.0);
        }
        let contour: Vec<Element> = heights
            .windows(2)
            .map(|two| {
                let [from, to] = [two[0], two[1]].map(|[along, height]| [-along, height]);
                Element { from, to, arc: None }
            })
            .collect();
        let strip = Strip {
            finish: random(2.0) > 1.0,
            depth: 0.4 + random(3.0),
            lift: 0.1 + random(2.0),
            rounds: random(2.0) > 1.0,
            ..PLAIN
        };
        let Ok(removal) = Removal::new(&contour, strip) else { panic!("{heights:?}") };
        let mut kept = Kept::default();
        removal.run(&mut kept).unwrap();
        let height = |at: f64| {
            let piece = heights.windows(2).find(|two| at >= two[0][0] && at <= two[1][0]);
            piece.map(|two| two[0][1] + (two[1][1] - two[0][1]) * (at - two[0][0]) / (two[1][0] - two[0][0]))
        };
        for two in kept.0.windows(2) {
            for step in 0..=40 {
                let share = f64::from(step) / 40.0;
                let [at, radius] = [0, 1].map(|axis| two[0][axis] + (two[1][axis] - two[0][axis]) * share);
                let below = height(at).is_some_and(|height| radius < height - 1e-6);
                assert!(!below, "{strip:?}\n{heights:?}\n{two:?}\n{:?}", kept.0);
            }
        }
        // No more than a level's depth is left anywhere after the levels alone.
        let deepest = |at: f64| {
            let passes =
                kept.0.windows(2).filter(|two| at >= two[0][0].min(two[1][0]) && at <= two[0][0].max(two[1][0]));
            let at_place = passes.map(|two| {
                let way = two[1][0] - two[0][0];
                if way.abs() < 1e-9 {
                    two[0][1].min(two[1][1])
                } else {
                    two[0][1] + (two[1][1] - two[0][1]) * (at - two[0][0]) / way
                }
            });
            at_place.fold(f64::INFINITY, f64::min)
        };
        for step in 1..50 {
            let at = heights[count - 1][0] * f64::from(step) / 50.0;
            let Some(height) = height(at) else { continue };
            let high = heights.iter().fold(0.0_f64, |high, spot| high.max(spot[1]));
            let left = deepest(at).min(high) - height;
            assert!(left <= strip.depth + 1e-6, "{left} left at {at}: {strip:?}\n{heights:?}\n{:?}", kept.0);
        }
    }
}

#[test]
fn a_tool_with_a_flat_end_stays_out_of_every_groove() {
    let mut seed = 11_u64;
    let mut random = |most: f64| {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 33) as f64 / f64::from(1_u32 << 31) * most
    };
    let mut finished = 0;
    for _ in 0..600 {
        let (down, up) = (0.2 + random(6.0), 0.2 + random(6.0));
        let (base, depth) = (0.5 + random(12.0), 1.0 + random(5.0));
        let corners = [(0.0, 20.0), (down, 20.0 - depth), (down + base, 20.0 - depth), (down + base + up, 20.0)];
        let shape: Vec<(f64, f64, f64)> = corners.iter().map(|(along, radius)| (2.0 * radius, -along, 0.0)).collect();
        let width = 0.5 + random(4.0);
        let other = if random(2.0) > 1.0 { width } else { -width };
        let finish = random(2.0) > 1.0;
        let strip = Strip { finish, rough: !finish, depth: 0.5 + random(3.0), plunges: other, ..PLAIN };
        let elements = contour((100.0, 100.0), &shape).elements;
        let removal = match Removal::new(&elements, strip) {
            Ok(removal) => removal,
            Err(why) => {
                assert_eq!(why, StripError::Narrow);
                assert!(width > if finish { base } else { down + base + up } - 1e-6);
                continue;
            }
        };
        let mut kept = Kept::default();
        removal.run(&mut kept).unwrap();
        finished += usize::from(finish);
        let height = |at: f64| {
            let two = corners.windows(2).find(|two| at >= two[0].0 && at <= two[1].0)?;
            Some(two[0].1 + (two[1].1 - two[0].1) * (at - two[0].0) / (two[1].0 - two[0].0))
        };
        let begins = if other > 0.0 { -width } else { 0.0 };
        for two in kept.0.windows(2) {
            for step in 0..=20 {
                let share = f64::from(step) / 20.0;
                let [at, radius] = [0, 1].map(|axis| two[0][axis] + (two[1][axis] - two[0][axis]) * share);
                for part in 0..=20 {
                    let below = height(at + begins + width * f64::from(part) / 20.0);
                    assert!(below.is_none_or(|height| radius > height - 1e-6), "{strip:?} {corners:?} {two:?}");
                }
            }
        }
        // The whole base is reached.
        let reached = kept.0.iter().any(|spot| (spot[1] - (20.0 - depth)).abs() < 1e-6);
        assert!(reached || width > base, "{strip:?} {corners:?}");
    }
    assert!(finished > 80, "{finished}");
}
