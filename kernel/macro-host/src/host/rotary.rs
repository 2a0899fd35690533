//! How functions name rotary axes, and `$FUNWIND`.
//!
//! Facts: reference functions.md 10.

use counterpoint_lang::fault::{MacroFault, Outcome};
use counterpoint_lang::ident::minor_code;
use counterpoint_lang::value::MacroValue;

use crate::context::KernelHost;
use counterpoint_channel::channel_context::ChannelContext;
use counterpoint_channel::clamps::Modulo;
use counterpoint_machine::ident::{DataId, data};
use counterpoint_machine::index::AxisSlot;

/// Subject of a function.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum RotarySubject {
    /// The tool axis.
    Tool,
    /// An axis of the channel.
    Axis(AxisSlot),
    /// An axis that the channel does not have.
    Missing,
}

pub(crate) fn is(value: Option<&MacroValue>, word: &str) -> bool {
    matches!(value, Some(MacroValue::Keyword(code)) if minor_code(word) == Some(*code))
}

/// Refuses arguments that can be neither an axis nor a setting of one.
pub(crate) fn only_axes(arguments: &[MacroValue]) -> Outcome<&[MacroValue]> {
    let fits =
        |value: &&MacroValue| matches!(value, MacroValue::Real(_) | MacroValue::Keyword(_) | MacroValue::Record(_));
    match arguments.iter().find(|value| !fits(value)) {
        Some(other) => Err(MacroFault::kind("a number or a keyword", other)),
        None => Ok(arguments),
    }
}

/// `$FUNWIND`: 1 if every axis that is named is a rotary one of the channel.
pub(crate) fn unwind_named(host: &mut KernelHost<'_, '_>, arguments: &[MacroValue]) -> MacroValue {
    let (mut at, mut done) = (0, true);
    while at < arguments.len() {
        let Some((named, count)) = named_axis(&host.kernel.channel, arguments, at) else {
            return MacroValue::Real(0.0);
        };
        at += count;
        let words = [("NORMAL", Modulo::Normal), ("PLUS", Modulo::Plus), ("MINUS", Modulo::Minus)];
        let given = words.iter().find(|(word, _)| is(arguments.get(at), word)).map(|(_, modulo)| *modulo);
        at += usize::from(given.is_some());
        match named {
            RotarySubject::Axis(axis) if host.kernel.channel.state.place.layout.axes[axis].rotary => {
                host.kernel.unwind_axis(axis, given.unwrap_or(Modulo::Normal));
            }
            _ => done = false,
        }
    }
    MacroValue::Real(f64::from(u8::from(done)))
}

/// The axis that the arguments from `at` on name, and how many of them do; none for anything else.
pub(crate) fn named_axis(
    channel: &ChannelContext<'_>,
    arguments: &[MacroValue],
    at: usize,
) -> Option<(RotarySubject, usize)> {
    let found = |ids: &[DataId]| {
        ids.iter()
            .find_map(|id| channel.state.place.axis_of_data(*id))
            .map_or(RotarySubject::Missing, RotarySubject::Axis)
    };
    let first = arguments.get(at)?;
    if let MacroValue::Real(number) = first {
        let ids: &[DataId] = match *number {
            0.0 => return Some((RotarySubject::Tool, 1)),
            7.0 => &[data::AXIS_AT],
            8.0 => &[data::AXIS_BT],
            9.0 => &[data::AXIS_CT, data::AXIS_CT2],
            10.0 => &[data::AXIS_AH],
            11.0 => &[data::AXIS_BH],
            12.0 => &[data::AXIS_CH],
            14.0 => &[data::AXIS_N],
            15.0 => &[data::AXIS_N2],
            _ => return None,
        };
        return Some((found(ids), 1));
    }
    if is(Some(first), "TOOL") {
        return Some((RotarySubject::Tool, 1));
    }
    let second = arguments.get(at + 1);
    if is(Some(first), "RAM") {
        let ids: &[DataId] = match second {
            Some(MacroValue::Real(1.0)) => &[data::AXIS_N],
            Some(MacroValue::Real(2.0)) => &[data::AXIS_N2],
            _ => return None,
        };
        return Some((found(ids), 2));
    }
    let (table, head) = match ["AAXIS", "BAXIS", "CAXIS"].iter().position(|word| is(Some(first), word))? {
        0 => (data::AXIS_AT, data::AXIS_AH),
        1 => (data::AXIS_BT, data::AXIS_BH),
        _ => (data::AXIS_CT, data::AXIS_CH),
    };
    // Without TABLE it is the axis of the head; a machine without one can only mean its table.
    Some(if is(second, "TABLE") { (found(&[table]), 2) } else { (found(&[head, table]), 1) })
}
