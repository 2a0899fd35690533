//! Pre-processors of other controls on a kernel: what they see of it and how they move it.
//!
//! Facts: reference control-emulator.md 2.2, 4.3, 5.4, 5.7. Invariant: what such a pre-processor leaves is a text, which
//! is split into words as any block is; on a kernel with macros it goes on to Pre-Processor Shutdown.

use std::sync::Arc;

use counterpoint_lang::value::Value;

use super::Kernel;
use super::flow::Callee;
use super::flow::{Frame, Pending};
use crate::diag::{self, Facts};
use crate::dialect::{Answer, AxisPlace, Call, Host, Interpreter, Modes, Place};
use crate::log::event::FileId;
use crate::log::info::Unit;
use crate::machine::ident::codes;
use crate::machine::macros::model::Hook;
use crate::machine::model::Dimension;
use crate::machine::number::written;
use crate::mcd::program::Range;
use crate::mcd::source::Source;
use crate::state::frames::offsets::Table;
use crate::state::modal::group;
use counterpoint_fault::{Acted, Halt};
use counterpoint_motion::frame::affine::Affine;

impl Kernel<'_> {
    /// A block that is not plain words.
    pub(crate) fn interpreted_line(&mut self, text: &[u8]) -> Acted {
        if self.channel.env.trace.is_some() {
            self.trace_deleted(text);
        }
        let text = text.to_vec();
        self.channel.block.clear();
        match self.with_interpreter(|interpreter, kernel| interpreter.block(kernel, &text)) {
            Some(left) => {
                left?.map_or(Ok(()), |left| left.split('\n').try_for_each(|left| self.left_words(left, &text)))
            }
            None => {
                let text = format!("'{}' comes while the pre-processor asks a macro, it is dropped", self.block_text());
                self.diagnose(&diag::PREPROCESSOR_ASKS, text);
                Ok(())
            }
        }
    }

    /// The words that are left of a block act.
    fn left_words(&mut self, text: &str, whole: &[u8]) -> Acted {
        // A sequence number alone is nothing that a loop could wait for.
        let number = text.trim().strip_prefix(['N', 'n']).unwrap_or("");
        if number.is_empty() || !number.bytes().all(|byte| byte.is_ascii_digit()) {
            self.flow.pass.effects = true;
        }
        if text.trim().as_bytes() != whole.trim_ascii() {
            self.trace_left(text);
        }
        if let Some(hooks) = self.plan.hooks {
            return (hooks.block.left)(self, text);
        }
        if text.trim().is_empty() {
            return Ok(());
        }
        let read = self.channel.text.edited.replace(Arc::from(text.as_bytes()));
        let plan = self.plan;
        let scanner = plan.unmarked.as_deref().unwrap_or(&plan.scanner);
        scanner.scan_as(text.as_bytes(), self.channel.state.secondary, &mut self.channel.block, false);
        let acted = self.words();
        // The next block has a text of its own.
        self.channel.text.edited = read;
        acted
    }

    /// Factor from positions as the program counts them to those of an axis.
    fn program_factor(&self, axis: usize) -> f64 {
        let turns = self.channel.state.place.layout.axes.get(axis).is_some_and(|axis| axis.rotary);
        let length = if turns { 1.0 } else { self.channel.unit_factor(Dimension::Length) };
        length * self.factor_across(axis)
    }

    /// Lets the interpreter work; it cannot be asked from within.
    pub(crate) fn with_interpreter<R>(&mut self, work: impl FnOnce(&mut dyn Interpreter, &mut Self) -> R) -> Option<R> {
        let mut interpreter = self.dialect.interpreter.take()?;
        let done = work(&mut *interpreter, self);
        self.dialect.interpreter = Some(interpreter);
        Some(done)
    }

    pub(crate) fn interpreter_started(&mut self) {
        if self.dialect.interpreter.is_some() {
            self.with_interpreter(|interpreter, kernel| interpreter.started(kernel));
        }
    }

    #[inline]
    pub(crate) fn interpreter_entered(&mut self) {
        if self.dialect.interpreter.is_some() {
            self.with_interpreter(|interpreter, kernel| interpreter.entered(kernel));
        }
    }

    #[inline]
    pub(crate) fn interpreter_again(&mut self) {
        if let Some(interpreter) = self.dialect.interpreter.as_deref_mut() {
            interpreter.again();
        }
    }

    #[inline]
    pub(crate) fn interpreter_left(&mut self) {
        if self.dialect.interpreter.is_some() {
            self.with_interpreter(|interpreter, kernel| interpreter.left(kernel));
        }
    }

    /// Calls a text that the interpreter has found, or that a startup macro may find.
    pub(crate) fn call_text(&mut self, call: Call) -> Acted {
        let Call { name, place, passes, closes } = call;
        self.check_nesting(|| name.to_string())?;
        let called = self.called(Callee::Named(Arc::clone(&name)), passes);
        let mut found = place;
        if let Some(hooks) = self.plan.hooks {
            match (hooks.program.call)(self, &called, found)? {
                None => return Ok(()),
                Some(place) => found = place,
            }
        }
        let Some((file, range)) = found else {
            let text = format!("subprogram {name} is missing, called in '{}'", self.block_text());
            return Err(self.alarm(&diag::SUBPROGRAM_MISSING, text));
        };
        let (next, repeats) = (range.first, passes.saturating_sub(1));
        let name = (*name).into();
        let (by, own_variables) = (None, false);
        self.enter(Frame { file, range, next, offset: 0, repeats, closes, own_variables, called, by, name });
        Ok(())
    }
}

