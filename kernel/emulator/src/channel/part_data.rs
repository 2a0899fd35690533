//! Data of the part that may be in another unit than the program.
//!
//! *Invariant:* a job reports such data once, in the channel that comes first in the order of shared operations.

use crate::channel::Kernel;
use counterpoint_event::info::MachineUnit;
use counterpoint_fault::{self as diag, Acted};
use counterpoint_machine::length_units::begins_in_inches;
use counterpoint_program::presets;

/// Reports values of `$0` without a decimal point if the program selects a unit other than the initial unit of the
/// machine.
#[cold]
pub fn check(kernel: &mut Kernel<'_>, inch: bool) -> Acted {
    let machine = kernel.channel.env.machine;
    let begins = begins_in_inches(machine);
    let main = kernel.flow.frames.first().map(|frame| frame.file);
    let Some(file) = main.filter(|_| begins != inch) else { return Ok(()) };
    let Some(source) = kernel.channel.env.sources.whole(file) else { return Ok(()) };
    let Some(first) = presets::whole(machine, source) else { return Ok(()) };
    if kernel.shared(|order| std::mem::replace(&mut order.shared.part_data_reported, true))? {
        return Ok(());
    }
    let [mm, inches] = first.values;
    let (own, other) = if begins { (inches, mm) } else { (mm, inches) };
    let [own_unit, other_unit] =
        [begins, inch].map(|inch| if inch { MachineUnit::Inch } else { MachineUnit::Mm }.name());
    let text = format!(
        "'{}' in line {} is read as {own} ({own_unit}), not {other} ({other_unit}): write a decimal point, or run with \
         --set units={other_unit}",
        first.text, first.line
    );
    kernel.diagnose(&diag::PART_DATA_UNIT, text);
    Ok(())
}
