//! Copies of a figure: a program is called several times, turned or shifted further each time.
//!
//! Facts: Fanuc G72.1 P L X Y R and G72.2 P L I J K; the first copy lies where the program draws it, the n-th is turned
//! by n − 1 times the angle about an absolute centre. *Invariant:* the machine does not move; the programmed point
//! changes.

use counterpoint_channel::figure::{CopiedFigure, Copy};
use counterpoint_fault as diag;
use counterpoint_fault::Acted;
use counterpoint_machine::ident::{DataId, codes, data};
use counterpoint_motion::frame::affine::{Affine, Point};
use counterpoint_motion::frame::local::{LocalFrame, LocalFramePart, Programmed};

use crate::context::ActionContext;
use crate::cutter;
use crate::entry::ActionEntry;
use crate::local::frame_text;

/// Codes with their actions.
pub(crate) const ENTRIES: &[ActionEntry] = &[
    ActionEntry::of(&[codes::FIGURE_TURN], |act, _, _| turn(act)),
    ActionEntry::of(&[codes::FIGURE_SHIFT], |act, _, _| shift(act)),
];

const CENTER: [DataId; 3] = [data::LCS_ROT_CENTER_X, data::LCS_ROT_CENTER_Y, data::LCS_ROT_CENTER_Z];
const STEP: [DataId; 3] = [data::ARC_CENTER_X, data::ARC_CENTER_Y, data::ARC_CENTER_Z];

fn turn(act: &mut ActionContext<'_, '_>) -> Acted {
    let center = lengths(act, CENTER);
    let Some(angle) = act.take(data::LCS_ROT_ANGLE).map(|datum| datum.value) else {
        return missing(act, "the angle of its copies");
    };
    call(act, Copy::Turned(angle, center))
}

fn shift(act: &mut ActionContext<'_, '_>) -> Acted {
    let by = lengths(act, STEP);
    call(act, Copy::Shifted(by))
}

/// Lengths as geometry, 0 without a word.
fn lengths(act: &mut ActionContext<'_, '_>, ids: [DataId; 3]) -> Point {
    let mut taken = [0.0; 3];
    for (role, (slot, id)) in taken.iter_mut().zip(ids).enumerate() {
        let scale = act.channel().state.place.scale_of(role);
        *slot = act.take(id).map_or(0.0, |datum| datum.value * scale);
    }
    taken
}

fn missing(act: &mut ActionContext<'_, '_>, what: &str) -> Acted {
    let text = format!("a figure copy needs {what} in '{}'; nothing is copied", act.channel().block_text());
    act.diagnose(&diag::DATA_MISSING, text);
    act.take(data::CALSUB_ID);
    act.take(data::CALSUB_REPEAT);
    act.channel().check_stop()
}

fn call(act: &mut ActionContext<'_, '_>, copy: Copy) -> Acted {
    let id = act.take(data::CALSUB_ID).map(|datum| datum.value);
    let repeat = act.take(data::CALSUB_REPEAT).map(|datum| datum.value);
    let Some(program) = id.filter(|v| *v >= 1.0 && *v <= f64::from(u32::MAX) && v.fract() == 0.0) else {
        let text = format!("a figure copy needs a program number in '{}'", act.channel().block_text());
        return Err(act.alarm(&diag::SUBPROGRAM_MISSING, text));
    };
    act.flush_lookahead()?;
    let base =
        act.channel().state.place.frames.as_deref().map_or_else(LocalFrame::default, |frames| frames.local.clone());
    let passes = repeat.map_or(1, |count| act.passes(count)).max(1);
    act.call_figure(program as u32, passes, Box::new(CopiedFigure { copy, made: 0, base }));
    Ok(())
}

/// The part that a copy adds to the local frame.
fn part(act: &ActionContext<'_, '_>, figure: &CopiedFigure) -> Option<(LocalFramePart, Programmed)> {
    let times = f64::from(figure.made);
    match figure.copy {
        Copy::Turned(angle, center) => {
            let about = super::local::normal(act);
            let map = Affine::rotation(about, angle * times)?.around(center);
            let given = Programmed { map, values: about, center: Some(center), order: "IJK", angle: angle * times };
            Some((LocalFramePart::Rotate, given))
        }
        Copy::Shifted(by) => {
            let by = by.map(|step| step * times);
            Some((LocalFramePart::Translate, Programmed::new(Affine::translation(by), by)))
        }
    }
}

/// The frame of the next copy (`on`), or the frame before all copies.
pub(crate) fn put(act: &mut ActionContext<'_, '_>, figure: &CopiedFigure, on: bool) -> Acted {
    act.flush_lookahead()?;
    let levels = act.channel_mut().state.cycle_levels();
    let before = act.channel().counts_from();
    let mirrored = cutter::mirror::is_mirrored(act);
    let mut local = figure.base.clone();
    let has = act.channel().state.place.has_axes();
    if on
        && let Some((part, given)) = part(act, figure)
        && let Err(refused) = local.add(part, given, has)
    {
        super::local::refuse(act, refused);
    }
    act.channel_mut().state.place.frames().local = local;
    act.channel_mut().state.place.frames_changed();
    cutter::mirror::frame_changed(act, mirrored);
    act.channel_mut().state.place.keep_ways(before);
    act.channel_mut().state.keep_levels(levels);
    let text = frame_text(act);
    act.channel_mut().emit(0, counterpoint_event::event::Kind::mode(text));
    Ok(())
}
