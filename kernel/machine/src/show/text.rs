//! Aligned tables.
//!
//! Invariant: columns are separated by two blanks and lines have none at their end.

use super::grid::TextTable;
use super::{register, word, written};
use crate::ident::kind::CodeKind;
use crate::ident::{CodeId, codes};
use crate::index::RegisterId;
use crate::model::paths::ThreadingRules;
use crate::model::{CallHow, CycleRules, Machine, WordCall};
use crate::rows::{CodeForm, NumberFormat};

pub(super) fn dash(text: impl Into<String>) -> String {
    let text = text.into();
    if text.is_empty() { "-".to_owned() } else { text }
}

pub(super) fn yes(flag: bool) -> String {
    if flag { "yes" } else { "-" }.to_owned()
}

fn optional(number: Option<f64>) -> String {
    number.map_or_else(|| "-".to_owned(), |number| number.to_string())
}

/// · mul + add, where they do something.
fn scaling(mul: f64, add: f64) -> String {
    let mut text = String::new();
    if mul != 1.0 {
        text.push_str(&format!("*{mul}"));
    }
    if add != 0.0 {
        text.push_str(&format!("{add:+}"));
    }
    dash(text)
}

/// A word that calls a program: `G101-G103 calls O9010-O9012 as a macro`.
#[must_use]
pub fn word_call(machine: &Machine, call: &WordCall) -> String {
    let letter = register(machine, call.register);
    let range = |sign: &str, first: String, last: String| {
        if first == last { format!("{sign}{first}") } else { format!("{sign}{first}-{sign}{last}") }
    };
    let number = |number: u32| format!("{number:04}");
    let (first, last) = call.programs();
    let words = if call.max.is_finite() {
        range(letter, call.min.to_string(), call.max.to_string())
    } else {
        letter.to_owned()
    };
    let how = match call.how {
        CallHow::Macro => "as a macro",
        CallHow::Subprogram => "as a subprogram",
        CallHow::Moves => "as a macro after every move",
        CallHow::Blocks => "as a macro on every block",
    };
    let value = call.variable.map_or_else(String::new, |variable| format!(", value in #{variable}"));
    format!("{words} calls {} {how}{value}", range("O", number(first), number(last)))
}

pub(super) fn summary(machine: &Machine) -> String {
    let ranges = |ranges: &[(u32, u32)]| {
        dash(ranges.iter().map(|(first, last)| format!("#{first}-#{last}")).collect::<Vec<_>>().join(", "))
    };
    let pair = |pair: &Option<(String, String)>| {
        pair.as_ref().map_or_else(|| "-".to_owned(), |(start, end)| format!("{start} {end}"))
    };
    let (format, sync, time) = (&machine.format, &machine.sync, &machine.time);
    // Components have their own calls, cycles, threads and initial codes.
    let all = super::components::of(machine);
    let named = |component: &str, name: &str| {
        if component.is_empty() { name.to_owned() } else { format!("{component}: {name}") }
    };
    let mut grid = TextTable::new(&["machine", &machine.name]);
    let mut line = |name: &str, value: String| grid.row([name.to_owned(), dash(value)]);
    line("description", machine.description.clone());
    line("number", format!("{}, revision {}", machine.number, machine.revision));
    line("author", machine.author.clone());
    line("type", word(machine.kind));
    line("units", word(machine.unit));
    for (component, own) in &all {
        line(&named(component, "preprocessor"), own.preprocessor.row().name.to_owned());
    }
    let beside = if format.rws_inline { " beside text" } else { "" };
    line("rewind-stop", format!("{} {}{beside}", format.rws, word(format.rws_at)).trim().to_owned());
    line("comment", pair(&format.comment));
    line("message", pair(&format.message));
    line(
        "optional skip",
        format.opskip_mark.map_or(String::new(), |c| format!("{c}, level {}", format.opskip_default)),
    );
    for (component, own) in &all {
        let calls = &own.subprograms;
        line(&named(component, "subprograms"), format!("{}, call {}", word(calls.placement), word(calls.call)));
        line(&named(component, "main return"), word(calls.main_return));
        for call in &calls.calls {
            line(&named(component, "word that calls"), word_call(own, call));
        }
    }
    line("sync", format!("{}, paths {}, alarm stops {}", word(sync.dialect), word(sync.paths), word(sync.alarm_scope)));
    line("sync times", format!("release {} ns, poll {} ns", sync.release_ns, sync.poll_ns));
    line("tool change", format!("{} s, {} s a step, {} stations", time.tool_change, time.tool_step, time.stations));
    line("rapid", word(time.rapid));
    line("spindle speed", format!("{} s", time.spindle_speed));
    if machine.axes.iter().any(|axis| axis.dynamics.acceleration.is_some()) {
        line("look-ahead", format!("{} blocks, {} s a block", time.look_ahead, time.block_time));
        line("corner deviation", optional(time.corner_deviation));
    }
    let has = |own: &Machine, is: fn(CodeId) -> bool| own.codes.iter().any(|row| row.enable && is(row.id));
    for (component, own) in &all {
        if has(own, |id| matches!(id.kind(), CodeKind::Cycle(_)) || id == codes::CYCLE_ON) {
            line(&named(component, "cycles"), cycles(&own.cycles));
        }
        if has(own, |id| matches!(id.kind(), CodeKind::ThreadCycle(_) | CodeKind::ThreadSetting(_))) {
            line(&named(component, "threads"), threads(&own.threads));
        }
    }
    line("shared", ranges(&machine.variables.shared));
    line("per channel", ranges(&machine.variables.channel));
    if machine.variables.own_common {
        line("named", "per channel".to_owned());
    }
    line("offset digits", machine.tool.offset_digits.to_string());
    line("tool offsets", machine.tool.offsets.len().to_string());
    line("tools with data", machine.tool.data.len().to_string());
    for (component, own) in &all {
        let initial: Vec<&str> = own.initial.iter().map(|id| own.code_name(*id)).collect();
        line(&named(component, "initial"), initial.join(", "));
    }
    grid.text()
}

