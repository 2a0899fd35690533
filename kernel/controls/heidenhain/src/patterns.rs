//! A cycle at each of several points: PATTERN DEF and tables of points with CYCL CALL PAT, cycles 220 and 221.
//!
//! Facts: programming manuals of the control (POS, ROW, PAT, FRAME, CIRC, PITCHCIRC; between points the tool is at the
//! second clearance, of a table at its own, or at the height of the call, whichever is higher; Z of a pattern moves the
//! surface; cycles 220 and 221 call the cycle defined before them where they are defined, at the first or second
//! clearance between points). Decisions: rows of a PAT alternate in direction, a FRAME goes around counter-clockwise;
//! before the first point the tool only rises. Invariant: the block of the call runs once for each point, and a cycle
//! that is not a program is never called so.

use counterpoint_control_api::contour::{Point, along, towards};
use counterpoint_control_api::host::{InterpreterHost, ProgramPlace};
use counterpoint_event::FileId;
use counterpoint_fault as diag;
use counterpoint_fault::Halt;

use super::Heidenhain;
use super::call_approach::{CallApproach, SECOND_CLEARANCE};
use super::eval::Evaluator;
use super::path_state::{AXES, actual};
use super::q_parameter::{ParameterKind, QParameter};
use super::words::{EvaluatedWord, HeidenhainWord, LeftBlock, headed};

/// Most points of a definition.
const MOST: usize = 10_000;

/// A point.
#[derive(Debug, Clone, Copy)]
pub(super) struct PatternPoint {
    /// Its place in the plane.
    pub(super) at: Point,
    /// How much its surface lies above Q203.
    pub(super) above: f64,
    /// Height above the surface on the way to it, where it has one of its own.
    pub(super) clearance: Option<f64>,
}

/// A call that is at work.
#[derive(Debug, Clone, Copy)]
struct PatternCall {
    /// Its block.
    at: (FileId, u32),
    /// Point that comes next.
    next: usize,
    /// Height of the tool when it began.
    height: f64,
}

/// The points of the last definition or table, and of a cycle that is at work.
#[derive(Debug, Default)]
pub(super) struct PointPattern {
    spots: Vec<PatternPoint>,
    of_cycle: Vec<PatternPoint>,
    call: Option<PatternCall>,
}

impl PointPattern {
    /// The points of calls to come.
    pub(super) fn define(&mut self, spots: Vec<PatternPoint>) {
        *self = Self { spots, ..Self::default() };
    }

    /// Bytes that it takes, about.
    pub(super) fn bytes(&self) -> usize {
        (self.spots.len() + self.of_cycle.len()) * size_of::<PatternPoint>()
    }
}

/// Values of a figure of a definition.
struct PatternElement<'s> {
    name: &'s str,
    words: &'s [EvaluatedWord],
}

impl PatternElement<'_> {
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

    /// Its points; none for a figure that does not exist, or that misses a word.
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
            "PAT" | "FRAME" => {
                let (columns, rows) = (self.count("NUMX")?, self.count("NUMY")?);
                let turn = self.or_zero("ROT");
                let sides = [towards(turn + self.or_zero("ROTX")), towards(turn + self.or_zero("ROTY") + 90.0)];
                let grid = PointGrid { start, sides, steps: [self.or_zero("DX"), self.or_zero("DY")], columns, rows };
                if self.name == "PAT" { grid.rows()? } else { grid.frame() }
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

/// Points in columns and rows.
struct PointGrid {
    start: Point,
    sides: [Point; 2],
    steps: [f64; 2],
    columns: usize,
    rows: usize,
}

impl PointGrid {
    fn spot(&self, column: usize, row: usize) -> Point {
        let across = along(self.start, self.sides[0], self.steps[0] * column as f64);
        along(across, self.sides[1], self.steps[1] * row as f64)
    }

    /// Row by row, there and back.
    fn rows(&self) -> Option<Vec<Point>> {
        let count = self.rows.checked_mul(self.columns).filter(|count| *count <= MOST)?;
        let spot = |at: usize| {
            let (row, column) = (at / self.columns, at % self.columns);
            self.spot(if row.is_multiple_of(2) { column } else { self.columns - 1 - column }, row)
        };
        Some((0..count).map(spot).collect())
    }

    /// Once round, from the first point along the first row.
    fn frame(&self) -> Vec<Point> {
        let (last, top) = (self.columns - 1, self.rows - 1);
        let mut spots: Vec<Point> = (0..=last).map(|column| self.spot(column, 0)).collect();
        spots.extend((1..=top).map(|row| self.spot(last, row)));
        if top > 0 {
            spots.extend((0..last).rev().map(|column| self.spot(column, top)));
        }
        if last > 0 {
            spots.extend((1..top).rev().map(|row| self.spot(0, row)));
        }
        spots
    }
}

/// How the tool goes from point to point.
struct Journey<'s> {
    program: &'s str,
    way: CallApproach,
    /// Heights above the surface: before the first point and between points.
    clearances: [f64; 2],
    /// The cycle ends at the first clearance, but at the last point.
    stays_low: bool,
    /// Functions of the block.
    functions: &'s [EvaluatedWord],
    of_cycle: bool,
    /// The path to each point except the first is a circle: the block of the centre, and the words after the point.
    round: Option<[LeftBlock; 2]>,
}

