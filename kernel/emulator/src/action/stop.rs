//! Stops and ends.

use crate::act::Act;
use crate::action::entry::Entry;
use counterpoint_event::event::{Kind, Stop};
use counterpoint_fault::Acted;
use counterpoint_machine::ident::codes;

/// Codes with their actions.
pub(crate) const ENTRIES: &[Entry] = &[
    Entry::of(&[codes::STOP], |act, _, _| stop(act, Stop::Program)),
    Entry::of(&[codes::OPSTOP], |act, _, _| stop(act, Stop::Optional)),
    Entry::of(&[codes::END], |act, _, _| stop(act, Stop::End)),
    Entry::of(&[codes::REWIND], |act, _, _| stop(act, Stop::Rewind)),
];

/// Program stop, optional stop, end, rewind.
pub(super) fn stop(act: &mut Act<'_, '_>, stop: Stop) -> Acted {
    match stop {
        Stop::Program => {
            act.channel_mut().emitter.stop_path();
            act.channel_mut().emit(0, Kind::Stop(stop));
            Ok(())
        }
        Stop::Optional => {
            if act.channel().env.options.opstop {
                act.channel_mut().emitter.stop_path();
                act.channel_mut().emit(0, Kind::Stop(stop));
            }
            Ok(())
        }
        // Inside a subprogram an end code returns or ends the program, depending on the control.
        Stop::End | Stop::Rewind if act.call_depth() > 1 && !act.channel().env.machine.subprograms.end_ends => {
            act.return_from(None);
            Ok(())
        }
        // The block is finished before the program ends (reference control-emulator.md 2.2).
        Stop::End | Stop::Rewind => {
            act.compare_last_speed()?;
            act.end_program(stop);
            Ok(())
        }
    }
}
