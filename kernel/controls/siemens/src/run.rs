//! A block, executed item by item.
//!
//! Facts: reference control-emulator.md 2.2 and 5.4. Statements act in the order in which they are written, words are
//! gathered and act after them; a call starts after the words. Invariant: text that is neither statement nor variable
//! nor subprogram is among the remaining words.

use std::sync::Arc;

use super::compiled::{Expression, IndexedName, SiemensArgument, as_name};
use super::coupled_spindles;
use super::expression::whole;
use super::item::{AssignmentValue, SiemensItem, SiemensLine};
use super::left::SiemensRemainder;
use super::line::read;
use super::places::{are_plain, leave_as_text, push_block_number};
use super::unknown_names::{lacks, limit, words_address};
use super::value::Data;
use super::{Outcome, Siemens, SiemensBlockError, needs_interpreter, syntax};
use counterpoint_control_api::host::{IdentificationAnswer, InterpreterHost, ProgramHost, SubprogramCall};
use counterpoint_control_api::interpreter::Remaining;
use counterpoint_control_api::text::without_comment;
use counterpoint_fault as diag;

/// Most passes of a call.
pub(super) const MOST_PASSES: i64 = 9_999;

/// Whether the rest of the block is executed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum BlockContinuation {
    Continue,
    Stop,
}

impl Siemens {
    /// Executes a block, whose bytes are `bytes`; returns its remaining words.
    pub(super) fn carry_out(
        &mut self,
        host: &mut dyn InterpreterHost,
        whole: &str,
        bytes: &[u8],
    ) -> Outcome<Remaining> {
        let Some(text) = skipped(host, whole) else { return Ok(Remaining::Nothing) };
        let place = host.place();
        if super::jumps::is_head(text) {
            return self.program_head(host).map(|()| Remaining::Nothing);
        }
        let kept = place.as_read && self.defines.is_empty();
        let line = match self.read.get((place.file, place.line)).filter(|_| kept) {
            Some(line) => Arc::clone(line),
            None => {
                let at_once = !whole.trim_start().starts_with('/');
                let start = whole.len() - text.len();
                let text = self.expanded(without_comment(text));
                let is_statement = at_once && needs_interpreter(whole.as_bytes());
                let mut line = read(&text).map(|line| SiemensLine { at_once, is_statement, ..line }.at(start));
                if let Ok(line) = &mut line
                    && !self.defines.is_empty()
                {
                    line.places.clear();
                }
                let line = Arc::new(line);
                if kept && place.repeats {
                    self.read.insert((place.file, place.line), &line, text.len());
                }
                line
            }
        };
        match &*line {
            Ok(line) => self.run(host, line, bytes),
            Err(text) => syntax(text.clone()),
        }
    }

    /// The block as it was read before, if it may act at once.
    #[inline]
    pub(super) fn read_before(&mut self, host: &dyn InterpreterHost) -> Option<Arc<Result<SiemensLine, String>>> {
        if !self.defines.is_empty() {
            return None;
        }
        let line = self.read.get(host.unchanged_line()?)?;
        line.as_ref().as_ref().is_ok_and(|line| line.at_once).then(|| Arc::clone(line))
    }

    /// The head of a program of an archive: the next one is not run into.
    fn program_head(&mut self, host: &mut dyn InterpreterHost) -> Outcome<()> {
        let place = host.place();
        let source = host.source(place.file);
        let is_first = source.is_none_or(|source| {
            (place.range.first..place.line).all(|line| source.line(line).iter().all(u8::is_ascii_whitespace))
        });
        if is_first { Ok(()) } else { Ok(host.go_to(place.range.last.saturating_add(1))?) }
    }

    pub(super) fn run(
        &mut self,
        host: &mut dyn InterpreterHost,
        line: &SiemensLine,
        text: &[u8],
    ) -> Outcome<Remaining> {
        let mut left = SiemensRemainder { speed_is_other: line.speed_is_other, ..SiemensRemainder::default() };
        self.test_actions(host, &mut left)?;
        let is_mode = |item: &&SiemensItem| matches!(item, SiemensItem::Text(text) if mode(text).is_some());
        if let Some(SiemensItem::Text(text)) = line.items.iter().rfind(is_mode) {
            left.relative = mode(text);
        }
        for (at, item) in line.items.iter().enumerate() {
            if let SiemensItem::Modal = item {
                self.set_modal(host, line.items.get(at + 1..).unwrap_or_default())?;
                break;
            }
            if at > 0 && matches!(item, SiemensItem::Declare(_) | SiemensItem::Header(_)) {
                return syntax("DEF and PROC stand at the beginning of a block (alarm 14500)");
            }
            let then = self.item(host, item, &mut left)?;
            left.places.put(left.words.len(), line.place(at));
            if then == BlockContinuation::Stop {
                break;
            }
        }
        if left.is_empty() && self.modal.is_none() {
            return Ok(Remaining::Nothing);
        }
        self.call_modally(host, &mut left);
        self.orient(host, &mut left)?;
        self.rewrite(host, &mut left)?;
        super::spindles::stop_once(&mut left);
        self.go_to_positions(host, &mut left)?;
        super::beside_words::check(&left.words, || super::system::plane(host))?;
        self.activate_frames(host, &left.words)?;
        self.finish(host, line, left, text)
    }

