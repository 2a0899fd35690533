//! Straight moves of a generated cycle: words that have been sorted once are not sorted again.
//!
//! *Invariant:* a block is executed here only if the normal stages would have exactly the same effect: a move of one
//! axis at rapid or at the feed of the active mode, or only a feed. All other blocks pass through the normal stages. So
//! do all blocks of a cycle while a macro, a trace, a frame or another active code could make a difference.

use counterpoint_channel::macro_queries::{has_embedded, may_have_remarks};
use counterpoint_channel::modal::{feed_of, group};
use counterpoint_control_api::{CycleWord, MadeWord, WordHost};
use counterpoint_event::event::FeedUnit;
use counterpoint_fault::Halt;
use counterpoint_machine::ident::dimension::Dimension;
use counterpoint_machine::ident::{CodeId, DataId, codes, data};
use counterpoint_machine::index::{AxisSlot, BySlot, CodeRowId, RegisterId};
use counterpoint_machine::macros::model::Hook;
use counterpoint_machine::rows::{CodeRow, Modality};
use counterpoint_program::block::irregular;
use counterpoint_program::data_plan::{DataSource, RECALLED};
use counterpoint_program::key_words::WrittenNumber;

use super::Kernel;
use crate::channel::refusals::is_block_never_refused;

/// Maximum number of kept blocks; cycles have few different blocks.
const MOST: usize = 16;
/// Maximum number of words of such a block.
const MOST_WORDS: usize = 4;
/// The feeds of all modes.
const FEEDS: [DataId; 3] = [data::FEED_UPM, data::FEED_UPR, data::FEED_1T];

/// A word of a block without the value of its data.
#[derive(Debug, Clone, Copy, PartialEq)]
enum WordMark {
    Data(RegisterId),
    Code(RegisterId, f64),
    Text(CodeRowId),
}

/// Words of a block, and their effect if it is a straight move or a feed.
#[derive(Debug)]
struct KnownMove {
    marks: Vec<WordMark>,
    effect: Option<StraightMove>,
}

/// Blocks of cycles by their words.
#[derive(Debug, Default)]
pub(crate) struct KnownMoves(Vec<KnownMove>);

/// The effect of a block.
#[derive(Debug, Clone, Copy, Default)]
struct StraightMove {
    /// Index of the axis word, and its axis.
    axis: Option<(usize, AxisSlot)>,
    /// Index of the feed word.
    feed: Option<usize>,
    rapid: bool,
    /// The motion code that is active afterwards.
    motion: Option<(CodeId, CodeRowId)>,
    /// The block ends compensation of the tool radius.
    uncompensated: bool,
}

/// A value as an action would read it.
#[derive(Debug, Clone, Copy)]
struct DirectValue {
    value: f64,
    /// The row of the value is modal.
    modal: bool,
}

/// Whether words of a cycle can be executed without sorting: no macro, trace or channel state depends on the blocks.
pub(crate) fn may_move(kernel: &Kernel<'_>) -> bool {
    let (env, state) = (&kernel.channel.env, &kernel.channel.state);
    env.trace.is_none()
        && !env.options.lint
        && kernel.plan.actions.record.is_none()
        && state.place.frames.is_none()
        && !state.cycle.running
        && state.modal.refires.is_empty()
        && state.modal.code(group::POSITION) == Some(codes::POSITION_ABSOLUTE)
        && no_macro_sees_blocks(kernel)
}

fn no_macro_sees_blocks(kernel: &Kernel<'_>) -> bool {
    let hooks = [Hook::BlockStartup, Hook::BlockShutdown, Hook::PreprocessorShutdown, Hook::Motion];
    kernel.plan.hooks.is_none()
        || hooks.into_iter().all(|hook| kernel.macros.ready(hook).is_none())
            && kernel.macros.modes.data_codes.is_empty()
            && !has_embedded(&kernel.channel, &kernel.macros, 1)
            && !may_have_remarks(&kernel.channel, &kernel.macros)
}

