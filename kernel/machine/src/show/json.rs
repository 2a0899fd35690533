//! JSON form.
//!
//! Invariant: names instead of indexes, the units of the machine file; rows carry the file and line that define them.

use serde_json::{Value, json};

use super::components::{of, rows, with_macros};
use super::{Show, register, sorted_codes, word, written};
use crate::index::{AxisId, IdTable, RegisterId, SpindleId};
use crate::model::{Axis, Channel, CompensationRules, Component, DistanceMode, Machine, WaitRow};
use crate::rows::{CodeForm, CodeRow, DataRow, NumberFormat, Register};

/// The whole machine.
#[must_use]
pub fn json(machine: &Machine) -> Value {
    json!({
        "name": machine.name,
        "number": machine.number,
        "revision": machine.revision,
        "author": machine.author,
        "description": machine.description,
        "units": word(machine.unit),
        "type": word(machine.kind),
        "preprocessor": machine.preprocessor.row().name,
        "format": format(machine),
        "registers": rows(of(machine), |machine| machine.registers.iter().map(register_json).collect()),
        "codes": rows(of(machine), |machine| sorted_codes(machine).into_iter().map(|row| code(machine, row)).collect()),
        "groups": rows(of(machine), super::groups::json),
        "macros": rows(with_macros(machine), super::macros::json),
        "refusals": rows(of(machine), super::refusals::json),
        "data": rows(of(machine), |machine| machine.data.iter().map(|row| data(machine, row)).collect()),
        "axes": machine.axes.iter().map(|axis| axis_json(machine, axis)).collect::<Vec<_>>(),
        "channels": machine.channels.iter().map(|row| channel(machine, row)).collect::<Vec<_>>(),
        "spindles": spindles(machine),
        "initial": machine.initial.iter().map(|id| machine.code_name(*id)).collect::<Vec<_>>(),
        "subprograms": subprograms(machine),
        "sync": sync(machine),
        "time": time(machine),
        "cycles": cycles(machine),
        "arcs": arcs(machine),
        "threads": threads(machine),
        "compensation": compensation(&machine.compensation),
        "corners": {
            "between": machine.corners.between,
            "blocks": if machine.corners.dwell_only { "dwell" } else { "any" },
            "too_long": if machine.corners.reduces { "reduce" } else { "error" },
            "rapid": machine.corners.rapid,
        },
        "output": {
            "file": machine.output.file,
            "leading_zeros": if machine.output.padded { "spaces" } else { "none" },
            "sign": if machine.output.sign_column { "column" } else { "minus" },
            "line_end": match machine.output.line_end { "\n" => "lf", "\r" => "cr", _ => "cr-lf" },
            "open": if machine.output.opened { "needed" } else { "not-needed" },
        },
        "variables": { "shared": machine.variables.shared, "channel": machine.variables.channel,
            "own_common": machine.variables.own_common, "alarm_base": machine.variables.system.alarm,
            "start_date": machine.variables.system.start.0, "start_time": machine.variables.system.start.1,
            "initial": machine.variables.system.initial, "system": system(machine),
            "external": external(machine), "other_external": machine.variables.external.any },
        "tool": { "offset_digits": machine.tool.offset_digits, "edges": machine.tool.edges,
            "named_from": machine.tool.named_from, "offsets": tool_offsets(machine), "data": tool_data(machine) },
        "components": machine.components.iter().map(component).collect::<Vec<_>>(),
        "work_offsets": machine.work_offsets.iter().map(|values| by_axis(machine, values)).collect::<Vec<_>>(),
    })
}

fn compensation(rules: &CompensationRules) -> Value {
    json!({
        "rapid": rules.rapid,
        "arcs": rules.arcs,
        "corner": word(rules.corner),
        "corner_angle": rules.corner_angle,
        "corner_sharp": rules.corner_shape.map(|shape| shape.sharp),
        "corner_flat": rules.corner_shape.map(|shape| shape.flat),
        "corner_distortion": rules.corner_shape.map(|shape| shape.distortion),
        "corner_circle": if rules.corner_after { "after" } else { "before" },
        "looked_through": rules.between.looked_through,
        "alarm_beyond_looked_through": rules.between.alarm_beyond,
        "program_stop": if rules.between.past_stops { "looked-through" } else { "ends" },
        "needs_tool": rules.needs_tool,
        "zero_move": rules.between.zero_move,
        "number_zero": if rules.zero_cancels { "cancels" } else { "no-radius" },
        "start_words": if rules.vector { "vector" } else { "unused" },
        "end_words": if rules.wall { "wall" } else { "unused" },
    })
}