/// Settings of canned cycles; settings that are only mentioned when on come last.
fn cycles(cycles: &CycleRules) -> String {
    let mut text = format!(
        "{}, clearance {}, depth {}, step {}, {} back",
        word(cycles.approach),
        word(cycles.clearance),
        word(cycles.depth),
        if cycles.step_required { "required" } else { "optional" },
        cycles.step_back
    );
    if cycles.motion_cancels {
        text.push_str(", motion cancels");
    }
    if cycles.last_of_block {
        text.push_str(", motion beside: last counts");
    }
    if cycles.cancel_required {
        text.push_str(", cancel required");
    }
    text
}

/// Settings of threading cycles.
fn threads(threads: &ThreadingRules) -> String {
    format!(
        "{}, in-feed {}, {} finishing, nose {} degrees, chamfer {}",
        if threads.two_lines { "two lines" } else { "one line" },
        threads.infeed,
        threads.finish_cuts,
        threads.nose,
        if threads.chamfer { "on" } else { "off" }
    )
}

pub(super) fn registers(machine: &Machine) -> TextTable {
    let mut grid =
        TextTable::new(&["index", "register", "second", "digits", "secondary", "point", "lead", "trail", "signed"]);
    let digits = |format: &NumberFormat| format!("{}.{}", format.whole, format.frac);
    for register in &machine.registers {
        grid.row([
            register.index.to_string(),
            register.name.clone(),
            dash(register.second.clone().unwrap_or_default()),
            digits(&register.format),
            digits(&register.secondary),
            word(register.format.point),
            word(register.format.lead),
            word(register.format.trail),
            yes(register.signed),
        ]);
    }
    grid
}

