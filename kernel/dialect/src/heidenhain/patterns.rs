//! PATTERN DEF and CYCL CALL PAT: a cycle at each of several points.
//!
//! Facts: programming manuals of the control (POS, ROW, PAT, CIRC, PITCHCIRC; between points the tool is at the second clearance
//! or at the height of the call, whichever is higher; Z of a pattern moves the surface). Decisions: rows of a PAT alternate in
//! direction; a frame of points is refused. Invariant: the block of the call runs once for each point, and a cycle that is no
//! program is never called so.

use counterpoint_fault::Halt;

use super::Heidenhain;
use super::cycles::Way;
use super::eval::Evaluator;
use super::path::{AXES, actual};
use super::words::{Seen, Word, shown};
use crate::contour::{Point, along, towards};
use crate::host::{Host, Place};
use counterpoint_event::FileId;

/// Most points of a definition.
const MOST: usize = 10_000;

/// A point in the plane, and how much its surface lies above Q203.
type Spot = (Point, f64);

/// A call that is at work.
#[derive(Debug, Clone, Copy)]
struct Call {
    /// Its block.
    at: (FileId, u32),
    /// Point that comes next.
    next: usize,
    /// Height of the tool when it began.
    height: f64,
}

/// The points of the last definition.
#[derive(Debug, Default)]
pub(super) struct Pattern {
    spots: Vec<Spot>,
    call: Option<Call>,
}

impl Pattern {
    /// Bytes that it takes, about.
    pub(super) fn bytes(&self) -> usize {
        self.spots.len() * size_of::<Spot>()
    }
}

/// Values of a figure of a definition.
struct Figure<'s> {
    name: &'s str,
    words: &'s [Seen],
}

impl Figure<'_> {
    fn value(&self, name: &str) -> Option<f64> {
        self.words.iter().find(|word| word.is(name)).and_then(|word| word.value)
    }

    fn or_zero(&self, name: &str) -> f64 {
        self.value(name).unwrap_or(0.0)
    }

    /// A number of points.
    fn count(&self, name: &str) -> Option<usize> {
        self.value(name).filter(|count| (1.0..=MOST as f64).contains(count)).map(|count| count as usize)
    }

    /// Its first point or its centre; distances count from the point before.
    fn start(&self, [first, second]: [&str; 2], before: Point) -> Option<Point> {
        let coordinate =
            |name: &str, before: f64| self.value(name).or_else(|| Some(before + self.value(&format!("I{name}"))?));
        Some([coordinate(first, before[0])?, coordinate(second, before[1])?])
    }

    /// Its points; none for a figure that there is not, or that misses a word.
    fn points(&self, letters: [&str; 2], before: Point) -> Option<Vec<Point>> {
        let start = self.start(letters, before)?;
        let circle = |step: f64, count: usize| {
            let angle = |at: usize| self.or_zero("START") + step * at as f64;
            let radius = self.or_zero("D") / 2.0;
            (0..count).map(|at| along(start, towards(angle(at)), radius)).collect()
        };
        Some(match self.name {
            "POS" => vec![start],
            "ROW" => {
                let way = towards(self.or_zero("ROT"));
                (0..self.count("NUM")?).map(|at| along(start, way, self.or_zero("D") * at as f64)).collect()
            }
            "PAT" => {
                let turn = self.or_zero("ROT");
                let (columns, rows) = (self.count("NUMX")?, self.count("NUMY")?);
                let sides = [towards(turn + self.or_zero("ROTX")), towards(turn + self.or_zero("ROTY") + 90.0)];
                let [across, up] = [self.or_zero("DX"), self.or_zero("DY")];
                let spot = |row: usize, column: usize| {
                    let column = if row.is_multiple_of(2) { column } else { columns - 1 - column };
                    along(along(start, sides[0], across * column as f64), sides[1], up * row as f64)
                };
                let count = rows.checked_mul(columns).filter(|count| *count <= MOST)?;
                (0..count).map(|at| spot(at / columns, at % columns)).collect()
            }
            "CIRC" => {
                let count = self.count("NUM")?;
                circle(360.0 / count as f64, count)
            }
            "PITCHCIRC" => circle(self.or_zero("STEP"), self.count("NUM")?),
            _ => return None,
        })
    }
}