impl Heidenhain {
    /// Letters of the working plane.
    pub(super) fn plane_letters(&self) -> [&'static str; 2] {
        self.path.plane.map(|axis| AXES.get(axis).copied().unwrap_or_default())
    }

    /// Letter of the tool axis.
    pub(super) fn tool_letter(&self) -> &'static str {
        AXES.get(self.variables.control.tool_axis.unwrap_or(2)).copied().unwrap_or("Z")
    }

    /// PATTERN DEF.
    pub(super) fn define_pattern(
        &mut self,
        host: &mut dyn InterpreterHost,
        words: &[HeidenhainWord],
    ) -> Result<(), Halt> {
        let seen = Evaluator::new(&mut self.variables, host).seen(words)?;
        let (letters, height) = (self.plane_letters(), self.tool_letter());
        self.cycles.pattern = PointPattern::default();
        let mut spots: Vec<PatternPoint> = Vec::new();
        // Behind `PATTERN DEF`: a name, its words in brackets.
        let mut rest = seen.get(2..).unwrap_or_default();
        while let Some((head, behind)) = rest.split_first() {
            let end = behind.iter().position(|word| word.is(")"));
            let figure = behind.first().filter(|word| word.is("(")).zip(end).map(|(_, end)| {
                let words = behind.get(1..end).unwrap_or_default();
                (PatternElement { name: &head.name, words }, end)
            });
            let before = spots.last().map_or([0.0; 2], |spot| spot.at);
            let made = figure.and_then(|(figure, end)| {
                let points = figure.points(letters, before)?;
                Some((points, figure.or_zero(height), end))
            });
            let fits = made.filter(|(points, ..)| spots.len() + points.len() <= MOST);
            let Some((points, surface, end)) = fits else {
                return Err(self.not_understood(host));
            };
            spots.extend(points.into_iter().map(|at| PatternPoint { at, above: surface, clearance: None }));
            rest = behind.get(end + 1..).unwrap_or_default();
        }
        self.cycles.pattern.define(spots);
        Ok(())
    }

    /// CYCL CALL PAT: the blocks that lead to the next point, with the program of the cycle after them; none where
    /// there are no points or the block cannot run once more.
    pub(super) fn call_at_pattern(
        &mut self,
        host: &mut dyn InterpreterHost,
        program: &str,
        seen: &[EvaluatedWord],
        place: ProgramPlace,
    ) -> Result<Option<Vec<LeftBlock>>, Halt> {
        let way = CallApproach::of(host, seen);
        let clearances = [self.second_clearance(); 2];
        self.next_point(
            host,
            &Journey { program, way, clearances, stays_low: false, functions: seen, of_cycle: false, round: None },
            place,
        )
    }

    /// Cycles 220 and 221: the same for the cycle defined before them.
    pub(super) fn point_cycle(
        &mut self,
        host: &mut dyn InterpreterHost,
        number: u32,
        place: ProgramPlace,
    ) -> Result<Vec<LeftBlock>, Halt> {
        let Some(program) = self.cycles.defined.program.clone() else {
            let text = format!("no cycle is defined for the points of '{}'; define one before it", host.block_text());
            return Err(host.alarm(&diag::STATEMENT_UNKNOWN, text));
        };
        if self.cycles.pattern.call.is_none_or(|call| call.at != (place.file, place.line)) {
            let spots = if number == 220 { self.on_circle() } else { self.in_rows() };
            let Some(spots) = spots else {
                let text = format!("the numbers of points in '{}' have to be 1 to {MOST} in all", host.block_text());
                return Err(host.alarm(&diag::STATEMENT_UNKNOWN, text));
            };
            self.cycles.pattern.of_cycle =
                spots.into_iter().map(|at| PatternPoint { at, above: 0.0, clearance: None }).collect();
        }
        let round = match number == 220 && self.q(365) == 1.0 {
            true => Some(self.round_the_circle(host)?),
            false => None,
        };
        let low = self.q(301) == 0.0;
        let second = self.second_clearance();
        let clearances = [second, if low { self.q(200) } else { second }];
        let way = CallApproach::of(host, &[]);
        let journey =
            Journey { program: &program, way, clearances, stays_low: low, functions: &[], of_cycle: true, round };
        Ok(self.next_point(host, &journey, place)?.unwrap_or_default())
    }

    /// A Q parameter of the program.
    fn q(&self, index: u32) -> f64 {
        self.number(QParameter { kind: ParameterKind::Q, index })
    }

    fn points(&self, index: u32) -> Option<usize> {
        Some(self.q(index)).filter(|count| (1.0..=MOST as f64).contains(count)).map(|count| count as usize)
    }

    /// Points of cycle 220. Without a step they divide the arc from the first angle to the last into equal parts; on a
    /// full circle the end has no point.
    fn on_circle(&self) -> Option<Vec<Point>> {
        let count = self.points(241)?;
        let [first, last, step] = [245, 246, 247].map(|index| self.q(index));
        let whole = ((last - first).abs() - 360.0).abs() < 1e-9;
        let shares = if whole { count } else { count.saturating_sub(1).max(1) };
        let step = if step == 0.0 { (last - first) / shares as f64 } else { step };
        let center = [self.q(216), self.q(217)];
        Some((0..count).map(|at| along(center, towards(first + step * at as f64), self.q(244) / 2.0)).collect())
    }

    /// The path from point to point of cycle 220 on the circle itself: its centre, its angle, and its feed.
    fn round_the_circle(&self, host: &mut dyn InterpreterHost) -> Result<[LeftBlock; 2], Halt> {
        let [first, second] = self.plane_letters();
        let [first_angle, last_angle, step] = [245, 246, 247].map(|index| self.q(index));
        let turns = if step == 0.0 { last_angle - first_angle } else { step };
        let center = headed("CC", [EvaluatedWord::made(first, self.q(216)), EvaluatedWord::made(second, self.q(217))]);
        Ok([center, vec![EvaluatedWord::turn(turns < 0.0), self.circle_rate(host)?]])
    }

    /// Points of cycle 221.
    fn in_rows(&self) -> Option<Vec<Point>> {
        let turn = self.q(224);
        let sides = [towards(turn), towards(turn + 90.0)];
        let (columns, rows) = (self.points(242)?, self.points(243)?);
        PointGrid { start: [self.q(225), self.q(226)], sides, steps: [self.q(237), self.q(238)], columns, rows }.rows()
    }

    /// The path to the next point and the call there.
    fn next_point(
        &mut self,
        host: &mut dyn InterpreterHost,
        journey: &Journey<'_>,
        place: ProgramPlace,
    ) -> Result<Option<Vec<LeftBlock>>, Halt> {
        let along = self.variables.control.tool_axis.unwrap_or(2);
        let stands = actual(host).get(along).copied().unwrap_or(0.0);
        let here = (place.file, place.line);
        let call = self.cycles.pattern.call.take().filter(|call| call.at == here);
        let height = if journey.of_cycle { f64::NEG_INFINITY } else { stands };
        let call = call.unwrap_or(PatternCall { at: here, next: 0, height });
        let pattern = &self.cycles.pattern;
        let spots = if journey.of_cycle { &pattern.of_cycle } else { &pattern.spots };
        let Some(&spot) = spots.get(call.next).filter(|_| place.as_read) else { return Ok(None) };
        let is_last = call.next + 1 >= spots.len();
        let surface = self.surface() + spot.above;
        let clearance =
            spot.clearance.unwrap_or(if call.next == 0 { journey.clearances[0] } else { journey.clearances[1] });
        let safe = call.height.max(surface + clearance);
        let way = &journey.way;
        let mut blocks = Vec::new();
        if stands < safe {
            blocks.push(way.block([EvaluatedWord::made(self.tool_letter(), safe)], true));
        }
        let [first, second] = self.plane_letters();
        let mut words = vec![EvaluatedWord::made(first, spot.at[0]), EvaluatedWord::made(second, spot.at[1])];
        // Functions of the block act at its beginning.
        words.extend(journey.functions.iter().filter(|word| call.next == 0 && word.is("M")).cloned());
        match journey.round.as_ref().filter(|_| call.next > 0) {
            Some([center, turn]) => {
                blocks.extend([center.clone(), headed("C", words.into_iter().chain(turn.iter().cloned()))]);
                blocks.extend(self.path.rates.last.clone().map(|feed| vec![feed]));
            }
            None => {
                blocks.push(way.block(words, false));
                blocks.extend(self.path.rates.last.clone().filter(|_| way.has_feed()).map(|feed| vec![feed]));
            }
        }
        self.call_cycle_program(host, journey.program, Some(surface))?;
        if journey.stays_low && !is_last {
            self.for_this_call(SECOND_CLEARANCE, 0.0);
        }
        if !is_last {
            self.cycles.pattern.call = Some(PatternCall { next: call.next + 1, ..call });
            self.lines.keeping = true;
            host.effect();
            host.go_to(place.line)?;
        }
        Ok(Some(blocks))
    }
}
