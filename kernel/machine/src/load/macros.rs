//! `[macros]`: the macros of a machine, compiled with everything they name.
//!
//! Invariant: every mistake of every file is a finding at its own file, line and column; the declaration comes first,
//! then the files of functions, then the rest in the order of the form. Facts: reference control-emulator.md 4, 7.2,
//! 7.3.

use std::sync::Arc;

use counterpoint_lang::compile::{self, CompileOptions, DeclarationStrictness, MacroProgram, MacroRole};
use counterpoint_lang::source::MacroSource;

use super::macro_uses::{self, Available};
use super::names::NameRegistry;
use crate::ident;
use crate::index::{Id, IdTable};
use crate::macros::condition::{self, BlockIdentifier, ConditionStep, MacroCondition};
use crate::macros::environment::{MachineEnvironment, beside};
use crate::macros::model::{FIRST_HOOK_ID, Hook, Macros, TriggeredMacro};
use crate::rows::{CodeForm, CodeRow, DataRow};
use crate::stored::StoredFile;
use crate::toml::node::DefinitionPlace;
use crate::toml::section::TableReader;
use counterpoint_ports::files::JobFiles;

/// Most code macros, and most data macros.
const MOST: usize = 1000;

/// The declaration macro of the composite that a component belongs to, if it has one; `None` for other machines.
type OfComposite<'a> = Option<Option<(&'a str, &'a DefinitionPlace)>>;

