//! From the tree to bytecode, with every check that can be made before running.
//!
//! *Invariant:* all diagnostics of a file are found in one pass; a program holds code only for macros without errors.
//! Names of shared variables and functions are resolved once, here. Facts: reference macro-language.md 1.4 to 1.6, 2,
//! 3.

mod arms;
mod assign;
mod call;
mod expression;
mod fast;
mod flow;
mod inline;
mod names;
mod register;
mod statement;
mod traced;

pub use crate::program::{CompileOptions, DeclarationStrictness, MacroProgram, MacroRole};
pub use traced::traced;

use crate::ast::{ParsedMacro, StatementKind};
use crate::bytecode::{CommandCode, CompiledMacro, Instruction, MAX_CODE, RuntimeDeclaration, SharedVariable, Slot};
use crate::diag::{DiagnosticNumber, MacroDiagnostic};
use crate::host::CompileEnvironment;
use crate::layout::standard_line;
use crate::parse::{self, MAX_DIAGNOSTICS};
use crate::source::{MacroSource, Span};
use crate::value::{MacroValue, ValueType};
use rustc_hash::{FxHashMap, FxHashSet};
use std::sync::Arc;

/// Result of compiling a source.
#[derive(Debug, Default)]
pub struct Added {
    /// Macros without a header, by index, in order.
    pub macros: Vec<u16>,
    /// Everything found, in order of place.
    pub diagnostics: Vec<MacroDiagnostic>,
}

impl Added {
    /// Tells whether nothing of the source may run.
    #[must_use]
    pub fn has_errors(&self) -> bool {
        self.diagnostics.iter().any(MacroDiagnostic::is_error)
    }
}

/// Compiles a source into `program`.
pub fn add(
    program: &mut MacroProgram,
    environment: &mut dyn CompileEnvironment,
    source: MacroSource,
    options: CompileOptions,
) -> Added {
    let source = Arc::new(source);
    program.sources.push((Arc::clone(&source), options));
    extend(program, environment, source, options)
}

fn extend(
    program: &mut MacroProgram,
    environment: &mut dyn CompileEnvironment,
    source: Arc<MacroSource>,
    options: CompileOptions,
) -> Added {
    let mut added = Added::default();
    let first = program.macros.len();
    load(program, environment, &source, options, &mut added, 0);
    inline::link(program, first);
    added.diagnostics.sort_by_key(|diagnostic| (diagnostic.file != source.name, diagnostic.line, diagnostic.column));
    if added.diagnostics.len() > MAX_DIAGNOSTICS {
        added.diagnostics.truncate(MAX_DIAGNOSTICS);
        let message = format!("only the first {MAX_DIAGNOSTICS} diagnostics are listed");
        added.diagnostics.push(MacroDiagnostic::new(&source, Span::default(), DiagnosticNumber::TOO_MANY, message));
    }
    added
}

/// Compiles embedded macro code: an expression, or statements.
pub fn embedded(
    program: &mut MacroProgram,
    environment: &mut dyn CompileEnvironment,
    source: MacroSource,
    options: CompileOptions,
) -> Added {
    match parse::expression(&source) {
        Some(_) => {
            let text = format!("%EMBEDDED={}", source.text.trim_end());
            let header = format!("MACRO/%EMBEDDED()\n{text}\nENDMAC");
            program.functions.remove("EMBEDDED");
            let mut added = extend(program, environment, Arc::new(MacroSource::new(source.name, header)), options);
            added.macros.extend(program.function("EMBEDDED"));
            added
        }
        None => extend(program, environment, Arc::new(source), options),
    }
}

fn load(
    program: &mut MacroProgram,
    environment: &mut dyn CompileEnvironment,
    source: &Arc<MacroSource>,
    options: CompileOptions,
    added: &mut Added,
    depth: usize,
) {
    let (macros, diagnostics) = parse::parse(source);
    added.diagnostics.extend(diagnostics);
    for statement in macros.iter().flat_map(|one| &one.statements) {
        if let StatementKind::Include(name) = &statement.kind {
            if register::restricted(options) && depth == 0 {
                let message = "under strong declaration INCLUD is allowed in the declaration macro only";
                added.diagnostics.push(MacroDiagnostic::new(
                    source,
                    statement.span,
                    DiagnosticNumber::UNDECLARED,
                    message,
                ));
            }
            include(program, environment, source, (name, statement.span), options, added, depth);
        }
    }
    let indices: Vec<u16> =
        macros.iter().map(|one| register::register(program, source, one, &mut added.diagnostics)).collect();
    for one in &macros {
        register::share(program, source, one, options, &mut added.diagnostics);
    }
    for (one, index) in macros.iter().zip(indices) {
        let before = added.diagnostics.len();
        let code = MacroCompiler::new(program, environment, source, options, &mut added.diagnostics).compile(one);
        let good = !added.diagnostics.get(before..).is_some_and(|new| new.iter().any(MacroDiagnostic::is_error));
        if let (true, Some(place)) = (good, program.macros.get_mut(usize::from(index))) {
            *place = Arc::new(code);
        }
        if one.header.is_none() && depth == 0 {
            added.macros.push(index);
        }
    }
}

