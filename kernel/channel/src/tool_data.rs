//! Data of the tools, reported whenever they change.
//!
//! Facts: reference listing-and-trace.md 7.1, system-variables.md 13. Sources by precedence: the tool table as macros
//! have written it, the machine's tools, the active offset while the tool was in use. *Invariants:* an event has all
//! known data of its tool, and is made only if they have changed; at the end of a run the tables are reported in the
//! order of `$TLSORT`.

use counterpoint_event::event::{Kind, ToolData};
use counterpoint_lang::value::MacroValue;
use counterpoint_machine::ident::codes;

use crate::channel_context::ChannelContext;
use crate::macros::runtime::Runtime;
use crate::macros::store::column;
use crate::macros::tool_table::sort_column;
use crate::modal::group;
use crate::offset_tables::Radii;

/// Tools that are reported; the tool table of macros has fewer rows.
const MOST: usize = 1000;

/// Maximum characters of a name.
const LONGEST_NAME: usize = 80;

/// Reports the data of the tool in use. Called after the tool has been loaded or another offset has become active.
pub fn report_tool(channel: &mut ChannelContext<'_>, macros: &Runtime, has_hooks: bool) {
    let tables = &channel.env.machine.tool;
    let current = channel.state.place.tools.current;
    let known = has_hooks
        || !tables.data.is_empty()
        || !tables.offsets.is_empty()
        || channel.state.place.offsets.is_some()
        || channel.state.others.tools.called.name_of(current).is_some();
    if current != 0 && known {
        report_tool_data(channel, tool_data(channel, macros, current));
    }
}

/// Reports the loaded tools, after macros have written into the tool table.
#[cold]
pub fn report_tools(channel: &mut ChannelContext<'_>, macros: &Runtime) {
    for at in 0.. {
        let Some(tool) = macros.tools.loaded().get(at).copied() else { break };
        report_tool_data(channel, tool_data(channel, macros, tool));
    }
}

/// Reports changed tools at the end of the program, and the order of the tools if `$TLSORT` requests an order.
pub fn report_order(channel: &mut ChannelContext<'_>, macros: &mut Runtime) {
    if macros.tools.take_changed() {
        report_tools(channel, macros);
    }
    let column = sort_column(&macros.variables.store).abs();
    if column == 0 {
        return;
    }
    for (place, at) in (1..).zip(macros.tools.sorted(&macros.variables.store, column)) {
        let tool = macros.tools.loaded().get(usize::from(at)).copied();
        if let Some(tool) = tool {
            report_tool_data(channel, ToolData { place, ..tool_data(channel, macros, tool) });
        }
    }
}

fn report_tool_data(channel: &mut ChannelContext<'_>, data: ToolData) {
    let reported = &mut channel.state.others.tools.reported;
    let known = match reported.get(&data.tool) {
        Some(before) => *before == data,
        None => reported.len() >= MOST || data == ToolData { tool: data.tool, ..ToolData::default() },
    };
    if known {
        return;
    }
    reported.insert(data.tool, data.clone());
    channel.emit(0, Kind::ToolData(Box::new(data)));
}

fn tool_data(channel: &ChannelContext<'_>, macros: &Runtime, tool: u32) -> ToolData {
    let facts = channel.env.machine.tool.facts(tool);
    let before = channel.state.others.tools.reported.get(&tool);
    let written = |column| macros.tools.cell(&macros.variables.store, tool, column);
    let number = |column| written(column).and_then(MacroValue::as_real).filter(|value| value.is_finite());
    let (diameter, radius) =
        if tool == channel.state.place.tools.current { offset_in_force(channel) } else { (None, None) };
    let name = written(column::NAME).and_then(MacroValue::as_text).map(str::trim).filter(|name| !name.is_empty());
    let name = name.or(facts.map(|facts| facts.name.as_str()).filter(|name| !name.is_empty()));
    let name = name.or_else(|| channel.state.others.tools.called.name_of(tool)).unwrap_or_default();
    let name: String = name.chars().take(LONGEST_NAME).map(|c| if c.is_control() { ' ' } else { c }).collect();
    ToolData {
        tool,
        name: name.into(),
        diameter: number(column::DIAMETER).or_else(|| facts?.diameter).or(diameter).or_else(|| before?.diameter),
        radius: facts.and_then(|facts| facts.radius).or(radius).or_else(|| before?.radius),
        length: number(column::LENGTH).or_else(|| facts?.length),
        place: 0,
    }
}

/// Diameter and corner radius by the active offset: the nose radius of a turning tool, or half the diameter of a
/// cutter while its path is compensated.
fn offset_in_force(channel: &ChannelContext<'_>) -> (Option<f64>, Option<f64>) {
    let some = |value: f64| Some(value).filter(|value| *value > 0.0);
    if channel.env.machine.tool.offset_digits > 0 {
        return (None, some(channel.offset_radius(Radii::Cutter, channel.state.place.in_force.tool_offset)));
    }
    let on = channel.state.modal.code(group::DIAMETER).is_some_and(|code| code != codes::COMP_DIAM_OFF);
    let number = channel.state.remembered.diameter();
    if !on || number == 0 {
        return (None, None);
    }
    let radius = |table| some(channel.offset_radius(table, number));
    (radius(Radii::Cutter).map(|radius| radius * 2.0), radius(Radii::Corner))
}