fn component(component: &Component) -> Value {
    json!({
        "designator": component.designator,
        "name": component.name,
        "channels": component.channels,
        "machine": component.machine.name,
        "file": component.machine.file,
    })
}

/// One part of the machine, under its key.
#[must_use]
pub fn part(machine: &Machine, what: Show) -> Value {
    let keys: &[&str] = match what {
        Show::All => return json(machine),
        Show::Summary => &["name", "number", "revision", "description", "units", "type", "format", "sync", "time"],
        Show::Registers => &["registers"],
        Show::Codes => &["codes"],
        Show::Data => &["data"],
        Show::Axes => &["axes"],
        Show::Channels => &["channels", "spindles", "components"],
        Show::Groups => &["groups"],
        Show::Macros => &["macros"],
        Show::Refusals => &["refusals"],
    };
    let mut value = json(machine);
    if let Some(object) = value.as_object_mut() {
        object.retain(|key, _| keys.contains(&key.as_str()));
    }
    value
}

fn format(machine: &Machine) -> Value {
    let format = &machine.format;
    json!({
        "rws": format.rws,
        "rws_at": word(format.rws_at),
        "rws_inline": format.rws_inline,
        "comment": format.comment,
        "comment_lines": if format.long_comments { "any" } else { "one" },
        "message": format.message,
        "opskip": { "mark": format.opskip_mark, "default": format.opskip_default },
        "eob": format.eob,
    })
}

fn number_format(format: &NumberFormat) -> Value {
    json!({
        "whole": format.whole,
        "frac": format.frac,
        "point": word(format.point),
        "lead": word(format.lead),
        "trail": word(format.trail),
        "plus": format.plus,
    })
}

/// A register.
#[must_use]
pub fn register_json(register: &Register) -> Value {
    json!({
        "index": register.index,
        "name": register.name,
        "second": register.second,
        "before": register.before,
        "after": register.after,
        "format": number_format(&register.format),
        "secondary": number_format(&register.secondary),
        "increment": register.increment,
        "signed": register.signed,
        "pointed": register.pointed,
        "counts_increments": register.counts,
    })
}

/// A row of the code table.
#[must_use]
pub fn code(machine: &Machine, row: &CodeRow) -> Value {
    let names = |list: &[RegisterId]| list.iter().map(|index| register(machine, *index)).collect::<Vec<_>>();
    let as_data = match &row.form {
        CodeForm::RegisterAsData { data, .. } => Some(machine.data_name(*data)),
        _ => None,
    };
    json!({
        "id": machine.code_name(row.id),
        "word": written(machine, &row.form),
        "as_data": as_data,
        "enable": row.enable,
        "process": row.process,
        "order": row.order,
        "group": row.group,
        "modality": word(row.modality),
        "mul": row.mul,
        "add": row.add,
        "with": names(&row.with),
        "without": names(&row.without),
        "ignores": names(&row.ignores),
        "owns_axes": row.owns_axes,
        "turns_no_spindle": row.turns_no_spindle,
        "also": row.also,
        "seconds": row.seconds,
        "overlap": word(row.overlap),
        "axis": row.axis.map(|axis| ["X", "Y", "Z"].get(usize::from(axis))),
        "file": row.file,
        "line": row.line,
    })
}

/// A row of the data table.
#[must_use]
pub fn data(machine: &Machine, row: &DataRow) -> Value {
    json!({
        "id": machine.data_name(row.id),
        "register": row.register.map(|index| register(machine, index)),
        "enable": row.enable,
        "process": row.process,
        "modal": row.modal,
        "min": row.min,
        "max": row.max,
        "mul": row.mul,
        "add": row.add,
        "dimension": word(row.dimension),
        "increment": row.increment,
        "file": row.file,
        "line": row.line,
    })
}