fn include(
    program: &mut MacroProgram,
    environment: &mut dyn CompileEnvironment,
    source: &Arc<MacroSource>,
    (name, span): (&String, Span),
    options: CompileOptions,
    added: &mut Added,
    depth: usize,
) {
    let options = CompileOptions {
        place: if options.place == MacroRole::Any { MacroRole::Library } else { options.place },
        ..options
    };
    if program.included.iter().any(|(known, _)| known == name) {
        return;
    }
    let place = program.included.len();
    program.included.push((name.clone(), None));
    if depth >= 20 {
        let message = "files are included more than 20 levels deep";
        added.diagnostics.push(MacroDiagnostic::new(source, span, DiagnosticNumber::TOO_DEEP, message));
        return;
    }
    match environment.include(name, &source.name) {
        Some(text) => {
            let text = Arc::new(text);
            if let Some((_, kept)) = program.included.get_mut(place) {
                *kept = Some(Arc::clone(&text));
            }
            load(program, environment, &text, options, added, depth + 1);
        }
        None => {
            let message = format!("the file '{name}' cannot be read");
            added.diagnostics.push(MacroDiagnostic::new(source, span, DiagnosticNumber::NO_FILE, message));
        }
    }
}

/// A local name.
#[derive(Clone, Debug)]
struct LocalSymbol {
    slot: Slot,
    kind: Option<ValueType>,
    indices: usize,
    channel: bool,
    /// Must be declared, and where it first is.
    declared: Option<u32>,
    written: bool,
    read: Option<Span>,
    user: bool,
}

/// Compiles one macro.
struct MacroCompiler<'a> {
    program: &'a MacroProgram,
    environment: &'a mut dyn CompileEnvironment,
    source: &'a Arc<MacroSource>,
    options: CompileOptions,
    diagnostics: &'a mut Vec<MacroDiagnostic>,
    code: CompiledMacro,
    locals: FxHashMap<String, LocalSymbol>,
    /// Names that the macro assigns somewhere: a loop may read them before the line that does.
    assigned: FxHashSet<String>,
    temporaries: Vec<Slot>,
    used: usize,
    place: Span,
    blocks: Vec<flow::OpenBlock>,
    labels: FxHashMap<String, usize>,
    jumps: Vec<(usize, String, Span)>,
    /// The macro issues blocks or codes, to which MATCH matters.
    issues: bool,
}

/// Whether a macro issues blocks or codes.
fn issues(one: &ParsedMacro) -> bool {
    let issue = |kind: &StatementKind| {
        matches!(kind, StatementKind::Output | StatementKind::Exec(..) | StatementKind::TapeWrite)
    };
    one.statements.iter().any(|statement| issue(&statement.kind))
}

