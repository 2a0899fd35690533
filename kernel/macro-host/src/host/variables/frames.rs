//! Variables of the local frame.
//!
//! Facts: reference system-variables.md 12. `$LCS` switches the programmed parts off and on; `$LCSMTN` is −1, since
//! frames never move rotary axes here.

use counterpoint_lang::diag::DiagnosticNumber;
use counterpoint_lang::fault::{MacroFault, Outcome};
use counterpoint_lang::value::MacroValue;
use counterpoint_motion::frame::affine::Affine;
use counterpoint_motion::frame::local::FrameError;

use super::{Read, Write, positions};
use crate::context::KernelHost;
use counterpoint_channel::frame_transforms::FrameTransforms;
use counterpoint_emulator::channel::Kernel;

fn local<T>(kernel: &Kernel<'_>, of: impl FnOnce(&FrameTransforms) -> T) -> Option<T> {
    kernel.channel.state.place.frames.as_deref().map(of)
}

/// How a variable is read and written.
pub(crate) fn find(name: &str) -> Option<(Read, Option<Write>)> {
    let row: (Read, Option<Write>) = match name {
        "$LCS" => (
            |k, _| MacroValue::Logical(local(k, FrameTransforms::is_on).unwrap_or(false)),
            Some(|k, _, value| {
                let on = value.as_logical().unwrap_or(true);
                let has = k.channel.state.place.has_axes();
                let frames = k.channel.state.place.frames.as_deref_mut();
                let switched = frames.map_or(Ok(()), |frames| frames.switch(on, has));
                changed(k, switched)
            }),
        ),
        "$LCSM" => (|k, _| MacroValue::Logical(local(k, FrameTransforms::changes_points).unwrap_or(false)), None),
        "$LCSTRA" => (|k, _| MacroValue::numbers(&k.channel.state.place.frame_values().translation), None),
        "$LCSROT" => (|k, _| MacroValue::numbers(&k.channel.state.place.frame_values().rotation), None),
        "$LCSSCA" => (|k, _| MacroValue::numbers(&k.channel.state.place.frame_values().scale), None),
        "$LCSMIR" => (|k, _| MacroValue::numbers(&k.channel.state.place.frame_values().mirror), None),
        "$LCSCEN" => (|k, _| MacroValue::numbers(&k.channel.state.place.frame_values().center), None),
        "$LCSANG" => (|k, _| MacroValue::Real(k.channel.state.place.frame_values().angle), None),
        "$LCSORD" => (|k, _| MacroValue::text(k.channel.state.place.frame_values().order), None),
        "$LCSMX" => (
            |k, _| MacroValue::numbers(&local(k, |frames| frames.local.map().cells()).unwrap_or(Affine::SAME.cells())),
            None,
        ),
        "$C2PMCH" => {
            (|k, _| MacroValue::Logical(k.channel.state.place.polar().is_some_and(|polar| !polar.is_cylinder())), None)
        }
        "$AXESC2P" => (
            |k, _| {
                let polar = k.channel.state.place.polar().filter(|polar| !polar.is_cylinder());
                let letters = polar
                    .map(|polar| polar.axes().map(|axis| positions::axis_letter(&k.channel.state.place, Some(axis))));
                MacroValue::text(letters.map_or_else(String::new, |letters| letters.iter().collect()))
            },
            None,
        ),
        "$LCSMTN" => (
            |_, _| MacroValue::Real(-1.0),
            Some(|_, _, _| {
                Err(MacroFault::new(DiagnosticNumber::BAD_VALUE, "frames cannot move the rotary axes of this machine"))
            }),
        ),
        _ => return None,
    };
    Some(row)
}

/// The frame may have changed; a macro learns why it has not.
fn changed(kernel: &mut Kernel<'_>, made: Result<(), FrameError>) -> Outcome<()> {
    kernel.channel.state.place.frames_changed();
    made.map_err(|refused| {
        let why = match refused {
            FrameError::NoWayBack => "the frame has no inverse",
            FrameError::MissingAxis => "the frame would move an axis that the channel does not have",
            FrameError::TooMany => "the frame has too many parts",
        };
        MacroFault::new(DiagnosticNumber::BAD_VECTOR, why)
    })
}

/// `$FMSLCS`: a frame of twelve numbers outside the programmed one, none without them.
pub(in crate::host) fn give_frame(host: &mut KernelHost<'_, '_>, arguments: &[MacroValue]) -> Outcome<MacroValue> {
    let given = match arguments.first() {
        None => None,
        Some(MacroValue::Sequence(values)) => {
            let mut cells = [0.0; 12];
            if values.len() != cells.len() {
                return Err(MacroFault::new(DiagnosticNumber::BAD_VECTOR, "a frame has 12 numbers"));
            }
            for (slot, value) in cells.iter_mut().zip(values.iter()) {
                *slot = value.as_real().ok_or_else(|| MacroFault::kind("a number", value))?;
            }
            let map = Affine::of_cells(cells);
            Some(map.ok_or_else(|| MacroFault::new(DiagnosticNumber::BAD_VECTOR, "a frame has 12 finite numbers"))?)
        }
        Some(value) => return Err(MacroFault::kind("a sequence", value)),
    };
    let has = host.kernel.channel.state.place.has_axes();
    let made = host.kernel.channel.state.place.frames().local.give(given, has);
    changed(host.kernel, made)?;
    Ok(MacroValue::Real(1.0))
}
