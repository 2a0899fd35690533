//! SL cycles: subprograms that are contours, and the requests of the cycle programs.
//!
//! `SL READ` records the contours that cycle 14 names, each with its side; `SL ROUGH`, `SL FLOOR`, `SL SIDE`, `SL
//! PILOT` and `SL TRAIN` leave the blocks of a cycle, with OLD those of cycles 6, 15 and 16, with OCM those of 272 to
//! 274; `SL SLOT` those of 275, `SL TRAIN 276` those of 276, `SL ROUND` those on a cylinder, `SL ENGRAVE` those of 225.
//! Facts: programming manuals of the control (the side of the compensation and the sense of the contour tell pockets
//! from islands; words of the tool axis do not count). Decision: a contour without compensation is a pocket.
//! *Invariant:* only programs stored with the machine have these statements.

use counterpoint_control_api::host::{InterpreterHost, ProgramPlace, SubprogramCall};
use counterpoint_fault as diag;
use counterpoint_fault::Halt;
use counterpoint_machine::stored::StoredFile;
use counterpoint_motion::contour::closed::ClosedContour;
use counterpoint_program::shape::ProgramRange;

use super::Heidenhain;
use super::flow::CalleeKind;
use super::moves::Moves;
use super::sl_contours::{AreaBoundary, ContourSource, ContourSubprogram, Contours, SlContour};
use super::statement::Label;
use super::tasks::{ContourParameters, ContourTools, OcmOperation};
use super::words::EvaluatedWord;

/// Most elements of all contours.
const MOST: usize = 1000;

impl Heidenhain {
    /// Cycle 14: `CONTOUR LABEL 1 /2 /3`.
    pub(super) fn name_contours(&mut self, host: &dyn InterpreterHost, seen: &[EvaluatedWord]) {
        let file = host.place().file;
        let values = seen.iter().filter(|word| word.is("LABEL") || word.is("/")).filter_map(|word| word.value);
        let of = |value: f64| ContourSource::Label(file, Label::Number(value as u32));
        let labels =
            values.map(|value| ContourSubprogram { source: of(value), is_pocket: None, depth: None }).collect();
        self.cycles.contours = Contours { labels, by_start: true, ..Contours::default() };
    }

    /// CONTOUR DEF: `P1 = LBL 1 I2 = "ISLAND" DEPTH5`; whether it is understood.
    pub(super) fn define_contours(&mut self, host: &dyn InterpreterHost, words: &[EvaluatedWord]) -> bool {
        let file = host.place().file;
        let mut labels = Vec::new();
        let mut words = words.iter().filter(|word| !word.reads("=")).peekable();
        while let Some(kind) = words.next() {
            let is_pocket = match &*kind.name {
                "P" | "P=" => true,
                "I" | "I=" => false,
                _ => return false,
            };
            let Some(named) = words.next() else { return false };
            let text = named.own_text();
            let source = match (text.strip_prefix('"'), named.value) {
                (Some(program), _) => ContourSource::Program(program.trim_end_matches('"').to_owned()),
                (None, Some(number)) if named.is("LBL") => ContourSource::Label(file, Label::Number(number as u32)),
                (None, None) if named.is("LBL") => match words.next().map(EvaluatedWord::own_text) {
                    Some(name) => ContourSource::Label(file, Label::Name(name.trim_matches('"').to_owned())),
                    None => return false,
                },
                _ => return false,
            };
            let depth = words.next_if(|word| matches!(&*word.name, "DEPTH" | "DEPTH=")).map(|word| word.value);
            if depth == Some(None) {
                return false;
            }
            // A depth of 0 is that of cycle 20.
            let depth = depth.flatten().map(f64::abs).filter(|depth| *depth > 0.0);
            labels.push(ContourSubprogram { source, is_pocket: Some(is_pocket), depth });
        }
        self.cycles.contours = Contours { labels, ..Contours::default() };
        true
    }

