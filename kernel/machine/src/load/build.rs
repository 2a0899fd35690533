//! The merged file to the machine: sections in the order in which they need each other.
//!
//! Invariant: every key of the top level is read exactly here.

use super::chain::Merged;
use super::names::NameRegistry;
use super::{
    axes, calls, channels, codes, compensation, components, cycles, data, diagnostics, dialogs, external, format,
    habits, head, idle, initial, kinematics, macros, output, overlap, paths, pump, refusals, registers,
};
use super::{signs, spindles, stops, storage, subprograms, sync, system_variables, tape, time, tool, variables, waits};
use crate::ident;
use crate::index::IdTable;
use crate::model::{Machine, MachineKind};
use crate::tables::LookupTables;
use crate::toml::check::FindingCollector;
use crate::toml::node::DefinitionPlace;
use crate::toml::section::TableReader;
use counterpoint_ports::files::JobFiles;

/// Builds the machine; whether it is any good is for the findings to say.
///
/// Of a component `composite` has the declaration macro of its composite, which is its own, too. Returns the rows of a
/// composite's components as well.
pub(super) fn machine(
    merged: &Merged,
    files: &dyn JobFiles,
    composite: Option<Option<(&str, &DefinitionPlace)>>,
    check: &FindingCollector,
) -> (Machine, Vec<components::ComponentRow>) {
    let mut top = TableReader::new(&merged.table, merged.start.clone(), "the machine file", check);
    top.text("extends");
    if top.flag("abstract") == Some(true) {
        let name = &merged.folder;
        top.error(
            "abstract",
            format!("{name} is a family (abstract = true), not a machine; name a machine that extends it"),
        );
        check.set_incomplete();
    }
    let head = head::read(&mut top);
    let together = composite.is_some() || head.kind == MachineKind::Composite;
    let format = format::read(&mut top, check, head.preprocessor);
    let registers = registers::read(&mut top, check);
    let mut names = NameRegistry { check, registers, codes: ident::code_names(), data: ident::data_names() };
    let mut data = data::read(&mut top, &mut names, head.unit);
    let mut axes = axes::read(&mut top, &names, &data);
    stops::read(&mut top, &mut axes, check);
    let spindles = spindles::read(&mut top, &axes, check);
    let channels = channels::read(&mut top, &axes, &spindles, check);
    let components = components::read(&mut top, head.kind, &channels, check);
    let mut codes = codes::read(&mut top, &mut names);
    let time = time::read(&mut top, &names, &mut codes);
    let cycles = cycles::read(&mut top, head.unit);
    let arcs = paths::arcs(&mut top, head.unit);
    let turning = paths::turning(&mut top, head.unit);
    let threads = paths::threads(&mut top);
    let pump = pump::read(&mut top);
    let (habits, coordinates) = habits::read(&mut top, head.preprocessor);
    registers::change_coordinates(&mut names.registers, coordinates);
    if !coordinates.increments {
        data::as_written(&mut data);
    }
    let output = output::read(&mut top);
    let kinematics = kinematics::read(&mut top, &axes, &channels, &codes, check);
    let corners = compensation::corners(&mut top);
    let compensation = compensation::read(&mut top);
    overlap::check_codes(&codes, &names.registers, check);
    let initial = initial::read(&mut top, &names, &codes);
    let waits = waits::read(&mut top, (&codes, &names.registers), (head.preprocessor, together), channels.len(), check);
    let sync = sync::read(&mut top, &channels, (&codes, waits), check);
    let system = system_variables::read(&mut top, &codes, &names.registers, check);
    let external = external::read(&mut top, head.preprocessor, check);
    let variables = variables::read(&mut top, (system, external), check);
    let around = calls::Around {
        registers: &names.registers,
        codes: &codes,
        variables: &variables,
        preprocessor: head.preprocessor,
    };
    let subprograms = subprograms::read(&mut top, &around);
    let tool = tool::read(&mut top, &axes, check);
    let work_offsets = tool::read_work(&mut top, &axes, check);
    signs::read(&mut top, check);
    let storage = storage::read(&mut top, files);
    let mut shown = Vec::new();
    let macros = macros::read(&mut top, &names, (&codes, &data), (files, &storage, composite), &mut shown);
    idle::check(&mut top, &codes, head.preprocessor, channels.len(), check);
    // Codes of a composite are never read, and macros of its components take theirs.
    if head.kind != MachineKind::Composite {
        overlap::check_custom(&codes, &names.codes, macros.as_deref(), check);
    }
    let tape_editor = tape::read(&mut top);
    let dialogs = dialogs::read(&mut top, files, macros.as_deref(), &shown, check);
    let mut diagnostics = diagnostics::read(&mut top, files);
    diagnostics.refusals = refusals::read(&mut top, &names, &codes);
    top.finish();
    let (codes, data): (IdTable<_, _>, IdTable<_, _>) = (codes.into_iter().collect(), data.into_iter().collect());
    let tables = LookupTables::new(&names.registers, &codes, &data, &names.data);
    let machine = Machine {
        name: head.name,
        number: head.number,
        revision: head.revision,
        created: head.created,
        file: merged.start.file.to_string(),
        author: head.author,
        description: head.description,
        unit: head.unit,
        kind: head.kind,
        preprocessor: head.preprocessor,
        format,
        registers: names.registers,
        codes,
        data,
        code_names: names.codes,
        data_names: names.data,
        axes,
        channels,
        spindles,
        initial,
        subprograms,
        sync,
        time,
        cycles,
        arcs,
        turning,
        threads,
        kinematics,
        pump,
        habits,
        output,
        compensation,
        corners,
        variables,
        tool,
        work_offsets,
        macros,
        tape_editor,
        dialogs,
        diagnostics,
        storage,
        components: Vec::new(),
        tables,
    };
    (machine, components)
}