    fn finish(
        &mut self,
        host: &mut dyn InterpreterHost,
        line: &SiemensLine,
        mut left: SiemensRemainder,
        block: &[u8],
    ) -> Outcome<Remaining> {
        match left.call.take() {
            Some(call) => {
                let passes = left.passes.unwrap_or(call.passes);
                if passes == 0 {
                    return syntax("P of a call is 1 to 9999, not 0 (alarm 14013)");
                }
                host.call(SubprogramCall { passes, ..call });
            }
            None => {
                if let Some(word) = left.passes_word.take() {
                    left.add(&word);
                    let at = line.items.iter().position(|item| matches!(item, SiemensItem::Passes(..)));
                    left.places.put(left.words.len(), at.and_then(|at| line.place(at)));
                }
            }
        }
        let SiemensRemainder { before, words, places, .. } = left;
        let is_covered = places.are_words_of(&words, block);
        let is_plain = before.iter().all(|words| are_plain(words)) && (is_covered || are_plain(&words));
        if block.is_empty() || !is_plain {
            return Ok(leave_as_text(host, line, &before, &words));
        }
        for (at, own) in before.iter().enumerate() {
            if at > 0 {
                host.end_block();
            }
            places.push_made(host, &mut self.known.meanings, own, block);
        }
        if words.is_empty() {
            return Ok(if before.is_empty() { Remaining::Nothing } else { Remaining::Words });
        }
        if !before.is_empty() {
            host.end_block();
        }
        push_block_number(host, line, block);
        if is_covered {
            places.push(host, &words, block);
        } else {
            places.push_made(host, &mut self.known.meanings, &words, block);
        }
        Ok(Remaining::Words)
    }

    pub(super) fn item(
        &mut self,
        host: &mut dyn InterpreterHost,
        item: &SiemensItem,
        left: &mut SiemensRemainder,
    ) -> Outcome<BlockContinuation> {
        match item {
            SiemensItem::Text(text) => left.add(text),
            SiemensItem::Set { name, value } => self.set(host, name, value, left)?,
            SiemensItem::Bare(name) => self.bare_name(host, name, left)?,
            SiemensItem::Function(name, arguments) => self.function_block(host, name, arguments, left)?,
            SiemensItem::Passes(passes, word) => {
                let passes = self.whole_number(host, passes)?;
                if passes > MOST_PASSES {
                    return syntax(format!("{passes} passes are too many (maximum {MOST_PASSES}) (alarm 14013)"));
                }
                left.passes = Some(u32::try_from(passes).unwrap_or(0));
                left.passes_word = Some(word.clone());
            }
            SiemensItem::Program(name) => match self.known_program(host, name)? {
                Some(found) => left.call = Some(self.prepare_call(host, name, found, &[])?),
                None if self.settings.subprograms => left.call = Some(self.prepare_call(host, name, None, &[])?),
                None => left.add(name),
            },
            SiemensItem::CallText { name, section, arguments } => {
                return self.call_text(host, name, section.as_ref(), arguments, left);
            }
            SiemensItem::Modal => {}
            SiemensItem::Return(text, elsewhere) => {
                if !self.settings.subprograms {
                    left.add(text);
                    return Ok(BlockContinuation::Continue);
                }
                if self.variables.calls.in_part() {
                    let text = format!("'{}' ends a pass of the part that is repeated", host.block_text());
                    host.diagnose(&diag::SIEMENS_IGNORED, text);
                }
                if *elsewhere {
                    let text = format!("the target of RET is ignored in '{}'", host.block_text());
                    host.diagnose(&diag::SIEMENS_IGNORED, text);
                }
                host.return_from();
            }
            SiemensItem::Define(name, text) => {
                self.define(name, text);
                self.watch(host);
            }
            SiemensItem::Declare(declaration) => {
                self.check_first(host)?;
                self.declare(host, declaration, false)?;
            }
            SiemensItem::Redeclare(declaration) => self.declare(host, declaration, true)?,
            SiemensItem::Header(header) => self.take_arguments(host, header)?,
            SiemensItem::External(header) => {
                self.held.externals.insert(header.name.clone());
            }
            SiemensItem::Message(argument) => self.message(host, argument.as_ref(), left)?,
            SiemensItem::Synchronised(action) => self.synchronise(host, action)?,
            SiemensItem::Shared { text, .. } if host.is_code_text(text) => left.add(text),
            SiemensItem::Shared { statement, operands, .. } => {
                statement.execute(host, operands, |host, operand| match self.argument(host, operand)? {
                    Some(value) => super::conversions::number(&value),
                    None => syntax("an argument is missing"),
                })?;
            }
            _ => return self.flow(host, item, left),
        }
        Ok(BlockContinuation::Continue)
    }

