//! The master kernel's macros: Declaration and Machine Startup before the channels, Machine Shutdown after them.
//!
//! Facts: reference control-emulator.md 2.1, 2.4, 8.1, 8.2. Invariant: the master works only while no channel does, so
//! its changes of shared variables need no order. A machine with one channel has no master.

use counterpoint_channel::emitter::ChunkTarget;
use counterpoint_channel::macros::store::names;
use counterpoint_emulator::channel::carried::MasterMemory;
use counterpoint_emulator::channel::report::report_softened;
use counterpoint_event::event::{Event, FileId};
use counterpoint_fault as diag;
use counterpoint_fault::Halt;
use counterpoint_lang::value::MacroValue;
use counterpoint_machine::index::IdTable;
use counterpoint_machine::macros::model::Hook;
use counterpoint_machine::model::Channel;
use counterpoint_macro_host as macros;
use counterpoint_program::layout::first_main;
use counterpoint_program::shape::ProgramRange;

use super::again::{Again, At};
use super::coordinator::wait_method::WaitMethod;
use super::{Assembly, again};

/// Program and name of a kernel, and its first channel of the model, as Machine Startup left them.
pub(super) type KernelInput = (String, String, f64);

/// Work that the master has left for later.
pub(super) struct Master {
    channel: Channel,
    memory: Option<MasterMemory>,
    /// Programs that Machine Startup gave to kernels instead of their own; none to start none.
    pub(super) programs: Vec<(u16, Option<At>)>,
    /// The channels may start.
    pub(super) good: bool,
}

