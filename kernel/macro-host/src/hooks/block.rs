//! Hooks around the text of a block: embedded code, macros of the pre-processor and of the block.
//!
//! Facts: reference control-emulator.md 2.2, 2.3, 4.1, 5.3. Invariants: the text of a block is made only for a macro
//! that asks for it; it is split into words again only if a macro has changed it.

use std::sync::Arc;

use counterpoint_channel::macro_queries::has_embedded;
use counterpoint_channel::macros::calls::OutputTask;
use counterpoint_channel::queued_codes::literal_of;
use counterpoint_channel::text;
use counterpoint_channel::trace;
use counterpoint_channel::trace::{TextStage, trace_line};
use counterpoint_channel::unknown_words::left_name;
use counterpoint_emulator::channel::Kernel;
use counterpoint_emulator::channel::hook_points::BlockTreatment;
use counterpoint_emulator::channel::macro_queries::block_scanner;
use counterpoint_emulator::channel::statement::forget_lines;
use counterpoint_emulator::pipeline::act_words;
use counterpoint_emulator::pipeline::split::split_again;
use counterpoint_fault as diag;
use counterpoint_fault::{Acted, Halt};
use counterpoint_lang::value::MacroValue;
use counterpoint_machine::ident::data;
use counterpoint_machine::macros::model::Hook;
use counterpoint_machine::rows::DecimalPointRule;
use counterpoint_program::scan::LineScanner;

use super::embedded;
use crate::context::MacroHooks;
use crate::host::block;

/// Macros that get the text of the words.
const READERS: [Hook; 4] =
    [Hook::PreprocessorShutdown, Hook::BlockStartup, Hook::SubprogramStartup, Hook::SubprogramShutdown];

impl MacroHooks<'_, '_> {
    /// Block delete around embedded code, embedded code before the pre-processor, Pre-Processor Startup.
    pub(crate) fn edit_block(&mut self) -> Result<BlockTreatment, Halt> {
        self.note_mark();
        let may_embed = has_embedded(&self.kernel.channel, &self.kernel.macros, 0)
            || has_embedded(&self.kernel.channel, &self.kernel.macros, 1);
        if may_embed {
            embedded::delete_around_code(self);
        }
        if may_embed && embedded::embedded(self, 0)? && self.kernel.channel.text_bytes().trim_ascii().is_empty() {
            return Ok(BlockTreatment::Dropped);
        }
        let preprocess = self.kernel.channel.tables.scanner.has_preprocessor();
        let preprocess = preprocess && self.block_macro(Hook::PreprocessorStartup)? != BlockDecision::Drop;
        self.kernel.channel.context.preprocessed = preprocess;
        Ok(if preprocess { BlockTreatment::Preprocess } else { BlockTreatment::Plain })
    }

    /// Pre-Processor Shutdown after a block of plain words.
    pub(crate) fn after_preprocessor(&mut self) -> Acted {
        if self.block_macro(Hook::PreprocessorShutdown)? == BlockDecision::Edited {
            split_again(self.kernel);
        }
        Ok(())
    }

    /// Pre-Processor Shutdown after a statement that made no words; the text that the macro returns becomes the block.
    pub(crate) fn consumed_block(&mut self) -> Acted {
        let made = std::mem::take(&mut self.kernel.channel.context.made);
        if made || self.kernel.macros.ready(Hook::PreprocessorShutdown).is_none() {
            return Ok(());
        }
        self.kernel.channel.context.text = Some(Arc::default());
        let edited = self.block_macro(Hook::PreprocessorShutdown)? == BlockDecision::Edited;
        if !edited || self.kernel.channel.text_bytes().trim_ascii().is_empty() {
            return Ok(());
        }
        split_again(self.kernel);
        act_words(self.kernel)
    }

    /// Keeps the level of the first mark of block skip, on machines that have a row for it.
    fn note_mark(&mut self) {
        if !block::knows_data(self.kernel.channel.env.machine, data::OPSKIP) {
            return;
        }
        let absent =
            |mark: u8| self.kernel.channel.context.text.is_none() && text::is_line_without(&self.kernel.channel, mark);
        if self.kernel.channel.tables.scanner.skip_mark().is_none_or(absent) {
            self.kernel.channel.context.mark = None;
            return;
        }
        let level = match block_scanner(self.kernel.plan, &self.kernel.channel, &self.kernel.macros) {
            Some(scanner) => scanner.first_mark(&self.kernel.channel.text_bytes()),
            None => self.kernel.channel.tables.scanner.first_mark(&self.kernel.channel.text_bytes()),
        };
        self.kernel.channel.context.mark = level;
    }

