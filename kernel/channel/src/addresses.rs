//! The last value of each address: the only source for system variables and stepping.
//!
//! [`RememberedWords`](crate::remembered::RememberedWords) holds the words; this module converts them to
//! the units of the program and adds the values of the running program. Program numbers come from the words that define
//! the programs, and from calls by number, never from a file name. *Invariant:* reading changes nothing. Facts:
//! reference fanuc-variables-and-alarms.md 1.5.

use counterpoint_machine::ident::dimension::Dimension;
use counterpoint_machine::index::{AxisSlot, BySlot};

use crate::callee::Callee;
use crate::channel_context::ChannelContext;
use crate::flow::{ProgramFlow, RunningProgram};
use crate::modal::{feed_of, group};
use crate::offset_tables::EXTENDED;
use crate::position::MotionState;

/// Addresses that the operator needs, in the order of a screen.
const SHOWN: &[u8] = b"ONDHFSTM";

/// Last value of an address, 0 without one.
pub fn address_value(channel: &ChannelContext<'_>, flow: &ProgramFlow, letter: u8) -> f64 {
    let (place, remembered) = (&channel.state.place, &channel.state.remembered);
    match letter {
        b'F' => {
            let (feed, _) = feed_of(channel.state.modal.code(group::FEED));
            remembered.value(feed).unwrap_or(0.0) / channel.unit_factor(Dimension::Feed)
        }
        b'S' => remembered.speed().unwrap_or(channel.state.spindle.command.rpm),
        b't' => f64::from(place.tools.current),
        b'T' if channel.is_turning() => {
            let digits = channel.env.machine.tool.offset_digits;
            f64::from(place.tools.current) * 10_f64.powi(i32::from(digits)) + f64::from(place.in_force.tool_offset)
        }
        b'T' if place.tools.chosen => f64::from(place.tools.selected),
        b'T' => f64::from(place.tools.current),
        b'D' => f64::from(remembered.diameter()),
        b'H' => f64::from(remembered.length()),
        b'M' => remembered.function().unwrap_or(0.0),
        b'N' => f64::from(channel.block.sequence.or(remembered.sequence()).unwrap_or(0)),
        b'O' => f64::from(running_program(channel, flow)),
        b'X' | b'Y' | b'Z' => {
            let slot = tool_axis(&channel.state.place, letter - b'X');
            slot.map_or(0.0, |slot| channel.state.place.programmed().at(slot) / length_factor(channel, slot))
        }
        b'P' => f64::from(place.in_force.work_offset.saturating_sub(EXTENDED)),
        _ => 0.0,
    }
}

/// Addresses with a value other than 0, for stepping.
pub fn shown_words(channel: &ChannelContext<'_>, flow: &ProgramFlow) -> Vec<(char, f64)> {
    let words = SHOWN.iter().map(|&letter| (char::from(letter), address_value(channel, flow, letter)));
    words.filter(|(_, value)| *value != 0.0).collect()
}

/// Number of the main program, 0 if it has none.
pub fn main_number(channel: &ChannelContext<'_>, flow: &ProgramFlow) -> u32 {
    flow.frames.first().and_then(|frame| program_of(channel, frame)).unwrap_or(0)
}

/// Number of the running program, 0 if it has none.
fn running_program(channel: &ChannelContext<'_>, flow: &ProgramFlow) -> u32 {
    flow.frames.iter().rev().find_map(|frame| program_of(channel, frame)).unwrap_or(0)
}

/// Number of the program of a frame, 0 without a number; `None` for a frame that runs blocks of its caller.
fn program_of(channel: &ChannelContext<'_>, frame: &RunningProgram) -> Option<u32> {
    match frame.called.what {
        Callee::Program(0) | Callee::Named(_) => Some(defined(channel, frame)),
        Callee::Program(number) | Callee::ProgramFrom(number, _) => Some(number),
        Callee::Blocks(..) | Callee::From(_) | Callee::Labels(..) => None,
    }
}

/// The program number in the text of a frame: that of its first definition, or of the program in which it begins.
fn defined(channel: &ChannelContext<'_>, frame: &RunningProgram) -> u32 {
    let range = &frame.range;
    let programs = channel.env.sources.get(frame.file).map_or(&[][..], |source| source.programs());
    let own = programs.iter().filter(|own| (range.first..=range.last).contains(&own.first));
    let around = programs.iter().filter(|own| (own.first..=own.last).contains(&range.first));
    let found = own.chain(around).find_map(|own| own.number);
    range.number.or(found).unwrap_or(0)
}

/// Factor from lengths of the program to those of an axis.
pub fn length_factor(channel: &ChannelContext<'_>, axis: AxisSlot) -> f64 {
    let turns = channel.state.place.layout.axes[axis].rotary;
    if turns { 1.0 } else { channel.unit_factor(Dimension::Length) }
}

/// The axis with this role: 0 to 2 are X, Y and Z.
pub fn tool_axis(place: &MotionState, role: u8) -> Option<AxisSlot> {
    place.layout.cartesian.get(usize::from(role)).copied().flatten()
}
