//! The last value of each address: the only source for system variables and stepping.
//!
//! [`RememberedWords`](counterpoint_channel::remembered::RememberedWords) holds the words; this module converts them to
//! the units of the program and adds the values of the running program. Program numbers come from the words that define
//! the programs, and from calls by number, never from a file name. *Invariant:* reading changes nothing. Facts:
//! reference fanuc-variables-and-alarms.md 1.5.

use counterpoint_machine::ident::dimension::Dimension;
use counterpoint_machine::index::BySlot;

use super::Kernel;
use crate::channel::system_variables;
use counterpoint_channel::callee::Callee;
use counterpoint_channel::channel_context::ChannelContext;
use counterpoint_channel::flow::RunningProgram;
use counterpoint_channel::modal::{feed_of, group};
use counterpoint_channel::offset_tables::EXTENDED;

/// Addresses that an operator wants to see, in the order of a screen.
const SHOWN: &[u8] = b"ONDHFSTM";

impl Kernel<'_> {
    /// Last value of an address, 0 without one.
    pub(super) fn address(&self, letter: u8) -> f64 {
        let channel = &self.channel;
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
            b'O' => f64::from(self.running_program()),
            b'X' | b'Y' | b'Z' => {
                let slot = system_variables::tool_axis(&self.channel.state.place, letter - b'X');
                slot.map_or(0.0, |slot| channel.state.place.programmed().at(slot) / self.length_factor(slot))
            }
            b'P' => f64::from(place.in_force.work_offset.saturating_sub(EXTENDED)),
            _ => 0.0,
        }
    }

    /// Addresses with a value other than 0, for stepping.
    pub(super) fn shown_words(&self) -> Vec<(char, f64)> {
        let words = SHOWN.iter().map(|&letter| (char::from(letter), self.address(letter)));
        words.filter(|(_, value)| *value != 0.0).collect()
    }

    /// Number of the main program, 0 if it has none.
    pub(super) fn main_number(&self) -> u32 {
        self.flow.frames.first().and_then(|frame| program_of(&self.channel, frame)).unwrap_or(0)
    }

    /// Number of the running program, 0 if it has none.
    fn running_program(&self) -> u32 {
        self.flow.frames.iter().rev().find_map(|frame| program_of(&self.channel, frame)).unwrap_or(0)
    }
}

/// Number of the program of a frame, 0 without one; none where blocks of the program before it run.
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
