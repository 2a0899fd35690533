//! Assignment of input files to kernels: `$MCEMCD`, `$MCEINP`, `$MFIKER`, the names of the files, `$MFINAM`, and the
//! channels of the model on which kernels and their files start, `$MCECHN`, `$MFICHN`, `$VMCHN`.
//!
//! *Invariant:* there is one truth, the program of each kernel; an index of a file is another way to say it, so that
//! the later assignment wins. Facts: reference system-variables.md 17.

use counterpoint_lang::diag::DiagnosticNumber;
use counterpoint_lang::fault::{MacroFault, Outcome};
use counterpoint_lang::value::MacroValue;

use super::{Read, Write};
use crate::context::KernelHost;
use counterpoint_channel::macros::store::names;
use counterpoint_emulator::channel::Kernel;

/// Characters of a kernel's name in diagnostics.
const MOST_NAME: usize = 80;

fn number(value: impl Into<f64>) -> MacroValue {
    MacroValue::Real(value.into())
}

fn index(at: &[i64]) -> i64 {
    at.first().copied().unwrap_or(0)
}

/// Input file with an index, blank without one.
fn file<'k>(kernel: &Kernel<'k>, at: i64) -> &'k str {
    let info = kernel.channel.env.info;
    let mut given = info.channels.iter().filter(|channel| !channel.program.is_empty());
    let place = usize::try_from(at).ok().and_then(|at| at.checked_sub(1));
    place.and_then(|place| given.nth(place)).map_or("", |channel| info.file_name(channel.file))
}

/// Program of a kernel as it is now.
fn program(kernel: &Kernel<'_>, at: i64) -> String {
    let set = kernel.macros.variables.store.element(names().kernel_program, (at, 0));
    if let Some(text) = set.and_then(MacroValue::as_text) {
        return text.trim().to_owned();
    }
    let place = usize::try_from(at).ok().and_then(|at| at.checked_sub(1));
    let own = place
        .and_then(|place| kernel.channel.env.info.channels.get(place))
        .filter(|channel| !channel.program.is_empty());
    own.map_or(String::new(), |channel| kernel.channel.env.info.file_name(channel.file).to_owned())
}

fn kernels(kernel: &Kernel<'_>) -> i64 {
    kernel.channel.env.machine.channels.len() as i64
}

/// Kernel that has an input file, 0 for none.
fn kernel_of(kernel: &Kernel<'_>, at: i64) -> i64 {
    let wanted = file(kernel, at);
    let has = |k: &i64| !wanted.is_empty() && program(kernel, *k) == wanted;
    // The file of its own index first: one file may hold the programs of several kernels.
    Some(at).filter(has).or_else(|| (1..=kernels(kernel)).find(has)).unwrap_or(0)
}

/// Index of the input file that a kernel has, 0 for none.
fn input_of(kernel: &Kernel<'_>, at: i64) -> i64 {
    let own = program(kernel, at);
    let is = |i: &i64| !own.is_empty() && file(kernel, *i) == own;
    Some(at).filter(is).or_else(|| (1..=kernels(kernel)).find(is)).unwrap_or(0)
}

fn set_program(kernel: &mut Kernel<'_>, at: i64, program: &str) -> Outcome<()> {
    let value = MacroValue::text(program);
    kernel.macros.variables.store.keep_element(names().kernel_program, (at, 0), value)
}

fn whole(value: &MacroValue, what: &str) -> Outcome<i64> {
    match value.as_real().filter(|n| n.fract() == 0.0 && (0.0..=65_535.0).contains(n)) {
        Some(number) => Ok(number as i64),
        None => Err(MacroFault::new(DiagnosticNumber::OUT_OF_RANGE, format!("no {what} with this number"))),
    }
}

fn set_input(kernel: &mut Kernel<'_>, at: &[i64], value: &MacroValue) -> Outcome<()> {
    let wanted = whole(value, "input file")?;
    let program = file(kernel, wanted).to_owned();
    if wanted > 0 && program.is_empty() {
        return Err(MacroFault::new(DiagnosticNumber::OUT_OF_RANGE, format!("input file {wanted} not found")));
    }
    set_program(kernel, index(at), &program)
}

