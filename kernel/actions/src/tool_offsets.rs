//! Tool offsets by number: the words of a program that give them, and the texts of messages about them.

use counterpoint_fault as diag;
use counterpoint_machine::ident::data;

use crate::context::ActionContext;

/// Reports a tool offset that has no values, if the machine or its table of tools gives values to others.
pub(crate) fn missing_among_listed(act: &mut ActionContext<'_, '_>, offset: u32) {
    let machine = act.channel().env.machine;
    if machine.tool.offsets.is_empty() || !has_no_values(act, offset) {
        return;
    }
    let subject = in_words(act, offset).unwrap_or_else(|| format!("tool offset {offset}"));
    let text = format!("{subject} has no values in machine {}, zero is used", machine.name);
    act.diagnose(&diag::NO_OFFSET, text);
}

/// A tool offset by its tool, as programs call it, where programs do not give numbers of offsets: an edge of a tool, or a
/// tool of a control that calls tools by name.
pub(crate) fn in_words(act: &ActionContext<'_, '_>, offset: u32) -> Option<String> {
    let (rows, tools) = (&act.channel().env.machine.tool, &act.channel().state.others.tools);
    let named = |tool: u32| {
        let known = rows.facts(tool).map(|facts| facts.name.as_str()).filter(|name| !name.is_empty());
        match tools.called.name_of(tool).or(known) {
            Some(name) => format!("tool \"{name}\""),
            None => format!("tool {tool}"),
        }
    };
    if let (Some(tool), Some(edge)) = (offset.checked_div(rows.edges), offset.checked_rem(rows.edges)) {
        return Some(format!("edge {edge} of {}", named(tool)));
    }
    rows.named_from?;
    // Allowances and indexes of a tool have rows of their own.
    let loaded = act.channel().state.place.tools.current;
    let own = tools.called.name_of(offset).is_some() || rows.facts(offset).is_some() || loaded == 0;
    Some(named(if own { offset } else { loaded }))
}

pub(crate) fn has_no_values(act: &ActionContext<'_, '_>, offset: u32) -> bool {
    let set = act.channel().state.place.offsets.as_deref().is_some_and(|own| own.has_tool(offset));
    offset != 0 && !set && act.channel().env.machine.tool.offsets.iter().all(|known| known.number != offset)
}

/// Takes the number of a diameter offset; the last one stays.
pub(crate) fn take_diameter(act: &mut ActionContext<'_, '_>) -> Option<f64> {
    let number = act.take(data::COMP_DIAM).map(|datum| datum.value);
    if let Some(number) = number.filter(|number| (0.0..=999_999.0).contains(number)) {
        act.channel_mut().state.remembered.remember(data::COMP_DIAM, number);
    }
    number
}
