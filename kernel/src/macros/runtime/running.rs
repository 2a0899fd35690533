//! Macros of a kernel as they run: how one begins and ends, and what the kernel does meanwhile.
//!
//! Invariant: the state of the machine of the language lies with the kernel while no macro runs, and goes to the one that
//! does; macros nest as deep as the stack of their thread holds.

use counterpoint_fault::Halt;
use std::sync::Arc;

use counterpoint_lang::compile::Program;
use counterpoint_lang::fault::Fault;
use counterpoint_lang::value::Value;
use counterpoint_lang::vm::{self, End, State};

use super::{Call, MOST_NESTED, Runtime, Task, limits, unwinding};
use crate::channel::Kernel;
use crate::log::info::Info;
use crate::machine::macros::model::{Hook, Macros};
use crate::macros::host::variables::names;

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

impl Kernel<'_> {
    /// Gives the kernel the macros of its machine.
    pub(crate) fn with_macros(mut self, program: Option<&Arc<Program>>) -> Self {
        let none = Macros::default();
        // A machine without macros has a program all the same if its programs have embedded code.
        let macros = self.channel.env.machine.macros.as_deref().unwrap_or(&none);
        let memory = self.channel.shares().macros;
        self.macros = program.map(|program| {
            let mut runtime = Runtime::new(
                macros,
                program,
                self.channel.kernel_number(),
                (self.channel.env.machine.channels.len(), memory),
            );
            runtime.slots = self.six_axes();
            runtime.columns = self.travel_columns();
            let extension = self.channel.env.machine.subprograms.extension.as_str();
            runtime.store.set(names().extension, Value::text(extension));
            runtime.store.set(names().parameters, Value::text(self.channel.env.info.parameters.as_str()));
            runtime.store.set(names().command_line, Value::text(command_line(self.channel.env.info)));
            Box::new(runtime)
        });
        self
    }

    /// The macro of a hook that may run now.
    #[inline]
    pub(crate) fn hook(&self, hook: Hook) -> Option<u16> {
        self.macros.as_deref().and_then(|runtime| runtime.ready(hook))
    }

    /// Runs a macro; `arguments` hold its `$P` before and after.
    ///
    /// # Errors
    /// Something inside made the kernel leave its program at once.
    pub(crate) fn run_macro(&mut self, code: u16, task: Task, arguments: &mut [Value]) -> Result<u32, Halt> {
        let Some(runtime) = self.macros.as_deref_mut() else { return Ok(0) };
        let Some(mut state) = runtime.state.take() else { return Ok(0) };
        let program = Arc::clone(&runtime.program);
        let selects = task.selects();
        if self.channel.env.trace.is_some() {
            self.trace_entering(code, selects);
        }
        let Some(runtime) = self.macros.as_deref_mut() else { return Ok(0) };
        runtime.calls.push(Call { code, task, matching: true, outputs: 0, functions: Vec::new() });
        runtime.set_busy(code, true);
        let matching = std::mem::replace(&mut runtime.matching, true);
        let limit = self.limit_nesting(&mut state);
        let (end, _) = vm::run(&program, &mut state, self, code, arguments);
        state.limits.depth = limit;
        let outputs = self.macro_ended(state, code, matching, end);
        if self.channel.env.trace.is_some() {
            self.trace_leaving(code, selects);
        }
        outputs
    }

    /// Runs embedded code for its value.
    ///
    /// # Errors
    /// As [`run_macro`](Self::run_macro).
    pub(crate) fn run_embedded(&mut self, code: u16) -> Result<Value, Halt> {
        let Some(runtime) = self.macros.as_deref_mut() else { return Ok(Value::Null) };
        let Some(mut state) = runtime.state.take() else { return Ok(Value::Null) };
        let program = Arc::clone(&runtime.program);
        runtime.calls.push(Call { code, task: Task::None, matching: true, outputs: 0, functions: Vec::new() });
        runtime.set_busy(code, true);
        let matching = std::mem::replace(&mut runtime.matching, true);
        let limit = self.limit_nesting(&mut state);
        let (end, value) = vm::run(&program, &mut state, self, code, &mut []);
        state.limits.depth = limit;
        self.macro_ended(state, code, matching, end)?;
        Ok(value)
    }

    /// Lets no further macro begin where the stack of the thread would not hold it; gives the limit as it was.
    fn limit_nesting(&self, state: &mut State) -> u32 {
        let limit = state.limits.depth;
        if self.macros.as_deref().is_some_and(|runtime| runtime.calls.len() > MOST_NESTED) {
            state.limits.depth = state.depth;
        }
        limit
    }

    fn macro_ended(&mut self, mut state: Box<State>, code: u16, matching: bool, end: End) -> Result<u32, Halt> {
        let Some(runtime) = self.macros.as_deref_mut() else { return Ok(0) };
        if state.depth == 0 {
            self.channel.burden.steps += state.limits.ticks - state.ticks;
        }
        let over = state.over_memory();
        runtime.state = Some(state);
        runtime.set_busy(code, false);
        runtime.matching = matching;
        let outputs = runtime.calls.pop().map_or(0, |call| call.outputs);
        if runtime.ending {
            let halt = runtime.halt.unwrap_or(Halt::Stopped);
            if runtime.calls.is_empty() {
                runtime.ending = false;
                runtime.halt = None;
            }
            return Err(halt);
        }
        if end == End::Budget {
            let inside = !runtime.calls.is_empty();
            // Reported with its place; a control whose macros run for ever stands still.
            let halt = match over {
                Some(largest) => self.macros_out_of_memory(&largest),
                None if self.ports.control.cancelled() => Halt::Stopped,
                None => Halt::Alarm,
            };
            if let Some(runtime) = self.macros.as_deref_mut() {
                runtime.ending = inside;
                if inside {
                    runtime.halt = Some(halt);
                }
            }
            return Err(halt);
        }
        let halt = if runtime.calls.is_empty() { runtime.halt.take() } else { None };
        if runtime.tools_changed && runtime.calls.is_empty() {
            runtime.tools_changed = false;
            self.tell_tools();
        }
        halt.map_or(Ok(outputs), Err)
    }

    /// Ends the job: the macros of this kernel keep more than their share of its memory.
    fn macros_out_of_memory(&mut self, largest: &str) -> Halt {
        let share = self.channel.shares().macros;
        self.out_of_memory(&format!("macros of this kernel keep more than {share} bytes, most of them in {largest}"))
    }

    /// Keeps a reason to leave the program until whoever runs the block can act on it.
    pub(crate) fn keep_halt(&mut self, halt: Halt) {
        if let Some(runtime) = self.macros.as_deref_mut() {
            runtime.halt = Some(halt);
            runtime.ending = !runtime.calls.is_empty();
        }
    }

    /// Lets the kernel work while a macro is running: its state lies here meanwhile.
    ///
    /// # Errors
    /// The work made the kernel leave its program: all running macros end.
    pub(crate) fn meanwhile(
        &mut self,
        state: &mut State,
        work: impl FnOnce(&mut Self) -> counterpoint_fault::Acted,
    ) -> Result<(), Fault> {
        let Some(runtime) = self.macros.as_deref_mut() else { return Ok(()) };
        let mut spare = runtime.spares.pop().unwrap_or_else(|| Box::new(State::new(limits(0))));
        std::mem::swap(&mut *spare, state);
        runtime.state = Some(spare);
        let outer = runtime.matching;
        runtime.matching = runtime.call().is_none_or(|call| call.matching);
        let done = work(self);
        let Some(runtime) = self.macros.as_deref_mut() else { return Ok(()) };
        runtime.matching = outer;
        if let Some(mut spare) = runtime.state.take() {
            std::mem::swap(&mut *spare, state);
            runtime.spares.push(spare);
        }
        match done {
            Ok(()) => Ok(()),
            Err(halt) => {
                runtime.halt = Some(halt);
                runtime.ending = true;
                Err(unwinding(state))
            }
        }
    }
}
