//! Functions of macros that need the kernel.
//!
//! Facts: reference functions.md. Functions of a machine model answer as a control without a model does: nothing, with
//! one message a run.

use super::rotary;
use super::search;
use super::variables::frames;
use counterpoint_lang::diag::DiagnosticNumber;
use counterpoint_lang::fault::{MacroFault, Outcome};
use counterpoint_lang::format::{
    ColumnStyle, FormatRegister, Numeric, PointStyle as Dot, ZeroStyle as Fill, wildcard_text,
};
use counterpoint_lang::host::{AbsentFn, HostFn, macro_states};
use counterpoint_lang::pattern::STEPS;
use counterpoint_lang::value::{MacroValue, ValueType};
use counterpoint_lang::vm::MacroState;
use counterpoint_machine::Machine;

use super::rotary::only_axes;
use crate::context::KernelHost;
use crate::host::kinematics;
use crate::host::variables::offsets;
use counterpoint_channel::channel_context::ChannelContext;
use counterpoint_channel::macros::parts::Restart;
use counterpoint_channel::macros::store::names;
use counterpoint_channel::offset_tables::{OffsetTable, Radii};
use counterpoint_event::event::FileId;
use counterpoint_machine::index::RegisterId;
use counterpoint_machine::macros::model::{FIRST_HOOK_ID, Hook, SELECT_TOOL};
use counterpoint_machine::macros::without;
use counterpoint_machine::rows::{DecimalPointRule, NumberFormat, Register as MachineRegister, ZeroRule};

fn text(arguments: &[MacroValue], at: usize) -> &str {
    arguments.get(at).and_then(MacroValue::as_text).unwrap_or("")
}

impl KernelHost<'_, '_> {
    pub(crate) fn macro_function(
        &mut self,
        state: &mut MacroState,
        function: HostFn,
        arguments: &[MacroValue],
    ) -> Outcome<MacroValue> {
        Ok(match function {
            HostFn::EndOfProgram => MacroValue::Logical(search::at_end(self)),
            HostFn::SearchForward => search::search_program(self, state, arguments, true)?,
            HostFn::SearchBackward => search::search_program(self, state, arguments, false)?,
            HostFn::DiagnosticSeverity => self.severity_of(arguments)?,
            HostFn::DiagnosticState => self.switched(arguments),
            HostFn::DiagnosticText => self.text_of(arguments),
            HostFn::MacroNames => self.macro_ids(state, arguments)?,
            HostFn::MacroStates => macro_states(arguments, |id, on| self.switch_macro(id, on)),
            HostFn::RegisterFormat => MacroValue::text(register_format(&self.kernel.channel, arguments)),
            HostFn::RegisterPosition => {
                let register = register_at(self.kernel.channel.env.machine, arguments.first());
                let index = register.map(|register| self.kernel.channel.env.machine.registers[register].index);
                index.map_or(MacroValue::Real(-1.0), |index| MacroValue::Real(f64::from(index)))
            }
            HostFn::AddItem | HostFn::TakeItem | HostFn::SeekItem if self.before_block() => {
                return Self::not_here(function.name());
            }
            HostFn::AddItem => self.add_item(arguments)?,
            HostFn::TakeItem => self.take_item(state, arguments)?,
            HostFn::SeekItem => self.seek_item(arguments)?,
            HostFn::ActiveCode => self.active_code(arguments, false),
            HostFn::SetActiveCode => self.active_code(arguments, true),
            HostFn::DataAsCode => self.data_as_code(arguments),
            HostFn::NcVariable => self.nc_variable(arguments),
            HostFn::SetNcVariable => MacroValue::Logical(self.set_nc_variable(arguments)),
            HostFn::PreProcessorSetting => self.preprocessor_setting(state, arguments),
            HostFn::MachineFrame => MacroValue::numbers(&[1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0]),
            HostFn::Restart => self.restart_with(state, arguments)?,
            HostFn::Dialog => self.show_dialog(state, text(arguments, 0))?,
            HostFn::ForwardKinematics => kinematics::forward(&self.kernel.channel, arguments)?,
            HostFn::InverseKinematics => kinematics::backward(&self.kernel.channel, arguments)?,
            HostFn::ConfigureKinematics => kinematics::configure(&mut self.kernel.channel, only_axes(arguments)?),
            HostFn::SelectRotaryAxes => kinematics::choose_rotary(&mut self.kernel.channel, only_axes(arguments)?),
            HostFn::Unwind => rotary::unwind_named(self, only_axes(arguments)?),
            HostFn::CutterDiameter => offsets::read_radius(&self.kernel.channel, Radii::Cutter, arguments)?,
            HostFn::CornerRadius => offsets::read_radius(&self.kernel.channel, Radii::Corner, arguments)?,
            HostFn::LengthOffset => offsets::read_offset(&self.kernel.channel, OffsetTable::Length, arguments)?,
            HostFn::WorkOffset => offsets::read_offset(&self.kernel.channel, OffsetTable::Work, arguments)?,
            HostFn::SetCutterDiameter => offsets::write_radius(&mut self.kernel.channel, Radii::Cutter, arguments)?,
            HostFn::SetCornerRadius => offsets::write_radius(&mut self.kernel.channel, Radii::Corner, arguments)?,
            HostFn::SetLengthOffset => offsets::write_offset(self, OffsetTable::Length, arguments)?,
            HostFn::SetWorkOffset => offsets::write_offset(self, OffsetTable::Work, arguments)?,
            HostFn::LocalFrame => frames::give_frame(self, arguments)?,
            HostFn::File(function) => self.file_function(state, function, arguments)?,
            HostFn::Absent(AbsentFn::Apply) if self.kernel.components.is_composite() => {
                self.ask_for_component(arguments)?
            }
            HostFn::Absent(function) => self.absent(state, function),
        })
    }

