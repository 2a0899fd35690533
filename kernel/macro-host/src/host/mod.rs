//! A running kernel as the host of its macros.
//!
//! *Invariant:* a macro reads and changes only the state of the kernel itself; data that belong to several kernels are
//! reached through shared operations only. Facts: reference control-emulator.md 4, system-variables.md, functions.md.

pub(crate) mod block;
mod commands;
mod diagnostics;
mod dialogs;
mod files;
mod functions;
mod kinematics;
pub(crate) mod preprocessor;
mod rotary;
mod search;
mod system;
mod trace;
pub(crate) mod variables;

pub(crate) use variables::kernels::{channel_of, set_program_of};

use counterpoint_lang::diag::{DiagnosticNumber, MacroDiagnostic};
use counterpoint_lang::fault::{MacroFault, Outcome};
use counterpoint_lang::format::{FormatRegister, RegisterHost};
use counterpoint_lang::host::{CommandHost, ConsoleHost, HostCommand, HostFn, MacroHost, TraceStep, VariableHost};
use counterpoint_lang::value::MacroValue;
use counterpoint_lang::vm::{MacroState, MemoryTally};
use counterpoint_sync::races::AccessMode;

use crate::context::KernelHost;
use counterpoint_channel::macros::calls::unwinding;
use counterpoint_channel::macros::issued::Later;
use counterpoint_channel::macros::values;
use counterpoint_channel::shared_target::SharedTarget;
use counterpoint_machine::ident::{CodeId, DataId};
use counterpoint_machine::macros::model::Hook;

impl KernelHost<'_, '_> {
    /// Identifier of a code value, none for `CODE_NONE`.
    pub(crate) fn code_id(&self, value: &MacroValue) -> Option<CodeId> {
        values::code_id(self.kernel.channel.env.machine, value)
    }

    /// Identifier of a data value, none for `REG_NONE`.
    pub(crate) fn data_id(&self, value: &MacroValue) -> Option<DataId> {
        values::data_id(self.kernel.channel.env.machine, value)
    }
}

impl RegisterHost for KernelHost<'_, '_> {
    fn code_name(&self, code: u32) -> String {
        match self.code_id(&MacroValue::Code(code)) {
            Some(id) => self.kernel.channel.env.machine.code_name(id).to_owned(),
            None => "CODE_NONE".to_owned(),
        }
    }

    fn register_name(&self, register: u32) -> String {
        match self.data_id(&MacroValue::Register(register)) {
            Some(id) => self.kernel.channel.env.machine.data_name(id).to_owned(),
            None => "REG_NONE".to_owned(),
        }
    }

    fn register_text(&mut self, register: FormatRegister, value: Option<f64>, word: bool) -> Option<String> {
        functions::register_word(&mut self.kernel.channel, register, value, word)
    }
}

impl VariableHost for KernelHost<'_, '_> {
    fn read_system(&mut self, index: u32, indices: &[i64]) -> Outcome<MacroValue> {
        self.read_variable(index, indices)
    }

    fn write_system(&mut self, index: u32, indices: &[i64], value: MacroValue) -> Outcome<()> {
        self.write_variable(index, indices, value)
    }

    fn global(&mut self, index: u32, growth: Option<usize>, access: &mut dyn FnMut(&mut MacroValue)) {
        let limit = self.kernel.channel.env.shares().common;
        let runtime = &mut *self.kernel.macros;
        if runtime.variables.first_shared.is_some_and(|first| index >= first) {
            let place = index as usize;
            let mode = if growth.is_some() { AccessMode::Write } else { AccessMode::Read };
            let done = self.kernel.access(SharedTarget::Global(index), mode, |shared| {
                shared.global(place, access);
                growth.is_some_and(|growth| growth > 0 && shared.grown(growth, limit))
            });
            match done {
                Ok(false) => {}
                Ok(true) => {
                    let halt = self.kernel.out_of_memory("GLOBAL variables and files of macros use most of it");
                    self.kernel.macros.calls.stop(halt);
                }
                Err(halt) => self.kernel.macros.calls.stop(halt),
            }
            return;
        }
        if let Some(value) = self.own_global(index) {
            access(value);
        }
    }

    fn own_global(&mut self, index: u32) -> Option<&mut MacroValue> {
        let runtime = &mut *self.kernel.macros;
        if runtime.variables.first_shared.is_some_and(|first| index >= first) {
            return None;
        }
        let index = index as usize;
        if runtime.variables.globals.len() <= index {
            runtime.variables.globals.resize(index + 1, MacroValue::Unset);
        }
        runtime.variables.globals.get_mut(index)
    }

