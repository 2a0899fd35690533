//! Stops and ends.

use crate::channel::Kernel;
use crate::channel::flow::Pending;
use crate::log::event::{Kind, Stop};
use counterpoint_fault::Acted;

/// Program stop, optional stop, end, rewind.
pub(super) fn stop(kernel: &mut Kernel<'_>, stop: Stop) -> Acted {
    match stop {
        Stop::Program => {
            kernel.emit(0, Kind::Stop(stop));
            Ok(())
        }
        Stop::Optional => {
            if kernel.channel.env.options.opstop {
                kernel.emit(0, Kind::Stop(stop));
            }
            Ok(())
        }
        // Inside a subprogram an end code returns (reference control-emulator.md 5.4, Fanuc row).
        Stop::End | Stop::Rewind if kernel.flow.frames.len() > 1 => {
            kernel.ask(Pending::Return(None));
            Ok(())
        }
        // The block is finished before the program ends (reference control-emulator.md 2.2).
        Stop::End | Stop::Rewind => {
            kernel.ask(Pending::End(stop));
            Ok(())
        }
    }
}
