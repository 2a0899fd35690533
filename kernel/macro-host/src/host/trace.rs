//! Macros in the trace: entering, statements, leaving, and the blocks of EXEC.
//!
//! Facts: reference listing-and-trace.md 4, 6. The letter M shows the macros of codes and data, H all others, X the
//! parameters of EXEC. *Invariant:* a macro and everything it shows has one letter; without a trace nothing here is
//! called.

use counterpoint_channel::macros::runtime::Runtime;
use counterpoint_channel::trace;
use counterpoint_channel::trace::trace_line;
use counterpoint_lang::host::TraceStep;
use counterpoint_lang::value::MacroValue;
use counterpoint_machine::Machine;
use counterpoint_machine::macros::condition::BlockIdentifier;
use counterpoint_machine::macros::model::{Hook, SELECT_TOOL};

use crate::context::KernelHost;

impl KernelHost<'_, '_> {
    /// A macro of the machine begins.
    #[cold]
    pub(crate) fn trace_entering(&mut self, code: u16, selects: bool) {
        let letter = macro_letter(self.kernel.channel.env.machine, code);
        trace_line(&mut self.kernel.channel, letter, |channel| {
            trace::entering(macro_name(channel.env.machine, code, selects), &matching_list(channel.env.machine, code))
        });
    }

    /// A macro of the machine has ended.
    #[cold]
    pub(crate) fn trace_leaving(&mut self, code: u16, selects: bool) {
        let letter = macro_letter(self.kernel.channel.env.machine, code);
        trace_line(&mut self.kernel.channel, letter, |channel| {
            trace::leaving(
                macro_name(channel.env.machine, code, selects),
                &matching_list(channel.env.machine, code),
                running_name(channel.env.machine, &self.kernel.macros),
            )
        });
    }

    /// A step inside a macro: its statements, and the user functions it calls.
    pub(crate) fn trace_step(&mut self, step: TraceStep<'_>) {
        match step {
            TraceStep::Statement(code, text) => {
                let running = self.kernel.macros.calls.running.last().map(|call| call.code);
                let letter = if code.is_function {
                    'H'
                } else {
                    running.map_or('H', |code| macro_letter(self.kernel.channel.env.machine, code))
                };
                trace_line(&mut self.kernel.channel, letter, |_| trace::statement(text));
            }
            TraceStep::Entering(code) if code.is_function => {
                trace_line(&mut self.kernel.channel, 'H', |_| trace::entering(code.name, ""));
                if let Some(call) = self.kernel.macros.calls.innermost() {
                    call.functions.push(code.name.to_owned());
                }
            }
            TraceStep::Leaving(code, _) if code.is_function => {
                if let Some(call) = self.kernel.macros.calls.innermost() {
                    call.functions.pop();
                }
                trace_line(&mut self.kernel.channel, 'H', |channel| {
                    trace::leaving(code.name, "", running_name(channel.env.machine, &self.kernel.macros))
                });
            }
            // The caller of a macro of the machine shows it with its name in the machine.
            TraceStep::Entering(_) | TraceStep::Leaving(..) => {}
        }
    }

    /// EXEC of a block.
    pub(crate) fn trace_exec_text(&mut self, now: bool, text: &str) {
        trace_line(&mut self.kernel.channel, 'X', |_| {
            trace::exec(&format!("{},'{}'", when(now), text.replace('\'', "''")))
        });
    }

    /// EXEC of identifiers and values.
    pub(crate) fn trace_exec_items(&mut self, now: bool, items: &[MacroValue]) {
        if self.kernel.channel.env.trace.is_some() {
            let listed = self.listed(items);
            trace_line(&mut self.kernel.channel, 'X', |_| trace::exec(&format!("{},{listed}", when(now))));
        }
    }

    /// Identifiers and values as EXEC lists them.
    pub(crate) fn listed(&self, items: &[MacroValue]) -> String {
        let mut text = String::new();
        for (at, item) in items.iter().enumerate() {
            if at > 0 {
                text.push(',');
            }
            counterpoint_lang::format::any(&mut text, item, self);
        }
        text
    }

    /// The innermost macro of the running machine.
    pub(crate) fn called_name(&self) -> Option<&str> {
        let call = self.kernel.macros.calls.running.last()?;
        Some(macro_name(self.kernel.channel.env.machine, call.code, call.task.selects()))
    }
}

/// The macro that continues, innermost first; none if no macro is running.
fn running_name<'k>(machine: &'k Machine, macros: &'k Runtime) -> Option<&'k str> {
    let call = macros.calls.running.last()?;
    let name = || macro_name(machine, call.code, call.task.selects());
    Some(call.functions.last().map_or_else(name, String::as_str))
}

fn when(now: bool) -> &'static str {
    if now { "NOW" } else { "NEXT" }
}

fn macro_letter(machine: &Machine, code: u16) -> char {
    let named = machine.macros.as_deref().is_some_and(|macros| macros.is_named(code));
    if named { 'M' } else { 'H' }
}

/// Name of a macro; the macro of tools has two, for selecting and for loading a tool.
fn macro_name(machine: &Machine, code: u16, selects: bool) -> &str {
    let macros = machine.macros.as_deref();
    match macros.filter(|_| selects).and_then(|macros| macros.hook(Hook::Tool)) {
        Some(tool) if tool == code => SELECT_TOOL,
        _ => macros.and_then(|macros| macros.name_of(code)).unwrap_or("embedded code"),
    }
}

/// The list of identifiers that a code macro matches, empty for all others.
fn matching_list(machine: &Machine, code: u16) -> String {
    let named = machine.macros.as_deref().and_then(|macros| macros.code_macro(code));
    let list = named.map_or(&[][..], |named| named.matches.as_slice()).iter().filter_map(|item| match item {
        BlockIdentifier::Code(id) => Some(machine.code_name(*id)),
        BlockIdentifier::Data(_) => None,
    });
    list.collect::<Vec<_>>().join(", ")
}
