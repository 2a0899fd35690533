//! Stage *codes*: a canned cycle and a motion code in one block, where only the later one acts.
//!
//! Facts: `[cycles] beside_motion`; docs/emulation.md, "Canned cycles". Invariant: the removed code was written in the
//! block; codes that words trigger are not changed.

use crate::channel::Kernel;
use crate::pipeline::codes;
use counterpoint_channel::channel_context::ChannelContext;
use counterpoint_channel::modal::group;
use counterpoint_fault as diag;
use counterpoint_machine::ident::kind::CodeKind;
use counterpoint_machine::ident::{DataId, data};
use counterpoint_machine::index::RegisterId;

/// Data of cycles that a motion code does not take.
const CYCLE_DATA: [DataId; 7] = [
    data::CYCLE_CLEAR,
    data::CYCLE_BOTTOM,
    data::CYCLE_STEP,
    data::CYCLE_DWELL,
    data::CYCLE_REPEAT,
    data::CYCLE_BORE_JOG_X,
    data::CYCLE_BORE_JOG_Y,
];

impl Kernel<'_> {
    /// Removes the earlier of a cycle and a motion code from the block.
    #[inline(never)]
    pub(crate) fn cycle_or_motion(&mut self) {
        let (Some(cycle), Some(motion)) =
            (last_written(&self.channel, is_cycle), last_written(&self.channel, is_motion))
        else {
            return;
        };
        let Some([cycle_word, motion_word]) = words_at(&self.channel, [cycle, motion]) else { return };
        let (wins, loses, at) =
            if motion > cycle { (motion_word, cycle_word, cycle) } else { (cycle_word, motion_word, motion) };
        if motion > cycle {
            drop_code(&mut self.channel, at);
            self.channel.block.flags.cycle_dropped = true;
        }
        let rest = if motion > cycle { "; the cycle is not executed" } else { "; the cycle is executed" };
        let text = format!("{loses} and then {wins} in '{}'{rest}", self.channel.block_text());
        self.diagnose(&diag::CYCLE_BESIDE_MOTION, text);
    }
}

fn is_cycle(_: u16, kind: CodeKind) -> bool {
    matches!(kind, CodeKind::Cycle(_))
}

fn is_motion(of: u16, _: CodeKind) -> bool {
    of == group::MOTION
}

/// Whether only the removed cycle would have used a word.
pub(crate) fn belongs_to_dropped_cycle(channel: &ChannelContext<'_>, register: RegisterId) -> bool {
    let machine = channel.env.machine;
    let of = |id: DataId| machine.tables.data(id).iter().any(|&row| machine.data[row].register == Some(register));
    channel.block.flags.cycle_dropped && CYCLE_DATA.into_iter().any(of)
}

/// The place of the last word that triggered a code of this kind.
fn last_written(channel: &ChannelContext<'_>, of: fn(u16, CodeKind) -> bool) -> Option<usize> {
    (0..channel.block.words.len()).rev().find(|&at| {
        fired_by(channel, at).is_some_and(|pending| {
            let row = channel.block.pending.get(pending).map(|code| &channel.env.machine.codes[code.row]);
            row.is_some_and(|row| of(row.group, row.id.kind()))
        })
    })
}

fn words_at(channel: &ChannelContext<'_>, places: [usize; 2]) -> Option<[String; 2]> {
    let word = |at: usize| channel.block.words.get(at).map(|&word| codes::word_text(channel.env.machine, word));
    Some([word(places[0])?, word(places[1])?])
}

fn drop_code(channel: &mut ChannelContext<'_>, at: usize) {
    if let Some(pending) = fired_by(channel, at) {
        channel.block.pending.remove(pending);
    }
}

/// The place of the code that the word triggered.
fn fired_by(channel: &ChannelContext<'_>, at: usize) -> Option<usize> {
    let word = channel.block.words.get(at).filter(|word| word.used)?;
    let rows = channel.env.machine.tables.code(word.register, word.value);
    channel.block.pending.iter().position(|code| code.value == word.value && rows.contains(&code.row))
}
