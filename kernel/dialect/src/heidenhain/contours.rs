//! SL cycles: subprograms that are contours, and what the programs of the cycles ask for.
//!
//! `SL READ` records the contours that cycle 14 names, each with its side; `SL ROUGH`, `SL FLOOR`, `SL SIDE`, `SL PILOT` and
//! `SL TRAIN` leave the blocks of a cycle, with OLD those of cycles 6, 15 and 16. Facts: programming manuals of the control (the side of the compensation and the sense of
//! the contour tell pockets from islands; words of the tool axis do not count). Decision: a contour without compensation is a
//! pocket. *Invariant:* only programs stored with the machine have these statements.

use counterpoint_event::FileId;
use counterpoint_fault as diag;
use counterpoint_fault::Halt;
use counterpoint_machine::stored::StoredFile;
use counterpoint_motion::contour::closed::Closed;
use counterpoint_motion::contour::element::Element;
use counterpoint_program::shape::Range;

use super::Heidenhain;
use super::flow::Kind;
use super::path::Path;
use super::statement::Label;
use super::words::Seen;
use crate::host::{Call, Host, Place};

/// Most elements of all contours.
const MOST: usize = 1000;

/// A contour that has been read.
#[derive(Debug, Clone)]
pub(super) struct Contour {
    pub(super) elements: Vec<Element>,
    /// The tool goes left of it.
    pub(super) is_left: Option<bool>,
}

/// A pocket or an island.
#[derive(Debug, Clone)]
pub(super) struct Figure {
    pub(super) outline: Closed,
    pub(super) is_pocket: bool,
}

/// A subprogram that is a contour.
#[derive(Debug, Clone)]
struct Named {
    file: FileId,
    label: Label,
    /// What CONTOUR DEF makes of it; in cycle 14 its side tells.
    is_pocket: Option<bool>,
}

/// The contours of cycle 14 or CONTOUR DEF.
#[derive(Debug, Default)]
pub(super) struct Contours {
    labels: Vec<Named>,
    /// Cycle 270 says how a train begins and ends.
    pub(super) train: bool,
    read: Vec<Contour>,
    /// A contour is being recorded; what the path was before.
    before: Option<Box<Path>>,
}

impl Contours {
    /// Bytes that they take, about.
    pub(super) fn bytes(&self) -> usize {
        self.read.iter().map(|contour| contour.elements.len() * size_of::<Element>()).sum::<usize>()
            + self.labels.len() * 60
    }
}

impl Heidenhain {
    /// Cycle 14: `CONTOUR LABEL 1 /2 /3`.
    pub(super) fn name_contours(&mut self, host: &dyn Host, seen: &[Seen]) {
        let file = host.place().file;
        let values = seen.iter().filter(|word| word.is("LABEL") || word.is("/")).filter_map(|word| word.value);
        let labels = values.map(|value| Named { file, label: Label::Number(value as u32), is_pocket: None }).collect();
        self.cycles.contours = Contours { labels, ..Contours::default() };
    }

    /// CONTOUR DEF: `P1 = LBL 1 I2 = LBL 2`; whether it is understood.
    pub(super) fn define_contours(&mut self, host: &dyn Host, words: &[Seen]) -> bool {
        let file = host.place().file;
        let mut labels = Vec::new();
        for part in words.chunks(3) {
            let (Some(kind), Some(sign), Some(label)) = (part.first(), part.get(1), part.get(2)) else { return false };
            let is_pocket = match &*kind.name {
                "P" => true,
                "I" => false,
                _ => return false,
            };
            let Some(number) = label.value.filter(|_| sign.text == "=" && label.is("LBL")) else { return false };
            labels.push(Named { file, label: Label::Number(number as u32), is_pocket: Some(is_pocket) });
        }
        self.cycles.contours = Contours { labels, ..Contours::default() };
        true
    }

