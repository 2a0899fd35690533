//! Cycles: CYCL DEF of both kinds.
//!
//! Facts: Heidenhain pre-processor pages and release notes (cycles as subprograms of the machine by
//! `$FCEPP('CYCLEDEF',…)`, KEEPCYCLDEFQVARS, cycle 12), programming manuals. Decisions: the tables of the machine
//! define the action of a cycle. They get `CYCL DEF` with its number and, for cycles of several lines, the words of all
//! lines. Invariant: titles are texts for people and never reach the tables.

use counterpoint_control_api::host::{InterpreterHost, ProgramPlace};
use counterpoint_control_api::words::part;
use counterpoint_event::FileId;
use counterpoint_fault as diag;
use counterpoint_fault::Halt;

use super::cycle_reader::head;
use super::cycle_state::DefinedCycle;
use super::eval::Evaluator;
use super::foreign_axes::refuse_axes_of_cycle;
use super::lex::HeidenhainCursor;
use super::moves::RAPID;
use super::q_parameter::{ParameterKind, ParameterValue, QParameter};
use super::statement::HeidenhainStatement;
use super::words::{EvaluatedWord, HeidenhainWord, LeftBlock};
use super::{Heidenhain, HeidenhainLine, old};

/// Cycles of one value, which the machine has under a name: dwell and orientation. Programs name it in the language of
/// the control.
const VALUES: [(u32, &str); 2] = [(9, "DWELL"), (13, "ANGLE")];

/// Gives the value of a cycle, which is at the end, its name.
fn named(seen: &mut Vec<EvaluatedWord>, name: &str) {
    if let Some(value) = seen.iter().skip(1).rev().find_map(|word| word.value) {
        seen.truncate(1);
        seen.push(EvaluatedWord::made(name, value));
    }
}

/// The text of a block that has been read.
fn text_of(host: &dyn InterpreterHost, (file, at): (FileId, u32), line: &HeidenhainLine) -> String {
    match &line.joined {
        Some(joined) => joined.to_string(),
        None => host.source(file).map_or_else(String::new, |source| part(source.line(at), line.place).into_owned()),
    }
}

/// The parameter that a word of a cycle sets.
pub(super) fn parameter_of(name: &str) -> Option<super::q_parameter::QParameter> {
    super::formula::parameter(&mut HeidenhainCursor::new(name.strip_suffix('=')?))
}

/// Cycles that act where they are defined.
const ACT_AT_ONCE: [u32; 14] = [7, 8, 9, 10, 11, 13, 14, 19, 20, 26, 30, 32, 239, 247];

/// Parameters at the end of a definition in newer software, with their values if the definition omits them.
const APPENDED: [(u32, &[(u32, f64)]); 22] = [
    (22, &[(18, 0.0), (19, 0.0), (208, RAPID)]),
    (23, &[(208, RAPID)]),
    (24, &[(14, 0.0)]),
    (200, &[(395, 0.0)]),
    (202, &[(357, 0.2)]),
    (203, &[(395, 0.0)]),
    (205, &[(395, 0.0), (208, RAPID)]),
    (208, &[(351, 1.0)]),
    (209, &[(403, 1.0)]),
    (225, &[(202, 0.0), (367, 0.0), (574, 0.0)]),
    (241, &[(401, 100.0), (202, 0.0), (212, 0.0), (205, 0.0)]),
    (251, &[(385, 0.0), (439, 0.0)]),
    (252, &[(385, 0.0), (439, 0.0)]),
    (253, &[(385, 0.0), (439, 0.0)]),
    (254, &[(385, 0.0), (439, 0.0)]),
    (256, &[(437, 0.0), (215, 1.0), (369, 0.0), (338, 0.0), (385, 0.0)]),
    (257, &[(376, -1.0), (215, 1.0), (369, 0.0), (338, 0.0), (385, 0.0)]),
    (262, &[(512, 0.0)]),
    (271, &[(578, 0.2), (569, 0.0)]),
    (272, &[(576, 0.0), (579, 1.0), (575, 0.0)]),
    (275, &[(369, 0.0), (439, 0.0)]),
    (276, &[(18, 0.0), (446, 0.01), (447, 10.0), (448, 2.0)]),
];

