//! Axes of a channel that follow axes of another channel: their positions, and the effect on the words of the block.
//!
//! Facts: reference channel-synchronisation.md 5. *Invariant:* an axis that follows has no commands of its own.

use counterpoint_event::event::Kind as Logged;
use counterpoint_event::event::{CarriedMove, Position};
use counterpoint_lang::format::wildcard_text;
use counterpoint_machine::index::{AxisSlot, BySlot};
use counterpoint_sync::shared::CoupledPosition;
use counterpoint_waits::coupling;
use counterpoint_waits::coupling::{CoupledAxis, CoupledPair, CouplingKind};

use crate::ChannelMemory;
use crate::channel_axis::TravelBounds;
use crate::channel_context::ChannelContext;
use crate::coupling::{Coupling, Parking, slots};
use crate::flow::ProgramFlow;
use crate::position::MotionState;

/// An axis that a coupling has moved to another position, and the previous position of its channel.
#[derive(Debug, Clone, Copy)]
pub struct CoupledAxisMove {
    slot: AxisSlot,
    from: Position,
}

/// Position of the own axis of a pair, and the distance commanded since the coupling.
pub fn coupled_position(channel: &ChannelContext<'_>, pair: &CoupledPair, own: CoupledAxis) -> CoupledPosition {
    let layout = &channel.state.place.layout;
    let Some(slot) = layout.axes.find(|axis| axis.machine == own.axis) else { return CoupledPosition::default() };
    let place = axis_place(channel, slot);
    let coupled = channel.state.others.couplings.iter().find(|coupling| coupling.pair == *pair);
    CoupledPosition { place, by: coupled.map_or(0.0, |coupling| place - coupling.from) }
}

/// Ends a coupling here: the axis is at the position to which both channels have moved it. Returns the axis if this
/// position is new.
pub fn uncouple(channel: &mut ChannelContext<'_>, pair: &CoupledPair, theirs: f64) -> Option<CoupledAxisMove> {
    let couplings = &mut channel.state.others.couplings;
    let at = couplings.iter().position(|coupling| coupling.pair == *pair)?;
    let coupling = couplings.remove(at);
    let slot = coupling.slot;
    if let Some((own, _)) = coupling.own {
        channel.state.place.layout.axes[slot] = own;
        limits_changed(&mut channel.state.place);
    }
    hold_followers(channel);
    let by = pair.sign(channel.env.machine) * theirs;
    let place = match (pair.kind, coupling.slave, coupling.parking) {
        (CouplingKind::Composite, ..) => coupling.stood + by,
        (CouplingKind::Synchronous, true, Parking::Slave) | (CouplingKind::Synchronous, false, Parking::Master) => {
            coupling.stood
        }
        (CouplingKind::Synchronous, true, _) => coupling.stood + by,
        (CouplingKind::Superimposed, true, _) => axis_place(channel, slot) + by,
        (CouplingKind::Synchronous | CouplingKind::Superimposed, false, _) => return None,
    };
    put_axis(channel, slot, place)
}

/// Position of an axis in the machine frame, geometry units.
pub fn axis_place(channel: &ChannelContext<'_>, slot: AxisSlot) -> f64 {
    let place = &channel.state.place;
    channel.state.place.machine_point(&place.position).at(slot) * place.layout.axes[slot].scale
}

/// Sets an axis to a position of the machine frame, geometry units. Returns the axis if its position has changed.
pub fn put_axis(channel: &mut ChannelContext<'_>, slot: AxisSlot, place: f64) -> Option<CoupledAxisMove> {
    let from = channel.state.place.position;
    let mut machine = channel.state.place.machine_point(&channel.state.place.position);
    let (before, after) = (machine.at(slot), place / channel.state.place.layout.axes[slot].scale);
    if before == after {
        return None;
    }
    *machine.at_mut(slot) = after;
    channel.state.place.position = channel.state.place.way_of_machine(&machine);
    if let Some(cutter) = channel.state.place.cutter() {
        *cutter.contour.at_mut(slot) += after - before;
    }
    Some(CoupledAxisMove { slot, from })
}

/// Keeps the couplings of axes after another component of a composite machine has become active.
pub fn keep_couplings(channel: &mut ChannelContext<'_>) {
    let (machine, own_number) = (channel.env.machine, channel.at.channel);
    let ChannelMemory { place, others, .. } = &mut channel.state;
    for coupling in &mut others.couplings {
        let (slot, other) = (coupling.slot, coupling.pair.of(own_number).map(|(_, other)| other));
        if let Some(((own, moves), other)) = coupling.own.as_mut().zip(other) {
            let moving = place.layout.axes[slot].moving(&machine.axes[other.axis], *moves);
            *own = std::mem::replace(&mut place.layout.axes[slot], moving);
        }
    }
    limits_changed(&mut channel.state.place);
    hold_followers(channel);
}