/// Reads the section; none if the machine has no macros. Dialogs that macros show by name are added to `shown`.
///
/// For a component, `composite` has the declaration macro of its composite, if there is one.
pub(super) fn read(
    top: &mut TableReader<'_>,
    names: &NameRegistry<'_>,
    (codes, data): (&[CodeRow], &[DataRow]),
    (files, stored, composite): (&dyn JobFiles, &[StoredFile], OfComposite<'_>),
    shown: &mut Vec<(String, DefinitionPlace)>,
) -> Option<Arc<Macros>> {
    let mut section = top.table("macros", "[macros]")?;
    let words = [
        ("off", DeclarationStrictness::Off),
        ("partial", DeclarationStrictness::Partial),
        ("full", DeclarationStrictness::Full),
    ];
    let strong = section.choice("strong", &words).unwrap_or_default();
    let uninitialised = section.flag("warn_unassigned").unwrap_or(false);
    let mut macros = Macros { strong, ..Macros::default() };
    let mut program = MacroProgram::new();
    let program_of = &mut program;
    let mut compiler = MacroLoader {
        names,
        codes,
        data,
        files,
        stored,
        program: program_of,
        own: false,
        strong,
        uninitialised,
        shown,
    };
    if let Some((file, place)) = composite.flatten() {
        // It runs in the master kernel; here it says which GLOBAL variables there are.
        compiler.add(file, place, MacroRole::Declaration, Available::of(Hook::Declaration));
    }
    compiler.own = composite.is_some();
    compiler.hook(&mut section, Hook::Declaration, &mut macros.hooks);
    for (file, place) in section.texts("functions").unwrap_or_default() {
        compiler.add(file, place, MacroRole::Library, Available::FUNCTIONS);
    }
    for hook in Hook::ALL.into_iter().filter(|hook| *hook != Hook::Declaration) {
        compiler.hook(&mut section, hook, &mut macros.hooks);
    }
    let mut ids = Vec::new();
    let code = |item: &BlockIdentifier| if let BlockIdentifier::Code(id) = item { Some(*id) } else { None };
    let data = |item: &BlockIdentifier| if let BlockIdentifier::Data(id) = item { Some(*id) } else { None };
    macros.of_code = names.codes.map(|_, _| Vec::new());
    macros.of_data = names.data.map(|_, _| Vec::new());
    macros.codes = compiler.rows(&mut section, code, &mut macros.of_code, &mut ids);
    macros.data = compiler.rows(&mut section, data, &mut macros.of_data, &mut ids);
    section.finish();
    macros.program = Arc::new(program);
    Some(Arc::new(macros))
}

struct MacroLoader<'a, 'n> {
    names: &'a NameRegistry<'n>,
    codes: &'a [CodeRow],
    data: &'a [DataRow],
    files: &'a dyn JobFiles,
    stored: &'a [StoredFile],
    program: &'a mut MacroProgram,
    /// GLOBAL variables are those of a component.
    own: bool,
    strong: DeclarationStrictness,
    /// Variables that are read and never assigned are findings.
    uninitialised: bool,
    /// Dialogs that macros show by name.
    shown: &'a mut Vec<(String, DefinitionPlace)>,
}

/// Kind of the macro of a hook, which decides its permitted content.
fn kind(hook: Hook) -> MacroRole {
    match hook {
        Hook::Declaration => MacroRole::Declaration,
        Hook::Motion | Hook::Cycle | Hook::Tool | Hook::Diagnostic => MacroRole::Any,
        _ => MacroRole::Startup,
    }
}

impl MacroLoader<'_, '_> {
    fn hook(&mut self, section: &mut TableReader<'_>, hook: Hook, hooks: &mut [Option<u16>]) {
        let Some(file) = section.text(hook.key()) else { return };
        let found = self.one(file, section.place_of(hook.key()), kind(hook), Available::of(hook));
        if let Some(slot) = hooks.get_mut(hook as usize) {
            *slot = found;
        }
    }

    /// Compiles a file; returns its macros without a header.
    fn add(&mut self, file: &str, place: &DefinitionPlace, kind: MacroRole, given: Available) -> Option<Vec<u16>> {
        let check = self.names.check;
        let Some(path) = beside(&place.file, file) else {
            let text = format!("\"{}\" must be a file below the folder of this machine file", file.escape_debug());
            check.error(place, text);
            return None;
        };
        let bytes = match self.files.read(&path) {
            Ok(bytes) => bytes,
            Err(error) => {
                check.error(place, format!("cannot read the file of this macro: {error}"));
                return None;
            }
        };
        let mut environment = MachineEnvironment {
            codes: &self.names.codes,
            data: &self.names.data,
            files: Some(self.files),
            stored: self.stored,
        };
        let options = CompileOptions {
            strong: self.strong,
            place: kind,
            uninitialised: self.uninitialised,
            globals_are_objects: self.own,
            ..CompileOptions::default()
        };
        let source = MacroSource::from_bytes(path, &bytes);
        let added = compile::add(self.program, &mut environment, source.clone(), options);
        if !added.has_errors() {
            macro_uses::check(&source, given, check, self.shown);
        }
        for diagnostic in &added.diagnostics {
            let help = diagnostic.help.as_ref().map(|help| format!("; {help}")).unwrap_or_default();
            let text = format!("{} {}{help}", diagnostic.number, diagnostic.message);
            let place = DefinitionPlace {
                file: diagnostic.file.as_str().into(),
                line: diagnostic.line,
                column: diagnostic.column,
            };
            if diagnostic.is_error() {
                check.error(&place, text);
            } else {
                check.warning(&place, text);
            }
        }
        Some(added.macros)
    }

    /// Compiles a file that holds one macro.
    fn one(&mut self, file: &str, place: &DefinitionPlace, kind: MacroRole, given: Available) -> Option<u16> {
        let found = self.add(file, place, kind, given)?;
        match found.as_slice() {
            [one] => Some(*one),
            // Functions are declared by being there.
            [] if kind == MacroRole::Declaration => None,
            [] => {
                self.names.check.error(place, format!("{} holds no macro", file.escape_debug()));
                None
            }
            more => {
                let text = format!("{} holds {} macros; a file holds one", file.escape_debug(), more.len());
                self.names.check.error(place, text);
                None
            }
        }
    }

    /// Macros of codes or of data; `of` picks the identifiers of the kind.
    fn rows<I: Id, M: Id>(
        &mut self,
        section: &mut TableReader<'_>,
        of: fn(&BlockIdentifier) -> Option<I>,
        by: &mut IdTable<I, Vec<M>>,
        ids: &mut Vec<u32>,
    ) -> IdTable<M, TriggeredMacro> {
        let of_codes = of(&BlockIdentifier::Code(ident::codes::COMMENT)).is_some();
        let (key, title) = if of_codes { ("code", "[[macros.code]]") } else { ("data", "[[macros.data]]") };
        let mut rows: IdTable<M, TriggeredMacro> = IdTable::default();
        for mut row in section.rows(key, title, MOST) {
            if let Some(named) = self.row(&mut row, of_codes, ids) {
                if row.node("name").is_some() && rows.iter().any(|other| other.name == named.name) {
                    let text = format!("another macro of {title} has the name \"{}\"; names must differ", named.name);
                    row.error("name", text);
                }
                let triggers: Vec<I> = named.matches.iter().filter_map(of).collect();
                if let Some(place) = rows.push(named) {
                    for id in triggers {
                        if by[id].last() != Some(&place) {
                            by[id].push(place);
                        }
                    }
                }
            }
            row.finish();
        }
        rows
    }

    fn row(&mut self, row: &mut TableReader<'_>, of_codes: bool, ids: &mut Vec<u32>) -> Option<TriggeredMacro> {
        let id = row.integer("id", 1..=i64::from(FIRST_HOOK_ID) - 1).map(|id| id as u32);
        let id = id.unwrap_or_else(|| ids.iter().max().map_or(1, |most| most + 1));
        if ids.contains(&id) {
            row.error("id", format!("another macro has the id {id}"));
        }
        ids.push(id);
        let name = row.name("name", 80).map(str::to_owned);
        let enabled = row.flag("enabled").unwrap_or(true);
        row.require("file", "the file of the macro");
        let (condition, triggers) = self.condition(row, of_codes);
        let default = triggers.iter().map(|item| self.item_name(*item)).collect::<Vec<_>>().join(", ");
        let (kind, given) =
            if of_codes { (MacroRole::Any, Available::CODE) } else { (MacroRole::Data, Available::DATA) };
        let file = row.text("file")?;
        let code = self.one(file, row.place_of("file"), kind, given)?;
        Some(TriggeredMacro { id, name: name.unwrap_or(default), enabled, code, matches: triggers, condition })
    }

    fn item_name(&self, item: BlockIdentifier) -> &str {
        match item {
            BlockIdentifier::Code(id) => &self.names.codes[id],
            BlockIdentifier::Data(id) => &self.names.data[id],
        }
    }

    /// Trigger of a macro: its condition, and the identifiers that fire it.
    fn condition(&self, row: &mut TableReader<'_>, of_codes: bool) -> (MacroCondition, Vec<BlockIdentifier>) {
        let list = |row: &mut TableReader<'_>, key: &'static str| -> Vec<BlockIdentifier> {
            let texts = row.texts(key).unwrap_or_default();
            let fires = key == "match";
            texts.into_iter().filter_map(|(name, place)| self.item(name, place, fires)).collect()
        };
        let present = list(row, "present");
        let absent = list(row, "absent");
        for item in present.iter().filter(|item| absent.contains(item)) {
            row.error("absent", format!("{} cannot both be and not be present", self.item_name(*item)));
        }
        let matched = list(row, "match");
        if !matched.is_empty() && matched.iter().all(|item| absent.contains(item)) {
            row.error("absent", "what fires the macro counts as present: it never runs");
        }
        let wanted = |item: &BlockIdentifier| matches!(item, BlockIdentifier::Code(_)) == of_codes;
        let kind = if of_codes { "CODE_" } else { "REG_" };
        if let Some(other) = matched.iter().find(|item| !wanted(item)) {
            let text = format!("{} cannot fire here: `match` lists {kind}…", self.item_name(*other));
            row.error("match", text);
        }
        let Some(text) = row.text("condition") else {
            if matched.is_empty() {
                row.require("match", &format!("the identifiers that fire the macro, {kind}…"));
            }
            return (
                MacroCondition { present, absent, steps: Vec::new() },
                matched.into_iter().filter(wanted).collect(),
            );
        };
        if !(matched.is_empty() && present.is_empty() && absent.is_empty()) {
            row.error("condition", "`condition` replaces `match`, `present` and `absent`; remove one or the other");
        }
        let place = row.place_of("condition").clone();
        let steps = condition::parse(text, |name| self.item(name, &place, false));
        let steps = steps.unwrap_or_else(|error| {
            row.error("condition", format!("the condition cannot be read: {error}"));
            Vec::new()
        });
        let mut triggers: Vec<BlockIdentifier> = Vec::new();
        for step in &steps {
            if let ConditionStep::Present(item) = step
                && wanted(item)
                && !triggers.contains(item)
            {
                triggers.push(*item);
            }
        }
        if triggers.is_empty() && !steps.is_empty() {
            row.error("condition", format!("the condition names no {kind}… that could fire the macro"));
        }
        (MacroCondition { steps, ..MacroCondition::default() }, triggers)
    }

    /// An identifier that the machine has in some row. The value of a code may also fire a macro.
    fn item(&self, name: &str, place: &DefinitionPlace, fires: bool) -> Option<BlockIdentifier> {
        let upper = name.to_ascii_uppercase();
        if upper.starts_with("REG_") || upper.starts_with("DATA_") {
            let id = self.names.data(name, place)?;
            let of_code = |row: &CodeRow| matches!(row.form, CodeForm::RegisterAsData { data, .. } if data == id);
            if fires && self.codes.iter().any(|row| row.enable && row.process && of_code(row)) {
                return Some(BlockIdentifier::Data(id));
            }
            if !self.data.iter().any(|row| row.id == id && row.enable) {
                let text = format!("no row of this machine's data table has {upper}, so it is never on a block");
                self.names.check.warning(place, text);
            } else if !self.data.iter().any(|row| row.id == id && row.enable && row.process) {
                let text = format!("the rows of {upper} say `process = false`: it is dropped and no macro sees it");
                self.names.check.warning(place, text);
            }
            return Some(BlockIdentifier::Data(id));
        }
        let id = self.names.code(name, place)?;
        let remark = id == ident::codes::COMMENT || id == ident::codes::DISPLY;
        if !remark && !self.codes.iter().any(|row| row.id == id && row.enable) {
            let text = format!("no row of this machine's code table has {upper}, so it never fires");
            self.names.check.warning(place, text);
        } else if !remark && !self.codes.iter().any(|row| row.id == id && row.enable && row.process) {
            let text =
                format!("the rows of {upper} say `process = false`: it is taken off the block and fires nothing");
            self.names.check.warning(place, text);
        }
        Some(BlockIdentifier::Code(id))
    }
}