fn axis_json(machine: &Machine, axis: &Axis) -> Value {
    json!({
        "name": axis.name,
        "letter": axis.letter,
        "data": machine.data_name(axis.data),
        "role": word(axis.role),
        "diameter": axis.diameter,
        "rapid": axis.rapid,
        "acceleration": axis.dynamics.acceleration,
        "jerk": axis.dynamics.jerk,
        "corner_speed": axis.dynamics.corner_speed,
        "home": axis.home,
        "part_zero": axis.positioning.part_zero,
        "references": axis.positioning.references,
        "floating": axis.positioning.floating,
        "one_way": axis.positioning.one_way,
        "stop": axis.positioning.stop.at,
        "stop_variable": axis.positioning.stop.variable,
        "limits": axis.limits,
    })
}

fn channel(machine: &Machine, channel: &Channel) -> Value {
    let number = |spindle: Option<SpindleId>| spindle.map(|spindle| machine.spindles[spindle].number);
    json!({
        "number": channel.number,
        "name": channel.name,
        "axes": channel.axes.iter().map(|axis| machine.axes[*axis].name.as_str()).collect::<Vec<_>>(),
        "spindle": number(channel.spindle),
        "rear": number(channel.rear),
        "milling": number(channel.milling),
        "side": if channel.lower { "lower" } else { "upper" },
    })
}

fn spindles(machine: &Machine) -> Vec<Value> {
    let spindle = |spindle: &crate::model::Spindle| {
        json!({
            "number": spindle.number,
            "name": spindle.name,
            "max": spindle.max,
            "min": spindle.min,
            "run_up": spindle.run_up,
            "follows": spindle.follows,
            "phase": spindle.phase,
            "chuck": spindle.chuck.map(word),
            "slide": spindle.slide.map(|axis| machine.axes[axis].name.clone()),
            "takes_in_phase": spindle.takes_in_phase,
            "overlap": word(spindle.overlap),
        })
    };
    machine.spindles.iter().map(spindle).collect()
}

fn subprograms(machine: &Machine) -> Value {
    let subprograms = &machine.subprograms;
    json!({
        "placement": word(subprograms.placement),
        "extension": subprograms.extension,
        "call": word(subprograms.call),
        "repeat_is_executions": subprograms.repeat_is_executions,
        "main_return": word(subprograms.main_return),
        "end": if subprograms.end_ends { "ends" } else { "returns" },
        "nested_calls": word(subprograms.nested),
        "levels": {
            "subprograms": subprograms.levels.subprograms,
            "macros": subprograms.levels.macros,
            "all": subprograms.levels.all,
        },
        "macro_words": word(subprograms.macro_words),
        "ijk": word(subprograms.ijk),
        "calls": subprograms.calls.iter().map(|call| super::text::word_call(machine, call)).collect::<Vec<_>>(),
    })
}

fn sync(machine: &Machine) -> Value {
    let sync = &machine.sync;
    json!({
        "dialect": word(sync.dialect),
        "paths": word(sync.paths),
        "alarm_scope": word(sync.alarm_scope),
        "release_ns": sync.release_ns,
        "poll_ns": sync.poll_ns,
        "signals": sync.signals,
        "waits": sync.waits.iter().map(wait).collect::<Vec<_>>(),
    })
}

fn external(machine: &Machine) -> Vec<Value> {
    let rows = machine.variables.external.rows.iter();
    rows.map(|row| {
        json!({
            "name": row.name,
            "scope": if row.own { "channel" } else { "global" },
            "synchronous": row.synchronous,
            "access": match (row.readable, row.writable) {
                (true, true) => "read-write",
                (true, false) => "read",
                _ => "write",
            },
            "type": word(row.kind),
            "elements": row.elements,
            "value": row.value,
        })
    })
    .collect()
}

fn wait(wait: &WaitRow) -> Value {
    json!({
        "word": wait.word,
        "primitive": word(wait.primitive),
        "act": word(wait.act),
        "mark": wait.mark,
        "need": wait.need,
        "absent": if wait.absent_counts { "counts" } else { "missed" },
        "met_by": wait.met_by.map(word),
        "line_up": wait.line_up,
        "mismatch": word(wait.mismatch),
        "broadcast": if wait.signals.stays { "stays" } else { "each" },
        "in_order": wait.signals.in_order,
    })
}

