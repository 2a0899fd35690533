//! Actions by which contour blocks are read: moves are recorded, everything else is skipped or refused.
//!
//! Facts: reference turning-cycles.md 1.3. *Invariant:* nothing here moves, takes time or reaches another channel.

use counterpoint_motion::arc::Arc;
use counterpoint_motion::contour::element::{Element, NOISE, distance};

use crate::act::Act;
use crate::action::arc::{Way, programmed};
use crate::action::entry::{Entry, entry_of_kind};
use crate::channel::actions::Action;
use crate::state::turning::First;
use counterpoint_event::event::Position;
use counterpoint_fault as diag;
use counterpoint_fault::Acted;
use counterpoint_machine::ident::kind::CodeKind;
use counterpoint_machine::ident::{CodeId, codes, data};
use counterpoint_machine::rows::CodeRow;
use counterpoint_program::block::PendingCode;

/// Codes that say something about the contour.
static READERS: &[Entry] = &[
    Entry::of(&[codes::RAPID, codes::INTERP_LINEAR], |act, row, _| straight(act, row.id == codes::RAPID)),
    entry_of_kind!(CodeKind::Arc(form) => |act, _row, code| match programmed(act, form, code)? {
        None => Ok(()),
        Some(Way::Straight { coded, to, .. }) => record(act, coded, to, None),
        Some(Way::Circle(_, circle)) => {
            let flat = act.lathe_plane().is_some_and(|plane| plane.axes == circle.axes);
            if flat { record(act, circle.coded, circle.to, Some(circle.made)) } else { refuse(act) }
        }
    }),
    Entry::of(&[codes::UNITS_PRIMARY, codes::UNITS_SECONDARY], |act, _, _| refuse(act)),
];

/// All other codes.
static OTHERS: Entry = Entry::of(&[], other);

/// What a code does while contour blocks are read.
pub(in crate::action) fn reading(id: CodeId) -> Option<&'static dyn Action> {
    READERS.iter().find(|entry| entry.takes(id)).or(Some(&OTHERS)).map(|entry| entry as &dyn Action)
}

/// G codes that a contour may have besides its moves.
const ALLOWED: [CodeId; 15] = [
    codes::DELAY,
    codes::FEED_UPM,
    codes::FEED_UPR,
    codes::SPINDLE_CSS,
    codes::SPINDLE_RPM,
    codes::SPINDLE_MAXRPM,
    codes::COMP_DIAM_OFF,
    codes::COMP_DIAM_LEFT,
    codes::COMP_DIAM_RIGHT,
    codes::POSITION_ABSOLUTE,
    codes::POSITION_RELATIVE,
    codes::EXACTSTOP,
    codes::EXACTSTOP_ON,
    codes::EXACTSTOP_OFF,
    codes::PLANE_ZX,
];

/// Codes of calls and ends, whatever their letter.
const FLOW: [CodeId; 4] = [codes::CALSUB_ID, codes::CALSUB_RETURN, codes::END, codes::REWIND];

/// A code that does not shape the contour.
fn other(act: &mut Act<'_, '_>, row: &CodeRow, code: &PendingCode) -> Acted {
    act.take(data::DELAY);
    let (letter, _) = act.written(row, code);
    if FLOW.contains(&row.id) || letter == 'G' && !ALLOWED.contains(&row.id) {
        return refuse(act);
    }
    Ok(())
}

fn refuse(act: &mut Act<'_, '_>) -> Acted {
    let text = format!("a contour has G0 to G4, feed, speed, tool and M codes only, not '{}'", act.block_text());
    Err(act.alarm(&diag::CONTOUR_CODE, text))
}

/// A straight move.
fn straight(act: &mut Act<'_, '_>, rapid: bool) -> Acted {
    act.feed();
    let (coded, target) = act.programmed_targets();
    if coded == 0 {
        return Ok(());
    }
    if act.state.others.turning.reading.first.is_none() {
        act.state.others.turning.reading.first = Some(First { rapid, coded });
        act.state.place.position = target;
        return Ok(());
    }
    record(act, coded, target, None)
}

/// A piece of the contour.
fn record(act: &mut Act<'_, '_>, coded: u8, target: Position, arc: Option<Arc>) -> Acted {
    if act.state.others.turning.reading.first.is_none() {
        let text = format!("the first block of a contour is a straight move, not '{}'", act.block_text());
        return Err(act.alarm(&diag::CONTOUR_FIRST, text));
    }
    let (from, to) = (act.flat(&act.state.place.position), act.flat(&target));
    if coded != 0 && (arc.is_some() || distance(from, to) > NOISE) {
        act.state.others.turning.reading.elements.push(Element { from, to, arc });
    }
    act.state.place.position = target;
    Ok(())
}
