//! The local frame of the program.
//!
//! Facts: reference control-emulator.md 6.7. Invariant: the machine stands still; the programmed point is what changes.

use crate::channel::{Acted, Kernel};
use crate::log::event::Kind;
use crate::machine::ident::data;

/// What a code does to its part of the frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Change {
    /// Sets it.
    On,
    /// Takes it away.
    Off,
}

/// Translation.
pub(super) fn translate(kernel: &mut Kernel<'_>, change: Change) -> Acted {
    let mut by = kernel.place.frames.as_deref().map_or([0.0; 3], |frames| frames.local.translation());
    match change {
        Change::Off => by = [0.0; 3],
        Change::On => {
            let ids = [data::LCS_TRANS_X, data::LCS_TRANS_Y, data::LCS_TRANS_Z];
            for (role, (slot, id)) in by.iter_mut().zip(ids).enumerate() {
                if let Some(datum) = kernel.take(id).filter(|datum| datum.value.is_finite()) {
                    *slot = datum.value * kernel.place.scale_of(role);
                }
            }
        }
    }
    kernel.frames().local.translate(by);
    kernel.frames_changed();
    let text = if kernel.place.frames.is_none() {
        "lcs off".to_owned()
    } else {
        format!("lcs tra={}", counterpoint_lang::format::wildcard_text(by[0]))
    };
    kernel.emit(0, Kind::Mode { text: text.into() });
    Ok(())
}
