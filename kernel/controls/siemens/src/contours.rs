//! Statements by which the cycles of the control read contours and cut along them.
//!
//! `SC_KEEP(name)` keeps the name of a contour for the next cycle that has none (CYCLE62). `SC_READ(name, …)` runs the
//! subprogram, with the arguments after its name, or the section between the labels of `A:B` of the program that has
//! called the cycle, so that its moves are recorded. A name that is not a subprogram is that of a contour between the
//! labels E_LAB_A_name and E_LAB_E_name. `SC_PIECES(count, table)` gives the recorded pieces; `SC_STRIP(…)` removes
//! stock along them. `SC_KEPT` and `SC_FORGET` count and forget the names; `SC_READ` with a number reads the contour
//! with that number. `SC_ADDRING` makes a ring of a pocket from the recorded contour. `SC_WAYS`, `SC_LINES` and
//! `SC_HOLES` give the paths of a tool around and between its rings, and the places where it goes down. `SC_LEAVE`
//! makes a blank with spigots of it, `SC_FOLLOW` describes a tool that has cleared it before. `SC_LETTERS(count, table,
//! text, width, gap)` gives the strokes of a text. The control does the same by CONTPRON and EXECUTE. Facts: reference
//! siemens-cycles.md 1.6. *Invariant:* only programs stored with the machine have these statements; elsewhere their
//! names are unknown, as on the control.

use super::compiled::SiemensArgument;
use super::conversions::number;
use super::value::Data;
use super::variable_store::VariableElement;
use super::{Outcome, Siemens, SiemensBlockError, syntax, wrong_type};
use counterpoint_control_api::host::{InterpreterHost, SubprogramCall};
use counterpoint_event::FileId;
use counterpoint_fault as diag;
use counterpoint_machine::stored::StoredFile;
use counterpoint_motion::contour::area::{ClearingArea, backwards};
use counterpoint_motion::contour::clearing::Clearing;
use counterpoint_motion::contour::element::{Element, Spot};
use counterpoint_motion::contour::shifted::shifted;
use counterpoint_motion::lettering;
use counterpoint_motion::turning::strip::Strip;
use counterpoint_program::shape::ProgramRange;

/// Columns of a table of pieces: kind (1 to 3 as G1 to G3), end, centre, along both axes of the plane.
const COLUMNS: usize = 5;
/// Pieces of a ring, and lines of a pocket, at most: its cycle takes fewer.
const MOST_PIECES: usize = 1000;
const MOST_LINES: u32 = 2002;

impl Siemens {
    /// Executes such a statement; whether it is one.
    pub(super) fn contour_statement(
        &mut self,
        host: &mut dyn InterpreterHost,
        name: &str,
        arguments: &[SiemensArgument],
    ) -> Outcome<bool> {
        let statement = match name {
            "SC_KEEP" => Self::keep_contour,
            "SC_READ" => Self::read_contour,
            "SC_PIECES" => Self::pieces,
            "SC_STRIP" => Self::strip,
            "SC_FORGET" => Self::forget_contours,
            "SC_KEPT" => Self::kept_contours,
            "SC_ADDRING" => Self::ring,
            "SC_WAYS" => Self::ways,
            "SC_LINES" => Self::lines,
            "SC_HOLES" => Self::holes,
            "SC_LEAVE" => Self::leave_blank,
            "SC_FOLLOW" => Self::follow_tool,
            "SC_LETTERS" => Self::letters,
            _ => return Ok(false),
        };
        let place = host.place();
        if !is_stored(&host.files(), place.file) {
            return Ok(false);
        }
        if host.reads_contour() {
            return Err(SiemensBlockError::Alarm(
                &diag::CONTOUR_CODE,
                "a contour has no cycle along a contour".to_owned(),
            ));
        }
        statement(self, host, arguments)?;
        Ok(true)
    }

    fn keep_contour(&mut self, host: &mut dyn InterpreterHost, arguments: &[SiemensArgument]) -> Outcome<()> {
        let name = self.contour_name(host, arguments)?;
        self.variables.contours.push(name);
        Ok(())
    }

    fn forget_contours(&mut self, _: &mut dyn InterpreterHost, _: &[SiemensArgument]) -> Outcome<()> {
        self.variables.contours.clear();
        self.variables.area = ClearingArea::default();
        Ok(())
    }

    fn contour_name(&mut self, host: &mut dyn InterpreterHost, arguments: &[SiemensArgument]) -> Outcome<String> {
        let Some(first) = arguments.first() else { return syntax("the name of a contour is missing") };
        match self.argument(host, first)? {
            Some(Data::Text(name)) => Ok(name.trim().to_ascii_uppercase()),
            Some(Data::Int(number)) => {
                let kept = usize::try_from(number - 1).ok().and_then(|at| self.variables.contours.get(at));
                kept.cloned().map_or_else(|| syntax(format!("contour {number} has no name")), Ok)
            }
            _ => wrong_type("the name of a contour is a text"),
        }
    }

