//! The unit in which words are read, selected by a variable instead of a code.

use counterpoint_channel::macro_queries::activate_code;
use counterpoint_event::event::Kind;
use counterpoint_event::info::MachineUnit;
use counterpoint_machine::ident::codes;

use crate::channel::Kernel;

/// Reads words in the other unit of the machine from now on, or again in its own. The log shows the change as that by a
/// code.
pub fn switch_unit(kernel: &mut Kernel<'_>, secondary: bool) {
    activate_code(&mut kernel.channel, if secondary { codes::UNITS_SECONDARY } else { codes::UNITS_PRIMARY });
    kernel.channel.reports.unit_named = true;
    if kernel.channel.state.secondary != secondary {
        kernel.channel.state.secondary = secondary;
        let inch = (kernel.channel.env.machine.unit == MachineUnit::Inch) != secondary;
        kernel.channel.emit(0, Kind::mode(if inch { "units inch" } else { "units mm" }));
    }
}
