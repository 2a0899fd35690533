//! Embedded macro code: code between `#{` or `!{` and `}` runs and its value takes its place.
//!
//! Facts: reference control-emulator.md 2.2, 5.3. *Invariant:* a piece of code is compiled once; code in a skipped
//! portion of a block is not run.

use std::sync::Arc;

use counterpoint_channel::macro_queries::has_embedded;
use counterpoint_channel::trace;
use counterpoint_channel::trace::{TextStage, trace_line};
use counterpoint_emulator::channel::Kernel;
use counterpoint_event::info::cut;
use counterpoint_fault as diag;
use counterpoint_fault::{Acted, Halt};
use counterpoint_lang::value::MacroValue;

use crate::context::MacroHooks;

/// Longest piece of embedded code, in bytes; how many different ones are remembered.
const LONGEST_CODE: usize = 4096;
const MOST_CODES: usize = 5000;

/// Applies block delete before the embedded code of the block. A mark inside such code does not count.
pub(crate) fn delete_around_code(hooks: &mut MacroHooks<'_, '_>) {
    let text = hooks.kernel.channel.text_bytes().into_owned();
    let seen = without_code(hooks.kernel, &text);
    let (tables, switched) = (hooks.kernel.channel.tables, hooks.kernel.macros.reading.switched.clone());
    let scanner = switched.as_deref().unwrap_or(&tables.scanner);
    let Some((active, left)) = scanner.without_deleted(&text, &seen) else { return };
    let left = String::from_utf8_lossy(&left).into_owned();
    let stage = if active { TextStage::DeleteOn } else { TextStage::DeleteOff };
    trace_line(&mut hooks.kernel.channel, 'E', |_| trace::edited(stage, left.trim()));
    hooks.kernel.channel.context.text = Some(Arc::new(left));
}

/// The text with blanks in place of embedded code.
fn without_code(kernel: &Kernel<'_>, text: &[u8]) -> Vec<u8> {
    let mut seen = text.to_vec();
    let [first, second, close] = &kernel.macros.variables.store.embedding;
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

/// Runs embedded code and puts its values in its place; true if there was any.
pub(crate) fn embedded(hooks: &mut MacroHooks<'_, '_>, kind: usize) -> Result<bool, Halt> {
    if !has_embedded(&hooks.kernel.channel, &hooks.kernel.macros, kind) {
        return Ok(false);
    }
    let delimiter =
        |kernel: &Kernel<'_>, at: usize| kernel.macros.variables.store.embedding.get(at).cloned().unwrap_or_default();
    let (open, close) = (delimiter(hooks.kernel, kind), delimiter(hooks.kernel, 2));
    if close.is_empty() {
        return Ok(false);
    }
    let text = String::from_utf8_lossy(&hooks.kernel.channel.text_bytes()).into_owned();
    let mut out = String::new();
    let mut rest = text.as_str();
    while let Some((before, after)) = rest.split_once(open.as_str()) {
        out.push_str(before);
        let Some((code, behind)) = after.split_once(close.as_str()) else {
            let text = format!("embedded macro code without '{close}' in '{}'", hooks.kernel.channel.block_text());
            hooks.kernel.diagnose(&diag::EMBEDDED_CODE, text);
            rest = "";
            break;
        };
        embed(hooks, code, &mut out)?;
        if out.len() > hooks.kernel.channel.env.options.limits.block_length.max(text.len()) {
            break;
        }
        rest = behind;
    }
    out.push_str(rest);
    let (length, limit) = (out.len(), hooks.kernel.channel.env.options.limits.block_length.max(text.len()));
    if length > limit {
        let text = format!("embedded macro code makes {length} bytes of the block, it may have {limit}");
        return Err(hooks.kernel.alarm(&diag::BLOCK_TOO_LONG, text));
    }
    if out != text {
        trace_line(&mut hooks.kernel.channel, 'E', |_| trace::edited(TextStage::EmbeddedMacro, out.trim()));
    }
    hooks.kernel.channel.context.text = Some(Arc::new(out));
    Ok(true)
}

/// One piece of embedded code: its value, formatted, goes to the text.
fn embed(hooks: &mut MacroHooks<'_, '_>, code: &str, out: &mut String) -> Acted {
    let Some((index, gives)) = compiled_code(hooks.kernel, code) else { return Ok(()) };
    if hooks.kernel.macros.calls.is_busy(index) {
        return Ok(());
    }
    let value = hooks.run_embedded(index)?;
    if gives && !matches!(value, MacroValue::Unset) {
        counterpoint_lang::format::any(out, &value, &hooks.host());
    }
    Ok(())
}

/// Compiles embedded code once.
fn compiled_code(kernel: &mut Kernel<'_>, code: &str) -> Option<(u16, bool)> {
    let machine = kernel.channel.env.machine;
    let runtime = &mut *kernel.macros;
    if let Some(known) = runtime.reading.embedded.get(code) {
        return *known;
    }
    if code.len() > LONGEST_CODE || runtime.reading.embedded.len() >= MOST_CODES {
        let text = format!(
            "embedded macro code of more than {LONGEST_CODE} bytes, or more than {MOST_CODES} different pieces"
        );
        kernel.diagnose(&diag::EMBEDDED_CODE, text);
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
        kernel.diagnose(&diag::EMBEDDED_CODE, text);
    }
    index
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