    /// A statement of the programs of SL cycles.
    pub(super) fn contour_statement(
        &mut self,
        host: &mut dyn Host,
        what: &str,
        place: Place,
    ) -> Result<Option<String>, Halt> {
        let stored = host.files().get(usize::from(place.file)).is_some_and(|name| name.starts_with(StoredFile::ROOT));
        if !stored {
            return Ok(self.not_understood(host));
        }
        if what == "READ" {
            return self.read_contours(host, place).map(|()| None);
        }
        let made = match what {
            "ROUGH" if self.sl(18) != 0.0 => {
                Err("roughing after a larger tool (Q18) is not emulated: program Q18=0".to_owned())
            }
            "ROUGH" => self.rough_out(host, &self.task(self.sl(1) + self.sl(4), self.sl(3)), false),
            "FLOOR" => self.rough_out(host, &self.task(self.sl(1), self.sl(3)), true),
            "SIDE" => self.finish_sides(host, &self.task(self.sl(1), self.sl(14))),
            "PILOT" => self.drill_pilots(host, &self.task(self.sl(1) + self.sl(4), self.sl(3))),
            "TRAIN" => self.follow_train(host),
            "OLD ROUGH" => self.rough_out(host, &self.old_task(host), false),
            "OLD SIDE" => self.finish_sides(host, &self.old_task(host)),
            "OLD PILOT" => self.drill_pilots(host, &self.old_task(host)),
            _ => return Ok(self.not_understood(host)),
        };
        match made {
            Ok(blocks) => Ok(Some(blocks.join("\n"))),
            Err(why) => {
                let text = format!("{why}, in '{}'", host.block_text());
                Err(host.alarm(&diag::STATEMENT_UNKNOWN, text))
            }
        }
    }

    /// Records the contours one after the other; the block runs again until all are there.
    fn read_contours(&mut self, host: &mut dyn Host, place: Place) -> Result<(), Halt> {
        match self.cycles.contours.before.take() {
            None => self.cycles.contours.read.clear(),
            Some(before) => {
                let is_left = self.path.side.is_left;
                self.path = *before;
                self.cycles.contours.read.push(Contour { elements: host.contour().to_vec(), is_left });
            }
        }
        let contours = &self.cycles.contours;
        let Some(Named { file, label, .. }) = contours.labels.get(contours.read.len()).cloned() else {
            if self.cycles.contours.labels.is_empty() {
                let text = "the cycle has no contour; program cycle 14 before it".to_owned();
                return Err(host.alarm(&diag::STATEMENT_UNKNOWN, text));
            }
            return Ok(());
        };
        let Some(line) = self.find_label_in(host, file, &label) else {
            let text = format!("{label}, a contour of cycle 14, is not in the program");
            return Err(host.alarm(&diag::JUMP_TARGET, text));
        };
        self.cycles.contours.before = Some(Box::new(self.path.clone()));
        self.path.side.is_left = None;
        let last = host.source(file).map_or(line, |source| source.lines());
        let range = Range { number: None, first: line, last };
        self.calling = Some(Kind::Label);
        self.keeping = true;
        host.read_contour(Call { name: label.to_string().into(), place: Some((file, range)), passes: 1, closes: true });
        host.effect();
        host.go_to(place.line)
    }

    /// The contours as pockets and islands.
    pub(super) fn figures(&self) -> Result<Vec<Figure>, String> {
        let count = self.cycles.contours.read.iter().map(|contour| contour.elements.len()).sum::<usize>();
        if count > MOST {
            return Err(format!("the contours of cycle 14 have {count} elements, at most {MOST} are possible"));
        }
        let figures = self.cycles.contours.read.iter().enumerate().map(|(at, contour)| {
            let number = at + 1;
            let outline = Closed::new(contour.elements.clone());
            let outline = outline.ok_or_else(|| format!("contour {number} of cycle 14 has no element"))?;
            let by_side = contour.is_left.is_none_or(|left| left != outline.is_clockwise());
            let named = self.cycles.contours.labels.get(at).and_then(|named| named.is_pocket);
            let is_pocket = named.unwrap_or(by_side);
            Ok(Figure { outline, is_pocket })
        });
        figures.collect()
    }

    /// The only contour.
    pub(super) fn only_contour(&self) -> Result<&Contour, String> {
        match self.cycles.contours.read.as_slice() {
            [contour] if (1..=MOST).contains(&contour.elements.len()) => Ok(contour),
            [_] => Err(format!("the contour of cycle 14 has no element, or more than {MOST}")),
            _ => Err("a contour train has one contour in cycle 14".to_owned()),
        }
    }
}