    /// Answers a function that has nothing to work on, and reports that once for each function.
    fn absent(&mut self, state: &mut MacroState, function: AbsentFn) -> MacroValue {
        let of = HostFn::Absent(function);
        let asked = &mut self.kernel.macros.outside.asked;
        if !asked.absent.contains(&function) {
            asked.absent.push(function);
            state
                .warn(MacroFault::new(DiagnosticNumber::NO_MODEL, format!("{} {}", of.name(), without::why(function))));
        }
        of.result().map_or(MacroValue::Null, ValueType::initial)
    }

    /// `$FAPPLY`: another component works in this channel from the next block on.
    fn ask_for_component(&mut self, arguments: &[MacroValue]) -> Outcome<MacroValue> {
        if self.kernel.channel.at.channel == 0 || self.inside(Hook::Declaration) || self.inside(Hook::ProgramShutdown) {
            return Self::not_here("$FAPPLY");
        }
        let keyword = |code: &i32| counterpoint_lang::ident::minor_name(*code);
        let wanted = match arguments.first() {
            Some(MacroValue::Keyword(code)) => keyword(code).unwrap_or(""),
            _ => text(arguments, 0).trim(),
        };
        let (components, channel) = (&mut self.kernel.components, self.kernel.channel.at.channel);
        let Some(place) = components.named(wanted, channel) else {
            let own = components.all.iter().filter(|component| component.channels.contains(&channel));
            let own = own.map(|component| component.designator).collect::<Vec<_>>().join(", ");
            let text = format!("channel {channel} has no component '{wanted}'; its components are {own}");
            return Err(MacroFault::new(DiagnosticNumber::BAD_VALUE, text));
        };
        let changes = components.turns.wanted.or(components.turns.now) != Some(place);
        components.turns.wanted = Some(place).filter(|place| components.turns.now != Some(*place));
        Ok(MacroValue::Logical(changes))
    }

    /// `$FCERST`: continues with another file after the shutdown macro has ended.
    fn restart_with(&mut self, state: &mut MacroState, arguments: &[MacroValue]) -> Outcome<MacroValue> {
        if !self.inside(Hook::ProgramShutdown) && !self.inside(Hook::MachineShutdown) {
            return Self::not_here(HostFn::Restart.name());
        }
        let name = text(arguments, 0).trim();
        let line = arguments.get(1).and_then(MacroValue::as_real).unwrap_or(1.0);
        let reset = arguments.get(2).and_then(MacroValue::as_logical).unwrap_or(false);
        let file = self.kernel.channel.env.info.files.iter().position(|file| file.name == name);
        let good = (1.0..=f64::from(u32::MAX)).contains(&line);
        let (Some(file), true) = (file, good) else {
            state.warn(MacroFault::new(
                DiagnosticNumber::NO_FILE,
                format!("the job has no file '{name}' with a line {line} to continue"),
            ));
            return Ok(MacroValue::Logical(false));
        };
        self.kernel.macros.course.restart = Some(Restart { file: file as FileId, line: line as u32, reset });
        Ok(MacroValue::Logical(true))
    }

