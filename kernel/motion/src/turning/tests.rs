//! Cycles worked by hand. Contours and moves are written as programs write them: X as a diameter.

use super::lap::{DepthChange, LapSettings};
use super::rough::{RoughCycle, RoughSettings};
use super::{ContourError, CycleMove, MoveSink, ProgrammedContour, pattern, peck};
use crate::arc::by_radius;
use crate::contour::element::{Element, Spot};

/// Writes moves as `R X63 Z2.5`, with changed values only.
pub(super) struct Written {
    at: Spot,
    pub(super) text: Vec<String>,
    passes: u32,
    most: u32,
}

impl Written {
    pub(super) fn from(at: Spot) -> Self {
        Self { at, text: Vec::new(), passes: 0, most: u32::MAX }
    }
}

fn number(value: f64) -> String {
    format!("{}", (value * 1e4).round() / 1e4 + 0.0)
}

impl MoveSink for Written {
    type Stop = ();

    fn pass(&mut self) -> Result<(), ()> {
        self.passes += 1;
        if self.passes > self.most { Err(()) } else { Ok(()) }
    }

    fn go(&mut self, to: CycleMove) -> Result<(), ()> {
        let (letter, to) = match to {
            CycleMove::Rapid(to) => ("R", to),
            CycleMove::Feed(to) => ("F", to),
            CycleMove::Arc { to, clockwise, .. } => (if clockwise { "G2" } else { "G3" }, to),
        };
        let mut text = letter.to_owned();
        if number(2.0 * to[1]) != number(2.0 * self.at[1]) {
            text += &format!(" X{}", number(2.0 * to[1]));
        }
        if number(to[0]) != number(self.at[0]) {
            text += &format!(" Z{}", number(to[0]));
        }
        if text != letter {
            self.text.push(text);
        }
        self.at = to;
        Ok(())
    }
}

/// A contour through points `(X, Z, radius)` from a start `(X, Z)`; a radius above 0 turns counter-clockwise.
pub(super) fn contour((x, z): (f64, f64), points: &[(f64, f64, f64)]) -> ProgrammedContour {
    let spot = |x: f64, z: f64| [z, x / 2.0];
    let mut elements = Vec::new();
    let mut points = points.iter();
    let first = points.next().unwrap();
    let mut from = spot(first.0, first.1);
    for &(x, z, radius) in points {
        let to = spot(x, z);
        let arc = (radius != 0.0).then(|| by_radius(from, to, radius.abs(), radius < 0.0, 1e-6).unwrap());
        elements.push(Element { from, to, arc });
        from = to;
    }
    ProgrammedContour { start: spot(x, z), elements, blank: Vec::new(), rapid: true }
}

fn settings(depth: f64, retract: f64, u: f64, w: f64) -> RoughSettings {
    RoughSettings { face: false, depth, retract, allowance: [w, u / 2.0], semi: [0.0; 2], pockets: false, lap: None }
}

fn rough(contour: &ProgrammedContour, settings: RoughSettings) -> String {
    let mut written = Written::from(contour.start);
    RoughCycle::new(contour, settings).unwrap().run(&mut written).unwrap();
    written.text.join("; ")
}

#[test]
fn levels_down_to_the_contour() {
    let part = contour(
        (62.0, 2.0),
        &[
            (20., 2., 0.),
            (20., -15., 0.),
            (30., -25., 0.),
            (30., -40., 0.),
            (50., -40., 0.),
            (50., -55., 0.),
            (62., -55., 0.),
        ],
    );
    assert_eq!(
        rough(&part, settings(5.0, 1.0, 1.0, 0.5)),
        "R X63 Z2.5; R X53; F Z-54.5; R X55 Z-53.5; R Z2.5; R X43; F Z-39.5; R X45 Z-38.5; R Z2.5; R X33; F Z-39.5; \
         R X35 Z-38.5; R Z2.5; R X23; F Z-16.5; R X25 Z-15.5; R Z2.5; R X21; F Z-14.5; R X23 Z-13.5; R Z2.5; R X21; \
         F Z-14.5; F X31 Z-24.5; F Z-39.5; F X51; F Z-54.5; F X63; R X62 Z2"
    );
}

