//! Speed words that no code of their block takes.
//!
//! Facts: reference control-emulator.md 3.3, shop-machines.md 2 (the speed belongs to the spindle of the M function in
//! its block). *Invariant:* a speed or a limit beside a function that may turn another spindle never reaches the active
//! spindle. Words that name their spindle, such as S1=, are exempt.

use counterpoint_channel::channel_context::ChannelContext;
use counterpoint_channel::macro_queries::matching_code_macro;
use counterpoint_channel::modal::group;
use counterpoint_fault as diag;
use counterpoint_fault::Acted;
use counterpoint_machine::ident::codes;
use counterpoint_machine::ident::kind::CodeKind;
use counterpoint_machine::number::written;
use counterpoint_machine::rows::{CodeForm, CodeRow};
use counterpoint_program::block::Word;

use crate::channel::Kernel;
use crate::channel::unknown_codes::machine_text;

/// Puts a speed that no code of the block takes before the move of the block.
///
/// # Errors
/// The alarm of a speed that may belong to another spindle.
#[cold]
pub(super) fn speed_before_codes(kernel: &mut Kernel<'_>) -> Acted {
    let (mut moves, mut modes, mut limits, mut function) = (false, false, false, None);
    for pending in &kernel.channel.block.pending {
        let row = &kernel.channel.env.machine.codes[pending.row];
        let takes = matches!(row.id.kind(), CodeKind::Spindle { .. }) || row.id == codes::DELAY_REV;
        if takes
            || kernel.plan.hooks.is_some() && matching_code_macro(&kernel.channel, &kernel.macros, row.id).is_some()
        {
            return Ok(());
        }
        limits |= row.id == codes::SPINDLE_MAXRPM;
        modes |= matches!(row.id, codes::SPINDLE_CSS | codes::SPINDLE_RPM);
        moves |= matches!(row.group, group::MOTION | group::CYCLE);
        function = function.or_else(|| function_without_effect(&kernel.channel, row).then_some(*pending));
    }
    if let Some(pending) = function.filter(|_| kernel.channel.env.machine.habits.guards_speed)
        && let Some(word) = plain_speed(kernel)
    {
        return refuse_speed(kernel, pending.value, word);
    }
    // G96, G97 and a limit take the speed themselves.
    if !moves || modes || limits {
        return Ok(());
    }
    (kernel.plan.actions.speed_word)(kernel)
}

/// The alarm of a speed beside a function without effect.
fn refuse_speed(kernel: &mut Kernel<'_>, function: f64, word: Word) -> Acted {
    let Some(register) = kernel.channel.tables.registers.function else { return Ok(()) };
    let machine = kernel.channel.env.machine;
    let function = format!("M{}", written(function, &machine.registers[register].format));
    let word = kernel.channel.span_text((word.start, word.end)).to_owned();
    let text = format!(
        "{word} beside {function} in '{}': {function} has no effect on {} and may turn another spindle, so \
         no spindle takes the speed; make {function} a spindle code of the machine, or give its row \
         `turns_no_spindle = true`",
        kernel.channel.block_text(),
        machine_text(&kernel.channel, &kernel.components)
    );
    Err(kernel.alarm(&diag::SPEED_OF_FUNCTION, text))
}

/// Whether the row is an M function that has no effect and may turn a spindle of the real machine.
fn function_without_effect(channel: &ChannelContext<'_>, row: &CodeRow) -> bool {
    let (CodeForm::Register { register, .. } | CodeForm::RegisterAsData { register, .. }) = row.form else {
        return false;
    };
    let idle = !row.process || row.id == codes::FUNCTION;
    idle && !row.turns_no_spindle && Some(register) == channel.tables.registers.function
}

/// The first speed of the block that names no spindle.
fn plain_speed(kernel: &Kernel<'_>) -> Option<Word> {
    let (speeds, machine) = (kernel.channel.tables.registers.speed, kernel.channel.env.machine);
    let plain = |word: &&Word| speeds & word.register.bit() != 0 && machine.registers[word.register].is_regular();
    kernel.channel.block.words.iter().filter(|word| !word.used).find(plain).copied()
}