    /// A statement of the programs of SL cycles.
    pub(super) fn contour_statement(
        &mut self,
        host: &mut dyn InterpreterHost,
        what: &str,
        place: ProgramPlace,
    ) -> Result<Moves, Halt> {
        let stored = host.files().get(usize::from(place.file)).is_some_and(|name| name.starts_with(StoredFile::ROOT));
        if !stored {
            return Err(self.not_understood(host));
        }
        if matches!(what, "READ" | "READ ROUND") {
            self.cycles.contours.unrolled = None;
            if what == "READ ROUND"
                && let Err(why) = self.unroll(host)
            {
                let text = format!("{why}, in '{}'", host.block_text());
                return Err(host.alarm(&diag::STATEMENT_UNKNOWN, text));
            }
            return self.read_contours(host, place).map(|()| Moves::default());
        }
        // Areas look at each element beside each other one.
        let elements = self.cycles.contours.read.iter().map(|contour| contour.elements.len()).sum::<usize>().min(MOST);
        host.work(elements * elements)?;
        let made = match what {
            "ROUGH" => {
                let others = ContourTools { earlier: self.tool_before(18), ..ContourTools::default() };
                self.rough_out(host, &ContourParameters { others, ..self.task(host, self.sl(4), self.sl(3)) }, false)
            }
            "FLOOR" => self.rough_out(host, &self.task(host, 0.0, self.sl(3)), true),
            "SIDE" => self.finish_sides(host, &self.task(host, 0.0, self.sl(14))),
            "PILOT" => self.drill_pilots(host, &self.task(host, self.sl(4), self.sl(3))),
            "TRAIN" => self.follow_train(host),
            "TRAIN 276" => self.follow_in_space(host),
            "OCM ROUGH" => {
                self.adaptive_task(host, OcmOperation::Rough).and_then(|task| self.rough_out(host, &task, false))
            }
            "OCM FLOOR" => {
                self.adaptive_task(host, OcmOperation::Floor).and_then(|task| self.rough_out(host, &task, true))
            }
            "OCM SIDE" => self.adaptive_task(host, OcmOperation::Side).and_then(|task| self.finish_sides(host, &task)),
            "OCM CHAMFER" => {
                self.adaptive_task(host, OcmOperation::Chamfer).and_then(|task| self.finish_sides(host, &task))
            }
            "SLOT" => self.mill_slot(host),
            "ENGRAVE" => self.engrave(host),
            "ROUND 27" => self.round_cylinder(host, 27),
            "ROUND 28" => self.round_cylinder(host, 28),
            "ROUND 29" => self.round_cylinder(host, 29),
            "ROUND 39" => self.round_cylinder(host, 39),
            "OLD ROUGH" => self.rough_out(host, &self.old_task(host), false),
            "OLD SIDE" => self.finish_sides(host, &self.old_task(host)),
            "OLD PILOT" => self.drill_pilots(host, &self.old_task(host)),
            _ => return Err(self.not_understood(host)),
        };
        match made {
            Ok(moves) => Ok(moves),
            Err(why) => {
                let text = format!("{why}, in '{}'", host.block_text());
                Err(host.alarm(&diag::STATEMENT_UNKNOWN, text))
            }
        }
    }

    /// Records the contours one after the other; the block runs again until all are there.
    fn read_contours(&mut self, host: &mut dyn InterpreterHost, place: ProgramPlace) -> Result<(), Halt> {
        match self.cycles.contours.before.take() {
            None => self.cycles.contours.read.clear(),
            Some(before) => {
                let is_left = self.path.side.is_left;
                self.path = *before;
                self.cycles.contours.read.push(SlContour { elements: host.contour().to_vec(), is_left });
            }
        }
        let contours = &self.cycles.contours;
        let Some(ContourSubprogram { source, .. }) = contours.labels.get(contours.read.len()).cloned() else {
            if self.cycles.contours.labels.is_empty() {
                let text = "the cycle has no contour; program cycle 14 before it".to_owned();
                return Err(host.alarm(&diag::STATEMENT_UNKNOWN, text));
            }
            return Ok(());
        };
        let (name, found, kind) = match source {
            ContourSource::Label(file, label) => {
                let Some(line) = self.find_label_in(host, file, &label) else {
                    let text = format!("{label}, a contour of cycle 14, is not in the program");
                    return Err(host.alarm(&diag::JUMP_TARGET, text));
                };
                let last = host.source(file).map_or(line, |source| source.lines());
                (label.to_string(), (file, ProgramRange { number: None, first: line, last }), CalleeKind::Label)
            }
            ContourSource::Program(name) => {
                let Some(found) = self.find_program(host, &name, false)? else {
                    let text = format!("contour program '{name}' not found; add it to the job");
                    return Err(host.alarm(&diag::SUBPROGRAM_MISSING, text));
                };
                (name, found, CalleeKind::Program)
            }
        };
        self.cycles.contours.before = Some(Box::new(self.path.clone()));
        self.path.side.is_left = None;
        self.calling = Some(kind);
        self.lines.keeping = true;
        host.read_contour(SubprogramCall { name: name.into(), place: Some(found), passes: 1, closes: true });
        host.effect();
        host.go_to(place.line)
    }

    /// The contours as pockets and islands.
    pub(super) fn figures(&self) -> Result<Vec<AreaBoundary>, String> {
        let count = self.cycles.contours.read.iter().map(|contour| contour.elements.len()).sum::<usize>();
        if count > MOST {
            return Err(format!("the contours of cycle 14 have {count} elements, at most {MOST} are possible"));
        }
        let figures = self.cycles.contours.read.iter().enumerate().map(|(at, contour)| {
            let number = at + 1;
            let outline = ClosedContour::new(contour.elements.clone());
            let outline = outline.ok_or_else(|| format!("contour {number} of cycle 14 has no element"))?;
            let by_side = contour.is_left.is_none_or(|left| left != outline.is_clockwise());
            let named = self.cycles.contours.labels.get(at).and_then(|named| named.is_pocket);
            let is_pocket = named.unwrap_or(by_side);
            Ok(AreaBoundary { outline, is_pocket })
        });
        figures.collect()
    }

    /// The only contour.
    pub(super) fn only_contour(&self) -> Result<&SlContour, String> {
        match self.cycles.contours.read.as_slice() {
            [contour] if (1..=MOST).contains(&contour.elements.len()) => Ok(contour),
            [_] => Err(format!("the contour of cycle 14 has no element, or more than {MOST}")),
            _ => Err("a contour train has one contour in cycle 14".to_owned()),
        }
    }
}
