//! ISO programs on machines that have only conversational words: a block is converted to the equivalent
//! conversational blocks.
//!
//! Facts: programming manuals of the control (DIN/ISO): G words of the path with their modes, G90 and G91, T with
//! the tool axis, and the G words of cycles, labels and programs, each with its conversational form. Decisions: a
//! block without a motion word repeats the last one where it names an axis, R or H; a block with T makes no move.
//! Invariant: a block is either turned into such blocks or an alarm.

use counterpoint_control_api::host::{InterpreterHost, ProgramPlace};
use counterpoint_event::FileId;
use counterpoint_fault::Halt;

use super::formula::{Formula, HeidenhainOp};
use super::lex::HeidenhainCursor;
use super::path_state::{PathBlockKind, axis};
use super::statement::{CycleCallForm, HeidenhainStatement};
use super::words::{EvaluatedWord, HeidenhainWord, LeftBlock, Operand, shown};
use super::{Heidenhain, HeidenhainLine, formula, iso_cycles};

/// Modes of an ISO program.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct IsoModes {
    motion: Option<u32>,
    increments: bool,
    clockwise: bool,
    /// Whether the previous block has used the G26 after it.
    pub(super) softened: bool,
    /// Radius of G27, until the block that leaves the contour.
    pub(super) leaves: Option<f64>,
    /// Whether the current file is an ISO program.
    file: Option<(FileId, bool)>,
}

/// A path block: its shape and its words.
pub(super) type Element = (PathBlockKind, Vec<HeidenhainWord>);

/// G words that only set a mode.
fn is_mode(g: u32) -> bool {
    matches!(g, 0..=3 | 5..=7 | 10..=13 | 15 | 16 | 17..=19 | 40..=42 | 90 | 91)
}

fn bare(name: &str) -> HeidenhainWord {
    HeidenhainWord::made(name, Operand::None)
}

fn valued(name: &str, value: f64) -> HeidenhainWord {
    HeidenhainWord::made(name, Operand::Number(shown(value).into(), value))
}

fn renamed(word: &HeidenhainWord, name: &str) -> HeidenhainWord {
    HeidenhainWord { span: word.span, ..HeidenhainWord::made(name, word.operand.clone()) }
}

fn has_value(word: &HeidenhainWord) -> bool {
    !matches!(word.operand, Operand::None | Operand::Sign(_))
}

/// The numbers of the G words, and the other words; none where a G word has no plain number.
fn split(words: &[HeidenhainWord]) -> Option<(Vec<u32>, Vec<HeidenhainWord>)> {
    let (mut numbers, mut others) = (Vec::new(), Vec::new());
    for word in words {
        match &word.operand {
            Operand::Number(_, value) if &*word.name == "G" && value.fract() == 0.0 => numbers.push(*value as u32),
            _ if &*word.name == "G" => return None,
            _ => others.push(word.clone()),
        }
    }
    Some((numbers, others))
}

/// Name of a word with a position, in increments or not.
fn position(name: &str, increments: bool) -> Option<String> {
    axis(name).filter(|(_, incremental)| !incremental)?;
    Some(if increments { format!("I{name}") } else { name.to_owned() })
}

