//! Another run of all kernels, requested by Machine Shutdown.
//!
//! *Invariant:* its programs are in the file that Machine Shutdown named, at or after the named line.

use std::sync::Arc;

use counterpoint_channel::macros::parts::Restart;
use counterpoint_emulator::channel::Kernel;
use counterpoint_event::event::FileId;
use counterpoint_fault as diag;
use counterpoint_program::layout;
use counterpoint_program::shape::ProgramRange;

/// Where a kernel starts.
pub(crate) type At = (FileId, ProgramRange, Arc<str>);

/// Request of Machine Shutdown for the next run.
pub(super) struct Again {
    /// Kernels with a program.
    pub(super) programs: Vec<(u16, At)>,
    /// Reset the machine, as for a first file.
    pub(super) reset: bool,
}

/// Where the kernels continue with the file that Machine Shutdown named: its main programs from left to right, as for a
/// job of this file alone. `wrong` is the reason why the machine cannot be restarted.
pub(super) fn restarted(kernel: &mut Kernel<'_>, restart: Restart, wrong: Option<&str>) -> Option<Again> {
    let Restart { file, line, reset } = restart;
    let (info, machine) = (kernel.channel.env.info, kernel.channel.env.machine);
    let name = info.file_name(file).to_owned();
    let refused = |kernel: &mut Kernel<'_>, reason: &str| {
        let text = format!("the machine is not restarted with line {line} of {name}: {reason}");
        kernel.diagnose(&diag::NO_RESTART, text);
        None
    };
    if let Some(reason) = wrong {
        return refused(kernel, reason);
    }
    kernel.load(file).ok()?;
    let ranges = kernel.channel.env.sources.whole(file).map(|source| layout::from_line(source, line, machine));
    let channels = machine.channels.iter().map(|channel| channel.number);
    let programs: Vec<(u16, At)> = channels
        .zip(ranges.unwrap_or_default())
        .filter_map(|(number, range)| {
            let range = range?;
            let name = match range.number {
                Some(program) => format!("{name}#{program}"),
                None => name.clone(),
            };
            Some((number, (file, range, name.into())))
        })
        .collect();
    if programs.is_empty() {
        return refused(kernel, "no main program of the file has that line or later ones");
    }
    Some(Again { programs, reset })
}