    /// Pre-Processor Shutdown for words that the pre-processor made: they become text if a macro or embedded code sees
    /// them.
    pub(crate) fn words_as_text(&mut self) -> Acted {
        self.kernel.channel.context.made = true;
        let left =
            Some(std::mem::take(&mut self.kernel.dialect.left.text)).filter(|left| !left.is_empty()).map(Arc::new);
        let asked = [Hook::PreprocessorShutdown, Hook::BlockStartup]
            .into_iter()
            .any(|hook| self.kernel.macros.ready(hook).is_some());
        if !asked && !has_embedded(&self.kernel.channel, &self.kernel.macros, 1) {
            self.kernel.channel.context.left = left;
        } else {
            match left {
                None => self.write_block(),
                left => self.kernel.channel.context.text = left,
            }
            self.block_macro(Hook::PreprocessorShutdown)?;
            split_again(self.kernel);
        }
        Ok(())
    }

    /// Words as text: the template as changed by the pre-processor.
    fn write_block(&mut self) {
        let mut text = String::new();
        if let Some(number) = self.kernel.channel.block.sequence {
            let register = self
                .kernel
                .channel
                .tables
                .scanner
                .sequence()
                .map(|register| &self.kernel.channel.env.machine.registers[register]);
            let name = register.map_or("N", |register| register.name.as_str());
            text.push_str(&format!("{name}{number} "));
        }
        for word in &self.kernel.channel.block.words {
            let register = &self.kernel.channel.env.machine.registers[word.register];
            let before = match &register.second {
                Some(second) if word.incremental => second,
                _ => &register.before,
            };
            text.push_str(&format!("{before}{}", word.value));
            if word.value.fract() == 0.0
                && register.format.frac > 0
                && register.format.point != DecimalPointRule::Fractional
            {
                text.push('.');
            }
            text.push_str(&register.after);
            text.push(' ');
        }
        for &row in &self.kernel.channel.block.texts {
            if let Some(literal) = literal_of(&self.kernel.channel, row) {
                text.push_str(literal);
                text.push(' ');
            }
        }
        let line = self.kernel.channel.text_bytes();
        for &(start, end) in &self.kernel.channel.block.unrecognised {
            let part = line.as_ref().get(start as usize..end as usize).unwrap_or_default();
            text.push_str(&String::from_utf8_lossy(part));
            text.push(' ');
        }
        text.truncate(text.trim_end().len());
        self.kernel.channel.context.text = Some(Arc::new(text));
    }

    /// `$OPSKIPL`: switches a level of block skip from the next block on.
    pub(crate) fn switch_level(&mut self, level: u8, on: bool) {
        let before = self
            .kernel
            .macros
            .reading
            .switched
            .clone()
            .map_or(self.kernel.channel.tables.scanner.levels(), |scanner| scanner.levels());
        let wanted = if on { before | 1 << level } else { before & !(1 << level) };
        let levels: Vec<u8> = (1..16).filter(|level| wanted & 1 << level != 0).collect();
        let (machine, syntax) = (self.kernel.channel.env.machine, self.kernel.channel.tables.scanner.syntax());
        self.kernel.macros.reading.switched = Some(Arc::new(LineScanner::new(machine, syntax, &levels)));
        // Lines compiled before have the parts that were skipped then.
        forget_lines(&mut self.kernel.dialect);
    }

    /// Embedded code after the pre-processor and Block Startup; false if the block is dropped.
    pub(crate) fn before_codes(&mut self) -> Result<bool, Halt> {
        if self.kernel.channel.text_bytes().trim_ascii().is_empty() {
            return Ok(false);
        }
        let changed = embedded::embedded(self, 1)?;
        match self.block_macro(Hook::BlockStartup)? {
            BlockDecision::Drop => return Ok(false),
            BlockDecision::Edited => {
                split_again(self.kernel);
                trace_line(&mut self.kernel.channel, 'E', |channel| {
                    trace::edited(TextStage::BlockMacro, &String::from_utf8_lossy(&channel.text_bytes()))
                });
            }
            BlockDecision::Go if changed => split_again(self.kernel),
            BlockDecision::Go => {}
        }
        Ok(!self.kernel.channel.text_bytes().trim_ascii().is_empty())
    }