impl Heidenhain {
    /// PATTERN DEF.
    pub(super) fn define_pattern(&mut self, host: &mut dyn Host, words: &[Word]) -> Result<(), Halt> {
        let seen = Evaluator::new(&mut self.variables, host).seen(words)?;
        let letters = self.path.plane.map(|axis| AXES.get(axis).copied().unwrap_or_default());
        let height = AXES.get(self.variables.control.tool_axis.unwrap_or(2)).copied().unwrap_or("Z");
        self.cycles.pattern = Pattern::default();
        let mut spots: Vec<Spot> = Vec::new();
        // Behind `PATTERN DEF`: a name, its words in brackets.
        let mut rest = seen.get(2..).unwrap_or_default();
        while let Some((head, behind)) = rest.split_first() {
            let end = behind.iter().position(|word| word.is(")"));
            let figure = behind.first().filter(|word| word.is("(")).zip(end).map(|(_, end)| {
                let words = behind.get(1..end).unwrap_or_default();
                (Figure { name: &head.name, words }, end)
            });
            let before = spots.last().map_or([0.0; 2], |(point, _)| *point);
            let made = figure.and_then(|(figure, end)| {
                let points = figure.points(letters, before)?;
                Some((points, figure.or_zero(height), end))
            });
            let fits = made.filter(|(points, ..)| spots.len() + points.len() <= MOST);
            let Some((points, surface, end)) = fits else {
                self.not_understood(host);
                return Ok(());
            };
            spots.extend(points.into_iter().map(|point| (point, surface)));
            rest = behind.get(end + 1..).unwrap_or_default();
        }
        self.cycles.pattern.spots = spots;
        Ok(())
    }

    /// CYCL CALL PAT: the blocks that lead to the next point, with the program of the cycle behind them; none where there are no
    /// points or the block cannot run once more.
    pub(super) fn call_at_pattern(
        &mut self,
        host: &mut dyn Host,
        program: &str,
        seen: &[Seen],
        place: Place,
    ) -> Result<Option<Vec<String>>, Halt> {
        let along = self.variables.control.tool_axis.unwrap_or(2);
        let stands = actual(host).get(along).copied().unwrap_or(0.0);
        let here = (place.file, place.line);
        let call = self.cycles.pattern.call.take().filter(|call| call.at == here);
        let call = call.unwrap_or(Call { at: here, next: 0, height: stands });
        let Some(&(point, above)) = self.cycles.pattern.spots.get(call.next).filter(|_| place.as_read) else {
            return Ok(None);
        };
        let surface = self.surface() + above;
        let safe = call.height.max(surface + self.second_clearance());
        let way = Way::of(host, seen);
        let mut blocks = Vec::new();
        if stands < safe {
            let letter = AXES.get(along).copied().unwrap_or("Z");
            blocks.push(way.block(&format!("{letter}{}", shown(safe)), true));
        }
        let [first, second] = self.path.plane.map(|axis| AXES.get(axis).copied().unwrap_or_default());
        let mut words = format!("{first}{} {second}{}", shown(point[0]), shown(point[1]));
        // Functions of the block act at its beginning.
        for word in seen.iter().filter(|word| call.next == 0 && word.is("M")) {
            words.push(' ');
            words.push_str(&word.text);
        }
        blocks.push(way.block(&words, false));
        blocks.extend(self.path.feed.clone().filter(|_| way.has_feed()));
        self.call_cycle_program(host, program, Some(surface))?;
        if call.next + 1 < self.cycles.pattern.spots.len() {
            self.cycles.pattern.call = Some(Call { next: call.next + 1, ..call });
            self.keeping = true;
            host.effect();
            host.go_to(place.line)?;
        }
        Ok(Some(blocks))
    }
}
