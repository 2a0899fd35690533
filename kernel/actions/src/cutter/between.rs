//! Blocks between two moves of a contour: which ones the control looks through.
//!
//! Facts: Fanuc B-63664EN/02 and Mitsubishi M700V, blocks without movement in the offset mode: few of them in a row
//! change nothing; more of them, and blocks that keep the control from reading ahead, let the move end beside its own
//! end. *Invariant:* an inside corner that is cut into for this reason is reported.

use counterpoint_channel::channel_context::ChannelContext;
use counterpoint_channel::cutter::ProgrammedMove;
use counterpoint_fault as diag;
use counterpoint_fault::Acted;
use counterpoint_machine::ident::{CodeId, codes};
use counterpoint_machine::model::LengthInMachineFrame;

use super::{corner, smooth};
use crate::context::ActionContext;
use crate::entry::CompensationEffect;

/// The effect of an action on a waiting move.
pub(crate) fn before(act: &mut ActionContext<'_, '_>, contour: CompensationEffect, code: CodeId) -> Acted {
    let reads_on =
        act.channel().env.machine.compensation.between.past_stops && matches!(code, codes::STOP | codes::OPSTOP);
    let contour = if reads_on { CompensationEffect::Waits } else { contour };
    corner::follow(act, contour)?;
    if act.channel().env.machine.corners.dwell_only && parts_corner(act, contour, code) {
        act.flush_lookahead()?;
        act.channel().check_stop()?;
    }
    let (blocks, in_machine) = (act.channel().at.blocks, act.channel().block.flags.machine_frame);
    let (most, of_machine) =
        (act.channel().env.machine.corners.between, act.channel().env.machine.compensation.between.looked_through);
    let shared = act.channel().state.spindle.is_seen(act.channel().env.machine);
    let Some(cutter) = act.channel_mut().state.place.cutter() else { return Ok(()) };
    if cutter.seen != blocks && !leads_on(code) {
        cutter.idle += u32::from(cutter.waiting.first().is_some_and(|first| first.block != cutter.seen));
        cutter.seen = blocks;
    }
    let smooth = cutter.waiting.first().is_some_and(|first| first.smooth.is_some());
    let most = if smooth { most.max(smooth::LOOKED_THROUGH) } else { most };
    let long = cutter.idle > if smooth || cutter.is_due() { most } else { of_machine };
    match contour {
        CompensationEffect::Follows if !in_machine => cutter.suspended = false,
        CompensationEffect::Follows | CompensationEffect::Waits => {}
        CompensationEffect::Leaves if code == codes::POSITION_MACHINE && stays_in_machine_frame(act) => {}
        CompensationEffect::Leaves => {
            act.flush_lookahead()?;
            if let Some(cutter) = act.channel_mut().state.place.cutter() {
                cutter.suspended = true;
            }
            return Ok(());
        }
        CompensationEffect::Commands if !shared => {}
        CompensationEffect::Commands | CompensationEffect::Ends => return act.flush_lookahead(),
    }
    if !long {
        return Ok(());
    }
    if act.channel().env.machine.compensation.between.alarm_beyond && !smooth {
        too_many(act, of_machine);
        act.channel().check_stop()?;
    }
    act.flush_lookahead()
}

/// Whether positions of the machine frame are those of the tool, beside which compensation stays active.
fn stays_in_machine_frame(act: &ActionContext<'_, '_>) -> bool {
    act.channel().env.machine.compensation.length.in_machine_frame == LengthInMachineFrame::Added
}

/// Whether calls and returns are statements of the program's flow, as those of custom macros; they are no blocks
/// without a move.
fn leads_on(code: CodeId) -> bool {
    matches!(code, codes::CALSUB_ID | codes::CALSUB_RANGE | codes::CALSUB_RETURN)
}

/// More blocks without a move in the plane than the control looks through, where that is an alarm.
#[cold]
fn too_many(act: &mut ActionContext<'_, '_>, most: u32) {
    let Some(cutter) = act
        .channel_mut()
        .state
        .place
        .cutter()
        .filter(|cutter| !cutter.plain && !cutter.is_due() && !cutter.stage.is_ending())
    else {
        return;
    };
    let Some(line) = cutter.waiting.first().map(|first| first.place.line) else { return };
    let text = format!(
        "more than {most} blocks between the move of line {line} and the next one in the plane of the compensation, \
         before '{}'",
        act.channel().block_text()
    );
    act.diagnose(&diag::EMPTY_BLOCKS, text);
}

/// Whether a code in a block without a move, after the block of a corner, is neither a dwell nor a call.
fn parts_corner(act: &mut ActionContext<'_, '_>, contour: CompensationEffect, code: CodeId) -> bool {
    let (blocks, moves) = (act.channel().at.blocks, act.has_motion_word());
    let due = act.channel_mut().state.place.cutter().filter(|cutter| cutter.is_due());
    let before = due.and_then(|cutter| cutter.waiting.last()).is_some_and(|last| last.block != blocks);
    let looked_through = matches!(code, codes::DELAY | codes::DELAY_REV) || leads_on(code);
    before && !moves && !looked_through && matches!(contour, CompensationEffect::Waits | CompensationEffect::Commands)
}

/// A move of length zero counts for several blocks without a move.
pub(crate) fn count_zero_move(channel: &mut ChannelContext<'_>, step: &ProgrammedMove) {
    let counts = channel.env.machine.compensation.between.zero_move;
    let stays = channel.state.place.contour() == step.to;
    if let Some(cutter) = channel.state.place.cutter().filter(|_| stays) {
        cutter.idle = cutter.idle.saturating_add(counts.saturating_sub(1));
    }
}
