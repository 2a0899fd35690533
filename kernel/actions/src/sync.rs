//! Codes at which channels wait for each other, or let each other continue.
//!
//! Facts: reference channel-synchronisation.md 1.0, 1.3. The meaning of a word is data of the machine: see `waits`.

use crate::context::ActionContext;
use crate::entry::ActionEntry;
use counterpoint_event::event::Kind;
use counterpoint_fault as diag;
use counterpoint_fault::Acted;
use counterpoint_machine::ident::DataId;
use counterpoint_machine::ident::codes;
use counterpoint_machine::ident::data;
use counterpoint_machine::model::SyncDialect;
use counterpoint_machine::rows::CodeRow;
use counterpoint_waits::balance::{self, BalanceStage};
use counterpoint_waits::{self as waits, Meaning, WaitArguments};

/// Codes with their actions.
pub(crate) const ENTRIES: &[ActionEntry] = &[
    ActionEntry::of(&[codes::SYNC_REG], |act, row, _| by_row(act, row)),
    ActionEntry::of(&[codes::SYNC_REG_MAIN], |act, _, _| by_heads(act, data::SYNC_MAIN, 'S')),
    ActionEntry::of(&[codes::SYNC_REG_SIDE], |act, _, _| by_heads(act, data::SYNC_SIDE, 'S')),
    // The first line of a stretch that both heads cut together, and its last.
    ActionEntry::of(&[codes::SYNC_REG_START], |act, _, _| by_heads(act, data::SYNC_START, 'B')),
    ActionEntry::of(&[codes::SYNC_REG_STOP], |act, _, _| by_heads(act, data::SYNC_STOP, 'E')),
    // Two channels begin their cuts together.
    ActionEntry::of(&[codes::BALANCE_ON], |act, _, _| balance(act, true)),
    ActionEntry::of(&[codes::BALANCE_OFF], |act, _, _| balance(act, false)),
    ActionEntry::of(&[codes::SYNC_START_MAIN], |act, _, _| start(act, 1)),
    ActionEntry::of(&[codes::SYNC_START_SIDE], |act, _, _| start(act, 2)),
];

/// A mark of the main and the side head: both wait for equal numbers, for any words.
fn by_heads(act: &mut ActionContext<'_, '_>, id: DataId, letter: char) -> Acted {
    let number = act.take(id).map_or(0.0, |d| d.value) as u32;
    let heads = waits::heads(act.channel().env.machine);
    let off = act.channel().env.machine.sync.dialect == SyncDialect::None || ignores_waits(act);
    if off || !heads.has(act.channel().at.channel) || act.channel().env.machine.channels.len() < 2 {
        return pass(act);
    }
    act.wait_for(waits::head_mark(letter, number, heads))
}

/// Whether the job says that the channel never waits.
fn ignores_waits(act: &ActionContext<'_, '_>) -> bool {
    act.channel().env.options.ignore_waits.contains(&act.channel().at.channel)
}

fn pass(act: &mut ActionContext<'_, '_>) -> Acted {
    act.channel_mut().emit(0, Kind::mode("sync passed without waiting"));
    Ok(())
}

/// A word or text whose meaning is a row of the machine.
fn by_row(act: &mut ActionContext<'_, '_>, row: &CodeRow) -> Acted {
    let number = act.take(data::SYNC).map_or(0.0, |d| d.value) as u32;
    let list = act.take(data::SYNC_PATHS).map(|d| d.raw);
    if act.channel().at.channel == 0 || !waits::is_on(act.channel().env.machine, row) {
        return pass(act);
    }
    let said = WaitArguments { channel: act.channel().at.channel, number, list };
    let line_up = act.channel().block.line_up.and_then(|word| {
        let job = (act.channel().env.info, act.channel().env.sources);
        waits::of_systems(act.channel().env.machine, job, row, (act.channel().at.channel, word))
    });
    match line_up.unwrap_or_else(|| waits::meaning(act.channel().env.machine, row, said)) {
        Ok(Meaning::Act(deed, shown)) => act.let_continue(deed, shown),
        _ if ignores_waits(act) => pass(act),
        Ok(Meaning::Wait(wait)) if waits::is_for_nobody(&wait, act.channel().at.channel) => pass(act),
        Ok(Meaning::Wait(wait)) => act.wait_for(wait),
        Err(reason) => {
            let text = format!("{reason} in '{}'", act.channel().block_text());
            Err(act.alarm(&diag::WAIT_ILLEGAL, text))
        }
    }
}

/// Balance cutting on or off. Both channels wait at the code; between the codes each block waits before its first cut.
fn balance(act: &mut ActionContext<'_, '_>, on: bool) -> Acted {
    let list = act.take(data::SYNC_PATHS).map(|d| d.raw);
    let active = act.channel_mut().state.others.balance.take();
    let off = act.channel().env.machine.sync.dialect == SyncDialect::None || act.channel().at.channel == 0;
    if off || ignores_waits(act) || (!on && active.is_none()) {
        return if on { pass(act) } else { Ok(()) };
    }
    let wait = match active.filter(|_| !on) {
        Some(wait) => balance::at(&wait, BalanceStage::Off),
        None => {
            match balance::wait(
                act.channel().env.machine,
                WaitArguments { channel: act.channel().at.channel, number: 0, list },
            ) {
                Ok(wait) => wait,
                Err(reason) => {
                    let text = format!("PS0163 {reason} in '{}'", act.channel().block_text());
                    return Err(act.alarm(&diag::BALANCE_ILLEGAL, text));
                }
            }
        }
    };
    act.wait_for(wait)?;
    act.channel_mut().state.others.balance = on.then(|| balance::at(&wait, BalanceStage::Cut));
    Ok(())
}

/// A start by one of the heads: the head that the code names lets the other head continue, which waits for it.
fn start(act: &mut ActionContext<'_, '_>, by: u16) -> Acted {
    let heads = waits::heads(act.channel().env.machine);
    // The code names a head by its place: the first or the second channel.
    let by = heads.iter().nth(usize::from(by).saturating_sub(1)).unwrap_or(by);
    let off = act.channel().env.machine.sync.dialect == SyncDialect::None;
    let gives = act.channel().at.channel == by && !off;
    if !heads.has(act.channel().at.channel)
        || act.channel().env.machine.channels.len() < 2
        || !gives && (off || ignores_waits(act))
    {
        return pass(act);
    }
    let (deed, wait) = waits::start(by, heads);
    if gives { act.let_continue(deed, wait) } else { act.wait_for(wait) }
}