#[test]
fn inside_the_stock_is_below() {
    let part = contour(
        (20.0, 2.0),
        &[
            (50., 2., 0.),
            (50., -10., 0.),
            (40., -20., 0.),
            (40., -30., 0.),
            (27., -30., 0.),
            (27., -45., 0.),
            (20., -45., 0.),
        ],
    );
    assert_eq!(
        rough(&part, settings(3.0, 0.5, -0.8, 0.2)),
        "R X19.2 Z2.2; R X25.2; F Z-44.8; R X24.2 Z-44.3; R Z2.2; R X31.2; F Z-29.8; R X30.2 Z-29.3; R Z2.2; R X37.2; \
         F Z-29.8; R X36.2 Z-29.3; R Z2.2; R X43.2; F Z-15.8; R X42.2 Z-15.3; R Z2.2; R X49.2; F Z-9.8; R X48.2 Z-9.3; \
         R Z2.2; R X49.2; F Z-9.8; F X39.2 Z-19.8; F Z-29.8; F X26.2; F Z-44.8; F X19.2; R X20 Z2"
    );
}

#[test]
fn levels_end_at_arcs() {
    let part = contour((52.0, 2.0), &[(0., 2., 0.), (0., 0., 0.), (40., -20., 20.), (40., -35., 0.), (52., -35., 0.)]);
    let text = rough(&part, settings(6.0, 0.5, 0.0, 0.2));
    // The arc of this program is written G3: it turns counter-clockwise seen with Z to the right and X up.
    assert_eq!(
        text,
        "R Z2.2; R X40; F Z-34.8; R X41 Z-34.3; R Z2.2; R X28; F Z-5.5171; R X29 Z-5.0171; R Z2.2; R X16; F Z-1.4697; \
         R X17 Z-0.9697; R Z2.2; R X4; F Z0.0997; R X5 Z0.5997; R Z2.2; R X0; F Z0.2; R X1 Z0.7; R Z2.2; R X0; F Z0.2; \
         G3 X40 Z-19.8; F Z-34.8; F X52; R Z2"
    );
}

#[test]
fn facing_is_turning_with_the_axes_exchanged() {
    let part = contour(
        (62.0, 3.0),
        &[
            (62., -20., 0.),
            (50., -20., 0.),
            (40., -12., 0.),
            (24., -12., 0.),
            (24., -4., 0.),
            (10., -4., 0.),
            (10., 3., 0.),
        ],
    );
    assert_eq!(
        rough(&part, RoughSettings { face: true, ..settings(4.0, 0.5, 0.4, 0.2) }),
        "R X62.4 Z3.2; R Z-0.8; F X10.4; R X11.4 Z-0.3; R X62.4; R Z-4.8; F X24.4; R X25.4 Z-4.3; R X62.4; R Z-8.8; \
         F X24.4; R X25.4 Z-8.3; R X62.4; R Z-12.8; F X41.65; R X42.65 Z-12.3; R X62.4; R Z-16.8; F X46.65; \
         R X47.65 Z-16.3; R X62.4; R Z-19.8; F X50.4; R X51.4 Z-19.3; R X62.4; R Z-19.8; F X50.4; F X40.4 Z-11.8; \
         F X24.4; F Z-3.8; F X10.4; F Z3.2; R X62 Z3"
    );
}

#[test]
fn pockets_follow_the_open_levels() {
    let part = contour(
        (52.0, 2.0),
        &[
            (30., 2., 0.),
            (30., -10., 0.),
            (18., -16., 0.),
            (18., -26., 0.),
            (40., -32., 0.),
            (40., -40., 0.),
            (52., -40., 0.),
        ],
    );
    assert_eq!(
        rough(&part, RoughSettings { pockets: true, ..settings(5.0, 1.0, 0.0, 0.0) }),
        "R X42; F Z-40; R X44 Z-39; R Z2; R X32; F Z-29.8182; R X34 Z-28.8182; R Z2; R Z-10; R X32; F X30; F X22 Z-14; \
         F Z-27.0909; R X24 Z-26.0909; R Z-15; F X22 Z-14; F X18 Z-16; F Z-26; R X20 Z-25; R X52; R Z2; R X30; F Z-10; \
         F X18 Z-16; F Z-26; F X40 Z-32; F Z-40; F X52; R Z2"
    );
}