pub(super) fn codes(machine: &Machine) -> TextTable {
    let heading =
        ["word", "code", "order", "group", "modality", "as data", "scaling", "if", "seconds", "notes", "defined"];
    let mut grid = TextTable::new(&heading);
    for row in super::sorted_codes(machine) {
        let data = match &row.form {
            CodeForm::RegisterAsData { data, .. } => machine.data_name(*data).to_owned(),
            _ => String::new(),
        };
        let names =
            |list: &[RegisterId]| list.iter().map(|index| register(machine, *index)).collect::<Vec<_>>().join(" ");
        let mut conditions = Vec::new();
        if !row.with.is_empty() {
            conditions.push(format!("with {}", names(&row.with)));
        }
        if !row.without.is_empty() {
            conditions.push(format!("without {}", names(&row.without)));
        }
        let along = |axis| row.axis == Some(axis);
        let notes = [
            (super::is_alias(machine, row), "alias"),
            (!row.enable, "off"),
            (!row.process, "swallowed"),
            (along(0), "along X"),
            (along(1), "along Y"),
            (along(2), "along Z"),
        ];
        let notes: Vec<&str> = notes.iter().filter(|(on, _)| *on).map(|(_, note)| *note).collect();
        grid.row([
            written(machine, &row.form),
            machine.code_name(row.id).to_owned(),
            row.order.to_string(),
            row.group.to_string(),
            word(row.modality),
            dash(data),
            scaling(row.mul, row.add),
            dash(conditions.join(", ")),
            row.seconds.to_string(),
            dash(notes.join(", ")),
            format!("{}:{}", row.file, row.line),
        ]);
    }
    grid
}

pub(super) fn data(machine: &Machine) -> TextTable {
    let heading = ["register", "data", "modal", "min", "max", "scaling", "dimension", "notes", "defined"];
    let mut grid = TextTable::new(&heading);
    let mut rows: Vec<_> = machine.data.iter().collect();
    rows.sort_by_key(|row| row.register.map_or(usize::MAX, RegisterId::index));
    for row in rows {
        let notes = [(!row.enable, "off"), (!row.process, "swallowed")];
        let notes: Vec<&str> = notes.iter().filter(|(on, _)| *on).map(|(_, note)| *note).collect();
        grid.row([
            row.register.map_or_else(|| "-".to_owned(), |index| register(machine, index).to_owned()),
            machine.data_name(row.id).to_owned(),
            yes(row.modal),
            optional(row.min),
            optional(row.max),
            scaling(row.mul, row.add),
            word(row.dimension),
            dash(notes.join(", ")),
            format!("{}:{}", row.file, row.line),
        ]);
    }
    grid
}

pub(super) fn axes(machine: &Machine) -> String {
    let heading =
        ["axis", "letter", "data", "role", "diameter", "rapid", "acceleration", "home", "part zero", "limits"];
    let mut grid = TextTable::new(&heading);
    for axis in &machine.axes {
        grid.row([
            axis.name.clone(),
            axis.letter.clone(),
            machine.data_name(axis.data).to_owned(),
            word(axis.role),
            yes(axis.diameter),
            axis.rapid.to_string(),
            optional(axis.dynamics.acceleration),
            axis.home.to_string(),
            axis.positioning.part_zero.to_string(),
            axis.limits.map_or_else(|| "-".to_owned(), |(low, high)| format!("{low} to {high}")),
        ]);
    }
    grid.text()
}

pub(super) fn channels(machine: &Machine) -> String {
    let mut grid = TextTable::new(&["channel", "name", "axes", "spindle"]);
    for channel in &machine.channels {
        let axes: Vec<&str> = channel.axes.iter().map(|axis| machine.axes[*axis].name.as_str()).collect();
        grid.row([
            channel.number.to_string(),
            channel.name.clone(),
            dash(axes.join(" ")),
            channel.spindle.map_or_else(|| "-".to_owned(), |spindle| machine.spindles[spindle].number.to_string()),
        ]);
    }
    let mut spindles = TextTable::new(&["spindle", "name", "max rev/min", "min rev/min", "run-up s"]);
    for spindle in &machine.spindles {
        spindles.row([
            spindle.number.to_string(),
            spindle.name.clone(),
            spindle.max.to_string(),
            spindle.min.to_string(),
            spindle.run_up.to_string(),
        ]);
    }
    let both = format!("{}\n{}", grid.text(), spindles.text());
    if machine.components.is_empty() {
        return both;
    }
    let mut components = TextTable::new(&["component", "name", "channels", "definition"]);
    for component in &machine.components {
        let channels: Vec<String> = component.channels.iter().map(u16::to_string).collect();
        let (designator, name) = (component.designator.clone(), component.name.clone());
        components.row([designator, name, channels.join(" "), component.machine.file.clone()]);
    }
    format!("{both}\n{}", components.text())
}