/// Parameters that stand as a word: MAX and FMAX are rapid, AUTO is the feed of TOOL CALL, PREDEF the value of GLOBAL
/// DEF.
fn with_words(seen: &mut Vec<EvaluatedWord>, tool_feed: Option<&EvaluatedWord>, global: &[(QParameter, f64)]) {
    let feed = tool_feed.and_then(|feed| feed.value);
    let mut at = 0;
    while at + 1 < seen.len() {
        let of_global = || {
            let name = parameter_of(&seen.get(at)?.name)?;
            global.iter().find(|(of, _)| *of == name).map(|(_, value)| *value)
        };
        let value = seen.get(at + 1).and_then(|word| match &*word.name {
            "MAX" | "FMAX" => Some(RAPID),
            "AUTO" | "FAUTO" => feed,
            "PREDEF" => of_global(),
            _ => None,
        });
        if let (Some(word), Some(value)) = (seen.get_mut(at), value)
            && word.value.is_none()
            && parameter_of(&word.name).is_some()
        {
            *word = EvaluatedWord::made(&word.name, value);
            seen.remove(at + 1);
        }
        at += 1;
    }
}

/// Gives the text parameters of a definition their texts.
fn take_texts(evaluator: &mut Evaluator<'_>, seen: &mut Vec<EvaluatedWord>) -> Result<(), Halt> {
    let is_text = |word: &EvaluatedWord| parameter_of(&word.name).is_some_and(|name| name.kind == ParameterKind::Text);
    while let Some(at) = seen.iter().position(|word| is_text(word) && word.value.is_none())
        && let Some(quoted) = seen.get(at + 1).map(EvaluatedWord::own_text)
        && let Some(text) = quoted.strip_prefix('"').and_then(|text| text.strip_suffix('"'))
        && let Some(name) = seen.get(at).and_then(|word| parameter_of(&word.name))
    {
        evaluator.assign(name, ParameterValue::Text(text.into()))?;
        seen.drain(at..at + 2);
    }
    Ok(())
}

impl Heidenhain {
    /// A cycle with its parameters.
    pub(super) fn define_cycle(
        &mut self,
        host: &mut dyn InterpreterHost,
        words: &[HeidenhainWord],
        place: ProgramPlace,
    ) -> Result<Vec<LeftBlock>, Halt> {
        let mut evaluator = Evaluator::new(&mut self.variables, host);
        let mut seen = evaluator.seen(words)?;
        take_texts(&mut evaluator, &mut seen)?;
        with_words(&mut seen, self.path.rates.of_tool.as_ref(), &self.cycles.global);
        let number = seen.first().and_then(|word| word.value).unwrap_or(0.0) as u32;
        let empty = seen.iter().find(|word| parameter_of(&word.name).is_some() && word.value.is_none());
        if let Some(word) = empty.filter(|_| self.settings.cycles.contains(&number)) {
            let text = format!(
                "{} has no value in '{}'; write a number, MAX, AUTO, or PREDEF after a GLOBAL DEF that says it",
                word.name.trim_end_matches('='),
                evaluator.host.block_text()
            );
            return Err(evaluator.host.alarm(&diag::STATEMENT_UNKNOWN, text));
        }
        for word in &seen {
            if let (Some(name), Some(value)) = (parameter_of(&word.name), word.value) {
                evaluator.assign(name, ParameterValue::Number(value))?;
            }
        }
        let appended = APPENDED.iter().filter(|(cycle, _)| *cycle == number).flat_map(|(_, appended)| *appended);
        let inches = evaluator.host.length_factor();
        for &(index, value) in appended {
            // The path off the wall is a length of its own, 0.2 mm.
            let value = if (number, index) == (202, 357) { value / inches } else { value };
            let is = |word: &EvaluatedWord| {
                parameter_of(&word.name).is_some_and(|name| name == QParameter { kind: ParameterKind::Q, index })
            };
            if !seen.iter().any(is) {
                evaluator.assign(QParameter { kind: ParameterKind::Q, index }, ParameterValue::Number(value))?;
            }
        }
        if matches!(number, 220 | 221) && self.settings.cycles.contains(&number) {
            return self.point_cycle(host, number, place);
        }
        if matches!(number, 20 | 270 | 271) && self.settings.cycles.contains(&number) {
            self.cycles.contours.train |= number == 270;
            return Ok(Vec::new());
        }
        let mut before = self.shifts.define(host, number, &mut Vec::new());
        if self.settings.cycles.contains(&number) {
            self.cycles.defined =
                DefinedCycle { program: Some(number.to_string().into()), stored: true, ..DefinedCycle::default() };
            return Ok(Vec::new());
        }
        if !ACT_AT_ONCE.contains(&number) {
            self.cycles.defined = DefinedCycle::default();
        }
        let keeps = self.settings.keeps;
        let stays = |word: &EvaluatedWord| {
            parameter_of(&word.name).is_none() || keeps.unwrap_or_else(|| host.is_register(&word.name))
        };
        before.push(seen.into_iter().filter(stays).collect());
        Ok(before)
    }

