//! The tool-change position: to it, back from it, and on the way to a tool change.
//!
//! Facts: reference control-emulator.md 6.1, 6.3. Decision: like the reference point, with coded axes via the given
//! point and only those, without any all axes that have a position.

use crate::channel::Kernel;
use crate::diag;
use crate::machine::habits::Home;
use counterpoint_fault::Acted;

/// To the change position.
pub(super) fn go(kernel: &mut Kernel<'_>) -> Acted {
    kernel.channel.state.others.before_change =
        Some(kernel.channel.machine_point(&kernel.channel.state.place.position));
    if kernel.channel.env.machine.habits.home == Home::Machine {
        let (coded, target) = super::home::machine_targets(kernel);
        return if coded == 0 { to_point(kernel, 0) } else { kernel.rapid_to(coded, target) };
    }
    let (coded, via) = kernel.targets();
    if coded != 0 {
        kernel.rapid_to(coded, via)?;
    }
    to_point(kernel, coded)
}

/// Before a tool is loaded.
pub(super) fn before_load(kernel: &mut Kernel<'_>) -> Acted {
    kernel.channel.state.others.before_change =
        Some(kernel.channel.machine_point(&kernel.channel.state.place.position));
    to_point(kernel, 0)
}

/// `coded` 0 = all axes that have a position.
fn to_point(kernel: &mut Kernel<'_>, coded: u8) -> Acted {
    let mut target = kernel.channel.machine_point(&kernel.channel.state.place.position);
    let (mut moving, mut missing) = (0_u8, false);
    let point = &kernel.channel.env.machine.tool.change_point;
    for (at, (slot, axis)) in target.iter_mut().zip(&kernel.channel.state.place.axes).enumerate() {
        if coded != 0 && coded & 1 << at == 0 {
            continue;
        }
        match point.get(axis.machine).copied().flatten() {
            Some(value) => {
                *slot = value;
                moving |= 1 << at;
            }
            None => missing |= coded != 0,
        }
    }
    let target = kernel.channel.way_of_machine(&target);
    if missing || moving == 0 {
        let text = format!("there is no tool-change position for every axis of '{}'", kernel.block_text());
        kernel.diagnose(&diag::NO_REFERENCE, text);
    }
    kernel.rapid_to(moving, target)
}

/// Back: to the programmed point, or to where the axes stood.
pub(super) fn come_back(kernel: &mut Kernel<'_>) -> Acted {
    let (coded, target) = kernel.targets();
    let before = kernel.channel.state.others.before_change.take();
    if coded != 0 {
        return kernel.rapid_to(coded, target);
    }
    match before {
        Some(before) => {
            let before = kernel.channel.way_of_machine(&before);
            let moved = kernel
                .channel
                .state
                .place
                .position
                .iter()
                .zip(&before)
                .take(kernel.channel.state.place.axes.len())
                .enumerate();
            let moving = moved.filter(|(_, (now, then))| now != then).fold(0, |bits, (at, _)| bits | 1_u8 << at);
            kernel.rapid_to(moving, before)
        }
        None => {
            let text =
                format!("the axes have not been sent to the tool-change position before '{}'", kernel.block_text());
            kernel.diagnose(&diag::RETURN_WITHOUT_HOME, text);
            Ok(())
        }
    }
}