/// Executes the words of a block if they are a known straight move or feed. Returns false if the block must pass
/// through the normal stages.
pub(crate) fn make(kernel: &mut Kernel<'_>, words: &[CycleWord]) -> Result<bool, Halt> {
    let Some(known) = known_move(kernel, words) else { return Ok(false) };
    let (feed_id, unit) = feed_of(kernel.channel.state.modal.code(group::FEED));
    let value = |at: usize, id: DataId| match words.get(at) {
        Some(CycleWord::Register(word)) => direct_value(kernel, id, word),
        _ => None,
    };
    if known.uncompensated && kernel.channel.state.modal.code(group::DIAMETER) != Some(codes::COMP_DIAM_OFF) {
        return Ok(false);
    }
    let mut feed = None;
    if let Some(at) = known.feed {
        let Some(given) = value(at, feed_id).filter(|_| unit != FeedUnit::InverseTime) else { return Ok(false) };
        feed = Some(given.value);
    }
    let mut level = None;
    if let Some((at, slot)) = known.axis {
        let id = kernel.channel.state.place.layout.axes[slot].data;
        let Some(given) = value(at, id) else { return Ok(false) };
        level = Some((slot, id, given));
    }
    kernel.channel.check_stop()?;
    if let Some((id, row)) = known.motion {
        kernel.channel.state.modal.activate(group::MOTION, id, Some(row));
    }
    if let Some(feed) = feed {
        kernel.channel.state.remembered.remember(feed_id, feed);
    }
    if let Some((slot, id, DirectValue { value, modal })) = level {
        if modal {
            kernel.channel.state.remembered.remember(id, value);
        }
        let mut target = kernel.channel.state.place.position;
        *target.at_mut(slot) = value;
        (kernel.plan.actions.straight.along)(kernel, known.rapid, slot.bit(), &target)?;
    }
    Ok(true)
}

/// The effect of a block, determined once for words with the same registers and codes.
fn known_move(kernel: &mut Kernel<'_>, words: &[CycleWord]) -> Option<StraightMove> {
    let only_data = kernel.channel.tables.registers.only_data;
    let mark = |word: &CycleWord| match *word {
        CycleWord::Text(row) => WordMark::Text(row),
        CycleWord::Register(word) if only_data & word.register.bit() != 0 => WordMark::Data(word.register),
        CycleWord::Register(word) => WordMark::Code(word.register, word.value),
    };
    let is_increment = |word: &CycleWord| matches!(word, CycleWord::Register(word) if word.incremental);
    if words.len() > MOST_WORDS || words.iter().any(is_increment) {
        return None;
    }
    let same = |known: &&KnownMove| {
        known.marks.len() == words.len() && known.marks.iter().zip(words).all(|(known, word)| *known == mark(word))
    };
    if let Some(known) = kernel.dialect.cycle_moves.0.iter().find(same) {
        return known.effect;
    }
    let marks: Vec<WordMark> = words.iter().map(mark).collect();
    let effect = effect_of(kernel, &marks, words);
    if kernel.dialect.cycle_moves.0.len() < MOST {
        kernel.dialect.cycle_moves.0.push(KnownMove { marks, effect });
    }
    effect
}

/// Determines the effect of words; none unless they can only be a straight move of one axis or a feed.
fn effect_of(kernel: &mut Kernel<'_>, marks: &[WordMark], words: &[CycleWord]) -> Option<StraightMove> {
    let machine = kernel.channel.env.machine;
    let mut effect = StraightMove::default();
    let mut motions: Vec<(u16, CodeRowId)> = Vec::new();
    for (at, mark) in marks.iter().enumerate() {
        match *mark {
            WordMark::Data(register) => mark_data(kernel, &mut effect, (at, register))?,
            WordMark::Text(row) => mark_code(kernel, &mut effect, &mut motions, row)?,
            WordMark::Code(register, value) => {
                mark_code(kernel, &mut effect, &mut motions, *machine.tables.code(register, value).first()?)?;
            }
        }
    }
    motions.sort_by_key(|(order, _)| *order);
    let row = |&(_, row): &(u16, CodeRowId)| &machine.codes[row];
    let non_modal = |row: &CodeRow| row.modality == Modality::NonModal;
    match motions.as_slice() {
        [] => {
            let alone = effect.axis.is_none() && !effect.uncompensated && marks.len() == 1;
            return effect.feed.filter(|_| alone).map(|_| effect);
        }
        [one] if !non_modal(row(one)) => {
            effect.rapid = row(one).id == codes::RAPID;
            effect.motion = Some((row(one).id, one.1));
        }
        // The first code moves; the second code finds no position and stays active.
        [first, then] if first.0 < then.0 && non_modal(row(first)) && !non_modal(row(then)) => {
            let rapid_first = row(first).id == codes::RAPID && row(then).id == codes::INTERP_LINEAR;
            (effect.rapid, effect.motion) = (true, Some((row(then).id, then.1)).filter(|_| rapid_first));
            effect.motion?;
        }
        _ => return None,
    }
    let is_move = effect.axis.is_some() && !(effect.rapid && effect.feed.is_some());
    (is_move && is_never_refused(kernel, words)).then_some(effect)
}

