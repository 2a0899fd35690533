//! Reference points: via an intermediate point to them, and back.
//!
//! Facts: reference control-emulator.md 6.1 (`CODE_GOHOME` has data, via the given point to the reference).

use crate::channel::Kernel;
use crate::diag;
use crate::log::event::Position;
use crate::machine::habits::Home;
use crate::machine::ident::data;
use crate::state::position::Axis;
use crate::trace::{self, ACTION};
use counterpoint_fault::Acted;

/// To reference point `number` (1 = home) via the programmed point; only coded axes move.
pub(super) fn go(kernel: &mut Kernel<'_>, number: usize) -> Acted {
    if kernel.channel.env.machine.habits.home == Home::Machine {
        return straight(kernel, number);
    }
    let (mut coded, via) = kernel.targets();
    if coded == 0 {
        if !kernel.channel.env.machine.habits.bare_home {
            return Ok(());
        }
        coded = every_axis(kernel);
    }
    kernel.trace(ACTION, |kernel| trace::action(&home_text(kernel, coded, number)));
    check_reference(kernel, coded, number)?;
    kernel.channel.state.place.home_via = Some(via);
    kernel.rapid_to(coded, via)?;
    to_reference(kernel, coded, number)
}

/// Point `number` of an axis in the machine frame.
fn reference(axis: &Axis, number: usize) -> Option<f64> {
    match number {
        1 => Some(axis.home),
        n => axis.references.get(n.wrapping_sub(2)).copied().flatten(),
    }
}

/// Reports a reference point that the machine does not have for all axes that go there.
fn check_reference(kernel: &mut Kernel<'_>, coded: u8, number: usize) -> Acted {
    let mut axes = kernel.channel.state.place.axes.iter().enumerate().filter(|(index, _)| coded & (1 << index) != 0);
    if axes.any(|(_, axis)| reference(axis, number).is_none()) {
        let text = format!("reference point {number} is not defined for every axis of '{}'", kernel.block_text());
        kernel.diagnose(&diag::NO_REFERENCE, text);
    }
    kernel.channel.check_stop()
}

/// Straight to the point of the machine frame that the block gives, without words to the reference point.
fn straight(kernel: &mut Kernel<'_>, number: usize) -> Acted {
    kernel.channel.state.place.home_via = Some(kernel.channel.state.place.position);
    let (coded, target) = machine_targets(kernel);
    if coded != 0 {
        return kernel.rapid_to(coded, target);
    }
    let coded = every_axis(kernel);
    check_reference(kernel, coded, number)?;
    to_reference(kernel, coded, number)
}

/// All axes of the channel, bit by axis.
fn every_axis(kernel: &Kernel<'_>) -> u8 {
    ((1_u16 << kernel.channel.state.place.axes.len().min(8)) - 1) as u8
}

/// Takes the axis words as positions of the machine frame.
pub(super) fn machine_targets(kernel: &mut Kernel<'_>) -> (u8, Position) {
    let before = std::mem::replace(&mut kernel.channel.block.machine_frame, true);
    let taken = kernel.targets();
    kernel.channel.block.machine_frame = before;
    taken
}

fn to_reference(kernel: &mut Kernel<'_>, coded: u8, number: usize) -> Acted {
    let mut target = kernel.channel.machine_point(&kernel.channel.state.place.position);
    for (index, (slot, axis)) in target.iter_mut().zip(&kernel.channel.state.place.axes).enumerate() {
        if coded & (1 << index) == 0 {
            continue;
        }
        if let Some(point) = reference(axis, number) {
            *slot = point;
        }
    }
    let target = kernel.channel.way_of_machine(&target);
    kernel.rapid_to(coded, target)
}

/// `home x, z`, the axes that move; `n=2` for a further reference point.
fn home_text(kernel: &Kernel<'_>, coded: u8, number: usize) -> String {
    let axes = (0..kernel.channel.state.place.axes.len()).filter(|axis| coded & (1 << axis) != 0);
    let mut items: Vec<String> = axes.map(|axis| kernel.channel.axis_name(axis)).collect();
    if number > 1 {
        items.push(format!("n={number}"));
    }
    format!("home {}", items.join(", "))
}

/// To the second, third or fourth reference point; 2 without a number.
pub(super) fn go_nth(kernel: &mut Kernel<'_>) -> Acted {
    let number = kernel.take(data::GOHOME_NTH).map_or(2.0, |d| d.value);
    if ![2.0, 3.0, 4.0].contains(&number) {
        let text = format!("there is no reference point {number} in '{}', expected 2, 3 or 4", kernel.block_text());
        kernel.diagnose(&diag::NO_REFERENCE, text);
        kernel.targets();
        return Ok(());
    }
    go(kernel, number as usize)
}

/// From the reference point via the last intermediate point to the programmed one.
pub(super) fn come_back(kernel: &mut Kernel<'_>) -> Acted {
    let (coded, target) = kernel.targets();
    if coded == 0 {
        return Ok(());
    }
    match kernel.channel.state.place.home_via {
        Some(via) => {
            let mut through = kernel.channel.state.place.position;
            for (index, (slot, value)) in through.iter_mut().zip(via).enumerate() {
                if coded & (1 << index) != 0 {
                    *slot = value;
                }
            }
            kernel.rapid_to(coded, through)?;
        }
        None => {
            let text = format!("no intermediate point is known for '{}'", kernel.block_text());
            kernel.diagnose(&diag::RETURN_WITHOUT_HOME, text);
        }
    }
    kernel.rapid_to(coded, target)
}
