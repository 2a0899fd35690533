//! A block on a kernel with macros: embedded code, pre-processor and block macros around what every kernel does.
//!
//! Facts: reference control-emulator.md 2.2, 2.3, 4.1, 5.3. Invariants: the text of a block is made only for a macro that
//! asks for it; it is split into words again only when somebody has changed it.

use std::sync::Arc;

use counterpoint_lang::value::Value;

use super::Kernel;
use super::custom_codes::Origin;
use super::scan::{Kind as LineKind, Scanner};
use crate::diag;
use crate::log::event::{Kind, Trace};
use crate::machine::ident::data;
use crate::machine::macros::model::Hook;
use crate::machine::model::Point;
use crate::macros::host::{code_id, data_id};
use crate::macros::runtime::{Later, Task};
use crate::state::block::Block;
use crate::trace::{self, Stage};
use counterpoint_fault::{Acted, Halt};

impl Kernel<'_> {
    /// A block that EXEC/NEXT left for later.
    #[inline]
    pub(crate) fn later_block(&mut self) -> Option<Later> {
        self.macros.as_deref_mut().and_then(|runtime| runtime.later.pop_front())
    }

    /// Tells the listing what such a block is: no line of a file has it.
    pub(crate) fn name_block(&mut self, block: &Later) {
        let text = match block {
            Later::Text(text, _) => text.to_string(),
            Later::Items(items, _) => self.listed(items),
        };
        let text = format!("{}{}", trace::BLOCK, crate::state::burden::shortened(&text)).into();
        self.emit(0, Kind::Trace(Trace { letter: trace::LISTING, text }));
    }

    /// Processes such a block.
    pub(crate) fn process_later(&mut self, block: Later) -> Acted {
        let (Later::Text(_, matching) | Later::Items(_, matching)) = block;
        let set = |kernel: &mut Self, matching| {
            if let Some(runtime) = kernel.macros.as_deref_mut() {
                runtime.matching = matching;
            }
        };
        set(self, matching);
        let done = match block {
            Later::Text(text, _) => self.custom_block(Some(text)),
            Later::Items(items, _) => {
                self.channel.block.clear();
                self.item_block(&items)
            }
        };
        set(self, true);
        done
    }

    /// Processes a block inside another one, which keeps what is left on it.
    pub(crate) fn nested_block(&mut self, process: impl FnOnce(&mut Self) -> Acted) -> Acted {
        let Some(runtime) = self.macros.as_deref_mut() else { return Ok(()) };
        let mut block = runtime.blocks.pop().unwrap_or_default();
        block.clear();
        let block = std::mem::replace(&mut self.channel.block, block);
        let text = runtime.text.take();
        let left = runtime.left.take();
        let code = runtime.store.code.take();
        let kept = (runtime.issued, runtime.preprocessed, runtime.made, runtime.mark);
        let (as_data, mode_changed) = (self.channel.acting.as_data.take(), self.channel.acting.mode_changed);
        let asked = self.flow.pending.take();
        // A block within a block is one, too.
        let begun = self.work(crate::state::burden::BLOCK).and_then(|()| self.check_limits());
        let done = begun.and_then(|()| process(self)).and_then(|()| self.call_at_once());
        // The rest of that block is dropped, not that of the one around it.
        let done = if done == Err(Halt::Dropped) { Ok(()) } else { done };
        (self.channel.acting.as_data, self.channel.acting.mode_changed) = (as_data, mode_changed);
        // An end waits for the end of the block that was interrupted.
        match std::mem::replace(&mut self.flow.pending, asked) {
            Some(own) if self.flow.pending.is_some() => self.ask(own),
            Some(own) => self.flow.pending = Some(own),
            None => {}
        }
        let nested: Block = std::mem::replace(&mut self.channel.block, block);
        if let Some(runtime) = self.macros.as_deref_mut() {
            runtime.blocks.push(nested);
            (runtime.text, runtime.left, runtime.store.code) = (text, left, code);
            (runtime.issued, runtime.preprocessed, runtime.made, runtime.mark) = kept;
        }
        done
    }

    /// A block given as identifiers and values: straight to the code loop.
    pub(crate) fn item_block(&mut self, items: &[Value]) -> Acted {
        if let Some(runtime) = self.macros.as_deref_mut() {
            runtime.text = Some(Arc::default());
        }
        let mut items = items.iter();
        while let Some(item) = items.next() {
            if let Some(id) = code_id(item) {
                if !self.add_code(id, 0.0) {
                    self.no_such_code(id);
                }
            } else if let Some(id) = data_id(item) {
                match items.next().and_then(Value::as_real) {
                    Some(value) if self.knows_data(id) => self.channel.block.added.push((id, value)),
                    Some(_) => {
                        let text = format!("this machine has no word for {}", self.channel.env.machine.data_name(id));
                        self.diagnose(&diag::DATA_MISSING, text);
                    }
                    None => {
                        let text = format!("EXEC needs a number behind {}", self.channel.env.machine.data_name(id));
                        self.diagnose(&diag::MACRO_RESULT, text);
                    }
                }
            } else {
                let text = format!("EXEC takes codes, and data with their values, not {}", item.kind_name());
                self.diagnose(&diag::MACRO_RESULT, text);
            }
        }
        self.act_block_of(Origin::Items)
    }

    /// Says that EXEC or OUTPUT named a code without a row.
    pub(crate) fn no_such_code(&mut self, id: crate::machine::ident::CodeId) {
        let name = self.channel.env.machine.code_name(id).to_owned();
        self.diagnose(&diag::CODE_NOT_HERE, format!("this machine has no {name}, it cannot act"));
    }

    /// One block on a kernel with macros; `text` if it is not the line of the file.
    pub(crate) fn custom_block(&mut self, text: Option<Arc<String>>) -> Acted {
        let machine = self.channel.env.machine;
        if let Some(runtime) = self.macros.as_deref_mut() {
            runtime.issued = text.is_some();
            if runtime.issued && runtime.unmarked.is_none() {
                runtime.unmarked = Some(Arc::new(Scanner::without_marks(machine)));
            }
            runtime.text = text;
            runtime.left = None;
            runtime.store.number = 0;
        }
        self.note_mark();
        self.delete_around_code();
        if self.embedded(0)? && self.text_bytes().trim_ascii().is_empty() {
            return Ok(());
        }
        let preprocess = self.plan.scanner.has_preprocessor();
        let preprocess = preprocess && self.block_macro(Hook::PreprocessorStartup)? != Verdict::Drop;
        if let Some(runtime) = self.macros.as_deref_mut() {
            runtime.preprocessed = preprocess;
        }
        let (sources, file, line) = (self.channel.env.sources, self.channel.at.file, self.channel.at.line);
        let own = self.macros.as_deref().and_then(|runtime| runtime.text.clone());
        let edited = self.channel.text.edited.clone();
        let as_read = || sources.get(file).map_or(&[][..], |source| source.line(line));
        let bytes = match &own {
            Some(text) => text.as_bytes(),
            None => edited.as_deref().unwrap_or_else(as_read),
        };
        let (plan, own) = (self.plan, self.block_scanner());
        let scanner = own.as_deref().unwrap_or(&plan.scanner);
        let kind = match preprocess && self.flow.watched {
            true => LineKind::Macro,
            false => scanner.scan_as(bytes, self.channel.state.secondary, &mut self.channel.block, preprocess),
        };
        match kind {
            LineKind::Words => {
                if self.channel.env.trace.is_some() && !self.has_embedded(1) {
                    self.trace_deleted(bytes);
                }
                if preprocess && self.block_macro(Hook::PreprocessorShutdown)? == Verdict::Edited {
                    self.scan_again();
                }
                self.words_block()
            }
            LineKind::Macro => {
                if self.may_have_remarks() || self.plan.scanner.has_messages() {
                    self.remarks(bytes)?;
                }
                self.macro_line(bytes)?;
                self.consumed_block()
            }
        }
    }

    /// Pre-Processor Shutdown behind a statement that left no words; the text that the macro gives is the block.
    fn consumed_block(&mut self) -> Acted {
        let made = self.macros.as_deref_mut().is_none_or(|runtime| std::mem::take(&mut runtime.made));
        if made || self.hook(Hook::PreprocessorShutdown).is_none() {
            return Ok(());
        }
        if let Some(runtime) = self.macros.as_deref_mut() {
            runtime.text = Some(Arc::default());
        }
        let edited = self.block_macro(Hook::PreprocessorShutdown)? == Verdict::Edited;
        if !edited || self.text_bytes().trim_ascii().is_empty() {
            return Ok(());
        }
        self.scan_again();
        self.words_block()
    }

    /// Keeps the level of the first mark of optional skip, on machines that have a row for it.
    fn note_mark(&mut self) {
        if !self.knows_data(data::OPSKIP) {
            return;
        }
        let level = match self.block_scanner() {
            Some(scanner) => scanner.first_mark(&self.text_bytes()),
            None => self.plan.scanner.first_mark(&self.text_bytes()),
        };
        if let Some(runtime) = self.macros.as_deref_mut() {
            runtime.mark = level;
        }
    }

    /// Words that the pre-processor made, on a kernel with macros.
    pub(crate) fn made_block(&mut self) -> Acted {
        if let Some(runtime) = self.macros.as_deref_mut() {
            runtime.made = true;
        }
        let wanted = [Hook::PreprocessorShutdown, Hook::BlockStartup].into_iter().any(|hook| self.hook(hook).is_some());
        if wanted || self.has_embedded(1) {
            self.write_block();
            self.block_macro(Hook::PreprocessorShutdown)?;
            self.scan_again();
        }
        self.words_block()
    }

    /// A text that the pre-processor left, on a kernel with macros.
    pub(crate) fn text_block(&mut self, text: &str) -> Acted {
        if let Some(runtime) = self.macros.as_deref_mut() {
            runtime.made = true;
            runtime.text = Some(Arc::new(text.to_owned()));
        }
        self.block_macro(Hook::PreprocessorShutdown)?;
        self.scan_again();
        self.words_block()
    }

    /// Words as text: what the pre-processor made of its template.
    fn write_block(&mut self) {
        let mut text = String::new();
        if let Some(number) = self.channel.block.sequence {
            let register =
                self.plan.scanner.sequence().and_then(|at| self.channel.env.machine.registers.get(usize::from(at)));
            let name = register.map_or("N", |register| register.name.as_str());
            text.push_str(&format!("{name}{number} "));
        }
        for word in &self.channel.block.words {
            let Some(register) = self.channel.env.machine.registers.get(usize::from(word.register)) else { continue };
            let before = match &register.second {
                Some(second) if word.incremental => second,
                _ => &register.before,
            };
            text.push_str(&format!("{before}{}", word.value));
            if word.value.fract() == 0.0 && register.format.frac > 0 && register.format.point != Point::Fractional {
                text.push('.');
            }
            text.push_str(&register.after);
            text.push(' ');
        }
        for &row in &self.channel.block.texts {
            if let Some(literal) = self.literal_of(row) {
                text.push_str(literal);
                text.push(' ');
            }
        }
        let line = self.text_bytes();
        for &(start, end) in &self.channel.block.unknown {
            let part = line.as_ref().get(start as usize..end as usize).unwrap_or_default();
            text.push_str(&String::from_utf8_lossy(part));
            text.push(' ');
        }
        text.truncate(text.trim_end().len());
        if let Some(runtime) = self.macros.as_deref_mut() {
            runtime.text = Some(Arc::new(text));
        }
    }

    /// The scanner to be used in place of the plan's, once a macro has switched a level of optional skip.
    #[inline]
    pub(crate) fn switched_scanner(&self) -> Option<Arc<Scanner>> {
        self.macros.as_deref().and_then(|runtime| runtime.scanner.clone())
    }

    /// The scanner for the text of the block in process, if not the plan's: what EXEC issued undergoes no block delete.
    #[inline]
    pub(crate) fn block_scanner(&self) -> Option<Arc<Scanner>> {
        let runtime = self.macros.as_deref()?;
        match &self.plan.unmarked {
            _ if runtime.issued => runtime.unmarked.clone(),
            Some(scanner) if runtime.made => Some(Arc::clone(scanner)),
            _ => runtime.scanner.clone(),
        }
    }

    /// `$OPSKIPL`: switches a level of optional skip from the next block on.
    pub(crate) fn switch_level(&mut self, level: u8, on: bool) {
        let before = self.switched_scanner().map_or(self.plan.scanner.levels(), |scanner| scanner.levels());
        let wanted = if on { before | 1 << level } else { before & !(1 << level) };
        let levels: Vec<u8> = (1..16).filter(|level| wanted & 1 << level != 0).collect();
        let machine = self.channel.env.machine;
        if let Some(runtime) = self.macros.as_deref_mut() {
            runtime.scanner = Some(Arc::new(Scanner::new(machine, &levels)));
        }
        // Lines compiled before have the parts that were skipped then.
        self.flow.compiled.clear();
        self.flow.pairs.clear();
    }

    /// Splits the text of the block again; the pre-processor has had its turn.
    fn scan_again(&mut self) {
        let own = self.macros.as_deref().and_then(|runtime| runtime.text.clone());
        if let Some(text) = own {
            let (plan, own) = (self.plan, self.block_scanner());
            let scanner = own.as_deref().unwrap_or(&plan.scanner);
            scanner.scan_as(text.as_bytes(), self.channel.state.secondary, &mut self.channel.block, false);
        }
    }

    /// From the block startup macro on.
    fn words_block(&mut self) -> Acted {
        if self.text_bytes().trim_ascii().is_empty() {
            return Ok(());
        }
        let changed = self.embedded(1)?;
        match self.block_macro(Hook::BlockStartup)? {
            Verdict::Drop => return Ok(()),
            Verdict::Edited => {
                self.scan_again();
                self.trace('E', |kernel| {
                    trace::edited(Stage::BlockMacro, &String::from_utf8_lossy(&kernel.text_bytes()))
                });
            }
            Verdict::Go if changed => self.scan_again(),
            Verdict::Go => {}
        }
        if self.text_bytes().trim_ascii().is_empty() {
            return Ok(());
        }
        if self.channel.env.trace.is_some() {
            self.trace_words();
        }
        if self.may_have_remarks() {
            let text = self.text_bytes().into_owned();
            self.remarks(&text)?;
        }
        self.act_block_of(Origin::Text)
    }

    /// Runs a macro with the arguments of block macros: flag, text, number of the block.
    fn block_macro(&mut self, hook: Hook) -> Result<Verdict, Halt> {
        let Some(runtime) = self.macros.as_deref() else { return Ok(Verdict::Go) };
        let Some(code) = runtime.ready(hook) else { return Ok(Verdict::Go) };
        let asks = runtime.uses(code, 2);
        let text = if asks { self.text_value() } else { Value::Null };
        let given = if let Value::Text(text) = &text { Some(Arc::clone(text)) } else { None };
        let mut arguments = [Value::Real(1.0), text, Value::Real(f64::from(self.channel.at.line))];
        self.run_macro(code, Task::None, &mut arguments)?;
        let [flag, text, _] = arguments;
        let drops = flag.as_real() == Some(0.0);
        let verdict = match (given, text) {
            (Some(given), Value::Text(text)) if !Arc::ptr_eq(&given, &text) && given != text => {
                let (length, limit) = (text.len(), self.channel.env.options.limits.block_length);
                if length > limit {
                    let text = format!("$P2 of the {} has {length} bytes, a block may have {limit}", hook.title());
                    return Err(self.alarm(&diag::BLOCK_TOO_LONG, text));
                }
                if let Some(runtime) = self.macros.as_deref_mut() {
                    runtime.text = Some(text);
                }
                Verdict::Edited
            }
            (Some(_), Value::Text(_)) | (None, _) => Verdict::Go,
            (Some(_), other) => {
                let text =
                    format!("$P2 of the {} is {}, not a text; it is passed over", hook.title(), other.kind_name());
                self.diagnose(&diag::MACRO_RESULT, text);
                Verdict::Go
            }
        };
        Ok(if drops { Verdict::Drop } else { verdict })
    }

    /// Left-over text after the codes: the block shutdown macro may change it.
    pub(crate) fn block_shutdown(&mut self) -> Acted {
        let Some(runtime) = self.macros.as_deref() else { return Ok(()) };
        let Some(code) = runtime.ready(Hook::BlockShutdown) else { return Ok(()) };
        self.left_name();
        let Some(runtime) = self.macros.as_deref() else { return Ok(()) };
        let asks = runtime.uses(code, 2);
        let left = if asks { self.left_text() } else { String::new() };
        let mut arguments =
            [Value::Real(1.0), Value::text(left.as_str()), Value::Real(f64::from(self.channel.at.line))];
        self.run_macro(code, Task::None, &mut arguments)?;
        match &arguments[1] {
            Value::Text(text) if **text != left => {
                let (length, limit) = (text.len(), self.channel.env.options.limits.block_length);
                if length > limit {
                    let title = Hook::BlockShutdown.title();
                    let text = format!("$P2 of the {title} has {length} bytes, a block may have {limit}");
                    return Err(self.alarm(&diag::BLOCK_TOO_LONG, text));
                }
                self.set_left(text.as_ref().clone());
            }
            _ => {}
        }
        Ok(())
    }

    /// Text of the block in process.
    pub(crate) fn text_bytes(&self) -> std::borrow::Cow<'_, [u8]> {
        match self.macros.as_deref().and_then(|runtime| runtime.text.as_ref()) {
            Some(text) => text.as_bytes().into(),
            None => self.current_text().into(),
        }
    }

    /// The same for a macro.
    pub(crate) fn text_value(&mut self) -> Value {
        let (sources, file, line) = (self.channel.env.sources, self.channel.at.file, self.channel.at.line);
        let Some(runtime) = self.macros.as_deref_mut() else { return Value::text("") };
        if let Some(text) = &runtime.text {
            return Value::Text(Arc::clone(text));
        }
        let as_read = || sources.get(file).map_or(&[][..], |source| source.line(line));
        let bytes = self.channel.text.edited.as_deref().unwrap_or_else(as_read);
        Value::Text(runtime.texts.with(|text| {
            text.clear();
            match std::str::from_utf8(bytes) {
                Ok(line) => text.push_str(line),
                Err(_) => text.push_str(&String::from_utf8_lossy(bytes)),
            }
        }))
    }

    /// Text that nothing has recognised, or what a macro left in its place.
    pub(crate) fn left_text(&self) -> String {
        if let Some(text) = self.macros.as_deref().and_then(|runtime| runtime.left.as_ref()) {
            return text.as_ref().clone();
        }
        let parts: Vec<String> = self.channel.block.unknown.iter().map(|&span| self.span_text(span)).collect();
        parts.join(" ")
    }

    /// Replaces the left-over text.
    pub(crate) fn set_left(&mut self, text: String) {
        self.channel.block.unknown.clear();
        if !text.trim().is_empty() {
            // Any span will do: the text comes from here.
            self.channel.block.unknown.push((0, 0));
        }
        if let Some(runtime) = self.macros.as_deref_mut() {
            runtime.left = Some(Arc::new(text));
        }
    }
}

/// What a block macro decided.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Verdict {
    /// The block goes on as it is.
    Go,
    /// Its text has changed.
    Edited,
    /// It is dropped, or the pre-processor skipped.
    Drop,
}