impl IsoModes {
    /// The path blocks of a block with these G words, and the modes after it.
    pub(super) fn elements(&mut self, numbers: &[u32], words: &[HeidenhainWord]) -> Vec<Element> {
        let mut own = None;
        for &number in numbers {
            match number {
                0..=3 | 5..=7 | 10..=13 | 15 | 16 => own = Some(number),
                90 => self.increments = false,
                91 => self.increments = true,
                _ => {}
            }
        }
        if own.is_some() {
            self.motion = own;
        }
        match self.motion {
            Some(2 | 12) => self.clockwise = true,
            Some(3 | 13) => self.clockwise = false,
            _ => {}
        }
        let others: Vec<HeidenhainWord> =
            words.iter().filter(|word| !matches!(&*word.name, "I" | "J" | "K")).cloned().collect();
        if let Some(shape) = numbers.iter().find_map(|number| match number {
            24 => Some(PathBlockKind::Chamfer),
            25 => Some(PathBlockKind::Round),
            _ => None,
        }) {
            return vec![(shape, others)];
        }
        let mut elements = Vec::new();
        if numbers.contains(&29) {
            elements.push((PathBlockKind::Pole, Vec::new()));
        }
        let center = |word: &HeidenhainWord| {
            let at = ["I", "J", "K"].iter().position(|name| *word.name == **name).filter(|_| has_value(word))?;
            Some(renamed(word, &position(["X", "Y", "Z"].get(at)?, self.increments)?))
        };
        let center: Vec<HeidenhainWord> = words.iter().filter_map(center).collect();
        let centers = !center.is_empty();
        if centers {
            elements.push((PathBlockKind::Pole, center));
        }
        let moves = others.iter().any(|word| has_value(word) && axis(&word.name).is_some());
        let polar = others.iter().any(|word| has_value(word) && matches!(&*word.name, "R" | "H"));
        let compensation = numbers.iter().find_map(|number| match number {
            40 => Some(valued("R", 0.0)),
            41 => Some(bare("RL")),
            42 => Some(bare("RR")),
            _ => None,
        });
        let Some(mode) = self.motion.filter(|_| moves || polar || centers && own.is_some()) else {
            let left: Vec<HeidenhainWord> = others.into_iter().chain(compensation).collect();
            if !left.is_empty() {
                elements.push((PathBlockKind::Iso, left));
            }
            return elements;
        };
        let shape = match mode {
            2 | 3 | 5 if others.iter().any(|word| &*word.name == "R") => PathBlockKind::Radius,
            2 | 3 | 5 => PathBlockKind::Arc,
            6 => PathBlockKind::Tangent,
            10 | 11 if polar || !moves => PathBlockKind::PolarLine,
            12 | 13 | 15 if polar || !moves => PathBlockKind::PolarArc,
            16 => PathBlockKind::PolarTangent,
            _ => PathBlockKind::Line,
        };
        let is_polar =
            matches!(shape, PathBlockKind::PolarLine | PathBlockKind::PolarArc | PathBlockKind::PolarTangent);
        let mut made = Vec::with_capacity(others.len() + 2);
        for word in &others {
            let name = match &*word.name {
                "R" if is_polar => Some(if self.increments { "IPR" } else { "PR" }.to_owned()),
                "H" if is_polar => Some(if self.increments { "IPA" } else { "PA" }.to_owned()),
                name if has_value(word) => position(name, self.increments),
                _ => None,
            };
            made.push(name.map_or_else(|| word.clone(), |name| renamed(word, &name)));
        }
        if matches!(shape, PathBlockKind::Arc | PathBlockKind::Radius | PathBlockKind::PolarArc) {
            made.push(HeidenhainWord::made("DR", Operand::Sign(if self.clockwise { '-' } else { '+' })));
        }
        made.extend(compensation);
        if matches!(mode, 0 | 10) {
            made.push(bare("FMAX"));
        }
        elements.push((shape, made));
        elements
    }
}

impl IsoModes {
    /// The path blocks of a block as it was read; none if it is not a path block.
    pub(super) fn read(&mut self, words: &[HeidenhainWord]) -> Option<Vec<Element>> {
        let (numbers, others) = split(words)?;
        Some(self.elements(&numbers, &others))
    }
}

/// The values after P01, P02 and so on.
fn numbered(seen: &[EvaluatedWord]) -> Vec<(u32, f64)> {
    let mut out = Vec::new();
    for pair in seen.windows(2) {
        let [place, value] = pair else { continue };
        let (true, Some(number), Some(size)) = (place.is("P"), place.value, value.value) else { continue };
        match &*value.name {
            "" | "+" => out.push((number as u32, size)),
            "-" => out.push((number as u32, -size)),
            _ => {}
        }
    }
    out
}

impl Heidenhain {
    /// Whether the current program is an ISO program and the machine has no G words for it.
    pub(super) fn is_translated(&mut self, host: &dyn InterpreterHost) -> bool {
        if host.is_register("G") {
            return false;
        }
        let file = host.place().file;
        if let Some((known, is)) = self.modes.file
            && known == file
        {
            return is;
        }
        let is = self.is_iso(host);
        self.modes.file = Some((file, is));
        is
    }

