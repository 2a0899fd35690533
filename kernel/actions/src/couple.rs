//! Codes that couple an axis of one channel with an axis of another one (Fanuc G51.4 to G51.6, G50.4 to G50.6).
//!
//! Both channels have the code in their programs, or one of them alone has that of synchronous control. *Invariant:* a
//! refusal comes before the channel waits.

use crate::context::ActionContext;
use crate::entry::ActionEntry;
use counterpoint_channel::coupling::{Coupling, Parking};
use counterpoint_event::event::Kind as Logged;
use counterpoint_fault as diag;
use counterpoint_fault::{Acted, Halt};
use counterpoint_machine::ident::{DataId, codes, data};
use counterpoint_machine::model::SyncDialect;
use counterpoint_waits::coupling::{self, CoupledAxis, CoupledPair, CouplingKind};

/// Codes with their actions.
pub(crate) const ENTRIES: &[ActionEntry] = &[
    ActionEntry::of(&[codes::COUPLE_SYNCHRONOUS], |act, _, _| on(act, CouplingKind::Synchronous)),
    ActionEntry::of(&[codes::COUPLE_SYNCHRONOUS_OFF], |act, _, _| off(act, CouplingKind::Synchronous)),
    ActionEntry::of(&[codes::COUPLE_COMPOSITE], |act, _, _| on(act, CouplingKind::Composite)),
    ActionEntry::of(&[codes::COUPLE_COMPOSITE_OFF], |act, _, _| off(act, CouplingKind::Composite)),
    ActionEntry::of(&[codes::COUPLE_SUPERIMPOSED], |act, _, _| on(act, CouplingKind::Superimposed)),
    ActionEntry::of(&[codes::COUPLE_SUPERIMPOSED_OFF], |act, _, _| off(act, CouplingKind::Superimposed)),
];

/// Begins: both channels meet, then the axes are coupled.
fn on(act: &mut ActionContext<'_, '_>, kind: CouplingKind) -> Acted {
    let named = (number(act, data::COUPLE_MASTER), number(act, data::COUPLE_SLAVE));
    let parking =
        if kind == CouplingKind::Synchronous { number(act, data::COUPLE_PARKING).unwrap_or(0.0) } else { 0.0 };
    let machine = act.channel().env.machine;
    let pair = coupling::end(machine, 'P', named.0)
        .and_then(|master| Ok((master, coupling::end(machine, 'Q', named.1)?)))
        .and_then(|(master, slave)| coupling::pair(machine, kind, master, slave))
        .map_err(|reason| illegal(act, &reason))?;
    let Some(parking) = Parking::of(parking) else {
        return Err(illegal(act, &format!("L{parking} is not 0, 1 or 2")));
    };
    if pair.of(act.channel().at.channel).is_none() {
        let (one, two) = (pair.master.channel, pair.slave.channel);
        return Err(illegal(act, &format!("the code belongs in the programs of channels {one} and {two}")));
    }
    if is_off(act) {
        act.channel_mut().emit(0, Logged::mode("sync passed without waiting"));
        return Ok(());
    }
    check_free(act, &pair)?;
    if kind == CouplingKind::Synchronous && act.couples_alone() {
        return act.couple_alone(pair, parking);
    }
    act.couple(pair, parking)
}

/// Ends: both channels meet. Nothing happens where the axes are not coupled.
fn off(act: &mut ActionContext<'_, '_>, kind: CouplingKind) -> Acted {
    let by_pair = kind == CouplingKind::Composite;
    let master = if by_pair { Some(number(act, data::COUPLE_MASTER)) } else { None };
    let slave = number(act, data::COUPLE_SLAVE);
    let machine = act.channel().env.machine;
    let slave = coupling::end(machine, 'Q', slave).map_err(|reason| illegal(act, &reason))?;
    let master = master.map(|number| coupling::end(machine, 'P', number)).transpose();
    let master = master.map_err(|reason| illegal(act, &reason))?;
    let is = |coupling: &&Coupling| {
        let pair = coupling.pair;
        pair.kind == kind && pair.slave == slave && master.is_none_or(|master| pair.master == master)
    };
    match act.channel().state.others.couplings.iter().find(is).map(|coupling| coupling.pair) {
        Some(pair) if kind == CouplingKind::Synchronous && act.couples_alone() => act.end_alone(pair),
        Some(pair) => act.end_coupling(pair),
        None => Ok(()),
    }
}

/// Value of a word as the program writes it.
fn number(act: &mut ActionContext<'_, '_>, id: DataId) -> Option<f64> {
    act.take(id).map(|datum| datum.raw)
}

/// Whether the channel runs alone, or the machine has no channels that meet.
fn is_off(act: &ActionContext<'_, '_>) -> bool {
    act.channel().env.machine.sync.dialect == SyncDialect::None
        || act.channel().env.options.ignore_waits.contains(&act.channel().at.channel)
}

/// A slave has one master and is none itself, and an axis in composite control has no other part.
fn check_free(act: &mut ActionContext<'_, '_>, pair: &CoupledPair) -> Acted {
    let again = |other: &CoupledPair| other == pair && pair.kind == CouplingKind::Synchronous;
    let both_lead = |other: &CoupledPair| {
        other.kind == pair.kind
            && pair.kind != CouplingKind::Composite
            && other.master == pair.master
            && other.slave != pair.slave
    };
    let shares = |other: &CoupledPair, end: CoupledAxis| other.master == end || other.slave == end;
    let clash = |coupling: &&Coupling| {
        let other = &coupling.pair;
        !again(other) && !both_lead(other) && (shares(other, pair.master) || shares(other, pair.slave))
    };
    let Some(other) = act.channel().state.others.couplings.iter().find(clash).map(|coupling| coupling.pair) else {
        return Ok(());
    };
    let machine = act.channel().env.machine;
    let (master, slave) = (&machine.axes[other.master.axis].name, &machine.axes[other.slave.axis].name);
    let text = format!(
        "{} axes {master} and {slave} are in {} control already, in '{}'",
        pair.kind.taken(),
        other.kind.name(),
        act.channel().block_text()
    );
    Err(act.alarm(&diag::COUPLING_ILLEGAL, text))
}

fn illegal(act: &mut ActionContext<'_, '_>, reason: &str) -> Halt {
    let text = format!("PS5339 {reason}, in '{}'", act.channel().block_text());
    act.alarm(&diag::COUPLING_ILLEGAL, text)
}
