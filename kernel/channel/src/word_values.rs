//! Values of the words of a block: their numbers, the factors of their rows, and the remembered values.
//!
//! Facts: reference control-emulator.md 1.3, 4.3. *Invariant:* reading takes no word off the block.

use counterpoint_event::info::MachineUnit;
use counterpoint_machine::Machine;
use counterpoint_machine::ident::DataId;
use counterpoint_machine::ident::dimension::Dimension;
use counterpoint_machine::index::AxisSlot;
use counterpoint_machine::rows::DecimalPointRule;
use counterpoint_program::block::{RetrievedValue, Word};
use counterpoint_program::data_plan::DataSource;

use crate::channel_context::{ChannelContext, Handed};

/// Whether a value of `id` is in the block.
pub fn block_has(channel: &ChannelContext<'_>, id: DataId) -> bool {
    let registers = channel.tables.data.registers_of[id];
    channel.block.has_any(registers) || channel.block.added.iter().any(|(other, _)| *other == id)
}

/// Length of a word that counts least increments.
#[cold]
pub fn counted(channel: &ChannelContext<'_>, source: &DataSource, word: &Word, raw: f64) -> f64 {
    let (value, dimension) = scaled_number(channel, source, word, raw);
    value * channel.unit_factor(dimension)
}

/// Number of a word for a row that does not count the last digit of its register.
#[cold]
fn plain_number(channel: &ChannelContext<'_>, source: &DataSource, word: &Word) -> f64 {
    let register = &channel.env.machine.registers[word.register];
    let format = if channel.state.secondary { register.secondary } else { register.format };
    let text = channel.word_bytes(word);
    let number = text.get(register.before.len()..).unwrap_or_default().trim_ascii_start();
    let number = number.strip_prefix(b"=").unwrap_or(number).trim_ascii_start();
    let number = number.strip_prefix(b"-").or(number.strip_prefix(b"+")).unwrap_or(number).trim_ascii();
    // An expression has a value, not digits.
    if number.is_empty() || !number.iter().all(u8::is_ascii_digit) {
        return word.value;
    }
    let written = match format.point {
        DecimalPointRule::Omit => (word.value * 10_f64.powi(i32::from(format.frac))).round(),
        _ => word.value,
    };
    let [primary, secondary] = source.one.unwrap_or([1.0; 2]);
    written * if channel.state.secondary { secondary } else { primary }
}

/// Reads the numbers of the block again in the formats of the current units; values of expressions do not change.
#[cold]
pub fn read_words_again(channel: &mut ChannelContext<'_>) {
    let tables = channel.tables;
    let secondary = channel.state.secondary;
    for at in 0..channel.block.words.len() {
        let Some(&word) = channel.block.words.get(at).filter(|word| !word.made) else { continue };
        let before = channel.env.machine.registers[word.register].before.len();
        let value = {
            let line = channel.text_bytes();
            let text = line.get(word.start as usize..word.end as usize).and_then(|text| text.get(before..));
            let number = text.map(|text| text.trim_ascii_start()).map(|text| text.strip_prefix(b"=").unwrap_or(text));
            number.and_then(|text| tables.scanner.read_again(word.register, text, secondary))
        };
        if let (Some(value), Some(word)) = (value, channel.block.words.get_mut(at)) {
            word.value = value;
        }
    }
}

/// Number of a word, before the factor of a row.
pub fn word_number(channel: &ChannelContext<'_>, source: &DataSource, word: &Word) -> f64 {
    if source.one.is_some() { plain_number(channel, source, word) } else { word.value }
}

/// Value of a number of a word with the factor of its row, in the unit of the program, and its dimension.
pub fn scaled_number(channel: &ChannelContext<'_>, source: &DataSource, word: &Word, raw: f64) -> (f64, Dimension) {
    let (increments, dimension) = match source.dimension {
        Dimension::Increments => increments_of(channel, word),
        other => (1.0, other),
    };
    (raw * increments * source.mul + source.add, dimension)
}

/// Number of increments of one unit of a word, and the dimension of the word: with a decimal point it is a length
/// (reference turning-cycles.md 1).
#[cold]
fn increments_of(channel: &ChannelContext<'_>, word: &Word) -> (f64, Dimension) {
    let pointed = channel.word_bytes(word).contains(&b'.');
    match (pointed, channel.env.machine.unit) {
        (false, _) => (1.0, Dimension::Increments),
        (true, MachineUnit::Mm) => (1000.0, Dimension::Length),
        (true, MachineUnit::Inch) => (10_000.0, Dimension::Length),
    }
}

/// The last value of modal data (reference control-emulator.md 1.3).
#[cold]
pub fn recall(channel: &ChannelContext<'_>, id: DataId) -> Option<RetrievedValue> {
    let modal = channel.tables.data.recall.as_ref()?[id];
    let value = channel.state.remembered.value(id).filter(|_| modal)?;
    Some(RetrievedValue { value, incremental: false, absolute: false, raw: value })
}

/// Diameter factor for the positions of an axis that have words of their own.
pub fn axis_diameter_factor(channel: &ChannelContext<'_>, axis: AxisSlot) -> f64 {
    let is_x = channel.state.place.layout.cartesian.first().copied().flatten() == Some(axis);
    if is_x && !channel.tables.data.diameter_x.is_empty() { channel.state.diameter_factor() } else { 1.0 }
}

/// Value that a code hands over, with the factor of its row, in the unit of the program.
#[cold]
pub fn handed_value(machine: &Machine, handed: Handed) -> f64 {
    handed.row.map_or(handed.raw, |at| {
        let row = &machine.data[at];
        handed.raw * row.mul + row.add
    })
}