#[test]
fn pockets_beside_each_other_come_along_the_cut() {
    // Two pockets of equal depth between walls of X30.
    let part = contour(
        (40.0, 2.0),
        &[
            (30., 2., 0.),
            (30., -10., 0.),
            (20., -12., 0.),
            (30., -14., 0.),
            (30., -20., 0.),
            (20., -22., 0.),
            (30., -24., 0.),
            (40., -24., 0.),
        ],
    );
    let text = rough(&part, RoughSettings { pockets: true, ..settings(5.0, 1.0, 0.0, 0.0) });
    assert_eq!(
        text,
        "R X30; F Z-24; R X32 Z-23; R Z2; R Z-10; F X30; F X20 Z-12; R X40; R Z2; R Z-20; R X32; F X30; F X20 Z-22; \
         R X40; R Z2; R X30; F Z-10; F X20 Z-12; F X30 Z-14; F Z-20; F X20 Z-22; F X30 Z-24; F X40; R Z2"
    );
}

#[test]
fn from_left_to_right() {
    let part =
        contour((62.0, -62.0), &[(20., -62., 0.), (20., -40., 0.), (40., -40., 0.), (40., -20., 0.), (62., -20., 0.)]);
    assert_eq!(
        rough(&part, settings(7.0, 1.0, 1.0, -0.5)),
        "R X63 Z-62.5; R X49; F Z-20.5; R X51 Z-21.5; R Z-62.5; R X35; F Z-40.5; R X37 Z-41.5; R Z-62.5; R X21; F Z-40.5; \
         R X23 Z-41.5; R Z-62.5; R X21; F Z-40.5; F X41; F Z-20.5; F X63; R X62 Z-62"
    );
}

#[test]
fn patterns_come_nearer() {
    let part = contour((50.0, 5.0), &[(20., 2., 0.), (20., -10., 0.), (30., -20., 0.), (44., -20., 0.)]);
    let mut written = Written::from(part.start);
    let settings = pattern::PatternRepeatSettings { relief: [3.0, 6.0], allowance: [0.2, 0.3], passes: 3 };
    pattern::run(&part, &settings, &mut written).unwrap();
    assert_eq!(
        written.text.join("; "),
        "R X62.6 Z8.2; R X32.6 Z5.2; F Z-6.8; F X42.6 Z-16.8; F X56.6; R Z6.7; R X26.6 Z3.7; F Z-8.3; F X36.6 Z-18.3; \
         F X50.6; R Z5.2; R X20.6 Z2.2; F Z-9.8; F X30.6 Z-19.8; F X44.6; R X50 Z5"
    );
}

fn pecks(settings: &peck::PeckSettings) -> String {
    let [peck, column] = settings.start;
    let mut written = Written::from(if settings.along_x { [column, peck] } else { [peck, column] });
    settings.run(&mut written).unwrap();
    written.text.join("; ")
}

#[test]
fn pecks_and_columns() {
    let hole = peck::PeckSettings {
        along_x: false,
        start: [2.0, 0.0],
        end: [-30.0, 0.0],
        peck: 12.0,
        shift: 0.0,
        back: 0.5,
        relief: 0.0,
    };
    assert_eq!(pecks(&hole), "F Z-10; R Z-9.5; F Z-22; R Z-21.5; F Z-30; R Z2");
    let face = peck::PeckSettings {
        start: [3.0, 20.0],
        end: [-12.0, 16.0],
        peck: 5.0,
        shift: 4.0,
        back: 1.0,
        relief: 0.5,
        ..hole
    };
    assert_eq!(
        pecks(&face),
        "F Z-2; R Z-1; F Z-7; R Z-6; F Z-12; R X41; R Z3; R X32; F Z-2; R Z-1; F Z-7; R Z-6; F Z-12; R X33; R Z3; R X40"
    );
    let groove = peck::PeckSettings {
        along_x: true,
        start: [26.0, -20.0],
        end: [20.0, -26.0],
        peck: 3.0,
        shift: 3.0,
        back: 0.5,
        relief: 0.0,
    };
    assert_eq!(
        pecks(&groove),
        "F X46; R X47; F X40; R X52; R Z-23; F X46; R X47; F X40; R X52; R Z-26; F X46; R X47; F X40; R X52; R Z-20"
    );
}

