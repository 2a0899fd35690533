//! CONTPRON and EXECUTE: the moves between them become the table of a contour.
//!
//! Facts: programming manual, job planning, chapter "user stock removal programs": nothing moves between CONTPRON and
//! EXECUTE; a row of eleven columns for each piece, abscissa before ordinate, radii. Row 0 is the move to the contour,
//! its first two columns are the row in which the contour ends and the last row; in every other row they are the rows
//! before and behind, 0 at the ends. Columns 2 to 10: the kind of move, start, end, the local maximum, the greatest
//! angle to the axis of the cuts, the centre. Decisions: EXECUTE is in the program of its CONTPRON; the blocks between
//! them are read as a part of that program, as cycles read contours, so modal codes are those of before again; moves
//! count as G90, and a G0 after the first one as G1; pieces of relief cuts are counted, but not divided, and the marks
//! of column 7 are left out with them. *Invariant:* a table that cannot hold the contour is an alarm before anything is
//! written.

use super::block_text::bare;
use super::compiled::{SiemensArgument, as_name};
use super::item::SiemensItem;
use super::line::read;
use super::value::{Data, Type};
use super::variable_store::VariableElement;
use super::{Outcome, Siemens, SiemensBlockError, syntax, wrong_type};
use counterpoint_control_api::host::InterpreterHost;
use counterpoint_fault as diag;
use counterpoint_motion::contour::element::Element;

/// Columns of the table.
const COLUMNS: usize = 11;
/// Mark of a local maximum without a relief cut.
const MAXIMUM: f64 = -1111.0;
/// Lengths and angles below this are none.
const NOISE: f64 = 1e-7;

/// A CONTPRON whose EXECUTE is still to come.
#[derive(Debug)]
pub(super) struct Preparation {
    table: VariableElement,
    /// Variable for the number of relief cuts.
    relief: VariableElement,
    /// Cuts along the ordinate (N, P), otherwise along the abscissa (L, G).
    face: bool,
    /// The part lies inside (G, N).
    inside: bool,
}

fn conditions<T>(text: impl std::fmt::Display) -> Outcome<T> {
    Err(SiemensBlockError::Alarm(&diag::SIEMENS_STATE, format!("{text} (alarm 15800)")))
}

impl Siemens {
    /// Executes CONTPRON or EXECUTE; returns whether the statement is one of them.
    pub(super) fn preparation(
        &mut self,
        host: &mut dyn InterpreterHost,
        name: &str,
        arguments: &[SiemensArgument],
    ) -> Outcome<bool> {
        match name {
            "CONTPRON" => self.prepare_contour(host, arguments).map(|()| true),
            "EXECUTE" => self.end_preparation(host, arguments).map(|()| true),
            _ => Ok(false),
        }
    }

    fn prepare_contour(&mut self, host: &mut dyn InterpreterHost, arguments: &[SiemensArgument]) -> Outcome<()> {
        if host.reads_contour() || self.held.preparation.is_some() {
            return conditions("CONTPRON stands behind another CONTPRON without EXECUTE between them");
        }
        if host.keeps_moves_back() {
            return conditions("CONTPRON under tool radius compensation; program G40 before it");
        }
        let ([table, kind, relief] | [table, kind, relief, _]) = arguments else {
            return syntax("CONTPRON needs a table, a kind of machining and a variable for relief cuts");
        };
        let table = self.variable_of(host, table)?;
        let rows = table.count / COLUMNS;
        if table.kind != Type::Real || !table.is_array() || self.sizes_of(&table) != [rows, COLUMNS] {
            return wrong_type(format!("the table of CONTPRON is REAL {}[…,{COLUMNS}] (alarm 15810)", table.name));
        }
        let kind = self.argument(host, kind)?.map_or_else(String::new, |kind| kind.text().to_ascii_uppercase());
        let (face, inside) = match kind.as_str() {
            "L" => (false, false),
            "G" => (false, true),
            "P" => (true, false),
            "N" => (true, true),
            _ => {
                return conditions(format!(
                    "the machining of CONTPRON is \"G\", \"L\", \"N\" or \"P\", not \"{kind}\""
                ));
            }
        };
        let relief = self.variable_of(host, relief)?;
        let both = match arguments.get(3) {
            Some(direction) => self.argument(host, direction)?.and_then(|value| value.number()).unwrap_or(0.0),
            None => 0.0,
        };
        if both != 0.0 {
            return conditions("CONTPRON in both directions is not emulated; leave the fourth argument out");
        }
        let end = self.end_of_preparation(host)?;
        let place = host.place();
        self.held.preparation = Some(Preparation { table, relief, face, inside });
        let call = self.prepare_part(host, "CONTPRON".to_owned(), (place.line + 1, end - 1), 1);
        host.go_to(end)?;
        if place.line + 1 < end {
            host.read_contour(call);
        }
        Ok(())
    }

