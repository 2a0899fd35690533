//! Axis words that belong to a code of their block: words that the code does not take are reported, and no motion code
//! gets them.
//!
//! *Invariant:* after a code that owns the axis words of its block, the block has no word of an axis of the channel.

use counterpoint_fault as diag;
use counterpoint_machine::number::written;
use counterpoint_machine::rows::{CodeForm, CodeRow};
use counterpoint_program::block::{PendingCode, Word};

use crate::channel::Kernel;

/// Takes the axis words off the block that the code `row` has left there, and reports them.
#[cold]
#[inline(never)]
pub(super) fn refuse_axis_words(kernel: &mut Kernel<'_>, row: &CodeRow, pending: PendingCode) {
    let ignored = row.ignores.iter().fold(0, |bits, register| bits | register.bit());
    take_axis_words(kernel, |kernel, word| {
        if ignored & word.register.bit() != 0 {
            return;
        }
        let code = match &row.form {
            CodeForm::Text(text) => text.clone(),
            CodeForm::Register { register, .. } | CodeForm::RegisterAsData { register, .. } => {
                let register = &kernel.channel.env.machine.registers[*register];
                format!("{}{}", register.before, written(pending.value, &register.format))
            }
            CodeForm::NotApplicable => kernel.channel.env.machine.code_name(row.id).to_lowercase(),
        };
        let word = kernel.channel.span_text((word.start, word.end));
        let text = format!(
            "{code} does not take {word} in '{}'; the word is ignored and moves nothing",
            kernel.channel.block_text()
        );
        kernel.diagnose(&diag::AXIS_WORD_OWNED, text);
    });
}

/// Takes all words of axes of the channel off the block.
#[cold]
pub(super) fn take_axis_words(kernel: &mut Kernel<'_>, mut taken: impl FnMut(&mut Kernel<'_>, Word)) {
    let axes = kernel.channel.state.place.layout.axes.iter();
    let registers = axes.fold(0, |bits, axis| bits | kernel.channel.tables.registers_of(axis.data));
    if !kernel.channel.block.has_any(registers) {
        return;
    }
    for position in 0..kernel.channel.block.words.len() {
        let word = kernel.channel.block.words.get(position).filter(|word| registers & word.register.bit() != 0);
        let register = word.map(|word| word.register);
        if let Some(word) = register.and_then(|register| kernel.channel.block.take(register)) {
            taken(kernel, word);
        }
    }
}