    /// A block of an ISO program, as its conversational blocks.
    pub(super) fn iso_block(
        &mut self,
        host: &mut dyn InterpreterHost,
        words: &[HeidenhainWord],
        line: &HeidenhainLine,
        place: ProgramPlace,
    ) -> Result<Vec<LeftBlock>, Halt> {
        let Some((numbers, others)) = split(words) else { return Err(self.not_understood(host)) };
        let mut functions = numbers.iter().copied().filter(|number| !is_mode(*number));
        let (function, further) = (functions.next(), functions.next());
        if further.is_some() {
            return Err(self.not_understood(host));
        }
        let tool_axis = numbers.iter().find_map(|number| match number {
            17 => Some("Z"),
            18 => Some("Y"),
            19 => Some("X"),
            _ => None,
        });
        let tool = others.iter().position(|word| &*word.name == "T");
        match function {
            None | Some(24 | 25 | 29) => {}
            Some(function) => {
                let mut quiet = self.modes;
                quiet.elements(&numbers, &[]);
                self.modes = quiet;
                return self.iso_function(host, function, others, line, place);
            }
        }
        if let Some(at) = tool {
            if others.iter().any(|word| has_value(word) && axis(&word.name).is_some()) {
                return Err(self.not_understood(host));
            }
            let Some((tool, others)) = tool_of(others, at) else { return Err(self.not_understood(host)) };
            let words: Vec<HeidenhainWord> = tool_axis.map(bare).into_iter().chain(others).collect();
            self.modes.elements(&numbers, &[]);
            return self.call_tool(host, Some(&tool), &words);
        }
        let mut modes = self.modes;
        let elements = modes.elements(&numbers, &others);
        self.modes = modes;
        let mut blocks = Vec::new();
        if let Some(axis) = tool_axis {
            blocks.extend(self.call_tool(host, None, &[bare(axis)])?);
        }
        for (shape, words) in self.softened(host, elements, line, place)? {
            blocks.extend(match shape {
                PathBlockKind::Iso => self.plain(host, &words)?,
                shape => self.path(host, (shape, false, &words), line, place)?,
            });
        }
        Ok(blocks)
    }

    /// A block with a G word that is not a path mode.
    fn iso_function(
        &mut self,
        host: &mut dyn InterpreterHost,
        function: u32,
        others: Vec<HeidenhainWord>,
        line: &HeidenhainLine,
        place: ProgramPlace,
    ) -> Result<Vec<LeftBlock>, Halt> {
        let increments = self.modes.increments;
        let is_foreign = |word: &HeidenhainWord| has_value(word) && axis(&word.name).is_some();
        if matches!(function, 4 | 36 | 51 | 62 | 72 | 73 | 99) && others.iter().any(is_foreign) {
            return Err(self.not_understood(host));
        }
        let of = |from: &str, to: &str| {
            others.iter().filter(|word| *word.name == *from).map(|word| renamed(word, to)).collect()
        };
        let (cycle, words): (u32, Vec<HeidenhainWord>) = match function {
            // The blank.
            30 | 31 => return Ok(Vec::new()),
            4 => (9, of("F", "DWELL")),
            36 => (13, of("S", "ANGLE")),
            72 => (11, of("F", "SCL")),
            73 => (10, of("H", if increments { "IROT" } else { "ROT" })),
            28 => (8, others),
            54 => {
                let moved = |word: &HeidenhainWord| match position(&word.name, increments) {
                    Some(name) => renamed(word, &name),
                    None => word.clone(),
                };
                (7, others.iter().map(moved).collect())
            }
            62 => (32, others.into_iter().filter(|word| &*word.name == "T").collect()),
            80 => (19, others),
            53 => {
                let values = self.values_of(host, &others)?;
                let Some((_, row)) = values.first() else { return Err(self.not_understood(host)) };
                (7, vec![valued("#", *row)])
            }
            37 => {
                let values = self.values_of(host, &others)?;
                (14, values.into_iter().map(|(_, label)| valued("LABEL", label)).collect())
            }
            56..=59 | 74..=78 | 83..=86 => return self.old_iso_cycle(host, function, &others),
            26 | 27 => return self.soft_end(host, function, &others),
            38 => return self.stop(host, &others),
            79 => return self.call_cycle(host, (CycleCallForm::Here, &others), place),
            51 | 99 => {
                let Some(at) = others.iter().position(|word| &*word.name == "T") else {
                    return Err(self.not_understood(host));
                };
                let Some((tool, others)) = tool_of(others, at) else { return Err(self.not_understood(host)) };
                return self.define_tool(host, &tool, &others);
            }
            _ => return Err(self.not_understood(host)),
        };
        let statement = HeidenhainStatement::CyclePart { cycle, part: 1, words, text: String::new() };
        let line = HeidenhainLine { number: line.number, statement, place: line.place, joined: None, next: line.next };
        self.define_by_parts(host, &line, place)
    }

    fn values_of(&mut self, host: &mut dyn InterpreterHost, words: &[HeidenhainWord]) -> Result<Vec<(u32, f64)>, Halt> {
        Ok(numbered(&super::eval::Evaluator::new(&mut self.variables, host).seen(words)?))
    }