#[test]
fn a_contour_that_cannot_be_cut_is_refused() {
    let of =
        |points: &[(f64, f64, f64)]| RoughCycle::new(&contour((50.0, 2.0), points), settings(2.0, 1.0, 0.0, 0.0)).err();
    assert_eq!(of(&[(20., 2., 0.), (20., -10., 0.), (30., -5., 0.)]), Some(ContourError::TurnsBack));
    assert_eq!(
        of(&[(20., 2., 0.), (20., -10., 0.), (60., -10., 0.), (60., -12., 0.)]),
        Some(ContourError::BeyondStart)
    );
    // The last piece may leave the part.
    assert_eq!(of(&[(20., 2., 0.), (20., -10., 0.), (60., -10., 0.)]), None);
    assert_eq!(of(&[(20., 2., 0.)]), Some(ContourError::Nothing));
    assert_eq!(of(&[(20., 2., 0.), (f64::NAN, -10., 0.)]), Some(ContourError::Nothing));
    assert_eq!(of(&[(20., 2., 0.), (20., -10., 0.)]), None);
}

#[test]
fn millions_of_passes_can_be_stopped() {
    let part = contour((50.0, 2.0), &[(20., 2., 0.), (20., -10., 0.), (50., -10., 0.)]);
    let mut written = Written { most: 10, ..Written::from(part.start) };
    assert!(RoughCycle::new(&part, settings(1e-5, 1.0, 0.0, 0.0)).unwrap().run(&mut written).is_err());
    assert_eq!(written.passes, 11);
}

const LAP: LapSettings = LapSettings { copies: false, changes: [None; 2], stays: false };

fn lap_part() -> ProgrammedContour {
    let points = [(20.0, 2.0, 0.0), (20.0, -20.0, 0.0), (30.0, -30.0, 0.0), (30.0, -50.0, 0.0), (42.0, -50.0, 0.0)];
    contour((44.0, 2.0), &points)
}

#[test]
fn bar_turning_of_lap() {
    let settings = RoughSettings { lap: Some(LAP), ..settings(2.0, 0.1, 0.4, 0.1) };
    let expected = "R X40; F Z-49.9; R X40.2 Z-49.8; R Z2; R X36; F Z-49.9; R X36.2 Z-49.8; R Z2; R X32; F Z-49.9; \
                    R X32.2 Z-49.8; R Z2; R X28; F Z-27.5; R X28.2 Z-27.4; R Z2; R X24; F Z-23.5; R X24.2 Z-23.4; R Z2; \
                    R X20.4; F Z-19.9; F X30.4 Z-29.9; F Z-49.9; F X42.4; R X44 Z2";
    assert_eq!(rough(&lap_part(), settings), expected);
}

#[test]
fn levels_of_lap_with_another_depth_from_a_place_on() {
    let change = DepthChange { from: 18.0, depth: Some(1.0) };
    let lap = LapSettings { changes: [Some(change), None], stays: true, ..LAP };
    let text = rough(&lap_part(), RoughSettings { lap: Some(lap), ..settings(2.0, 0.1, 0.4, 0.1) });
    let levels: Vec<_> = text.split("; ").filter(|step| step.starts_with("R X") && !step.contains('Z')).collect();
    assert_eq!(levels, ["R X40", "R X36", "R X34", "R X32", "R X30", "R X28", "R X26", "R X24", "R X22", "R X20.4"]);
    assert!(text.ends_with("F X42.4"));
}

#[test]
fn copy_turning_of_lap() {
    let lap = LapSettings { copies: true, ..LAP };
    let points = [(20.0, 2.0, 0.0), (20.0, -20.0, 0.0), (30.0, -30.0, 0.0)];
    let text = rough(&contour((32.0, 2.0), &points), RoughSettings { lap: Some(lap), ..settings(3.0, 0.1, 0.0, 0.0) });
    assert_eq!(text, "R X26; F Z-20; F X36 Z-30; R Z2; R X20; F Z-20; F X30 Z-30; R Z2; R X32");
}
