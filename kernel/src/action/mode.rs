//! Modes whose effect is that other actions read them, and switches that only show in the log.

use crate::channel::Kernel;
use crate::log::event::{Function, Kind, OffsetKind};
use crate::machine::ident::{CodeId, data};
use crate::machine::model::CodeRow;
use crate::state::block::Firing;
use counterpoint_fault::Acted;

/// A modal state.
pub(super) fn mode(kernel: &mut Kernel<'_>, text: &'static str) -> Acted {
    if kernel.channel.acting.mode_changed {
        kernel.emit(0, Kind::mode(text));
    }
    Ok(())
}

/// Primary or secondary units.
pub(super) fn units(kernel: &mut Kernel<'_>, secondary: bool) -> Acted {
    use crate::log::info::Unit;
    kernel.channel.state.secondary = secondary;
    let inch = (kernel.channel.env.machine.unit == Unit::Inch) != secondary;
    mode(kernel, if inch { "units inch" } else { "units mm" })
}

/// Exact stop at the end of this block.
pub(super) fn exact_stop_block(kernel: &mut Kernel<'_>) -> Acted {
    kernel.channel.block.exact_stop = true;
    Ok(())
}

/// Cutter or nose radius compensation: number, listing, and the path if there is a radius.
pub(super) fn diameter(kernel: &mut Kernel<'_>, side: &'static str, code: CodeId) -> Acted {
    // What ends compensation needs no number.
    let asks = side != "off" || kernel.block_has(data::COMP_DIAM);
    let number = if asks { super::compensation::take_diameter(kernel) } else { None };
    if kernel.channel.acting.mode_changed || number.is_some() {
        let text = format!("comp diam {side}");
        let mode = match number.filter(|_| side != "off") {
            Some(number) => {
                let text = format!("{text} n={}", counterpoint_lang::format::wildcard_text(number));
                Kind::compensation(text, OffsetKind::Diameter, number)
            }
            None => Kind::mode(text),
        };
        super::cutter::switched(kernel, code)?;
        kernel.emit(0, mode);
        kernel.report_tool();
    }
    Ok(())
}

/// A function of the machine that only takes time; the time itself is added by the code loop.
pub(super) fn function(kernel: &mut Kernel<'_>, row: &CodeRow, firing: Firing) -> Acted {
    kernel.take(data::FUNCTION);
    if row.seconds <= 0.0 {
        let (letter, value) = kernel.written(row, firing);
        kernel.emit(0, Kind::Function(Function { letter, value }));
    }
    Ok(())
}

/// Power of additive machining.
pub(super) fn additive(kernel: &mut Kernel<'_>, on: bool) -> Acted {
    let power = kernel.take(data::AM).map(|d| counterpoint_lang::format::wildcard_text(d.value));
    let text = match (on, power) {
        (true, Some(power)) => format!("am on p={power}"),
        (true, None) => "am on".to_owned(),
        (false, _) => "am off".to_owned(),
    };
    kernel.emit(0, Kind::mode(text));
    Ok(())
}