    fn held(&self, scale: &mut MemoryTally) {
        let runtime = &*self.kernel.macros;
        let mut part = |name: &str, values: &mut dyn Iterator<Item = &MacroValue>| {
            let from = scale.bytes;
            values.for_each(|value| scale.add(value));
            scale.held_by(from, || name.to_owned());
        };
        part("GLOBAL variables", &mut runtime.variables.globals.iter());
        part("system variables", &mut runtime.variables.store.all());
        let from = scale.bytes;
        for later in &runtime.issued.later {
            scale.weigh(match later {
                Later::Text(text, _) => text.len() + 64,
                Later::Items(items, _) => items.len() * 16 + 64,
            });
        }
        scale.held_by(from, || "blocks of EXEC/NEXT".to_owned());
    }
}

impl CommandHost for KernelHost<'_, '_> {
    fn command(&mut self, state: &mut MacroState, command: HostCommand<'_>) -> Outcome<i32> {
        self.check_running(state)?;
        self.macro_command(state, command)
    }
}

impl ConsoleHost for KernelHost<'_, '_> {
    fn report(&mut self, state: &mut MacroState, diagnostic: MacroDiagnostic) {
        if self.kernel.macros.calls.ending || self.kernel.ports.control.cancelled() {
            return;
        }
        let number = diagnostic.number;
        // The verdict of the job says it.
        if number == DiagnosticNumber::MEMORY || state.is_over_memory() {
            return;
        }
        let stops = number == DiagnosticNumber::TICKS
            || self.kernel.channel.env.machine.diagnostics.stops(number.0) == Some(true);
        if !self.kernel.has_room(stops) {
            return;
        }
        if stops {
            self.kernel.channel.reports.alarms.stopping = true;
        }
        let origin = (self.origin_of(&diagnostic), stops);
        let shown = self.customised_of_macro(number, (diagnostic.severity, stops), diagnostic.message);
        let Some((severity, message)) = shown else { return };
        let what = (number.0, severity);
        if self.kernel.macros.ready(Hook::Diagnostic).is_none() {
            return self.issue(what, message, origin);
        }
        // A halt raised here surfaces at the macro's next call of the host.
        let _ = self.hooks().meanwhile(state, |hooks| {
            hooks.host().issue(what, message, origin);
            Ok(())
        });
    }

    fn diagnostic(&self, number: u32) -> Option<(u8, String)> {
        self.diagnostic_entry(number)
    }

    fn trace(&mut self, step: TraceStep<'_>) {
        self.trace_step(step);
    }
}

impl MacroHost for KernelHost<'_, '_> {
    fn function(&mut self, state: &mut MacroState, function: HostFn, arguments: &[MacroValue]) -> Outcome<MacroValue> {
        self.check_running(state)?;
        self.macro_function(state, function, arguments)
    }

    fn stopped(&self) -> bool {
        self.kernel.ports.control.wait_while_suspended();
        self.kernel.ports.control.cancelled()
    }
}

impl KernelHost<'_, '_> {
    /// Refuses everything once the kernel has to leave its program.
    fn check_running(&mut self, state: &mut MacroState) -> Outcome<()> {
        if self.kernel.macros.calls.ending || self.kernel.ports.control.cancelled() {
            Err(unwinding(state))
        } else {
            Ok(())
        }
    }

    /// Refuses a request that is not available in this kind of macro.
    fn not_here<T>(what: &str) -> Outcome<T> {
        Err(MacroFault::new(DiagnosticNumber::NOT_HERE, format!("{what} is not available in this macro")))
    }

    /// Whether the innermost running macro is one of those for which no block has been split into codes and data yet.
    fn before_block(&self) -> bool {
        let hooks = [
            Hook::Declaration,
            Hook::MachineStartup,
            Hook::ProgramStartup,
            Hook::PreprocessorStartup,
            Hook::BlockStartup,
        ];
        hooks.into_iter().any(|hook| self.inside(hook))
    }

    /// Whether the innermost running macro is that of this hook.
    fn inside(&self, hook: Hook) -> bool {
        let code = self.kernel.channel.env.machine.macros.as_deref().and_then(|macros| macros.hook(hook));
        let running = self.kernel.macros.calls.running.last().map(|call| call.code);
        code.is_some() && code == running
    }
}