    /// Line of the EXECUTE that ends the contour of this block.
    fn end_of_preparation(&mut self, host: &mut dyn InterpreterHost) -> Outcome<u32> {
        let place = host.place();
        let source = host.source(place.file);
        let is_end = |line: u32| {
            let text = source.as_ref().map(|source| String::from_utf8_lossy(source.line(line)).into_owned());
            let line = text.and_then(|text| read(bare(&text)).ok());
            line.is_some_and(|line| {
                line.items.iter().any(|item| matches!(item, SiemensItem::Function(name, _) if name == "EXECUTE"))
            })
        };
        let last = place.range.last;
        let lines = source.as_ref().map_or(0, |source| source.lines());
        match (place.line + 1..=last.min(lines)).find(|line| is_end(*line)) {
            Some(line) => Ok(line),
            None => conditions("no EXECUTE follows CONTPRON in its program"),
        }
    }

    fn end_preparation(&mut self, host: &mut dyn InterpreterHost, arguments: &[SiemensArgument]) -> Outcome<()> {
        let [error] = arguments else { return syntax("EXECUTE needs a variable for the error") };
        let error = self.variable_of(host, error)?;
        if let Some(preparation) = self.held.preparation.take() {
            self.fill_table(host, &preparation)?;
        }
        self.store(host, &error, Data::Int(0))
    }

    fn fill_table(&mut self, host: &mut dyn InterpreterHost, preparation: &Preparation) -> Outcome<()> {
        let factor = host.length_factor();
        let (inch, rapid) = (host.is_inch(), host.contour_begins_rapid());
        // The move to the contour is the first row.
        let mut pieces = host.contour().to_vec();
        if let (Some(first), Some(from)) = (pieces.first().map(|piece| piece.from), start(host)) {
            let from = from.map(|place| place * factor);
            pieces.insert(0, Element { from, to: first, arc: None });
        }
        let relief = relief_cuts(&pieces, preparation);
        let rows = preparation.table.count / COLUMNS;
        if pieces.len() < 2 || pieces.len() > rows {
            let count = pieces.len();
            return conditions(format!(
                "the contour of CONTPRON has {count} moves, its table {rows} rows (alarm 15810)"
            ));
        }
        if relief > 0 {
            let text =
                "CONTPRON: pieces of relief cuts are not divided, and column 7 of the table has no marks".to_owned();
            host.diagnose(&diag::SIEMENS_IGNORED, text);
        }
        host.work(preparation.table.count)?;
        for at in 0..rows {
            let row = match pieces.get(at) {
                Some(piece) => row(piece, (at, pieces.len()), (preparation, relief, inch, rapid), factor, &pieces),
                None => [0.0; COLUMNS],
            };
            for (column, value) in row.into_iter().enumerate() {
                self.store(host, &preparation.table.element(at * COLUMNS + column), Data::Real(value))?;
            }
        }
        self.store(host, &preparation.relief, Data::Int(i64::try_from(relief).unwrap_or(i64::MAX)))
    }

    /// The variable that an argument is.
    pub(super) fn variable_of(
        &mut self,
        host: &mut dyn InterpreterHost,
        argument: &SiemensArgument,
    ) -> Outcome<VariableElement> {
        let name = match &argument.value {
            Ok(Some(expression)) => as_name(expression),
            _ => None,
        };
        let found = match name {
            Some(name) => self.locate(host, name)?,
            None => None,
        };
        found.map_or_else(|| syntax(format!("'{}' is not a variable", argument.text)), Ok)
    }

    fn sizes_of(&self, table: &VariableElement) -> Vec<usize> {
        let known = self.variables.whole(&table.name).map(|variable| variable.sizes.clone());
        known.or_else(|| self.variables.shared.get(&*table.name).map(|(_, sizes)| sizes.clone())).unwrap_or_default()
    }
}

/// Where the tool is, along both axes of the plane, as radii of the program.
fn start(host: &dyn InterpreterHost) -> Option<[f64; 2]> {
    let axes = host.axes();
    let at = |letter: &str| {
        let axis = axes.iter().find(|axis| axis.letter.eq_ignore_ascii_case(letter))?;
        Some(if axis.diameter { axis.work / 2.0 } else { axis.work })
    };
    let [first, second] = match super::system::plane(host)? {
        1 => ["X", "Y"],
        2 => ["Z", "X"],
        _ => ["Y", "Z"],
    };
    Some([at(first)?, at(second)?])
}