    fn read_contour(&mut self, host: &mut dyn InterpreterHost, arguments: &[SiemensArgument]) -> Outcome<()> {
        let mut name = self.contour_name(host, arguments)?;
        if name.is_empty() {
            match self.variables.contours.as_slice() {
                [] => return syntax("no contour is named (CYCLE62)"),
                [one] => name.clone_from(one),
                _ => return syntax("several contours (CYCLE62) of one cycle are not emulated"),
            }
            self.variables.contours.clear();
        }
        let call = match name.split_once(':') {
            Some((from, to)) => self.contour_section(host, &name, (from.trim(), to.trim()))?,
            None => self.contour_by_name(host, &name, arguments)?,
        };
        host.read_contour(call);
        Ok(())
    }

    /// A contour by its name: the subprogram of that name, or a section of the program. The control's editor of
    /// contours writes labels around such a section.
    fn contour_by_name(
        &mut self,
        host: &mut dyn InterpreterHost,
        name: &str,
        arguments: &[SiemensArgument],
    ) -> Outcome<SubprogramCall> {
        let found = self.program_by_path(host, name)?;
        if !name.is_empty() && found.is_some() {
            return self.prepare_call(host, name, found, arguments.get(1..).unwrap_or_default());
        }
        let (from, to) = (format!("E_LAB_A_{name}"), format!("E_LAB_E_{name}"));
        self.contour_section(host, name, (&from, &to)).map_err(|fault| match fault {
            SiemensBlockError::Halt(halt) => SiemensBlockError::Halt(halt),
            SiemensBlockError::Alarm(..) => {
                let text = format!(
                    "the contour '{name}' is no subprogram (alarm 14011, program not there), and the program has no labels {from} and {to}"
                );
                SiemensBlockError::Alarm(&diag::SUBPROGRAM_MISSING, text)
            }
        })
    }

    /// The lines between two labels of the program that has called the cycle.
    fn contour_section(
        &mut self,
        host: &mut dyn InterpreterHost,
        name: &str,
        (from, to): (&str, &str),
    ) -> Outcome<SubprogramCall> {
        let (files, callers) = (host.files(), host.callers());
        let outer = callers.iter().take_while(|(file, _)| is_stored(&files, *file)).count();
        let Some(caller) = callers.get(outer).copied() else { return syntax("no program has called the cycle") };
        let labels = (from.to_owned(), to.to_owned());
        let (file, range) = self.section(host, caller, &labels)?;
        let mut call = self.prepare_part(host, name.to_owned(), (range.first, range.last), 1);
        call.place = Some((file, ProgramRange { number: None, ..range }));
        if let Some(calling) = &mut self.calling {
            calling.outer = outer;
        }
        Ok(call)
    }

    /// Number of the contours that are named.
    fn kept_contours(&mut self, host: &mut dyn InterpreterHost, arguments: &[SiemensArgument]) -> Outcome<()> {
        let count = i64::try_from(self.variables.contours.len()).unwrap_or(i64::MAX);
        let [target] = self.targets(host, arguments)?;
        self.store(host, &target, Data::Int(count))
    }

    /// Adds the contour that was read to the pocket, as its rim or as an island; the number of rings, -1 if it is not
    /// closed.
    fn ring(&mut self, host: &mut dyn InterpreterHost, arguments: &[SiemensArgument]) -> Outcome<()> {
        let [target] = self.targets(host, arguments)?;
        if host.contour().len() > MOST_PIECES {
            return syntax(format!("a contour of a pocket has more than {MOST_PIECES} pieces"));
        }
        let count = self.variables.area.add(host.contour());
        let count = count.ok().and_then(|count| i64::try_from(count).ok()).unwrap_or(-1);
        self.store(host, &target, Data::Int(count))
    }

    /// The first ring is the rim of a blank: the tool may be beyond it by a number.
    fn leave_blank(&mut self, host: &mut dyn InterpreterHost, arguments: &[SiemensArgument]) -> Outcome<()> {
        let [beyond] = self.numbers(host, arguments)?;
        self.variables.area.leave(beyond * host.length_factor());
        Ok(())
    }

    /// A tool of a radius has cleared the pocket before, with an allowance.
    fn follow_tool(&mut self, host: &mut dyn InterpreterHost, arguments: &[SiemensArgument]) -> Outcome<()> {
        let [radius, away] = self.numbers(host, arguments)?;
        let factor = host.length_factor();
        self.variables.area.follow(radius * factor, away * factor);
        Ok(())
    }