/// Treats words of axes that follow other axes as words without commands.
pub fn hold_followers(channel: &mut ChannelContext<'_>) {
    let machine = channel.env.machine;
    let held = slots(&channel.state.others.couplings, Coupling::follows);
    let layout = &mut channel.state.place.layout;
    for (slot, axis) in layout.axes.entries().filter(|(_, axis)| machine.axes[axis.machine].coupling.number.is_some()) {
        let registers = channel.tables.registers_of(axis.data);
        let leased = machine.axes[axis.machine].master.is_some();
        if held & slot.bit() != 0 {
            layout.bounds.foreign |= registers;
            layout.exchanged |= slot.bit();
        } else if !leased {
            layout.bounds.foreign &= !registers;
            layout.exchanged &= !slot.bit();
        }
    }
}

/// Logs the beginning or the end of a coupling, and the axis that it has moved.
pub fn log_coupling(channel: &mut ChannelContext<'_>, pair: &CoupledPair, what: &str, moved: Option<CoupledAxisMove>) {
    let machine = channel.env.machine;
    let (master, slave) = (&machine.axes[pair.master.axis].name, &machine.axes[pair.slave.axis].name);
    let position = &channel.state.place.position;
    let place = moved.map_or_else(String::new, |moved| {
        format!(" {}={}", channel.axis_name(moved.slot), wildcard_text(position.at(moved.slot)))
    });
    // Composite control changes the coordinates of the program; nothing has moved.
    let carried = moved.filter(|_| pair.kind != CouplingKind::Composite).map(|moved| CarriedMove {
        from: Box::new(moved.from),
        to: Box::new(*position),
        axes: format!("{slave} with {master}").into(),
    });
    let text = format!("{}{what} {master} {slave}{place}", pair.kind.name());
    channel.emit(0, Logged::coupling(text, carried));
}

/// Updates the data about all limits after the limits of an axis have changed.
pub fn limits_changed(place: &mut MotionState) {
    let stored = place.stored.as_deref().is_some_and(|area| area.on);
    let layout = &mut place.layout;
    layout.bounds.nearness = TravelBounds::nearness(&layout.axes);
    layout.bounds.limited = layout.axes.iter().any(|axis| axis.limits.is_some()) || stored;
}

/// Whether the program of this channel alone has the code of synchronous control.
pub fn couples_alone(channel: &mut ChannelContext<'_>, flow: &ProgramFlow) -> bool {
    words_of_couplings(channel, flow) == [true, false]
}

/// Whether only programs of other channels have the code.
pub fn hears_of_couplings(channel: &mut ChannelContext<'_>, flow: &ProgramFlow) -> bool {
    let machine = channel.env.machine;
    machine.axes.iter().any(|axis| axis.coupling.number.is_some()) && words_of_couplings(channel, flow) == [false, true]
}

/// Whether the program of this channel, and programs of other channels, have the code.
fn words_of_couplings(channel: &mut ChannelContext<'_>, flow: &ProgramFlow) -> [bool; 2] {
    if let Some(words) = channel.state.others.alone.words {
        return words;
    }
    let Some(main) = flow.frames.first().map(|frame| (frame.file, frame.range)) else { return [false; 2] };
    let env = &channel.env;
    let words = coupling::words(env.machine, (env.info, env.sources), main);
    channel.state.others.alone.words = Some(words);
    words
}

/// Starts the coupling for the axis of this channel.
pub fn begin_coupling(channel: &mut ChannelContext<'_>, pair: CoupledPair, parking: Parking) {
    let Some((own, _)) = pair.of(channel.at.channel) else { return };
    let Some(slot) = channel.state.place.layout.axes.find(|axis| axis.machine == own.axis) else { return };
    let stood = axis_place(channel, slot);
    let slave = own == pair.slave;
    let coupling = Coupling { pair, slot, slave, parking, stood, from: stood, meetings: 0, own: None };
    channel.state.others.couplings.push(coupling);
    hold_followers(channel);
}

/// Ends a coupling that this channel has commanded: a slave is at its master's position of the last barrier.
pub fn end_own(channel: &mut ChannelContext<'_>, pair: &CoupledPair) -> Option<CoupledAxisMove> {
    let sign = pair.sign(channel.env.machine);
    let coupled = channel.state.others.couplings.iter().find(|coupling| coupling.pair == *pair);
    let theirs = coupled.map_or(0.0, |coupling| sign * (axis_place(channel, coupling.slot) - coupling.stood));
    uncouple(channel, pair, theirs)
}
