//! Stock removal along a contour that a subprogram has described (Siemens CYCLE95).
//!
//! Facts: reference siemens-cycles.md 1.6 and 6; the moves are those of `counterpoint_motion::turning::strip`.
//! *Invariant:* a contour that cannot be cut is an alarm of the control, and nothing has moved.

use counterpoint_channel::turning::RecordedContour;
use counterpoint_fault as diag;
use counterpoint_fault::Acted;
use counterpoint_motion::turning::strip::{Removal, Strip, StripError};

use super::moves::Cutting;
use crate::context::ActionContext;

/// Removes stock along the contour that was read last.
pub(crate) fn strip(act: &mut ActionContext<'_, '_>, strip: &Strip) -> Acted {
    let reading = std::mem::take(&mut act.channel_mut().state.others.turning.kept);
    let done = cut(act, strip, &reading);
    act.channel_mut().state.others.turning.kept = reading;
    done
}

fn cut(act: &mut ActionContext<'_, '_>, strip: &Strip, reading: &RecordedContour) -> Acted {
    let plane =
        act.channel().state.lathe_plane().filter(|plane| reading.plane.is_none_or(|own| own.axes == plane.axes));
    let Some(plane) = plane else {
        let text = format!(
            "the program sets alarm 61606: the contour is not in the plane of Z and X in '{}'",
            act.channel().block_text()
        );
        return Err(act.alarm(&diag::SIEMENS_STOP, text));
    };
    let why = match Removal::new(&reading.elements, *strip) {
        Ok(removal) => {
            let [first, into, along] = strip.feeds;
            let (_, unit) = act.active_feed();
            let mut cutting =
                Cutting::new(act, &plane, (Some(first), unit)).with_feeds([Some(into), Some(along)], Vec::new());
            return removal.run(&mut cutting);
        }
        Err(StripError::TurnsBack) if strip.plunges != 0.0 => "61605: finishing a groove needs one way down and one up",
        Err(StripError::TurnsBack) => "61605: the contour turns back along the cut",
        Err(StripError::Nothing) => "61606: the contour has no piece to cut",
        Err(StripError::Narrow) if strip.plunges != 0.0 => {
            "61605: the tool or the allowances do not fit into the groove"
        }
        Err(StripError::Narrow) => "61605: the allowances do not fit into the contour",
        Err(StripError::Clearance) => {
            "61604: the contour falls more steeply than the clearance angle of the tool allows"
        }
    };
    let text = format!("the program sets alarm {why} in '{}'", act.channel().block_text());
    Err(act.alarm(&diag::SIEMENS_STOP, text))
}