impl<'a> MacroCompiler<'a> {
    fn new(
        program: &'a MacroProgram,
        environment: &'a mut dyn CompileEnvironment,
        source: &'a Arc<MacroSource>,
        options: CompileOptions,
        diagnostics: &'a mut Vec<MacroDiagnostic>,
    ) -> MacroCompiler<'a> {
        MacroCompiler {
            program,
            environment,
            source,
            options,
            diagnostics,
            code: CompiledMacro::empty(source),
            locals: FxHashMap::default(),
            assigned: FxHashSet::default(),
            temporaries: Vec::new(),
            used: 0,
            place: Span::default(),
            blocks: Vec::new(),
            labels: FxHashMap::default(),
            jumps: Vec::new(),
            issues: false,
        }
    }

    fn compile(mut self, one: &ParsedMacro) -> CompiledMacro {
        self.code.name = self.source.name.clone();
        self.place = one.span;
        self.declare_locals(one);
        self.note_assigned(one);
        self.issues = issues(one);
        if let Some(header) = &one.header {
            self.header(header);
            if self.issues {
                self.bare(CommandCode::MatchAgain);
            }
        }
        for statement in &one.statements {
            self.place = statement.span;
            self.used = 0;
            self.statement(statement);
        }
        self.finish_blocks();
        if one.statements.last().is_none_or(|last| last.kind != StatementKind::EndMacro) {
            self.trace_text("ENDMAC".to_owned());
        }
        self.emit(Instruction::Return);
        self.finish_jumps();
        self.warn_uninitialised();
        if self.code.ops.len() > MAX_CODE || self.code.registers.count > MAX_CODE {
            self.error(one.span, DiagnosticNumber::TOO_LARGE, "this macro is too large; split it into functions");
        }
        // With a trace every jump takes the long form, whose cost excludes the trace instructions.
        if self.code.statements.is_empty() {
            self.code.short.forms = fast::forms(&self.code, &self.temporaries);
        }
        self.code
    }

    fn header(&mut self, header: &crate::ast::FunctionHeader) {
        self.code.name.clone_from(&header.name);
        self.code.signature.is_function = true;
        let cleared = self.code.registers.locals.len();
        for (name, kind) in &header.parameters {
            let slot = self.new_local(name, *kind, Some(0));
            self.code.signature.parameters.push((slot, *kind));
            if let Some(local) = self.locals.get_mut(name) {
                local.written = true;
            }
        }
        let slot = self.new_local(&header.name, header.result, Some(0));
        if let Some(local) = self.locals.get_mut(&header.name) {
            local.written = true;
        }
        self.code.signature.result = Some((slot, header.result));
        // Parameters and the result are set at every entry.
        self.code.registers.locals.truncate(cleared);
    }

    fn error(&mut self, span: Span, number: DiagnosticNumber, message: impl Into<String>) {
        self.error_with(span, number, message, None);
    }

    fn error_with(&mut self, span: Span, number: DiagnosticNumber, message: impl Into<String>, help: Option<String>) {
        self.diagnostics.push(MacroDiagnostic::new(self.source, span, number, message).help(help));
    }

    fn emit(&mut self, op: Instruction) -> usize {
        self.code.ops.push(op);
        self.code.places.push(self.place);
        self.code.ops.len() - 1
    }

    fn here(&self) -> u16 {
        u16::try_from(self.code.ops.len()).unwrap_or(u16::MAX)
    }

    fn slot(&mut self) -> Slot {
        self.code.registers.count += 1;
        Slot::try_from(self.code.registers.count - 1).unwrap_or(0)
    }

    fn temporary(&mut self) -> Slot {
        self.used += 1;
        if let Some(slot) = self.temporaries.get(self.used - 1) {
            return *slot;
        }
        let slot = self.slot();
        self.temporaries.push(slot);
        slot
    }

    fn constant(&mut self, value: MacroValue) -> Slot {
        if matches!(
            value,
            MacroValue::Real(_)
                | MacroValue::Logical(_)
                | MacroValue::Null
                | MacroValue::Keyword(_)
                | MacroValue::Text(_)
        ) {
            let same = |other: &MacroValue| {
                other.kind() == value.kind()
                    && match (other, &value) {
                        (MacroValue::Text(a), MacroValue::Text(b)) => a == b,
                        (MacroValue::Real(a), MacroValue::Real(b)) => a.to_bits() == b.to_bits(),
                        _ => other.equals(&value) == Some(true),
                    }
            };
            if let Some((slot, _)) = self.code.registers.constants.iter().rev().take(50).find(|(_, other)| same(other))
            {
                return *slot;
            }
        }
        let slot = self.slot();
        self.code.registers.constants.push((slot, value));
        slot
    }

    fn list(&mut self, slots: Vec<Slot>) -> u16 {
        if slots.is_empty() && self.code.lists.first().is_some_and(Vec::is_empty) {
            return 0;
        }
        if self.code.lists.is_empty() {
            self.code.lists.push(Vec::new());
            if slots.is_empty() {
                return 0;
            }
        }
        self.code.lists.push(slots);
        u16::try_from(self.code.lists.len() - 1).unwrap_or(u16::MAX)
    }

    fn declaration(&mut self, declaration: RuntimeDeclaration) -> u16 {
        self.code.declarations.push(declaration);
        u16::try_from(self.code.declarations.len() - 1).unwrap_or(u16::MAX)
    }

    fn shared(&mut self, shared: SharedVariable, kind: Option<ValueType>) -> u16 {
        let known = self.code.shared.iter().position(|(other, _)| *other == shared);
        let position = known.unwrap_or_else(|| {
            self.code.shared.push((shared, kind));
            let home = self.slot();
            self.code.homes.push(home);
            self.code.shared.len() - 1
        });
        u16::try_from(position).unwrap_or(u16::MAX)
    }

    fn trace(&mut self) {
        if self.options.trace {
            self.trace_text(standard_line(self.source.slice(self.place)));
        }
    }

    fn trace_text(&mut self, text: String) {
        if !self.options.trace {
            return;
        }
        self.code.statements.push(text);
        let statement = u16::try_from(self.code.statements.len() - 1).unwrap_or(u16::MAX);
        self.emit(Instruction::Trace { statement });
    }
}
