//! Changes of the machine to a diagnostic before it is logged.
//!
//! Facts: reference control-emulator.md 7.5. *Invariant:* these changes do not affect whether a diagnostic stops the
//! channel.

use counterpoint_machine::macros::model::Hook;

use crate::channel_context::ChannelContext;
use crate::macros::runtime::Runtime;

/// Lowest severity of an error; a job cannot switch errors off.
const ERROR: u8 = 8;

/// Severity and text of a diagnostic on this machine; an alarm is never lost.
pub fn customised(
    channel: &mut ChannelContext<'_>,
    macros: &Runtime,
    number: u32,
    (severity, alarm): (u8, bool),
    text: String,
) -> Option<(u8, String)> {
    let off = !alarm && channel.env.options.warnings_off.contains(&number);
    by_machine(channel, macros, number, (severity, alarm), text).filter(|(severity, _)| !off || *severity >= ERROR)
}

/// Severity and text by the rules of the machine, except for numbers that the job switches on.
fn by_machine(
    channel: &mut ChannelContext<'_>,
    macros: &Runtime,
    number: u32,
    (severity, alarm): (u8, bool),
    text: String,
) -> Option<(u8, String)> {
    let table = &channel.env.machine.diagnostics;
    if table.is_plain() {
        return Some((severity, text));
    }
    let before = if table.rule(number).is_some_and(|rule| rule.repeat.is_some()) {
        let count = channel.reports.raised.entry(number).or_insert(0);
        *count = count.saturating_add(1);
        count.saturating_sub(1)
    } else {
        0
    };
    let kept = alarm.then(|| (severity, text.clone()));
    let by_macro = macros.diagnostics.severities.get(&number).is_some_and(|(_, on)| *on);
    let on = by_macro || channel.env.options.warnings_on.contains(&number);
    // The diagnostic macro also sees numbers that are switched off.
    let seen = on || macros.ready(Hook::Diagnostic).is_some();
    if seen && let Some(rule) = table.rule(number).filter(|rule| !rule.enable) {
        return table.shown(rule, severity, text).or(kept);
    }
    table.custom(number, severity, text, before).or(kept)
}
