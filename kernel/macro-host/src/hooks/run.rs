//! Macros of a kernel as they run: how one starts and ends, and how the kernel works while it runs.
//!
//! *Invariant:* the state of the machine of the language is with the kernel while no macro runs, and with the running
//! macro otherwise. Macros nest as deep as the stack of their thread allows.

use std::sync::Arc;

use counterpoint_channel::macros::calls::{OutputTask, unwinding};
use counterpoint_channel::macros::runtime::Runtime;
use counterpoint_channel::macros::store::names;
use counterpoint_channel::tool_data::report_tools;
use counterpoint_event::info::Info;
use counterpoint_fault::Halt;
use counterpoint_lang::compile::MacroProgram;
use counterpoint_lang::fault::MacroFault;
use counterpoint_lang::value::MacroValue;
use counterpoint_lang::vm;
use counterpoint_lang::vm::{MacroEnd, MacroState};
use counterpoint_machine::macros::model::Macros;

use crate::context::MacroHooks;
use crate::host::variables::positions;

/// Programs and parameters of a job as a command line names them.
fn command_line(info: &Info) -> String {
    let programs = info.channels.iter().filter(|channel| !channel.program.is_empty());
    let mut line = programs.map(|channel| channel.program.as_str()).collect::<Vec<_>>().join(";");
    if !info.parameters.is_empty() {
        line.push_str(" /u ");
        line.push_str(&info.parameters);
    }
    line
}

impl MacroHooks<'_, '_> {
    /// Sets up the macros of the kernel's machine.
    pub(crate) fn set_up_macros(&mut self, program: Option<&Arc<MacroProgram>>) {
        let none = Macros::default();
        // A machine without macros has a program nevertheless if its programs have embedded code.
        let macros = self.kernel.channel.env.machine.macros.as_deref().unwrap_or(&none);
        let memory = self.kernel.channel.env.shares().macros;
        let Some(program) = program else { return };
        // A composite has a master also for one channel.
        let kernels =
            self.kernel.channel.env.machine.channels.len() + usize::from(self.kernel.components.is_composite());
        let mut runtime = Runtime::new(
            macros,
            program,
            self.kernel.channel.env.kernel_number(self.kernel.channel.at.channel),
            (kernels, memory),
        );
        runtime.arguments.slots = positions::six_axes(&self.kernel.channel.state.place);
        runtime.books.set_columns(&self.kernel.channel);
        let (extension, store) =
            (self.kernel.channel.env.machine.subprograms.extension.as_str(), &mut runtime.variables.store);
        store.set(names().extension, MacroValue::text(extension));
        store.set(names().parameters, MacroValue::text(self.kernel.channel.env.info.parameters.as_str()));
        store.set(names().command_line, MacroValue::text(command_line(self.kernel.channel.env.info)));
        *self.kernel.macros = runtime;
    }

    /// Runs a macro; `arguments` hold its `$P` before and after.
    ///
    /// # Errors
    /// Something inside made the kernel leave its program at once.
    pub(crate) fn run_macro(&mut self, code: u16, task: OutputTask, arguments: &mut [MacroValue]) -> Result<u32, Halt> {
        let Some(mut state) = self.kernel.macros.calls.take_state() else { return Ok(0) };
        let program = Arc::clone(&self.kernel.macros.program);
        let selects = task.selects();
        if self.kernel.channel.env.trace.is_some() {
            self.host().trace_entering(code, selects);
        }
        let matching = self.kernel.macros.begin_macro(code, task);
        let limit = self.kernel.macros.calls.limit_nesting(&mut state);
        let (end, _) = vm::run(&program, &mut state, &mut self.host(), code, arguments);
        state.limits.depth = limit;
        let outputs = self.macro_ended(state, code, matching, end);
        if self.kernel.channel.env.trace.is_some() {
            self.host().trace_leaving(code, selects);
        }
        outputs
    }

    /// Runs embedded code for its value.
    ///
    /// # Errors
    /// As [`run_macro`](Self::run_macro).
    pub(crate) fn run_embedded(&mut self, code: u16) -> Result<MacroValue, Halt> {
        let Some(mut state) = self.kernel.macros.calls.take_state() else { return Ok(MacroValue::Null) };
        let program = Arc::clone(&self.kernel.macros.program);
        let matching = self.kernel.macros.begin_macro(code, OutputTask::None);
        let limit = self.kernel.macros.calls.limit_nesting(&mut state);
        let (end, value) = vm::run(&program, &mut state, &mut self.host(), code, &mut []);
        state.limits.depth = limit;
        self.macro_ended(state, code, matching, end)?;
        Ok(value)
    }

    fn macro_ended(
        &mut self,
        mut state: Box<MacroState>,
        code: u16,
        matching: bool,
        end: MacroEnd,
    ) -> Result<u32, Halt> {
        if state.depth == 0 {
            self.kernel.channel.burden.steps += state.limits.ticks - state.ticks;
        }
        let over = state.over_memory();
        let runtime = &mut *self.kernel.macros;
        runtime.calls.put_state(state);
        runtime.hooks.matching = matching;
        let outputs = runtime.calls.end(code);
        let inside = !runtime.calls.running.is_empty();
        if runtime.calls.ending {
            let halt = runtime.calls.halt.unwrap_or(Halt::Stopped);
            if !inside {
                runtime.calls.resume();
            }
            return Err(halt);
        }
        if end == MacroEnd::Budget {
            // Reported with its place; a control whose macros run indefinitely is stopped.
            let halt = match over {
                Some(largest) => self.macros_out_of_memory(&largest),
                None if self.kernel.ports.control.cancelled() => Halt::Stopped,
                None => Halt::Alarm,
            };
            self.kernel.macros.calls.ending = inside;
            if inside {
                self.kernel.macros.calls.halt = Some(halt);
            }
            return Err(halt);
        }
        let halt = if inside { None } else { runtime.calls.halt.take() };
        if !inside && runtime.tools.take_changed() {
            report_tools(&mut self.kernel.channel, &self.kernel.macros);
        }
        halt.map_or(Ok(outputs), Err)
    }

    /// Ends the job: the macros of this kernel keep more than their share of its memory.
    fn macros_out_of_memory(&mut self, largest: &str) -> Halt {
        let share = self.kernel.channel.env.shares().macros;
        self.kernel
            .out_of_memory(&format!("macros of this kernel keep more than {share} bytes, most of them in {largest}"))
    }

    /// Lets the kernel work while a macro is running: its state lies here meanwhile.
    ///
    /// # Errors
    /// The work made the kernel leave its program: all running macros end.
    pub(crate) fn meanwhile(
        &mut self,
        state: &mut MacroState,
        work: impl FnOnce(&mut Self) -> counterpoint_fault::Acted,
    ) -> Result<(), MacroFault> {
        let runtime = &mut *self.kernel.macros;
        runtime.calls.lend_state(state);
        let inner = runtime.calls.innermost().is_none_or(|call| call.matching);
        let outer = std::mem::replace(&mut runtime.hooks.matching, inner);
        let done = work(self);
        let runtime = &mut *self.kernel.macros;
        runtime.hooks.matching = outer;
        runtime.calls.return_state(state);
        done.map_err(|halt| {
            (runtime.calls.halt, runtime.calls.ending) = (Some(halt), true);
            unwinding(state)
        })
    }
}