impl Host for Kernel<'_> {
    fn place(&self) -> Place {
        let frame = self.flow.frames.last();
        let range = frame.map_or(Range { number: None, first: 1, last: 0 }, |frame| frame.range);
        let as_read = self.channel.text.edited.is_none() && self.macros.block.text.is_none();
        Place {
            file: self.channel.at.file,
            line: self.channel.at.line,
            range,
            level: self.flow.frames.len().saturating_sub(1),
            as_read,
        }
    }

    fn source(&self, file: FileId) -> Option<Arc<Source>> {
        self.channel.env.sources.shared(file)
    }

    fn files(&self) -> Vec<String> {
        self.channel.env.info.files.iter().map(|file| file.name.clone()).collect()
    }

    fn load(&mut self, file: FileId) -> Acted {
        Kernel::load(self, file)
    }

    fn main_file(&self) -> FileId {
        self.flow.frames.first().map_or(self.channel.at.file, |frame| frame.file)
    }

    fn work(&mut self, elements: usize) -> Acted {
        Kernel::work(self, elements)
    }

    fn skips(&self, level: Option<u8>) -> bool {
        match self.block_scanner() {
            Some(scanner) => scanner.skips(level),
            None => self.plan.scanner.skips(level),
        }
    }

    fn go_to(&mut self, line: u32) -> Acted {
        self.jump_to_line(line)
    }

    fn call(&mut self, call: Call) {
        self.ask(Pending::CallText(Box::new(call)));
    }

    fn calls_modally(&mut self, on: bool) {
        self.flow.modal_text = on;
    }

    fn give_back(&mut self) {
        self.ask(Pending::Return(None));
    }

    fn show(&mut self, text: &str) {
        self.display(text);
    }

    fn tells_messages(&self, text: &[u8]) -> bool {
        self.plan.hooks.is_some() && self.plan.scanner.remarks(text).iter().any(|(is_message, ..)| *is_message)
    }

    fn diagnose(&mut self, facts: &'static Facts, text: String) {
        let unknown = facts.number == diag::NOT_RECOGNISED.number && self.channel.env.machine.habits.unknown_alarms;
        Kernel::diagnose(self, if unknown { &diag::UNKNOWN_TEXT } else { facts }, text);
    }

    fn alarm(&mut self, facts: &'static Facts, text: String) -> Halt {
        Kernel::alarm(self, facts, text)
    }

    fn block_text(&self) -> String {
        Kernel::block_text(self)
    }

    fn shared(&mut self, name: &str) -> Result<Option<Value>, Halt> {
        self.flow.pass.polled = true;
        Kernel::shared(self, |order| order.shared.named.get(name).cloned())
    }

    fn set_shared(&mut self, name: &str, value: Option<Value>) -> Acted {
        self.flow.pass.effects = true;
        let limit = self.channel.shares().common;
        let growth = name.len() + 200 + value.as_ref().and_then(Value::as_text).map_or(0, str::len);
        let over = Kernel::shared(self, |order| match value {
            Some(value) => {
                order.shared.named.insert(name.into(), value);
                order.shared.grown(growth, limit)
            }
            None => {
                order.shared.named.remove(name);
                false
            }
        })?;
        if over { Err(self.out_of_memory("variables that all channels share take most of it")) } else { Ok(()) }
    }

    fn has_own_common(&self) -> bool {
        self.channel.env.machine.variables.own_common
    }

    fn effect(&mut self) {
        self.flow.pass.effects = true;
    }

    fn identify(&mut self, text: &str, assigned: Option<&Value>) -> Result<Answer, Halt> {
        let asked = self.macros.course.identifying;
        let Some(code) = self.hook(Hook::Identification).filter(|_| !asked) else { return Ok(Answer::Unknown) };
        let assigned = assigned.cloned().unwrap_or(Value::Null);
        Ok(match self.ask_identification(code, text, assigned)? {
            // Evaluating the same text again would ask for ever.
            Answer::Instead(answer) if answer.trim() == text.trim() => Answer::Unknown,
            answer => answer,
        })
    }

    fn is_register(&self, name: &str) -> bool {
        let is = |text: &str| text.eq_ignore_ascii_case(name);
        let mut registers = self.channel.env.machine.registers.iter();
        registers
            .any(|register| is(&register.name) || is(&register.before) || register.second.as_deref().is_some_and(is))
    }

    fn word(&self, name: &str, value: f64, spelled: Option<&str>) -> Option<String> {
        let is = |text: &str| text.strip_suffix('=').unwrap_or(text).eq_ignore_ascii_case(name);
        let mut registers = self.channel.env.machine.registers.iter();
        let (before, register) = registers.find_map(|register| match &register.second {
            Some(second) if is(second) => Some((second, register)),
            _ => is(&register.before).then_some((&register.before, register)),
        })?;
        let format = if self.channel.state.secondary { &register.secondary } else { &register.format };
        let number = spelled.map_or_else(|| written(value, format), str::to_owned);
        Some(format!("{before}{number}{}", register.after))
    }

    fn is_inch(&self) -> bool {
        (self.channel.env.machine.unit == Unit::Inch) != self.channel.state.secondary
    }

    fn is_code_text(&self, text: &str) -> bool {
        let mut texts = self.channel.env.machine.tables.texts.iter();
        texts.any(|&row| self.literal_of(row).is_some_and(|literal| literal.eq_ignore_ascii_case(text)))
    }

    fn knows_code(&self, letter: u8, value: f64) -> bool {
        let tables = &self.channel.env.machine.tables;
        let register = tables.letter.get(usize::from(letter)).copied().flatten();
        register.is_some_and(|(register, _)| !tables.code(register, value).is_empty())
    }

    fn positions(&self) -> Vec<(String, f64, f64)> {
        let programmed = self.channel.programmed();
        let machine = self.channel.machine_point(&self.channel.state.place.position);
        let axes = self
            .channel
            .state
            .place
            .layout
            .axes
            .iter()
            .filter_map(|axis| self.channel.env.machine.axes.get(axis.machine));
        let values = programmed.iter().zip(machine.iter());
        axes.zip(values).map(|(axis, (work, machine))| (axis.name.clone(), *work, *machine)).collect()
    }

    fn length_factor(&self) -> f64 {
        match (self.channel.env.machine.unit, self.channel.state.secondary) {
            (Unit::Mm, true) => 25.4,
            (Unit::Inch, true) => 1.0 / 25.4,
            (_, false) => 1.0,
        }
    }

    fn clock(&self) -> i64 {
        self.channel.at.clock
    }

    fn channel(&self) -> u16 {
        self.channel.at.channel
    }

    fn watch(&mut self, on: bool) {
        self.flow.watched = on;
    }

    fn axes(&self) -> Vec<AxisPlace> {
        let programmed = self.channel.programmed();
        let machine = self.channel.machine_point(&self.channel.state.place.position);
        let counted = self.channel.counted();
        let values = programmed.iter().zip(machine.iter()).zip(counted.iter());
        let places = self.channel.state.place.layout.axes.iter().enumerate().zip(values).filter_map(
            |((at, axis), ((work, machine), from))| {
                let named = self.channel.env.machine.axes.get(axis.machine)?;
                let factor = self.program_factor(at);
                Some(AxisPlace {
                    name: named.name.clone(),
                    letter: named.letter.clone(),
                    diameter: self.factor_across(at) * axis.scale < 1.0,
                    work: work / factor,
                    from: from / factor,
                    machine: machine / factor,
                })
            },
        );
        places.collect()
    }

    fn relative(&self) -> bool {
        self.channel.state.modal.code(group::POSITION) == Some(codes::POSITION_RELATIVE)
    }

    fn moves_straight(&self) -> bool {
        matches!(self.channel.state.modal.code(group::MOTION), Some(codes::RAPID | codes::INTERP_LINEAR))
    }

    fn second(&self, register: &str) -> Option<String> {
        let found =
            self.channel.env.machine.registers.iter().find(|found| found.name.eq_ignore_ascii_case(register))?;
        found.second.clone()
    }

    fn local_frame(&self) -> [f64; 12] {
        let map = self.channel.state.place.frames.as_deref().map_or(Affine::SAME, |frames| *frames.local.map());
        let mut rows = <[f64; 12]>::try_from(map.cells()).unwrap_or_default();
        for (row, axis) in self.channel.state.place.layout.cartesian.iter().enumerate() {
            let Some(at) = axis.map(usize::from) else { continue };
            let scale = self.channel.state.place.layout.axes.get(at).map_or(1.0, |axis| axis.scale);
            if let Some(shift) = rows.get_mut(row * 4 + 3) {
                *shift /= scale * self.program_factor(at);
            }
        }
        rows
    }

    fn work_offset(&self) -> u32 {
        self.channel.state.place.in_force.work_offset
    }

    fn offset(&self, number: u32) -> Vec<f64> {
        let values = self.channel.offset_values(Table::Work, number);
        let values = values.iter().take(self.channel.state.place.layout.axes.len()).enumerate();
        values.map(|(at, value)| value / self.program_factor(at)).collect()
    }

    fn set_offset(&mut self, number: u32, values: &[f64]) -> bool {
        let mut offset = self.channel.offset_values(Table::Work, number);
        for (at, (slot, value)) in offset.iter_mut().zip(values).enumerate() {
            *slot = value * self.program_factor(at);
        }
        Kernel::set_offset(self, Table::Work, number, offset)
    }

    fn tool(&self) -> u32 {
        self.channel.state.place.tools.current
    }

    fn modes(&self) -> Modes {
        Modes(self.channel.state.modal.saved())
    }

    fn restore_modes(&mut self, modes: &Modes) {
        self.put_modes_back(&modes.0);
    }

    fn report(&mut self, facts: &'static Facts, severity: u8, text: String) {
        Kernel::diagnose(self, &Facts { severity, ..*facts }, text);
    }
}
