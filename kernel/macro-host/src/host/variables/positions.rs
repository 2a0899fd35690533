//! `$XM`, `$LZJ`, `$YW` …: positions of the axes of the channel.
//!
//! *Invariant:* an axis that the channel does not have is at 0. Programmed units: a diameter on a diameter axis,
//! degrees on a rotary one. M = machine without length and work offsets, J = joint with both, W = programmed.

use crate::context::KernelHost;
use counterpoint_channel::channel_context::ChannelContext;
use counterpoint_channel::position::MotionState;
use counterpoint_machine::ident::kind::data::DataKind;
use counterpoint_machine::ident::{DataId, data};
use counterpoint_machine::index::{AxisSlot, BySlot};

/// Which value of which axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct AxisPosition {
    letter: char,
    kind: char,
    /// On the table (T) or the head (H), blank for either.
    side: char,
    /// At the start of the last motion.
    before: bool,
}

/// The place that a name means.
pub(crate) fn place(name: &str) -> Option<AxisPosition> {
    let name = name.strip_prefix('$')?;
    let (before, name) = match name.strip_prefix('L') {
        Some(rest) if rest.len() > 1 => (true, rest),
        _ => (false, name),
    };
    let mut letters = name.chars();
    let letter = letters.next()?;
    let rest: String = letters.collect();
    let kind = match rest.as_str() {
        "M" | "TM" | "HM" => 'M',
        "J" | "TJ" | "HJ" => 'J',
        "W" if "XYZ".contains(letter) => 'W',
        _ => return None,
    };
    let side = if rest.len() == 2 { rest.chars().next()? } else { ' ' };
    let rotary = "ABC".contains(letter);
    ("XYZUVWEND".contains(letter) && side == ' ' || rotary).then_some(AxisPosition { letter, kind, side, before })
}

pub(crate) fn position_of(host: &KernelHost<'_, '_>, place: AxisPosition) -> f64 {
    let Some(axis) = axis_at(&host.kernel.channel, place) else { return 0.0 };
    if place.kind == 'W' && !place.before {
        return host.kernel.channel.state.place.programmed().at(axis);
    }
    let at =
        if place.before { &host.kernel.macros.arguments.before } else { &host.kernel.channel.state.place.position };
    let value = |of: &counterpoint_event::event::Position| of.at(axis);
    match place.kind {
        'M' if host.kernel.channel.state.place.couples() => {
            value(&host.kernel.channel.state.place.machine_point(at)) - value(&host.kernel.channel.state.place.shift)
                + value(&host.kernel.channel.state.place.preset)
        }
        'M' => value(at) + value(&host.kernel.channel.state.place.preset),
        'J' => value(&host.kernel.channel.state.place.machine_point(at)),
        _ => value(&host.kernel.channel.state.place.program_point(at)),
    }
}

/// Channel axis of a name.
fn axis_at(channel: &ChannelContext<'_>, place: AxisPosition) -> Option<AxisSlot> {
    let find = |ids: &[DataId]| ids.iter().find_map(|id| channel.state.place.axis_of_data(*id));
    let of = |table: DataId, head: DataId| match place.side {
        'T' => find(&[table]),
        'H' => find(&[head]),
        _ => find(&[table, head]),
    };
    match place.letter {
        'A' => of(data::AXIS_AT, data::AXIS_AH),
        'B' => of(data::AXIS_BT, data::AXIS_BH),
        'C' => of(data::AXIS_CT, data::AXIS_CH).or_else(|| find(&[data::AXIS_CT2]).filter(|_| place.side != 'H')),
        'N' => find(&[data::AXIS_N]),
        'D' => find(&[data::AXIS_N2]),
        'E' => find(&[data::AXIS_E]),
        letter => channel.state.place.layout.axis_of_letter(channel.env.machine, letter),
    }
}

/// Channel axes of the six elements of `$AXES`: X Y Z, two rotary ones, and one more.
pub(crate) fn six_axes(place: &MotionState) -> [Option<AxisSlot>; 6] {
    let mut rotary = place.layout.axes.entries().filter(|(_, axis)| axis.rotary).map(|(at, _)| at);
    let cartesian = place.layout.cartesian;
    let [x, y, z] = cartesian;
    let (fourth, fifth) = (rotary.next(), rotary.next());
    let mut others = place.layout.axes.entries().filter(|(_, axis)| !axis.rotary).map(|(at, _)| at);
    let sixth = others.find(|at| !cartesian.contains(&Some(*at))).or_else(|| rotary.next());
    [x, y, z, fourth, fifth, sixth]
}

/// Letter of a channel axis in `$AXES`.
pub(crate) fn axis_letter(place: &MotionState, axis: Option<AxisSlot>) -> char {
    let axis = axis.map(|axis| &place.layout.axes[axis]);
    match axis.map(|axis| axis.data.kind()) {
        Some(DataKind::Axis(letter)) => letter,
        _ => '*',
    }
}

/// `$AXES`
pub(crate) fn axes_text(place: &MotionState) -> String {
    six_axes(place).into_iter().map(|axis| axis_letter(place, axis)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_positions() {
        let of = |name: &str| place(name).map(|p| (p.letter, p.kind, p.before));
        assert_eq!(of("$XM"), Some(('X', 'M', false)));
        assert_eq!(of("$LZJ"), Some(('Z', 'J', true)));
        assert_eq!(of("$ATM"), Some(('A', 'M', false)));
        assert_eq!([of("$LW"), of("$EV"), of("$SDIR"), of("$FMODE"), of("$IW")], [None; 5]);
    }
}
