//! Words of the machine for the interpreter.

use counterpoint_channel::queued_codes::literal_of;
use counterpoint_control_api::{MadeWord, WordHost};
use counterpoint_event::info::MachineUnit;
use counterpoint_machine::index::{CodeRowId, RegisterId};
use counterpoint_machine::model::{MacroWords, Triples};
use counterpoint_machine::number::{shortest, written};
use counterpoint_program::block::{Block, Word, irregular};
use counterpoint_program::key_words::WrittenNumber;

use crate::channel::Kernel;
use crate::channel::left_words::{left_plain, left_unknown, left_value, left_written};
use counterpoint_channel::trace::trace_preprocessed;

impl WordHost for Kernel<'_> {
    fn is_register(&self, name: &str) -> bool {
        self.channel.tables.names.is_register(name)
    }

    fn word(&self, name: &str, value: f64, spelled: Option<&str>) -> Option<String> {
        let (register, incremental) = self.channel.tables.names.register(name)?;
        let register = &self.channel.env.machine.registers[register];
        let before = register.second.as_ref().filter(|_| incremental).unwrap_or(&register.before);
        let format = if self.channel.state.secondary { &register.secondary } else { &register.format };
        let number = spelled.map_or_else(|| written(value, format), str::to_owned);
        Some(format!("{before}{number}{}", register.after))
    }

    fn second(&self, register: &str) -> Option<String> {
        let found =
            self.channel.env.machine.registers.iter().find(|found| found.name.eq_ignore_ascii_case(register))?;
        found.second.clone()
    }

    fn is_code_text(&self, text: &str) -> bool {
        self.literal(text).is_some()
    }

    fn literal(&self, text: &str) -> Option<CodeRowId> {
        self.channel.tables.names.text(text)
    }

    fn knows_code(&self, letter: u8, value: f64) -> bool {
        let tables = &self.channel.env.machine.tables;
        let register = tables.letter.get(usize::from(letter)).copied().flatten();
        register.is_some_and(|(register, _)| !tables.code(register, value).is_empty())
    }

    fn is_inch(&self) -> bool {
        (self.channel.env.machine.unit == MachineUnit::Inch) != self.channel.state.secondary
    }

    fn length_factor(&self) -> f64 {
        match (self.channel.env.machine.unit, self.channel.state.secondary) {
            (MachineUnit::Mm, true) => 25.4,
            (MachineUnit::Inch, true) => 1.0 / 25.4,
            (_, false) => 1.0,
        }
    }

    fn register(&self, letter: u8) -> Option<(RegisterId, bool)> {
        self.channel.tables.scanner.register(letter)
    }

    fn register_named(&self, name: &str) -> Option<(RegisterId, bool)> {
        self.channel.tables.names.register(name)
    }

    fn data_register(&self, before: &str) -> Option<(RegisterId, bool)> {
        let (register, incremental) = register_of_number(self, &format!("{before}1"))?;
        let is_data = self.channel.tables.registers.only_data & register.bit() != 0
            && !self.channel.tables.names.begins_text(before);
        is_data.then_some((register, incremental))
    }

    fn value_register(&self, before: &str) -> Option<(RegisterId, bool)> {
        let found = register_of_number(self, &format!("{before}1"))?;
        let is_longer = |name: &[u8]| matches!(name.first(), Some(b'0'..=b'9' | b'+' | b'-' | b'.'));
        (!self.channel.tables.names.continues(before, is_longer)).then_some(found)
    }

    fn separate_text(&self, text: &str) -> Option<CodeRowId> {
        let block = scanned_apart(self, text);
        let [row] = block.texts.as_slice() else { return None };
        let is_whole = literal_of(&self.channel, *row) == Some(text) && block.words.is_empty() && !block.has_remarks();
        let is_longer = |name: &[u8]| name.first() == Some(&b' ');
        (is_whole && block.sequence.is_none() && !self.channel.tables.names.continues(text, is_longer)).then_some(*row)
    }

    fn begins_name(&self, text: &str) -> bool {
        self.channel.tables.names.continues(text, |_| true)
    }

    fn steps(&self, register: RegisterId) -> Option<f64> {
        let [primary, secondary] = self.channel.tables.rules.steps.as_ref()?[register];
        Some(if self.channel.state.secondary { secondary } else { primary })
    }

    fn read(&mut self, register: RegisterId, number: WrittenNumber) -> f64 {
        let (value, irregular) = self.channel.tables.scanner.reading(register, number, self.channel.state.secondary);
        self.channel.block.flags.irregular |= irregular;
        value
    }

    fn take_sequence(&mut self, register: RegisterId, value: f64) -> bool {
        let is_free = self.channel.block.sequence.is_none() && value >= 0.0;
        let takes = Some(register) == self.channel.tables.scanner.sequence() && is_free;
        if takes {
            self.channel.block.sequence = Some(value as u32);
        }
        takes
    }

    fn set_sequence(&mut self, number: u32) {
        self.channel.block.sequence = Some(number);
    }

    fn set_program_name(&mut self, span: (u32, u32)) {
        self.channel.block.set_name(span);
    }

    fn push(&mut self, word: MadeWord) {
        let MadeWord { register, incremental, value, written, span: (start, end) } = word;
        let value = match written {
            Some(number) => self.read(register, number),
            None => {
                // Its size and its sign count; no point was written.
                let number = WrittenNumber { value, point: true, digits: 0, fraction: 0 };
                let (_, bits) = self.channel.tables.scanner.reading(register, number, self.channel.state.secondary);
                self.channel.block.flags.irregular |= bits & !irregular::POINT;
                value
            }
        };
        self.channel.block.push(Word { register, incremental, used: false, made: false, value, start, end });
    }

    fn push_value(&mut self, register: (RegisterId, bool), value: f64, spelled: Option<&str>, span: (u32, u32)) {
        left_value(&mut self.channel, &mut self.flow, &mut self.dialect, register, value, spelled, span);
    }

    fn push_computed(&mut self, (register, incremental): (RegisterId, bool), value: f64, (start, end): (u32, u32)) {
        let (tables, machine, secondary) =
            (self.channel.tables, self.channel.env.machine, self.channel.state.secondary);
        let value = shortest(value);
        let (value, bits) = match tables.scanner.reading_of_value(register, value, secondary) {
            Some(read) => read,
            None => tables.scanner.reading_of(register, value.to_string().as_bytes(), secondary).unwrap_or((value, 0)),
        };
        self.dialect.left.add(|| {
            let row = &machine.registers[register];
            let before = row.second.as_ref().filter(|_| incremental).unwrap_or(&row.before);
            format!("{before}{value}{}", row.after)
        });
        self.channel.block.flags.irregular |= bits;
        if !self.take_sequence(register, value) {
            self.channel.block.push(Word { register, incremental, used: false, made: true, value, start, end });
            self.flow.pass.effects = true;
        }
    }

    fn push_literal(&mut self, row: CodeRowId, span: (u32, u32)) {
        self.channel.block.push_text(row, span);
        let kernel = &*self;
        let text = kernel.dialect.left.asked.then(|| literal_of(&kernel.channel, row).unwrap_or_default().to_owned());
        if let Some(text) = text {
            self.dialect.left.add(|| text);
        }
        self.flow.pass.effects = true;
    }

    fn end_block(&mut self) {
        self.dialect.left.end_block(&mut self.channel.block);
    }

    fn push_plain(&mut self, text: &[u8], span: (u32, u32)) {
        left_plain(&mut self.channel, &mut self.flow, &mut self.dialect, text, span);
    }

    fn push_number(
        &mut self,
        (register, incremental): (RegisterId, bool),
        number: &str,
        word: &str,
        (start, end): (u32, u32),
    ) -> bool {
        let read = self.channel.tables.scanner.reading_of(register, number.as_bytes(), self.channel.state.secondary);
        let Some((value, bits)) = read else { return false };
        self.channel.block.flags.irregular |= bits;
        self.dialect.left.add(|| word.to_owned());
        if !self.take_sequence(register, value) {
            self.channel.block.push(Word { register, incremental, used: false, made: true, value, start, end });
            self.flow.pass.effects = true;
        }
        true
    }

    fn push_written(&mut self, words: &str, span: (u32, u32)) {
        left_written(&mut self.channel, &mut self.flow, &mut self.dialect, words, span);
    }

    fn push_unknown(&mut self, text: &[u8], span: (u32, u32)) {
        left_unknown(&mut self.channel, &mut self.flow, &mut self.dialect, text, span);
    }

    fn join_lines(&mut self, text: &[u8]) {
        self.dialect.left.joined = Some(text.into());
    }

    fn push_text(&mut self, row: CodeRowId) {
        self.channel.block.texts.push(row);
    }

    fn keep_text(&mut self, span: (u32, u32)) {
        self.channel.block.unrecognised.push(span);
    }

    fn words_are_made(&mut self) {
        if self.channel.env.trace.is_some() {
            trace_preprocessed(&mut self.channel);
        }
    }

    fn macro_words(&self) -> MacroWords {
        self.channel.env.machine.subprograms.macro_words
    }

    fn triples(&self) -> Triples {
        self.channel.env.machine.subprograms.ijk
    }
}

/// A text split into words, beside the block of the kernel.
fn scanned_apart(kernel: &Kernel<'_>, text: &str) -> Block {
    let tables = kernel.channel.tables;
    let scanner = tables.unmarked.as_deref().unwrap_or(&tables.scanner);
    let mut block = Block::default();
    scanner.scan_part(text.as_bytes(), (0, text.len() as u32), kernel.channel.state.secondary, &mut block);
    block
}

/// Register of a text that is one word, and whether it is the incremental form.
fn register_of_number(kernel: &Kernel<'_>, text: &str) -> Option<(RegisterId, bool)> {
    let block = scanned_apart(kernel, text);
    let one = match (block.words.as_slice(), block.sequence) {
        ([word], None) if (word.start, word.end as usize) == (0, text.len()) => (word.register, word.incremental),
        ([], Some(_)) => (kernel.channel.tables.scanner.sequence()?, false),
        _ => return None,
    };
    (block.texts.is_empty() && !block.has_remarks()).then_some(one)
}
