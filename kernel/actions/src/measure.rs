//! Automatic measuring of a tool (Fanuc G37, G36 of lathes; Mitsubishi G37).
//!
//! The tool moves to the position at which the program expects the measuring device. *Invariant:* there is no device
//! here, so its signal comes at the expected position: offsets do not change, and a warning says so.

use counterpoint_event::event::FeedUnit;
use counterpoint_fault as diag;
use counterpoint_fault::Acted;
use counterpoint_machine::ident::{codes, data};
use counterpoint_machine::index::BySlot;

use crate::context::{ActionContext, StraightSteps};
use crate::entry::{ActionEntry, CompensationEffect};
use crate::motion::rapid_to;

/// Codes with their actions.
pub(crate) const ENTRIES: &[ActionEntry] =
    &[ActionEntry::of(&[codes::TOOL_MEASURE], |act, _, _| measure(act)).contour(CompensationEffect::Leaves)];

/// Moves at rapid up to a distance from the point and at a feed from there, if the block gives both.
fn measure(act: &mut ActionContext<'_, '_>) -> Acted {
    let distance = act.take(data::OFFSET_VALUE).map(|datum| datum.value.abs());
    let feed = act.take(data::FEED_UPM).map(|datum| datum.value).filter(|feed| *feed > 0.0);
    let (coded, target) = act.targets();
    if coded == 0 {
        return Ok(());
    }
    let from = act.channel().state.place.position;
    let mut near = target;
    for slot in act.channel().state.place.layout.axes.ids().filter(|slot| coded & slot.bit() != 0) {
        let way = target.at(slot) - from.at(slot);
        let left = distance.unwrap_or(0.0).min(way.abs());
        *near.at_mut(slot) -= left.copysign(way);
    }
    rapid_to(act, coded, near)?;
    match feed {
        Some(feed) => act.feed_to(coded, target, Some(feed), FeedUnit::PerMinute)?,
        None => rapid_to(act, coded, target)?,
    }
    let text = format!(
        "the tool is assumed to match its offset in '{}'; the offset does not change",
        act.channel().block_text()
    );
    act.diagnose(&diag::MEASURE_ASSUMED, text);
    Ok(())
}
