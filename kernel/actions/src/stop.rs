//! Stops and ends.

use crate::context::ActionContext;
use crate::entry::ActionEntry;
use counterpoint_event::event::{Kind, StopCode};
use counterpoint_fault::Acted;
use counterpoint_machine::ident::codes;

/// Codes with their actions.
pub(crate) const ENTRIES: &[ActionEntry] = &[
    ActionEntry::of(&[codes::STOP], |act, _, _| stop(act, StopCode::Program)),
    ActionEntry::of(&[codes::OPSTOP], |act, _, _| stop(act, StopCode::Optional)),
    ActionEntry::of(&[codes::END], |act, _, _| stop(act, StopCode::End)),
    ActionEntry::of(&[codes::REWIND], |act, _, _| stop(act, StopCode::Rewind)),
];

/// Program stop, optional stop, end, rewind.
pub(crate) fn stop(act: &mut ActionContext<'_, '_>, stop: StopCode) -> Acted {
    match stop {
        StopCode::Program => {
            act.channel_mut().emitter.stop_path();
            act.channel_mut().emit(0, Kind::Stop(stop));
            Ok(())
        }
        StopCode::Optional => {
            if act.channel().env.options.opstop {
                act.channel_mut().emitter.stop_path();
                act.channel_mut().emit(0, Kind::Stop(stop));
            }
            Ok(())
        }
        // Inside a subprogram an end code returns or ends the program, depending on the control.
        StopCode::End | StopCode::Rewind if act.call_depth() > 1 && !act.channel().env.machine.subprograms.end_ends => {
            act.return_from(None);
            Ok(())
        }
        // The block is finished before the program ends (reference control-emulator.md 2.2).
        StopCode::End | StopCode::Rewind => {
            act.compare_last_speed()?;
            act.end_program(stop);
            Ok(())
        }
    }
}