/// Row `at` of `count`.
fn row(
    piece: &Element,
    (at, count): (usize, usize),
    (preparation, relief, inch, rapid): (&Preparation, usize, bool, bool),
    factor: f64,
    pieces: &[Element],
) -> [f64; COLUMNS] {
    let last = count - 1;
    let (before, behind) = match at {
        0 => (last, last),
        _ => (at - 1, if at == last { 0 } else { at + 1 }),
    };
    let kind = match &piece.arc {
        None if at == 0 && rapid => 0.0,
        None => 1.0,
        Some(arc) if arc.sweep < 0.0 => 2.0,
        Some(_) => 3.0,
    };
    let center = piece.arc.as_ref().map_or([0.0; 2], |arc| arc.center.map(|place| place / factor));
    let rises = |piece: &Element| height(piece.to, preparation.face) - height(piece.from, preparation.face);
    let is_maximum = relief == 0
        && !preparation.inside
        && at > 0
        && rises(piece) < -NOISE
        && pieces.get(at - 1).is_some_and(|before| rises(before) > NOISE);
    let unit = if inch { 0.0 } else { 10.0 };
    let [from, to] = [piece.from, piece.to].map(|spot| spot.map(|place| place / factor));
    [
        before as f64,
        behind as f64,
        unit + kind,
        from[0],
        from[1],
        to[0],
        to[1],
        if is_maximum { MAXIMUM } else { 0.0 },
        steepest(piece, preparation.face),
        center[0],
        center[1],
    ]
}

/// Greatest angle between a piece and the axis of the cuts: over 0 to 180 degrees, 0 for a line along the axis.
fn steepest(piece: &Element, face: bool) -> f64 {
    let angle = |[first, second]: [f64; 2]| {
        let (along, across) = if face { (second, first) } else { (first, second) };
        libm::atan2(across, along).to_degrees()
    };
    let from = angle(piece.start());
    let turns =
        piece.arc.as_ref().map_or(0.0, |arc| if face { -arc.sweep.to_degrees() } else { arc.sweep.to_degrees() });
    let (low, high) = (from.min(from + turns), from.max(from + turns));
    if high - low < NOISE {
        let flat = from.rem_euclid(180.0);
        return if flat < NOISE || 180.0 - flat < NOISE { 0.0 } else { flat };
    }
    // The direction along the axis ends a turn from below with 180 degrees.
    let turn = ((high + NOISE) / 180.0).floor() * 180.0;
    if turn > low + NOISE { 180.0 } else { high.rem_euclid(180.0) }
}

/// The coordinate across the cuts.
fn height([first, second]: [f64; 2], face: bool) -> f64 {
    if face { first } else { second }
}

/// How often the contour behind its first move goes into the part and comes out again.
fn relief_cuts(pieces: &[Element], preparation: &Preparation) -> usize {
    let face = preparation.face;
    let sign = if preparation.inside { -1.0 } else { 1.0 };
    let mut heights: Vec<f64> = Vec::new();
    for piece in pieces.iter().skip(1) {
        if heights.is_empty() {
            heights.push(sign * height(piece.from, face));
        }
        if let Some(arc) = &piece.arc {
            heights.extend(extremes(piece, arc.center, arc.sweep, face).into_iter().map(|height| sign * height));
        }
        heights.push(sign * height(piece.to, face));
    }
    let (mut falls, mut cuts) = (false, 0);
    for pair in heights.windows(2) {
        let &[before, after] = pair else { continue };
        if after < before - NOISE {
            falls = true;
        } else if after > before + NOISE {
            cuts += usize::from(falls);
            falls = false;
        }
    }
    cuts
}

/// Where an arc is highest and lowest within its path, in order.
fn extremes(piece: &Element, center: [f64; 2], sweep: f64, face: bool) -> Vec<f64> {
    let start = libm::atan2(piece.from[1] - center[1], piece.from[0] - center[0]);
    let radius = libm::hypot(piece.from[0] - center[0], piece.from[1] - center[1]);
    let quarter = std::f64::consts::FRAC_PI_2;
    let first = if face { 0.0 } else { quarter };
    let places = (-4..=4).map(|turn| first + f64::from(turn) * 2.0 * quarter);
    let mut found: Vec<(f64, f64)> = places
        .map(|place| {
            let way = if face { libm::cos(place) } else { libm::sin(place) };
            ((place - start) / sweep, height(center, face) + radius * way)
        })
        .filter(|(way, _)| (NOISE..1.0 - NOISE).contains(way))
        .collect();
    found.sort_by(|(a, _), (b, _)| a.total_cmp(b));
    found.into_iter().map(|(_, height)| height).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use counterpoint_motion::contour::element::Spot;

    fn line(from: Spot, to: Spot) -> Element {
        Element { from, to, arc: None }
    }

    #[test]
    fn a_line_has_the_same_angle_both_ways() {
        let angle = |from, to| steepest(&line(from, to), false);
        for (to, expected) in
            [([30.0, 40.0], 53.130_102_354), ([10.0, -10.0], 135.0), ([0.0, -15.0], 90.0), ([-7.0, 0.0], 0.0)]
        {
            assert!((angle([0.0, 0.0], to) - expected).abs() < 1e-6, "{to:?}");
            assert!((angle(to, [0.0, 0.0]) - expected).abs() < 1e-6, "back from {to:?}");
        }
        let square = |to| steepest(&line([0.0, 0.0], to), true);
        assert!((square([0.0, 5.0]) - 0.0).abs() < 1e-9 && (square([5.0, 0.0]) - 90.0).abs() < 1e-9);
    }
}