    /// A cycle whose values have numbers.
    fn old_iso_cycle(
        &mut self,
        host: &mut dyn InterpreterHost,
        function: u32,
        others: &[HeidenhainWord],
    ) -> Result<Vec<LeftBlock>, Halt> {
        let Some((cycle, lines)) = iso_cycles::lines(function) else { return Err(self.not_understood(host)) };
        if !self.settings.cycles.contains(&cycle) {
            return Err(self.not_understood(host));
        }
        let seen = super::eval::Evaluator::new(&mut self.variables, host).seen(others)?;
        let lines: Vec<(u32, Vec<EvaluatedWord>)> = iso_cycles::filled(lines, &seen);
        self.define_old(cycle, lines.iter().map(|(number, words)| (*number, words.as_slice())));
        Ok(Vec::new())
    }

    /// Number of the cycle that a G word of an ISO program defines: G200 is cycle 200, G120 is cycle 20.
    pub(super) fn iso_definition(words: &[HeidenhainWord]) -> Option<Vec<HeidenhainWord>> {
        let (first, parameters) = words.split_first()?;
        let number = match first.operand {
            Operand::Number(_, value) if &*first.name == "G" && value.fract() == 0.0 => value as u32,
            _ => return None,
        };
        let cycle = match number {
            120..=139 => number - 100,
            200..=299 => number,
            _ => return None,
        };
        Some(std::iter::once(super::cycle_reader::head(cycle)).chain(parameters.iter().cloned()).collect())
    }
}

/// The tool of T, and the remaining words.
fn tool_of(mut others: Vec<HeidenhainWord>, at: usize) -> Option<(Formula, Vec<HeidenhainWord>)> {
    let word = others.remove(at);
    let tool = match word.operand {
        Operand::Number(_, value) => formula::number(value),
        Operand::Parameter { negative: false, name } => Formula::own(HeidenhainOp::Variable(name)),
        Operand::None => {
            let name = HeidenhainCursor::new(&others.get(at)?.name).quoted().map(formula::text)?;
            others.remove(at);
            name
        }
        _ => return None,
    };
    Some((tool, others))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(modes: &mut IsoModes, text: &str) -> Vec<String> {
        let words = super::super::words::words(&mut HeidenhainCursor::new(text));
        let (numbers, others) = split(&words).unwrap();
        let shown = |word: &HeidenhainWord| match &word.operand {
            Operand::Number(text, _) => format!("{}{text}", word.name),
            Operand::Sign(sign) => format!("{}{sign}", word.name),
            _ => word.name.to_string(),
        };
        let line = |(shape, words): Element| {
            let head = shape.head();
            let words: Vec<String> = words.iter().map(shown).collect();
            [&[head.to_owned()][..], &words].concat().join(" ").trim().to_owned()
        };
        modes.elements(&numbers, &others).into_iter().map(line).collect()
    }

    #[test]
    fn blocks_become_conversational() {
        let mut modes = IsoModes::default();
        for (iso, conversational) in [
            ("G00 G40 G90 X+0 Y+10 M3", &["L X+0 Y+10 M3 R0 FMAX"][..]),
            ("Z-5", &["L Z-5 FMAX"]),
            ("G01 G41 X+5 F300", &["L X+5 F300 RL"]),
            ("G91 Y+5", &["L IY+5"]),
            ("G90 I+10 J+20", &["CC X+10 Y+20"]),
            ("G02 X+5 Y+3", &["C X+5 Y+3 DR-"]),
            ("G03 X+9 Y+3 R+4", &["CR X+9 Y+3 R+4 DR+"]),
            ("G02 I+1 J+2", &["CC X+1 Y+2", "C DR-"]),
            ("G05 X+1 Y+1", &["C X+1 Y+1 DR-"]),
            ("G06 X+2", &["CT X+2"]),
            ("G11 R+10 H+30", &["LP PR+10 PA+30"]),
            ("G10 G91 H+30", &["LP IPA+30 FMAX"]),
            ("G90 G13 H+90", &["CP PA+90 DR+"]),
            ("G16 R+10 H+0", &["CTP PR+10 PA+0"]),
            ("G25 R5", &["RND R5"]),
            ("G24 R2 F100", &["CHF R2 F100"]),
            ("G29", &["CC"]),
            ("G40 M5", &["M5 R0"]),
            ("M8", &["M8"]),
        ] {
            assert_eq!(read(&mut modes, iso), conversational, "{iso}");
        }
    }
}
