//! Balance cutting of Fanuc: two channels begin their cuts together.
//!
//! Facts: reference channel-synchronisation.md 1.3. Decisions: the code that switches it on is a wait of both channels,
//! so is the first cut of each block, and so is the code that switches it off; those never are alarm PS0160.
//! *Invariant:* two channels take part.

use counterpoint_event::event::Primitive;
use counterpoint_machine::ident::codes;
use counterpoint_machine::model::Machine;
use counterpoint_sync::wait::{ChannelSet, MarkSpace, RuleId, Wait, WaitMark, WaitRule};

use super::{WaitArguments, all, channels};

/// The common wait of the channels of balance cutting.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BalanceStage {
    /// The code that switches it on.
    On,
    /// The first cut of a block.
    Cut,
    /// The code that switches it off.
    Off,
}

/// The rules of the stages, in their order.
pub(super) fn rules(machine: &Machine) -> impl Iterator<Item = WaitRule> {
    let word = |id| super::word(machine, id).unwrap_or_else(|| "BALANCE".to_owned());
    let (on, off) = (word(codes::BALANCE_ON), word(codes::BALANCE_OFF));
    let words = [on.clone(), format!("{on} cut"), off];
    words.into_iter().map(|word| WaitRule { word: word.into(), numbered: false, acts: true, ..WaitRule::plain("") })
}

/// The wait of a channel and its partner.
///
/// # Errors
/// Why the list of channels is not possible.
pub fn wait(machine: &Machine, said: WaitArguments) -> Result<Wait, String> {
    let everybody = all(machine);
    let named = said.list.map(|list| channels::named(list, machine.sync.paths, everybody)).transpose()?;
    let parts = match named {
        Some(named) => named.with(said.channel),
        // The first two paths (B-63944EN-1/02).
        None => everybody.iter().take(2).collect(),
    };
    if !parts.has(said.channel) {
        return Err(format!("channel {} does not take part: name the channels with P", said.channel));
    }
    if parts.count() != 2 {
        return Err(format!("two channels cut in balance, not {}", parts.count()));
    }
    Ok(stage(parts, BalanceStage::On))
}

/// Another stage of the channels of a wait.
pub fn at(wait: &Wait, to: BalanceStage) -> Wait {
    stage(wait.parts, to)
}

fn stage(parts: ChannelSet, stage: BalanceStage) -> Wait {
    let number = stage as u32;
    let key = WaitMark { space: MarkSpace::Balance, number };
    Wait { primitive: Primitive::Barrier, key, named: None, parts, need: 0, rule: RuleId::Balance(number as u16) }
}