    /// `$FMACID`: numbers and names of the macros whose name matches, of the running one without an expression.
    fn macro_ids(&mut self, state: &mut MacroState, arguments: &[MacroValue]) -> Outcome<MacroValue> {
        let Some(macros) = self.kernel.channel.env.machine.macros.as_deref() else {
            return Ok(MacroValue::sequence(Vec::new()));
        };
        let hooks = Hook::ALL.into_iter().zip(FIRST_HOOK_ID..);
        let hooks = hooks.filter_map(|(hook, id)| Some((macros.hook(hook)?, id, hook.title())));
        let named = macros.codes.iter().chain(&macros.data).map(|one| (one.code, one.id, one.name.as_str()));
        let tools = FIRST_HOOK_ID + Hook::Tool as u32;
        let select = macros.hook(Hook::Tool).map(|code| (code, tools, SELECT_TOOL));
        let all = named.chain(hooks).chain(select);
        let expression = text(arguments, 0).trim_end();
        let mut found = Vec::new();
        if expression.is_empty() {
            let call = self.kernel.macros.calls.running.last();
            let running = call.map(|call| call.code);
            for (_, id, name) in all.filter(|(code, ..)| Some(*code) == running).take(1) {
                found.extend([MacroValue::Real(f64::from(id)), MacroValue::text(self.called_name().unwrap_or(name))]);
            }
            return Ok(MacroValue::sequence(found));
        }
        // Ones of the mask ask for macros of the control, tens for those of a model, which is not there.
        let wanted = arguments.get(1).and_then(MacroValue::as_real).is_none_or(|mask| (mask % 10.0).trunc() == 1.0);
        let pattern = state.pattern(expression)?;
        let mut budget = STEPS;
        for (_, id, name) in all.filter(|_| wanted) {
            state.spend(1 + name.len())?;
            if pattern.find(name, 0, &mut budget)?.is_some() {
                found.extend([MacroValue::Real(f64::from(id)), MacroValue::text(name)]);
            }
        }
        Ok(MacroValue::sequence(found))
    }

    /// State of a macro before it was switched.
    fn switch_macro(&mut self, id: f64, on: Option<bool>) -> Option<bool> {
        let macros = self.kernel.channel.env.machine.macros.as_deref()?;
        let runtime = &mut *self.kernel.macros;
        let is = |other: u32| f64::from(other) == id;
        let code = macros.codes.find(|one| is(one.id)).map(|at| &mut runtime.hooks.codes[at]);
        let data = macros.data.find(|one| is(one.id)).map(|at| &mut runtime.hooks.data[at]);
        if let Some(slot) = code.or(data) {
            return Some(std::mem::replace(slot, on.unwrap_or(*slot)));
        }
        let (hook, _) = Hook::ALL.into_iter().zip(FIRST_HOOK_ID..).find(|(_, number)| is(*number))?;
        let code = macros.hook(hook)?;
        let slot = runtime.hooks.on.get_mut(hook as usize)?;
        let before = slot.is_some();
        *slot = on.unwrap_or(before).then_some(code);
        if let Some(switch) = runtime.variables.store.switches.get_mut(hook as usize) {
            *switch = on.unwrap_or(before);
        }
        Some(before)
    }

    /// `$FCEGNCV`
    fn nc_variable(&mut self, arguments: &[MacroValue]) -> MacroValue {
        let name = text(arguments, 0).trim().to_owned();
        let indices = indices(arguments, 1);
        let found = self.kernel.with_interpreter(|interpreter, kernel| interpreter.variable(kernel, &name, &indices));
        match found {
            Some(Ok(value)) => value.unwrap_or(MacroValue::Null),
            Some(Err(halt)) => {
                self.kernel.macros.calls.stop(halt);
                MacroValue::Null
            }
            None => MacroValue::Null,
        }
    }

    /// `$FCESNCV`
    fn set_nc_variable(&mut self, arguments: &[MacroValue]) -> bool {
        let name = text(arguments, 0).trim().to_owned();
        let indices = indices(arguments, 2);
        let Some(value) = arguments.get(1) else { return false };
        let set = self
            .kernel
            .with_interpreter(|interpreter, kernel| interpreter.set_variable(kernel, &name, &indices, value));
        match set {
            Some(Ok(set)) => set,
            Some(Err(halt)) => {
                self.kernel.macros.calls.stop(halt);
                false
            }
            None => false,
        }
    }