    /// A cycle of several lines: those that follow belong to it.
    pub(super) fn define_by_parts(
        &mut self,
        host: &mut dyn InterpreterHost,
        line: &HeidenhainLine,
        place: ProgramPlace,
    ) -> Result<Vec<LeftBlock>, Halt> {
        let HeidenhainStatement::CyclePart { cycle, part, words, text } = &line.statement else {
            return Ok(Vec::new());
        };
        let mut all = vec![head(*cycle)];
        let mut program = None;
        let mut lines = Vec::new();
        let mut source = String::new();
        let mut add = |part: u32, words: &[HeidenhainWord], text: &str, before: usize| {
            if part > 0 {
                lines.push((part, all.len()));
                all.extend(words.iter().map(|word| word.further(before)));
                program = text.strip_prefix("PGM").map(|name| name.trim().to_owned()).or(program.take());
            }
        };
        add(*part, words, text, 0);
        let mut next = line.next;
        while place.as_read && next <= place.range.last {
            let Ok(more) = self.line(host, next) else { break };
            match &more.statement {
                HeidenhainStatement::CyclePart { cycle: same, part, words, text } if same == cycle && *part > 0 => {
                    if source.is_empty() {
                        source = text_of(host, (place.file, place.line), line);
                    }
                    source.push(' ');
                    add(*part, words, text, source.len());
                    source.push_str(&text_of(host, (place.file, next), &more));
                }
                HeidenhainStatement::Nothing => {}
                _ => break,
            }
            next = more.next;
        }
        if next > line.next {
            host.go_to(next)?;
        }
        self.lines.taken = Some(source).filter(|source| !source.is_empty());
        if *cycle == 12 {
            let Some(program) = program.filter(|name| !name.is_empty()) else {
                let text = format!("cycle 12 names no program in '{}'", host.block_text());
                return Err(host.alarm(&diag::STATEMENT_UNKNOWN, text));
            };
            let name = match super::formula::parameter(&mut HeidenhainCursor::new(&program)) {
                Some(name) => match Evaluator::new(&mut self.variables, host).value_or_kept(name)? {
                    Some(ParameterValue::Text(text)) => text,
                    _ => program.as_str().into(),
                },
                None => program.trim_matches('"').into(),
            };
            self.cycles.defined = DefinedCycle { program: Some(name), ..DefinedCycle::default() };
            return Ok(Vec::new());
        }
        if !ACT_AT_ONCE.contains(cycle) {
            self.cycles.defined = DefinedCycle::default();
        }
        let mut seen = Evaluator::new(&mut self.variables, host).seen(&all)?;
        if *cycle == 7
            && let Some(row) = seen.iter().find(|word| word.is("#")).and_then(|word| word.value)
        {
            seen.truncate(1);
            seen.extend(self.datum_row(host, row, None)?);
        }
        if *cycle == 14 && self.settings.cycles.contains(cycle) {
            self.name_contours(host, &seen);
            return Ok(Vec::new());
        }
        if self.settings.cycles.contains(cycle) {
            let ends = lines.iter().skip(1).map(|(_, begin)| *begin).chain([seen.len()]);
            let lines =
                lines.iter().zip(ends).map(|(&(part, begin), end)| (part, seen.get(begin..end).unwrap_or_default()));
            self.define_old(*cycle, lines);
            return Ok(Vec::new());
        }
        refuse_axes_of_cycle(host, *cycle, &seen)?;
        if let Some((_, name)) = VALUES.iter().find(|(of, _)| of == cycle) {
            named(&mut seen, name);
        }
        if *cycle == 7 {
            self.take_shifts(&seen);
        }
        let mut before = self.shifts.define(host, *cycle, &mut seen);
        if *cycle == 19
            && let Some(blocks) = self.plane_cycle(host, &seen)
        {
            return Ok(blocks);
        }
        before.push(seen);
        Ok(before)
    }

    /// A cycle of several lines that is a program, with the values of its lines.
    pub(super) fn define_old<'s>(&mut self, cycle: u32, lines: impl Iterator<Item = (u32, &'s [EvaluatedWord])>) {
        self.cycles.old = old::data(cycle, lines, self.path.plane);
        self.cycles.defined =
            DefinedCycle { program: Some(cycle.to_string().into()), stored: true, ..DefinedCycle::default() };
    }

    /// GLOBAL DEF: sets the values of PREDEF in later definitions.
    pub(super) fn define_globally(
        &mut self,
        host: &mut dyn InterpreterHost,
        words: &[HeidenhainWord],
    ) -> Result<(), Halt> {
        let mut seen = Evaluator::new(&mut self.variables, host).seen(words)?;
        with_words(&mut seen, self.path.rates.of_tool.as_ref(), &[]);
        for word in seen {
            let (Some(name), Some(value)) = (parameter_of(&word.name), word.value) else { continue };
            self.cycles.global.retain(|(of, _)| *of != name);
            self.cycles.global.push((name, value));
        }
        Ok(())
    }
}