    /// Runs a macro with the arguments of block macros: flag, text, number of the block.
    fn block_macro(&mut self, hook: Hook) -> Result<BlockDecision, Halt> {
        let runtime = &*self.kernel.macros;
        let Some(code) = runtime.ready(hook) else { return Ok(BlockDecision::Go) };
        let asks = runtime.calls.uses(code, 2);
        let text = if asks { self.text_value() } else { MacroValue::Null };
        let given = if let MacroValue::Text(text) = &text { Some(Arc::clone(text)) } else { None };
        let mut arguments = [MacroValue::Real(1.0), text, MacroValue::Real(f64::from(self.kernel.channel.at.line))];
        self.run_macro(code, OutputTask::None, &mut arguments)?;
        let [flag, text, _] = arguments;
        let drops = flag.as_real() == Some(0.0);
        let verdict = match (given, text) {
            (Some(given), MacroValue::Text(text)) if !Arc::ptr_eq(&given, &text) && given != text => {
                let (length, limit) = (text.len(), self.kernel.channel.env.options.limits.block_length);
                if length > limit {
                    let text = format!("$P2 of the {} has {length} bytes, a block may have {limit}", hook.title());
                    return Err(self.kernel.alarm(&diag::BLOCK_TOO_LONG, text));
                }
                self.kernel.channel.context.text = Some(text);
                BlockDecision::Edited
            }
            (Some(_), MacroValue::Text(_)) | (None, _) => BlockDecision::Go,
            (Some(_), other) => {
                let text = format!("$P2 of the {} is {}, not a text; it is ignored", hook.title(), other.kind_name());
                self.kernel.diagnose(&diag::MACRO_RESULT, text);
                BlockDecision::Go
            }
        };
        Ok(if drops { BlockDecision::Drop } else { verdict })
    }

    /// Left-over text after the codes: the block shutdown macro may change it.
    pub(crate) fn block_shutdown(&mut self) -> Acted {
        let runtime = &*self.kernel.macros;
        let Some(code) = runtime.ready(Hook::BlockShutdown) else { return Ok(()) };
        left_name(&mut self.kernel.channel);
        let runtime = &*self.kernel.macros;
        let asks = runtime.calls.uses(code, 2);
        let left = if asks { text::left_text(&self.kernel.channel) } else { String::new() };
        let mut arguments = [
            MacroValue::Real(1.0),
            MacroValue::text(left.as_str()),
            MacroValue::Real(f64::from(self.kernel.channel.at.line)),
        ];
        self.run_macro(code, OutputTask::None, &mut arguments)?;
        match &arguments[1] {
            MacroValue::Text(text) if **text != left => {
                let (length, limit) = (text.len(), self.kernel.channel.env.options.limits.block_length);
                if length > limit {
                    let title = Hook::BlockShutdown.title();
                    let text = format!("$P2 of the {title} has {length} bytes, a block may have {limit}");
                    return Err(self.kernel.alarm(&diag::BLOCK_TOO_LONG, text));
                }
                text::set_left(&mut self.kernel.channel, text.as_ref().clone());
            }
            _ => {}
        }
        Ok(())
    }

    /// The same for a macro.
    pub(crate) fn text_value(&mut self) -> MacroValue {
        let (sources, file, line) =
            (self.kernel.channel.env.sources, self.kernel.channel.at.file, self.kernel.channel.at.line);
        let runtime = &mut *self.kernel.macros;
        if let Some(text) = &self.kernel.channel.context.text {
            return MacroValue::Text(Arc::clone(text));
        }
        let as_read = || sources.get(file).map_or(&[][..], |source| source.line(line));
        let bytes = self.kernel.channel.text.edited.as_deref().unwrap_or_else(as_read);
        MacroValue::Text(runtime.arguments.texts.with(|text| {
            text.clear();
            match std::str::from_utf8(bytes) {
                Ok(line) => text.push_str(line),
                Err(_) => text.push_str(&String::from_utf8_lossy(bytes)),
            }
        }))
    }
}

/// Decision of a block macro.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum BlockDecision {
    /// The block continues as it is.
    Go,
    /// Its text has changed.
    Edited,
    /// It is dropped, or the pre-processor skipped.
    Drop,
}

/// Whether a macro or embedded code may read the words that the pre-processor leaves of the block.
pub(super) fn reads_left(kernel: &Kernel<'_>) -> bool {
    let macros = kernel.channel.env.machine.macros.as_deref();
    let runs = macros.is_some_and(|macros| READERS.into_iter().any(|hook| macros.hook(hook).is_some()));
    runs || kernel.macros.calls.read_block || has_embedded(&kernel.channel, &kernel.macros, 1)
}