    pub(super) fn set(
        &mut self,
        host: &mut dyn InterpreterHost,
        name: &IndexedName,
        value: &AssignmentValue,
        left: &mut SiemensRemainder,
    ) -> Outcome<()> {
        if self.set_r(host, name, value)? {
            return Ok(());
        }
        if name.name.starts_with('$') {
            return self.set_by_name(host, name, value, left);
        }
        if ("RG", 1) == (name.name.as_str(), name.index.len()) && !self.variables.knows("RG") {
            return self.set_global_parameter(host, name, value);
        }
        if let ("G", [group]) = (name.name.as_str(), name.index.as_slice()) {
            return self.indirect_function(host, group, value, left);
        }
        let is_parameter = name.name == "R" && !name.index.is_empty();
        let is_local = is_parameter || self.variables.knows(&name.name);
        let is_word = || name.name.len() == 1 || name.name == "AX" || words_address(host, &name.name);
        if !is_local && is_word() {
            return self.word(host, name, value, left);
        }
        match self.locate(host, name)? {
            Some(target) => self.assign(host, &target, value),
            None if self.positions(host, name, value, left)? => Ok(()),
            None => self.set_by_name(host, name, value, left),
        }
    }

    /// A system variable, or a name that is neither a variable nor an address.
    fn set_by_name(
        &mut self,
        host: &mut dyn InterpreterHost,
        name: &IndexedName,
        value: &AssignmentValue,
        left: &mut SiemensRemainder,
    ) -> Outcome<()> {
        let is_system = name.name.starts_with('$');
        let assigned = match value {
            AssignmentValue::One(value, _) if is_system => Some(self.evaluate(host, value)?),
            AssignmentValue::One(value, _) => self.quietly(|this| this.evaluate(host, value))?,
            _ => None,
        };
        let asked = self.written(host, name)?;
        let given = assigned.as_ref().map(Data::value);
        match self.ask(host, &asked, given.as_ref())? {
            IdentificationAnswer::Drop => Ok(()),
            IdentificationAnswer::Instead(text) => self.set_instead(host, &text, value, left),
            IdentificationAnswer::Keep => self.word(host, name, value, left),
            IdentificationAnswer::Unknown if is_system => {
                if let Some(assigned) = &assigned
                    && let Some(blocks) = self.set_system(host, name, assigned)?
                {
                    left.before.extend(blocks);
                    return Ok(());
                }
                Err(SiemensBlockError::Alarm(&diag::MACRO_VARIABLE, format!("the variable {asked} cannot be set")))
            }
            IdentificationAnswer::Unknown => match limit(&name.name) {
                Some(limit) => Err(SiemensBlockError::Alarm(&diag::SIEMENS_STATE, format!("{}: {limit}", name.name))),
                None => self.word(host, name, value, left),
            },
        }
    }

    /// A macro has named another variable, or given the text that is in the block.
    fn set_instead(
        &mut self,
        host: &mut dyn InterpreterHost,
        text: &str,
        value: &AssignmentValue,
        left: &mut SiemensRemainder,
    ) -> Outcome<()> {
        if let Ok(expression) = whole(text)
            && let Some(name) = as_name(&expression)
            && let Some(target) = self.locate(host, name)?
        {
            return self.assign(host, &target, value);
        }
        left.add(text.trim());
        Ok(())
    }

    /// A name alone: a literal code, a subprogram, or text.
    fn bare_name(&mut self, host: &mut dyn InterpreterHost, written: &str, left: &mut SiemensRemainder) -> Outcome<()> {
        let name = written.to_ascii_uppercase();
        if host.is_code_text(&name) {
            left.add(&name);
            return Ok(());
        }
        if let Some(found) = self.known_program(host, &name)? {
            left.call = Some(self.prepare_call(host, &name, found, &[])?);
            return Ok(());
        }
        if self.reset_orientation(host, &name, &[], left)? || self.master_spindle(host, &name, &[], left)? {
            return Ok(());
        }
        self.unknown(host, &name, written, left)
    }