/// Adds a word of data: the position of a linear axis, or a feed.
fn mark_data(kernel: &Kernel<'_>, effect: &mut StraightMove, (at, register): (usize, RegisterId)) -> Option<()> {
    let (machine, tables) = (kernel.channel.env.machine, kernel.channel.tables);
    let no_macro = |id: DataId| machine.macros.as_deref().is_none_or(|macros| macros.of_data(id).is_empty());
    if (tables.registers.before_codes | tables.registers.length) & register.bit() != 0 {
        return None;
    }
    let mut rows = machine.tables.data_of(register).iter().map(|&row| &machine.data[row]);
    if rows.all(|row| FEEDS.contains(&row.id) && row.modal && row.process && no_macro(row.id)) {
        return effect.feed.replace(at).is_none().then_some(());
    }
    let axes = &kernel.channel.state.place.layout.axes;
    let of = |id: DataId| tables.registers_of(id);
    let (slot, axis) = axes.entries().find(|(_, axis)| of(axis.data) & register.bit() != 0)?;
    let taken_before = FEEDS.into_iter().chain([data::RAPID_FEED]).fold(0, |bits, id| bits | of(id));
    let others = axes.iter().filter(|other| other.data != axis.data).fold(0, |bits, other| bits | of(other.data));
    let recalled = (taken_before | others | of(axis.data)) & RECALLED != 0;
    let plain = !axis.rotary && !recalled && (taken_before | others) & register.bit() == 0;
    let mut ids = axes.iter().map(|axis| axis.data).chain([data::RAPID_FEED]);
    (plain && ids.all(no_macro) && effect.axis.replace((at, slot)).is_none()).then_some(())
}

/// Adds a code: a straight move, or a code that is already active and does nothing.
fn mark_code(
    kernel: &Kernel<'_>,
    effect: &mut StraightMove,
    motions: &mut Vec<(u16, CodeRowId)>,
    at: CodeRowId,
) -> Option<()> {
    let machine = kernel.channel.env.machine;
    let row = &machine.codes[at];
    let no_macro = machine.macros.as_deref().is_none_or(|macros| macros.of_code(row.id).is_empty());
    let conditions = row.with.is_empty() && row.without.is_empty();
    if !(row.process && conditions && no_macro) || row.seconds != 0.0 || row.special || row.owns_axes {
        return None;
    }
    match row.id {
        codes::RAPID | codes::INTERP_LINEAR if row.group == group::MOTION => motions.push((row.order, at)),
        codes::POSITION_ABSOLUTE if row.group == group::POSITION => {}
        codes::COMP_DIAM_OFF if row.group == group::DIAMETER => effect.uncompensated = true,
        _ => return None,
    }
    Some(())
}

/// Whether no rule of the machine can refuse the words.
fn is_never_refused(kernel: &mut Kernel<'_>, words: &[CycleWord]) -> bool {
    kernel.channel.block.clear();
    for word in words {
        match *word {
            CycleWord::Register(word) => kernel.push(word),
            CycleWord::Text(row) => kernel.push_text(row),
        }
    }
    kernel.categorise();
    let never = is_block_never_refused(&kernel.channel);
    kernel.channel.block.clear();
    never
}

/// The value of a word as an action would read it; none if this takes more than a factor.
fn direct_value(kernel: &Kernel<'_>, id: DataId, word: &MadeWord) -> Option<DirectValue> {
    let [source] = kernel.channel.tables.sources_of(id) else { return None };
    let DataSource { register, mul, add, min, max, dimension, modal, .. } = *source;
    let plain = register == word.register && source.one.is_none() && !source.diameter_x;
    if !plain || dimension == Dimension::Increments || word.value < min || word.value > max {
        return None;
    }
    let number = WrittenNumber { value: word.value, point: true, digits: 0, fraction: 0 };
    let (_, bits) = kernel.channel.tables.scanner.reading(register, number, kernel.channel.state.secondary);
    if bits & !irregular::POINT != 0 {
        return None;
    }
    let value = (word.value * mul + add) * kernel.channel.unit_factor(dimension);
    Some(DirectValue { value, modal })
}