    /// Text of the last message to the operator.
    pub(crate) fn show_display(&mut self, text: &str) {
        self.store(names().display, || MacroValue::text(text));
    }
}

/// Indices after the name of a variable.
fn indices(arguments: &[MacroValue], from: usize) -> Vec<f64> {
    arguments.get(from..).unwrap_or_default().iter().filter_map(MacroValue::as_real).collect()
}

/// A register's format as a format of the language.
fn numeric(format: &NumberFormat) -> Numeric {
    let fill = |zeros: ZeroRule| match zeros {
        ZeroRule::Keep => Fill::Shown,
        ZeroRule::One => Fill::KeepOne,
        ZeroRule::Omit => Fill::Dropped,
    };
    Numeric {
        style: ColumnStyle::Variable,
        plus: format.plus,
        lead: fill(format.lead),
        whole: format.whole,
        groups: Vec::new(),
        point: match format.point {
            DecimalPointRule::Keep if format.frac > 0 => Dot::Always,
            DecimalPointRule::Keep | DecimalPointRule::Omit => Dot::Implied,
            DecimalPointRule::Fractional => Dot::WithFraction,
        },
        fraction: format.frac,
        trail: fill(format.trail),
    }
}

/// The same as format text for `$FSWRIT`.
fn descriptor(format: &NumberFormat) -> String {
    let zeros = |zeros: ZeroRule| match zeros {
        ZeroRule::Keep => "",
        ZeroRule::One => "e",
        ZeroRule::Omit => "s",
    };
    let point = match format.point {
        DecimalPointRule::Keep if format.frac > 0 => ".",
        DecimalPointRule::Fractional => "f",
        _ => "",
    };
    let plus = if format.plus { "+" } else { "" };
    let (whole, frac) = (wildcard_text(f64::from(format.whole)), wildcard_text(f64::from(format.frac)));
    format!("!({plus}{}{whole}{point}{frac}{})", zeros(format.lead), zeros(format.trail))
}

/// Register by its number in the list, or by the start of its descriptor.
fn register_at(machine: &Machine, value: Option<&MacroValue>) -> Option<RegisterId> {
    let registers = &machine.registers;
    match value? {
        MacroValue::Real(index) => registers.find(|register| f64::from(register.index) == *index),
        MacroValue::Text(text) => {
            let text = text.trim();
            let exact = registers.find(|register| register.name == text);
            let described = |register: &MachineRegister| {
                let format = descriptor(&register.format);
                format!("{}{}", register.name, format.trim_matches(['!', '(', ')'])).starts_with(text)
            };
            exact.or_else(|| registers.find(|register| !text.is_empty() && described(register)))
        }
        _ => None,
    }
}

fn register_format(channel: &ChannelContext<'_>, arguments: &[MacroValue]) -> String {
    match register_at(channel.env.machine, arguments.first()).map(|at| &channel.env.machine.registers[at]) {
        Some(register) => descriptor(if channel.state.secondary { &register.secondary } else { &register.format }),
        None => String::new(),
    }
}

/// A register as text: `!(@n)`, `!(@X)` and their kind.
pub(crate) fn register_word(
    channel: &mut ChannelContext<'_>,
    register: FormatRegister,
    value: Option<f64>,
    word: bool,
) -> Option<String> {
    let at = match register {
        FormatRegister::Letter(letter) => register_at(channel.env.machine, Some(&MacroValue::text(letter.to_string()))),
        FormatRegister::Index(index) => register_at(channel.env.machine, Some(&MacroValue::Real(f64::from(index)))),
    }?;
    let register = &channel.env.machine.registers[at];
    let value = match value {
        Some(value) => value,
        None => {
            let rows = channel.env.machine.tables.data_of(at);
            let ids = rows.iter().map(|&row| &channel.env.machine.data[row]);
            let mut known = ids.filter_map(|row| channel.state.remembered.value(row.id));
            known.next().unwrap_or(0.0)
        }
    };
    let format = if channel.state.secondary { &register.secondary } else { &register.format };
    let mut out = if word { register.name.clone() } else { String::new() };
    numeric(format).write(&mut out, value);
    Some(out)
}