fn time(machine: &Machine) -> Value {
    let time = &machine.time;
    json!({
        "tool_change": time.tool_change,
        "tool_step": time.tool_step,
        "tool_overlap": word(time.tool_overlap),
        "stations": time.stations,
        "rapid": word(time.rapid),
        "spindle_speed": time.spindle_speed,
        "look_ahead": time.look_ahead,
        "corner_deviation": time.corner_deviation,
        "block_time": time.block_time,
    })
}

fn cycles(machine: &Machine) -> Value {
    let cycles = &machine.cycles;
    json!({
        "approach": word(cycles.approach),
        "clearance": word(cycles.clearance),
        "depth": word(cycles.depth),
        "clearance_word": if cycles.clearance_required { "required" } else { "optional" },
        "step": if cycles.step_required { "required" } else { "optional" },
        "step_back": cycles.step_back,
        "min_step": cycles.min_step,
        "cancel": if cycles.cancel_required { "required" } else { "optional" },
        "motion_cancels": cycles.motion_cancels,
        "typed_tap_feed": if cycles.tap_pitch { "pitch" } else { "mode" },
        "beside_motion": if cycles.last_of_block { "last" } else { "cycle" },
    })
}

fn arcs(machine: &Machine) -> Value {
    let arcs = &machine.arcs;
    json!({
        "center": match arcs.center {
            DistanceMode::Incremental => "offset".to_owned(),
            other => word(other),
        },
        "tolerance": arcs.tolerance,
        "tolerance_share": arcs.tolerance_share,
        "largest_tolerance": arcs.largest_tolerance.is_finite().then_some(arcs.largest_tolerance),
        "max_radius": arcs.max_radius.is_finite().then_some(arcs.max_radius),
        "helix": word(arcs.helix),
        "turns": word(arcs.turns),
        "to_start": if arcs.stands { "stand" } else { "error" },
        "without_center": if arcs.straight { "line" } else { "error" },
    })
}

fn threads(machine: &Machine) -> Value {
    let threads = &machine.threads;
    json!({
        "form": if threads.two_lines { "two-line" } else { "one-line" },
        "infeed": threads.infeed,
        "min_step": threads.min_step,
        "finish_cuts": threads.finish_cuts,
        "finish": threads.finish,
        "nose": threads.nose,
        "noses": (0..=120).filter(|degree| threads.noses >> degree & 1 != 0).collect::<Vec<u32>>(),
        "chamfer": threads.chamfer,
        "chamfer_length": threads.chamfer_length,
        "chamfer_angle": threads.chamfer_angle,
    })
}

fn tool_offsets(machine: &Machine) -> Vec<Value> {
    let offset = |offset: &crate::model::ToolOffset| {
        json!({
            "number": offset.number,
            "radius": offset.radius,
            "tip": offset.tip,
            "values": by_axis(machine, &offset.values),
            "radius_wear": offset.radius_wear,
            "wear": by_axis(machine, &offset.wear),
        })
    };
    machine.tool.offsets.iter().map(offset).collect()
}

fn tool_data(machine: &Machine) -> Vec<Value> {
    let facts = |facts: &crate::model::ToolFacts| {
        json!({
            "number": facts.number,
            "name": facts.name,
            "diameter": facts.diameter,
            "radius": facts.radius,
            "length": facts.length,
            "offset": facts.offset,
        })
    };
    machine.tool.data.iter().map(facts).collect()
}

/// Values with the names of their axes.
fn by_axis(machine: &Machine, values: &IdTable<AxisId, f64>) -> Value {
    let named = machine.axes.iter().zip(values).map(|(axis, value)| (axis.name.clone(), json!(value)));
    Value::Object(named.collect())
}

/// First and last number of each row of system variables, and whether programs may set them.
fn system(machine: &Machine) -> Vec<Value> {
    let rows = machine.variables.system.rows.iter();
    rows.map(|row| json!({ "first": row.first, "last": row.last, "also": row.also, "write": row.writable })).collect()
}