    /// How a tool clears the pocket at a distance from its rings, and cuts not further apart than a step, if that is
    /// above 0.
    fn clearing(&self, factor: f64, [by, step]: [f64; 2]) -> Option<(Clearing, Vec<Vec<Element>>)> {
        let clearing = Clearing::of(&self.variables.area, by * factor)?;
        let rows = clearing.rows(step * factor, MOST_LINES);
        Some((clearing, rows))
    }

    /// Paths around the pocket and its islands at a distance, as rows of a table. They run in the direction of G3
    /// around the rim or, with a number other than 0 after the step of the cuts, of G2. Each path follows a row of kind
    /// 0 with its start. -1 rows if the tool fits nowhere.
    fn ways(&mut self, host: &mut dyn InterpreterHost, arguments: &[SiemensArgument]) -> Outcome<()> {
        let [count, table] = self.targets(host, arguments)?;
        let [by, step, turned] = self.numbers(host, arguments.get(2..).unwrap_or_default())?;
        let factor = host.length_factor();
        let Some((clearing, rows)) = self.clearing(factor, [by, step]) else {
            return self.store(host, &count, Data::Int(-1));
        };
        let turn = |way: &Vec<Element>| if turned == 0.0 { way.clone() } else { backwards(way) };
        let ways: Vec<_> = clearing.ways(&rows).iter().map(turn).collect();
        self.fill(host, (&count, &table), &passes(&ways), factor)
    }

    /// Cuts that clear the pocket inside of such paths: rows of a table as those of the paths.
    fn lines(&mut self, host: &mut dyn InterpreterHost, arguments: &[SiemensArgument]) -> Outcome<()> {
        let [count, table] = self.targets(host, arguments)?;
        let sizes = self.numbers(host, arguments.get(2..).unwrap_or_default())?;
        let factor = host.length_factor();
        let rows = self.clearing(factor, sizes).map(|(_, rows)| rows).unwrap_or_default();
        self.fill(host, (&count, &table), &passes(&rows), factor)
    }

    /// Where the tool goes down into the full to clear the pocket: rows of kind 0; -1 of them if it fits nowhere.
    fn holes(&mut self, host: &mut dyn InterpreterHost, arguments: &[SiemensArgument]) -> Outcome<()> {
        let [count, table] = self.targets(host, arguments)?;
        let sizes = self.numbers(host, arguments.get(2..).unwrap_or_default())?;
        let factor = host.length_factor();
        let Some((clearing, rows)) = self.clearing(factor, sizes) else {
            return self.store(host, &count, Data::Int(-1));
        };
        let holes: Vec<_> = clearing.plunges(&rows).iter().map(|[x, y]| [0.0, *x, *y, 0.0, 0.0]).collect();
        self.fill(host, (&count, &table), &holes, factor)
    }

    /// Strokes of a text with capitals of height 1, and the width of one of its letters. The strokes are rows of a
    /// table, each starting with a row of kind 0; -1 rows if a letter is not ASCII.
    fn letters(&mut self, host: &mut dyn InterpreterHost, arguments: &[SiemensArgument]) -> Outcome<()> {
        let [count, table, wide] = self.targets(host, arguments)?;
        let mut rest = [None, None];
        for (slot, argument) in rest.iter_mut().zip(arguments.iter().skip(3)) {
            *slot = self.argument(host, argument)?;
        }
        let [Some(Data::Text(text)), gap] = rest else { return wrong_type("what is engraved is a text") };
        let gap = gap.map_or(Ok(lettering::GAP), |gap| number(&gap))?;
        self.store(host, &wide, Data::Real(lettering::WIDTH))?;
        if lettering::unknown(&text).is_some() {
            return self.store(host, &count, Data::Int(-1));
        }
        let stroke = |stroke: Vec<Spot>| {
            let row = |(at, [x, y]): (usize, Spot)| [if at == 0 { 0.0 } else { 1.0 }, x, y, 0.0, 0.0];
            stroke.into_iter().enumerate().map(row).collect::<Vec<_>>()
        };
        let rows: Vec<_> = lettering::strokes(&text, gap).flat_map(stroke).collect();
        self.fill(host, (&count, &table), &rows, 1.0)
    }

    /// Variables that the first arguments name.
    fn targets<const N: usize>(
        &mut self,
        host: &mut dyn InterpreterHost,
        arguments: &[SiemensArgument],
    ) -> Outcome<[VariableElement; N]> {
        let mut targets = Vec::new();
        for argument in arguments.iter().take(N) {
            targets.push(self.variable_of(host, argument)?);
        }
        targets.try_into().or_else(|_| syntax("a statement of contours needs variables"))
    }

