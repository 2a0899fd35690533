//! Words of a block that the machine does not know.
//!
//! *Invariant:* nothing here reports; messages are made from these answers.

use counterpoint_machine::ident::codes;
use counterpoint_machine::index::RegisterId;

use crate::channel_context::ChannelContext;
use crate::queued_codes::group_queued;

/// Treats a program name: at the start of its block it defines the program; elsewhere it is unknown text.
pub fn left_name(channel: &mut ChannelContext<'_>) {
    let Some((start, _)) = channel.block.name() else { return };
    let line = channel.text_bytes();
    let before = line.get(..start as usize).unwrap_or_default();
    if before.iter().all(|byte| matches!(byte, b' ' | b'\t' | b'/')) {
        channel.block.take_name();
    }
}

/// Whether one of the channel's axes takes words of this register.
pub fn channel_has(channel: &ChannelContext<'_>, register: RegisterId) -> bool {
    channel.state.place.layout.axes.iter().any(|axis| {
        channel
            .env
            .machine
            .tables
            .data(axis.data)
            .iter()
            .map(|&row| &channel.env.machine.data[row])
            .any(|row| row.register == Some(register))
    })
}

/// Most characters of unknown text in a message.
const MOST: usize = 60;

/// The unrecognised parts of the block, in their order.
pub fn unknown_parts(channel: &mut ChannelContext<'_>) -> Vec<String> {
    left_name(channel);
    let name = channel.block.name().filter(|_| calls_by_name(channel));
    let line = channel.text_bytes();
    let spans = channel.block.unrecognised.iter().filter(|span| Some(**span) != name);
    let text = |&(start, end): &(u32, u32)| {
        let bytes = line.get(start as usize..end as usize).unwrap_or_default();
        String::from_utf8_lossy(bytes).trim().to_owned()
    };
    spans.map(text).collect()
}

/// Whether this is a word of a letter with which codes are written.
pub fn is_code_word(channel: &ChannelContext<'_>, text: &str) -> bool {
    let letter = text.bytes().next().and_then(|letter| channel.tables.scanner.register(letter));
    let codes = letter.is_some_and(|(register, _)| channel.env.machine.tables.has_codes(register));
    codes && text.get(1..).is_some_and(|rest| rest.trim_start().starts_with(|c: char| c.is_ascii_digit()))
}

/// The words of which a code needs one, if the machine has the code only with another word.
pub fn words_needed(channel: &ChannelContext<'_>, text: &str) -> Option<String> {
    let machine = channel.env.machine;
    let (register, _) = channel.tables.scanner.register(*text.as_bytes().first()?)?;
    let value = text.get(1..)?.trim().parse().ok()?;
    let rows = machine.tables.code(register, value).iter().map(|&row| &machine.codes[row]);
    let mut names: Vec<&str> = rows.flat_map(|row| &row.with).map(|&of| &*machine.registers[of].name).collect();
    names.sort_unstable();
    names.dedup();
    match names.split_last()? {
        (last, []) => Some((*last).to_owned()),
        (last, others) => Some(format!("{} or {last}", others.join(", "))),
    }
}

/// Whether the text is an address without a number.
pub fn is_letter(channel: &ChannelContext<'_>, text: &str) -> bool {
    match text.as_bytes() {
        [letter] => channel.tables.scanner.register(*letter).is_some(),
        _ => false,
    }
}

/// Whether a motion code is written in the block.
pub fn moves_by_itself(channel: &ChannelContext<'_>) -> bool {
    group_queued(channel, crate::modal::group::MOTION)
}

/// Text for a message, without its end if it is long.
pub fn shortened(text: &str) -> String {
    if text.chars().count() <= MOST {
        return text.to_owned();
    }
    text.chars().take(MOST - 3).chain("...".chars()).collect()
}

/// Whether a code of the block takes a program name.
fn calls_by_name(channel: &ChannelContext<'_>) -> bool {
    let mut rows = channel.block.pending.iter().map(|pending| &channel.env.machine.codes[pending.row]);
    rows.any(|row| row.id == codes::CALSUB_ID)
}

/// A letter and a number.
pub fn is_word_like(text: &str) -> bool {
    let rest = text.strip_prefix(|c: char| c.is_ascii_alphabetic()).map(str::trim_start);
    rest.is_some_and(|rest| rest.starts_with(|c: char| c.is_ascii_digit() || matches!(c, '.' | '-' | '+')))
}
