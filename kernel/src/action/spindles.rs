//! Which spindle of a channel is in work: the front or the rear one when it turns the part, the milling one when it mills.
//!
//! Facts: reference control-emulator.md 3.2, 6.3, system-variables.md 9. Invariant: the spindle in work is that of
//! `Kernel::spindle`; what the channel has commanded of its other spindles is kept here, unless another channel can
//! command them too.

use crate::channel::Kernel;
use crate::diag;
use crate::log::event::Kind;
use crate::machine::ident::data;
use crate::state::spindle::index_of;
use counterpoint_fault::Acted;

/// `CODE_SPINDLE_FRONT`, `CODE_SPINDLE_REAR`: their group says which one it is.
pub(super) fn in_work(kernel: &mut Kernel<'_>, rear: bool) -> Acted {
    if kernel.channel.acting.mode_changed {
        let text = if rear { "spindle rear" } else { "spindle front" };
        kernel.emit(0, Kind::mode(text));
    }
    kernel.channel.follow_spindle();
    Ok(())
}

/// `CODE_APPLY_TURN`, `CODE_APPLY_MILL`.
pub(super) fn apply(kernel: &mut Kernel<'_>, milling: bool) -> Acted {
    if kernel.channel.state.others.spindles.milling != milling {
        kernel.channel.state.others.spindles.milling = milling;
        let text = if milling { "apply mill" } else { "apply turn" };
        kernel.emit(0, Kind::mode(text));
        kernel.channel.follow_spindle();
    }
    Ok(())
}

/// Lets an action command a spindle of the channel: `number` 0 = by codes without a number.
pub(super) fn commanded(kernel: &mut Kernel<'_>, number: u16, action: impl FnOnce(&mut Kernel<'_>) -> Acted) -> Acted {
    let index = if number == 0 {
        kernel.channel.plain_spindle()
    } else {
        let index = index_of(kernel.channel.env.machine, number);
        if index.is_none() {
            let text = format!("the machine has no spindle {number} for '{}'", kernel.block_text());
            kernel.diagnose(&diag::NO_SPINDLE, text);
            super::spindle::drop_data(kernel);
            return Ok(());
        }
        index
    };
    let before = kernel.channel.state.spindle.index;
    kernel.channel.select_spindle(index);
    let done = action(kernel);
    kernel.channel.select_spindle(before);
    done
}

/// The head that `CODE_SPINDLE_CSS_ID` names.
pub(super) fn driver_by_id(kernel: &mut Kernel<'_>) -> Acted {
    let Some(id) = kernel.take(data::SPINDLE_CSS_ID).map(|d| d.value) else {
        let text = format!("no head is named in '{}'", kernel.block_text());
        kernel.diagnose(&diag::DATA_MISSING, text);
        return Ok(());
    };
    let known = kernel.channel.env.machine.channels.iter().find(|channel| f64::from(channel.number) == id);
    match known.map(|channel| channel.number) {
        Some(channel) => super::spindle::driver(kernel, channel),
        None => no_head(kernel, id),
    }
}

/// There is no such head to drive constant surface speed.
pub(super) fn no_head(kernel: &mut Kernel<'_>, id: f64) -> Acted {
    let id = counterpoint_lang::format::wildcard_text(id);
    let text = format!("there is no head {id} to drive constant surface speed in '{}'", kernel.block_text());
    kernel.diagnose(&diag::NO_HEAD, text);
    Ok(())
}