    /// Numbers among arguments; a missing number is 0.
    fn numbers<const N: usize>(
        &mut self,
        host: &mut dyn InterpreterHost,
        arguments: &[SiemensArgument],
    ) -> Outcome<[f64; N]> {
        let mut values = [0.0; N];
        for (slot, argument) in values.iter_mut().zip(arguments) {
            *slot = self.argument(host, argument)?.map_or(Ok(0.0), |value| number(&value))?;
        }
        Ok(values)
    }

    /// Puts rows into a table as far as it has room, and their number into a variable.
    fn fill(
        &mut self,
        host: &mut dyn InterpreterHost,
        (count, table): (&VariableElement, &VariableElement),
        rows: &[[f64; COLUMNS]],
        factor: f64,
    ) -> Outcome<()> {
        let values = rows.iter().flat_map(|[kind, places @ ..]| {
            std::iter::once(*kind).chain(places.iter().map(move |place| place / factor))
        });
        let room = table.count.saturating_sub(table.at);
        for (step, value) in values.take(room).enumerate() {
            self.store(host, &table.element(step), Data::Real(value))?;
        }
        self.store(host, count, Data::Int(i64::try_from(rows.len()).unwrap_or(i64::MAX)))
    }

    /// Number of pieces, and the pieces as far as the table has room; the first row is where the contour begins. A
    /// third number moves them to the left, below zero to the right; -1 pieces if that is not possible.
    fn pieces(&mut self, host: &mut dyn InterpreterHost, arguments: &[SiemensArgument]) -> Outcome<()> {
        let [count, table] = self.targets(host, arguments)?;
        let by = match arguments.get(2) {
            Some(argument) => self.argument(host, argument)?.map_or(Ok(0.0), |value| number(&value))?,
            None => 0.0,
        };
        let mut rows: Vec<[f64; COLUMNS]> = Vec::new();
        // The program counts in its own unit.
        let factor = host.length_factor();
        let moved = if by == 0.0 {
            Some(host.contour().to_vec())
        } else {
            shifted(host.contour(), by.signum(), by.abs() * factor)
        };
        let Some(contour) = moved else { return self.store(host, &count, Data::Int(-1)) };
        for element in &contour {
            if rows.is_empty() {
                rows.push([0.0, element.from[0], element.from[1], 0.0, 0.0]);
            }
            rows.push(row(element));
        }
        let pieces = i64::try_from(contour.len()).unwrap_or(i64::MAX);
        self.fill(host, (&count, &table), &rows, factor)?;
        self.store(host, &count, Data::Int(pieces))
    }

    /// Removes stock along the contour that was read.
    fn strip(&mut self, host: &mut dyn InterpreterHost, arguments: &[SiemensArgument]) -> Outcome<()> {
        let mut values = [0.0; 16];
        if !(15..=values.len()).contains(&arguments.len()) {
            return syntax("SC_STRIP needs 15 or 16 numbers");
        }
        for (slot, argument) in values.iter_mut().zip(arguments) {
            *slot = self.argument(host, argument)?.map_or(Ok(0.0), |value| number(&value))?;
        }
        let [kind, face, inside, depth, z, x, around, lift, rounds, pause, way, first, into, along, clearance, plunges] =
            values;
        let unit = host.length_factor();
        host.remove_stock(Strip {
            rough: kind == 1.0 || kind == 3.0,
            finish: kind >= 2.0,
            face: face != 0.0,
            inside: inside != 0.0,
            depth: depth * unit,
            allowance: [z * unit, x * unit],
            around: around * unit,
            lift: lift * unit,
            rounds: rounds != 0.0,
            pause: [pause, way * unit],
            feeds: [first * unit, into * unit, along * unit],
            clearance,
            plunges: plunges * unit,
        });
        Ok(())
    }
}

/// Paths as rows of a table, each after a row of kind 0 with its beginning.
fn passes(ways: &[Vec<Element>]) -> Vec<[f64; COLUMNS]> {
    let begin = |way: &[Element]| way.first().map(|first| [0.0, first.from[0], first.from[1], 0.0, 0.0]);
    ways.iter().flat_map(|way| begin(way).into_iter().chain(way.iter().map(row))).collect()
}

/// A piece as a row of a table.
fn row(element: &Element) -> [f64; COLUMNS] {
    let [end, second] = element.to;
    match &element.arc {
        None => [1.0, end, second, 0.0, 0.0],
        Some(arc) => [if arc.sweep < 0.0 { 2.0 } else { 3.0 }, end, second, arc.center[0], arc.center[1]],
    }
}

/// A file stored with the machine.
fn is_stored(files: &[String], file: FileId) -> bool {
    files.get(usize::from(file)).is_some_and(|name| name.starts_with(StoredFile::ROOT))
}