impl<'a> Assembly<'a> {
    /// Runs Declaration and Machine Startup; none if the machine has no master's macros.
    pub(super) fn master_startup(self, log: &mut dyn FnMut(&Event) -> bool) -> Option<Master> {
        let machine = &self.job.spec().machine;
        if machine.macros.is_none() || machine.channels.len() < 2 && machine.components.is_empty() {
            return None;
        }
        let (name, axes) = ("MASTER".to_owned(), IdTable::default());
        let channel =
            Channel { number: 0, name, axes, spindle: None, rear: None, milling: None, polar: None, lower: false };
        let mut kept = Vec::new();
        let mut kernel = self.kernel(&channel, self.control.spare(), ChunkTarget::Kept(&mut kept), WaitMethod::Thread);
        for (number, at) in machine.channels.iter().zip(1_i64..) {
            let program = self.job.info().channel(number.number).filter(|info| !info.program.is_empty());
            let file = program.map_or("", |info| self.job.info().file_name(info.file)).to_owned();
            let (names, store) = (names(), &mut kernel.macros.variables.store);
            store.starting = true;
            store.set_element(names.kernel_program, (at, 0), MacroValue::text(file));
            store.set_element(names.kernel_name, (at, 0), MacroValue::text(number.name.as_str()));
            store.set_element(names.kernel_channel, (at, 0), MacroValue::Real(f64::from(number.number)));
        }
        let done =
            macros::run(&mut kernel, Hook::Declaration).and_then(|()| macros::run(&mut kernel, Hook::MachineStartup));
        if let Err(halt) = done {
            report_softened(&mut kernel.channel, halt);
        }
        let good = !matches!(done, Err(Halt::Alarm | Halt::Stopped | Halt::Blocked));
        let mut programs = Vec::new();
        for (number, at) in machine.channels.iter().zip(1_i64..) {
            let wanted = {
                kernel
                    .macros
                    .variables
                    .store
                    .element(names().kernel_program, (at, 0))
                    .and_then(MacroValue::as_text)
                    .map(str::to_owned)
            };
            let wanted = wanted.unwrap_or_default();
            let program = self.job.info().channel(number.number).filter(|info| !info.program.is_empty());
            if program.map_or("", |info| self.job.info().file_name(info.file)) == wanted.trim() {
                continue;
            }
            if wanted.trim().is_empty() {
                programs.push((number.number, None));
                continue;
            }
            let file = self.job.info().files.iter().position(|file| file.name == wanted.trim());
            let start = file.and_then(|file| {
                let file = file as FileId;
                kernel.load(file).ok()?;
                let source = self.job.sources().get(file)?;
                let whole = ProgramRange { number: None, first: 1, last: source.lines() };
                Some((file, first_main(source, machine, number.number).unwrap_or(whole), wanted.trim().into()))
            });
            if start.is_none() {
                let text = format!("kernel {at} gets the program '{}', which is not in the job", wanted.trim());
                kernel.diagnose(&diag::FILE_UNREADABLE, text);
            }
            programs.push((number.number, start));
        }
        for (number, at) in machine.channels.iter().zip(1_i64..) {
            let line = kernel.macros.variables.store.element(names().kernel_line, (at, 0));
            let Some(line) = line.and_then(MacroValue::as_real).filter(|line| *line != 1.0) else { continue };
            let place = programs.iter().position(|(given, _)| *given == number.number);
            let own = || self.job.info().channel(number.number).filter(|c| !c.program.is_empty());
            let start = match place.and_then(|place| programs.get(place)) {
                Some((_, at)) => at.clone(),
                None => own().map(|c| {
                    let range = ProgramRange { number: None, first: c.lines.0, last: c.lines.1 };
                    (c.file, range, c.program.clone().into())
                }),
            };
            let Some((file, range, name)) = start else { continue };
            if !(f64::from(range.first)..=f64::from(range.last)).contains(&line) {
                let (first, last) = (range.first, range.last);
                let text = format!("kernel {at} cannot start at line {line} of {name}, which has {first} to {last}");
                kernel.diagnose(&diag::MACRO_RESULT, text);
                continue;
            }
            let start = (number.number, Some((file, ProgramRange { first: line as u32, ..range }, name)));
            match place.and_then(|place| programs.get_mut(place)) {
                Some(slot) => *slot = start,
                None => programs.push(start),
            }
        }
        kernel.macros.variables.store.starting = false;
        let program = |at| {
            let set = kernel.macros.variables.store.element(names().kernel_program, (at, 0));
            set.and_then(MacroValue::as_text).unwrap_or("").trim().to_owned()
        };
        let name = |at| {
            let set = kernel.macros.variables.store.element(names().kernel_name, (at, 0));
            set.and_then(MacroValue::as_text).unwrap_or("").to_owned()
        };
        let given =
            (1..).take(machine.channels.len()).map(|at| (program(at), name(at), macros::model_channel(&kernel, at)));
        // The master starts once, so nothing is there yet.
        let _ = self.given.set(given.collect());
        let memory = Some(kernel.into_master());
        kept.iter().for_each(|event| {
            log(event);
        });
        Some(Master { channel, memory, programs, good })
    }

    /// Runs Machine Shutdown at the end of the log; how the machine continues, if it does. `wrong` tells why it cannot.
    pub(super) fn master_shutdown(
        self,
        master: &mut Option<Master>,
        wrong: Option<&str>,
        (t, micro): (i64, u32),
        log: &mut dyn FnMut(&Event) -> bool,
    ) -> Option<Again> {
        let Master { channel, memory, .. } = master.as_mut()?;
        let mut kept = Vec::new();
        let mut kernel = self.kernel(channel, self.control.spare(), ChunkTarget::Kept(&mut kept), WaitMethod::Thread);
        kernel.take_over_master(memory.take()?, (t, micro));
        let done = macros::run(&mut kernel, Hook::MachineShutdown);
        if let Err(halt) = done {
            report_softened(&mut kernel.channel, halt);
        }
        macros::close_files(&mut kernel, Halt::ProgramEnd(None));
        let restart = kernel.macros.course.restart.take();
        let restart = restart.filter(|_| !matches!(done, Err(Halt::Alarm | Halt::Stopped | Halt::Blocked)));
        let again = restart.and_then(|restart| again::restarted(&mut kernel, restart, wrong));
        *memory = Some(kernel.into_master());
        // Time that the macro may have let pass does not take the log beyond its end.
        kept.iter_mut().for_each(|event| {
            event.dur_ns = 0;
            (event.t_ns, event.micro) = (t, micro);
            log(event);
        });
        again
    }
}
