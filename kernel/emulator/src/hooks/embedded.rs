//! Embedded macro code: code between `#{` or `!{` and `}` runs and its value takes its place.
//!
//! Facts: reference control-emulator.md 2.2, 5.3. *Invariant:* a piece of code is compiled once; code in a skipped
//! portion of a block is not run.

use counterpoint_fault::{Acted, Halt};
use std::sync::Arc;

use crate::channel::Kernel;
use crate::pipeline::edit;
use crate::trace::{self, TextStage};
use counterpoint_event::info::cut;
use counterpoint_fault as diag;

use counterpoint_lang::value::MacroValue;

/// Longest piece of embedded code, in bytes; how many different ones are remembered.
const LONGEST_CODE: usize = 4096;
const MOST_CODES: usize = 5000;

impl Kernel<'_> {
    /// Block delete comes before embedded code, which the block holds; a mark inside such code is none.
    pub(crate) fn delete_around_code(&mut self) {
        let text = self.channel.text_bytes().into_owned();
        let seen = self.without_code(&text);
        let (plan, switched) = (self.plan, self.macros.reading.switched.clone());
        let scanner = switched.as_deref().unwrap_or(&plan.scanner);
        let Some((active, left)) = scanner.without_deleted(&text, &seen) else { return };
        let left = String::from_utf8_lossy(&left).into_owned();
        let stage = if active { TextStage::DeleteOn } else { TextStage::DeleteOff };
        self.trace('E', |_| trace::edited(stage, left.trim()));
        self.channel.context.text = Some(Arc::new(left));
    }

    /// The text with blanks in place of embedded code.
    fn without_code(&self, text: &[u8]) -> Vec<u8> {
        let mut seen = text.to_vec();
        let [first, second, close] = &self.macros.variables.store.embedding;
        for open in [first, second].into_iter().filter(|open| !open.is_empty() && !close.is_empty()) {
            let mut from = 0;
            while let Some(at) = text.get(from..).and_then(|rest| memchr::memmem::find(rest, open.as_bytes())) {
                let start = from + at;
                let inside = start + open.len();
                let end = text.get(inside..).and_then(|rest| memchr::memmem::find(rest, close.as_bytes()));
                from = end.map_or(text.len(), |end| inside + end + close.len());
                seen.get_mut(start..from).unwrap_or_default().fill(b' ');
            }
        }
        seen
    }

    /// Whether the block may hold embedded code of this kind: 0 before, 1 after the pre-processor.
    pub(crate) fn has_embedded(&self, kind: usize) -> bool {
        let runtime = &*self.macros;
        let open = runtime.variables.store.embedding.get(kind).map_or("", String::as_str);
        let Some(&first) = open.as_bytes().first() else { return false };
        let absent = self.channel.context.text.is_none() && edit::is_line_without(&self.channel, first);
        !absent && contains(&self.channel.text_bytes(), open.as_bytes())
    }

    /// Runs embedded code and puts its values in its place; true if there was any.
    pub(crate) fn embedded(&mut self, kind: usize) -> Result<bool, Halt> {
        if !self.has_embedded(kind) {
            return Ok(false);
        }
        let delimiter =
            |kernel: &Self, at: usize| kernel.macros.variables.store.embedding.get(at).cloned().unwrap_or_default();
        let (open, close) = (delimiter(self, kind), delimiter(self, 2));
        if close.is_empty() {
            return Ok(false);
        }
        let text = String::from_utf8_lossy(&self.channel.text_bytes()).into_owned();
        let mut out = String::new();
        let mut rest = text.as_str();
        while let Some((before, after)) = rest.split_once(open.as_str()) {
            out.push_str(before);
            let Some((code, behind)) = after.split_once(close.as_str()) else {
                let text = format!("embedded macro code without '{close}' in '{}'", self.channel.block_text());
                self.diagnose(&diag::EMBEDDED_CODE, text);
                rest = "";
                break;
            };
            self.embed(code, &mut out)?;
            if out.len() > self.channel.env.options.limits.block_length.max(text.len()) {
                break;
            }
            rest = behind;
        }
        out.push_str(rest);
        let (length, limit) = (out.len(), self.channel.env.options.limits.block_length.max(text.len()));
        if length > limit {
            let text = format!("embedded macro code makes {length} bytes of the block, it may have {limit}");
            return Err(self.alarm(&diag::BLOCK_TOO_LONG, text));
        }
        if out != text {
            self.trace('E', |_| trace::edited(TextStage::EmbeddedMacro, out.trim()));
        }
        self.channel.context.text = Some(Arc::new(out));
        Ok(true)
    }

    /// One piece of embedded code: its value, formatted, goes to the text.
    fn embed(&mut self, code: &str, out: &mut String) -> Acted {
        let Some((index, gives)) = self.compiled_code(code) else { return Ok(()) };
        if self.macros.calls.is_busy(index) {
            return Ok(());
        }
        let value = self.run_embedded(index)?;
        if gives && !matches!(value, MacroValue::Unset) {
            counterpoint_lang::format::any(out, &value, self);
        }
        Ok(())
    }

    /// Compiles embedded code once.
    fn compiled_code(&mut self, code: &str) -> Option<(u16, bool)> {
        let machine = self.channel.env.machine;
        let runtime = &mut *self.macros;
        if let Some(known) = runtime.reading.embedded.get(code) {
            return *known;
        }
        if code.len() > LONGEST_CODE || runtime.reading.embedded.len() >= MOST_CODES {
            let text = format!(
                "embedded macro code of more than {LONGEST_CODE} bytes, or more than {MOST_CODES} different pieces"
            );
            self.diagnose(&diag::EMBEDDED_CODE, text);
            return None;
        }
        let mut environment = machine.macro_environment();
        let source = counterpoint_lang::source::MacroSource::new("embedded code", statements(code));
        let expression = counterpoint_lang::parse::expression(&source).is_some();
        let program = Arc::make_mut(&mut runtime.program);
        // No macro of another kernel knows a name that is first declared here.
        let options = counterpoint_lang::compile::CompileOptions { globals_are_objects: true, ..Default::default() };
        let added = counterpoint_lang::compile::embedded(program, &mut environment, source, options);
        let index = if added.has_errors() { None } else { added.macros.first().map(|&at| (at, expression)) };
        runtime.measure();
        runtime.reading.embedded.insert(code.to_owned(), index);
        if let Some(wrong) = added.diagnostics.iter().find(|diagnostic| diagnostic.is_error()) {
            let text = format!("embedded macro code '{}': {} {}", cut(code, 60), wrong.number, wrong.message);
            self.diagnose(&diag::EMBEDDED_CODE, text);
        }
        index
    }
}

/// Whether a short text is part of another one. Few blocks have its first byte.
#[inline]
fn contains(text: &[u8], part: &[u8]) -> bool {
    let Some(at) = part.first().and_then(|first| memchr::memchr(*first, text)) else { return false };
    text.get(at..).is_some_and(|rest| memchr::memmem::find(rest, part).is_some())
}

/// Embedded statements on lines of their own: a semicolon outside a text ends one.
fn statements(code: &str) -> String {
    let mut inside = false;
    let line = |c: char| {
        inside ^= c == '\'';
        if c == ';' && !inside { '\n' } else { c }
    };
    code.chars().map(line).collect()
}