fn set_kernel(kernel: &mut Kernel<'_>, at: &[i64], value: &MacroValue) -> Outcome<()> {
    let wanted = whole(value, "kernel")?;
    let own = file(kernel, index(at)).to_owned();
    if own.is_empty() || wanted > kernels(kernel) {
        let text = format!("kernel {wanted} or input file {} not found", index(at));
        return Err(MacroFault::new(DiagnosticNumber::OUT_OF_RANGE, text));
    }
    match wanted {
        0 => match kernel_of(kernel, index(at)) {
            0 => Ok(()),
            owner => set_program(kernel, owner, ""),
        },
        wanted => set_program(kernel, wanted, &own),
    }
}

/// Channel of the model that a kernel starts on.
pub(crate) fn channel_of(kernel: &Kernel<'_>, at: i64) -> f64 {
    let set = kernel.macros.variables.store.element(names().kernel_channel, (at, 0));
    set.and_then(MacroValue::as_real).unwrap_or(at as f64)
}

fn set_channel(kernel: &mut Kernel<'_>, at: i64, value: &MacroValue) -> Outcome<()> {
    let wanted = whole(value, "channel")?;
    kernel.macros.variables.store.keep_element(names().kernel_channel, (at, 0), number(wanted as f64))
}

/// A kernel has got this program and name, and starts on this channel of the model.
pub(crate) fn set_program_of(host: &mut KernelHost<'_, '_>, at: i64, program: &str, name: &str, channel: f64) {
    if host.kernel.plan.hooks.is_none() {
        return;
    }
    let store = &mut host.kernel.macros.variables.store;
    store.set_element(names().kernel_program, (at, 0), MacroValue::text(program));
    store.set_element(names().kernel_channel, (at, 0), MacroValue::Real(channel));
    store.set_element(names().kernel_name, (at, 0), MacroValue::text(name));
}

/// `$MCENAM` of this kernel where macros have changed it, for diagnostics; otherwise blank.
pub(crate) fn kernel_name(host: &KernelHost<'_, '_>) -> String {
    let at = (i64::from(host.kernel.channel.env.kernel_number(host.kernel.channel.at.channel)), 0);
    let set = host.kernel.macros.variables.store.element(names().kernel_name, at);
    let set = set.and_then(MacroValue::as_text).unwrap_or("").trim();
    let own = host
        .kernel
        .channel
        .env
        .info
        .channel(host.kernel.channel.at.channel)
        .map_or("MASTER", |channel| channel.name.as_str());
    if set == own || host.kernel.channel.env.machine.channels.len() < 2 {
        return String::new();
    }
    set.chars().take(MOST_NAME).map(|c| if c.is_control() { ' ' } else { c }).collect()
}

/// How a variable is read and written.
pub(crate) fn find(name: &str) -> Option<(Read, Option<Write>)> {
    let row: (Read, Option<Write>) = match name {
        "$MCEMCD" => (
            |k, at| MacroValue::text(program(k, index(at))),
            Some(|k, at, value| set_program(k, index(at), value.as_text().unwrap_or(""))),
        ),
        "$MCEINP" => (|k, at| number(input_of(k, index(at)) as f64), Some(set_input)),
        "$MFIKER" => (|k, at| number(kernel_of(k, index(at)) as f64), Some(set_kernel)),
        "$MCECHN" => {
            (|k, at| MacroValue::Real(channel_of(k, index(at))), Some(|k, at, value| set_channel(k, index(at), value)))
        }
        "$VMCHN" => (
            |k, _| {
                let set = k.macros.variables.store.element(names().model_channel, (0, 0));
                set.cloned().unwrap_or_else(|| {
                    if k.channel.at.channel == 0 {
                        number(0)
                    } else {
                        MacroValue::Real(channel_of(k, k.channel.env.kernel_number(k.channel.at.channel).into()))
                    }
                })
            },
            Some(|k, _, value| {
                let wanted = whole(value, "channel")?;
                k.macros.variables.store.keep_element(names().model_channel, (0, 0), number(wanted as f64))
            }),
        ),
        "$MFICHN" => (
            |k, at| match kernel_of(k, index(at)) {
                0 => number(0),
                owner => MacroValue::Real(channel_of(k, owner)),
            },
            Some(|k, at, value| match kernel_of(k, index(at)) {
                0 => Err(MacroFault::new(
                    DiagnosticNumber::OUT_OF_RANGE,
                    format!("input file {} has no kernel", index(at)),
                )),
                owner => set_channel(k, owner, value),
            }),
        ),
        "$MFINAM" => (|k, at| MacroValue::text(file(k, index(at))), None),
        _ => return None,
    };
    Some(row)
}
