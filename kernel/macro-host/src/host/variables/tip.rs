//! Variables of tool tip control and of the tool axis.
//!
//! Facts: reference system-variables.md 11, 12. `$TCPSIM` and `$TCPSIMR` are kept; the tip always goes straight here.

use counterpoint_lang::diag::DiagnosticNumber;
use counterpoint_lang::fault::{MacroFault, Outcome};
use counterpoint_lang::value::MacroValue;

use super::{Read, Write};
use counterpoint_emulator::channel::Kernel;

fn number(value: &MacroValue) -> u8 {
    value.as_real().map_or(0, |number| number.clamp(0.0, 255.0) as u8)
}

fn switch(kernel: &mut Kernel<'_>, _: &[i64], value: &MacroValue) -> Outcome<()> {
    if value.as_logical() != Some(true) {
        kernel.channel.end_tip();
    } else if kernel.channel.state.place.tip().is_none() && !kernel.channel.start_tip(false) {
        return Err(MacroFault::new(DiagnosticNumber::BAD_VALUE, "the axes of this channel do not allow TCP"));
    }
    Ok(())
}

/// A part of the tool axis in the local frame, now or at the start of the last motion.
fn axis<const PART: usize, const BEFORE: bool>(kernel: &Kernel<'_>, _: &[i64]) -> MacroValue {
    let at = if BEFORE { kernel.macros.arguments.before } else { kernel.channel.state.place.position };
    let direction = kernel.channel.local_direction(&at);
    MacroValue::Real(direction.get(PART).copied().unwrap_or(0.0))
}

/// How a variable is read and written.
pub(crate) fn find(name: &str) -> Option<(Read, Option<Write>)> {
    let row: (Read, Option<Write>) = match name {
        "$TCP" => (|k, _| MacroValue::Logical(k.channel.state.place.tip().is_some()), Some(switch)),
        "$TCPFMT" => (
            |k, _| MacroValue::Real(f64::from(k.channel.state.others.tip.format)),
            Some(|k, _, value| {
                k.channel.state.others.tip.format = number(value);
                Ok(())
            }),
        ),
        "$TCPSET" => (
            |k, _| MacroValue::Real(f64::from(k.channel.state.others.tip.method)),
            Some(|k, _, value| {
                k.channel.state.others.tip.method = number(value);
                Ok(())
            }),
        ),
        "$IW" => (axis::<0, false>, None),
        "$JW" => (axis::<1, false>, None),
        "$KW" => (axis::<2, false>, None),
        "$LIW" => (axis::<0, true>, None),
        "$LJW" => (axis::<1, true>, None),
        "$LKW" => (axis::<2, true>, None),
        _ => return None,
    };
    Some(row)
}
