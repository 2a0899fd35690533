//! Texts of messages for a code that the tables of the machine, or of the active component, do not have.
//!
//! *Invariant:* the machine has the name by which the job knows it; on a composite the message also names the
//! components.

use counterpoint_channel::channel_context::ChannelContext;
use counterpoint_channel::unknown_words::shortened;
use counterpoint_fault as diag;
use counterpoint_fault::DiagnosticFacts;

use super::components::PreparedComponent;
use crate::channel::components::Components;

/// `machine fanuc-mill`, with the active component of a composite.
pub(crate) fn machine_text(channel: &ChannelContext<'_>, components: &Components<'_>) -> String {
    let machine = &channel.env.whole.name;
    match components.current() {
        None => format!("machine {machine}"),
        Some(current) => format!("component {} of machine {machine}", current.designator),
    }
}

/// `machine fanuc-mill has no G411`, with the component of a composite that has the code.
pub(super) fn lacks_code(channel: &ChannelContext<'_>, components: &Components<'_>, text: &str) -> String {
    let lacks = format!("{} has no {text}", machine_text(channel, components));
    match components.current().and_then(|_| component_with(components, text)) {
        Some(other) => format!("{lacks} (component {} has it)", other.designator),
        None => lacks,
    }
}

/// Remedy for a code without a row on the machine: the program is wrong, the definition lacks the code, or another
/// component has it.
pub(super) fn remedy_for(
    channel: &ChannelContext<'_>,
    components: &Components<'_>,
    facts: &DiagnosticFacts,
    text: &str,
) -> String {
    if facts.number != diag::UNKNOWN_CODE.number {
        return String::new();
    }
    let text = shortened(text);
    let row = format!("add a row for {text} to the machine definition");
    let Some(current) = components.current() else {
        return format!(": correct the word, {row}, or choose another machine");
    };
    let row = format!("add a row for {text} to component {}", current.designator);
    let other = component_with(components, &text).filter(|other| other.channels.contains(&channel.at.channel));
    let select = other.and_then(|other| Some((current.machine.word_that_selects(other.designator)?, other.designator)));
    match select {
        Some((word, other)) => {
            format!(": program {word} before the block, which selects component {other}, or {row}")
        }
        None => format!(": correct the word, {row}, or choose another machine"),
    }
}

/// Another component that has the code.
fn component_with<'a>(components: &Components<'a>, text: &str) -> Option<&'a PreparedComponent<'a>> {
    let letter = text.get(..1)?;
    let number: f64 = text.get(1..)?.trim().parse().ok()?;
    let now = components.turns.now;
    let others = components.all.iter().enumerate().filter(|(at, _)| Some(*at) != now);
    others.map(|(_, other)| other).find(|other| other.machine.has_word(&letter.to_ascii_uppercase(), number))
}