    /// A name with arguments: SETAL, a subprogram, or text.
    fn function_block(
        &mut self,
        host: &mut dyn InterpreterHost,
        name: &str,
        arguments: &[SiemensArgument],
        left: &mut SiemensRemainder,
    ) -> Outcome<()> {
        if name == "SETAL" {
            return self.set_alarm(host, arguments);
        }
        if name == "FGROUP" {
            return self.feed_group(host, arguments);
        }
        let is_statement = self.coordination(host, name, arguments)?
            || self.contour_statement(host, name, arguments)?
            || self.preparation(host, name, arguments)?
            || self.records(host, name, arguments)?
            || self.waits_for_axes(host, name, arguments)?
            || self.cancel(host, name, arguments)?;
        if is_statement || self.reset_orientation(host, name, arguments, left)? {
            return Ok(());
        }
        if self.master_spindle(host, name, arguments, left)?
            || coupled_spindles::statement(self, host, name, arguments, left)?
        {
            return Ok(());
        }
        let is_text = host.is_code_text(name) || host.is_register(&format!("{name}("));
        if !is_text && let Some(found) = self.known_program(host, name)? {
            left.call = Some(self.prepare_call(host, name, found, arguments)?);
            return Ok(());
        }
        let text = format!("{name}({})", self.texts(host, arguments)?);
        if is_text {
            left.add(&text);
            return Ok(());
        }
        self.unknown(host, &text, &text, left)
    }

    /// A text that nothing knows: a macro may, otherwise the tables of the machine have to.
    fn unknown(
        &mut self,
        host: &mut dyn InterpreterHost,
        asked: &str,
        written: &str,
        left: &mut SiemensRemainder,
    ) -> Outcome<()> {
        if let Some(text) = lacks(host, asked) {
            return Err(SiemensBlockError::Halt(host.alarm(&diag::UNKNOWN_TEXT, text)));
        }
        match self.ask(host, asked, None)? {
            IdentificationAnswer::Drop => {}
            IdentificationAnswer::Instead(text) => return self.block_instead(host, &text, left),
            IdentificationAnswer::Unknown if super::words::begins_with_code(host, written) => {
                host.report_unrecognised(written)?
            }
            IdentificationAnswer::Keep | IdentificationAnswer::Unknown => left.add(written),
        }
        Ok(())
    }

    /// A macro has given a text for a part of the block; the macro is not asked about the content of that text.
    fn block_instead(
        &mut self,
        host: &mut dyn InterpreterHost,
        text: &str,
        left: &mut SiemensRemainder,
    ) -> Outcome<()> {
        let line = read(text).or_else(syntax)?;
        let before = std::mem::replace(&mut self.quiet, true);
        let done = line.items.iter().try_for_each(|item| self.item(host, item, left).map(|_| ()));
        self.quiet = before;
        done
    }

    fn call_text(
        &mut self,
        host: &mut dyn InterpreterHost,
        name: &Expression,
        section: Option<&(String, String)>,
        arguments: &[SiemensArgument],
        left: &mut SiemensRemainder,
    ) -> Outcome<BlockContinuation> {
        let name = match self.evaluate(host, name)? {
            Data::Text(text) => text.trim().to_owned(),
            other => return super::wrong_type(format!("{} is not a valid name of a subprogram", other.described())),
        };
        if !self.settings.subprograms {
            left.add(&format!("CALL \"{name}\""));
            return Ok(BlockContinuation::Continue);
        }
        let place = host.place();
        let whole = if name.is_empty() && section.is_some() {
            Some((place.file, place.range))
        } else {
            self.program_by_path(host, &name)?
        };
        let Some((labels, whole)) = section.zip(whole) else {
            left.call = Some(self.prepare_call(host, &name, whole, arguments)?);
            return Ok(BlockContinuation::Continue);
        };
        let (file, range) = self.section(host, whole, labels)?;
        let call = if file == place.file && name.is_empty() {
            self.prepare_part(host, labels.0.clone(), (range.first, range.last), 1)
        } else {
            self.prepare_call(host, &name, Some((file, range)), &[])?
        };
        left.call = Some(call);
        Ok(BlockContinuation::Continue)
    }
}

/// The block after its marks of optional skip; none if it is skipped.
pub(super) fn skipped<'a>(host: &dyn ProgramHost, text: &'a str) -> Option<&'a str> {
    let mut text = text.trim_start();
    while let Some(rest) = text.strip_prefix('/') {
        let digit = rest.bytes().next().filter(u8::is_ascii_digit);
        let level = digit.map(|digit| digit - b'0').filter(|level| *level > 0);
        if host.skips(level) {
            return None;
        }
        text = rest.get(usize::from(digit.is_some())..).unwrap_or_default().trim_start();
    }
    Some(text)
}

/// G90 and G91: whether positions are distances.
fn mode(text: &str) -> Option<bool> {
    let digits = text.strip_prefix(['G', 'g'])?.trim_start().trim_start_matches('0');
    match digits {
        "90" => Some(false),
        "91" => Some(true),
        _ => None,
    }
}
