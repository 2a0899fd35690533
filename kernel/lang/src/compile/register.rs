//! The contributions of a file to all macros: functions and shared variables.

use super::arms::Arms;
use super::{CompileOptions, DeclarationStrictness, MacroProgram, MacroRole};
use crate::ast::{MacroVariableScope, ParsedMacro, StatementKind};
use crate::bytecode::{CompiledMacro, SharedVariable};
use crate::diag::{DiagnosticNumber, MacroDiagnostic};
use crate::program::{FunctionSymbol, SharedSymbol};
use crate::source::MacroSource;
use std::sync::Arc;

/// Gives a macro its index, and its name if it is a function.
pub(super) fn register(
    program: &mut MacroProgram,
    source: &Arc<MacroSource>,
    one: &ParsedMacro,
    diagnostics: &mut Vec<MacroDiagnostic>,
) -> u16 {
    let index = u16::try_from(program.macros.len()).unwrap_or(u16::MAX);
    if index == u16::MAX {
        diagnostics.push(MacroDiagnostic::new(
            source,
            one.span,
            DiagnosticNumber::TOO_LARGE,
            "there are too many macros",
        ));
        return index;
    }
    program.macros.push(Arc::new(CompiledMacro::empty(source)));
    if let Some(header) = &one.header {
        let parameters = header.parameters.iter().map(|(_, kind)| *kind).collect();
        let symbol = FunctionSymbol { index, parameters, result: header.result };
        if program.functions.insert(header.name.clone(), symbol).is_some() {
            let message = format!("the function {} is defined twice", header.name);
            diagnostics.push(MacroDiagnostic::new(source, header.span, DiagnosticNumber::DUPLICATE_FUNCTION, message));
        }
    }
    index
}

/// Tells whether shared variables and files of functions may not be named here.
pub(super) fn restricted(options: CompileOptions) -> bool {
    options.strong != DeclarationStrictness::Off
        && !matches!(options.place, MacroRole::Declaration | MacroRole::Library)
}

/// Makes the shared variables that a macro declares.
pub(super) fn share(
    program: &mut MacroProgram,
    source: &MacroSource,
    one: &ParsedMacro,
    options: CompileOptions,
    diagnostics: &mut Vec<MacroDiagnostic>,
) {
    let mut arms = Arms::default();
    for statement in &one.statements {
        arms.pass(statement);
        let StatementKind::Declare { scope, kind, channel, names } = &statement.kind else { continue };
        if *scope == MacroVariableScope::Local {
            continue;
        }
        if restricted(options) {
            let message = "under strong declaration GLOBAL and OBJECT variables are declared in the declaration macro";
            diagnostics.push(MacroDiagnostic::new(source, statement.span, DiagnosticNumber::UNDECLARED, message));
        }
        for declared in names {
            let said = (*scope, *kind, declared.sizes.len(), *channel);
            let again = arms.again(&declared.name, said);
            arms.declared(&declared.name, said);
            if again {
                continue;
            }
            let shared = if *scope == MacroVariableScope::Global && !options.globals_are_objects {
                program.globals.push(declared.name.clone());
                SharedVariable::Global(u32::try_from(program.globals.len() - 1).unwrap_or(u32::MAX))
            } else {
                program.objects += 1;
                SharedVariable::Object(program.objects - 1)
            };
            let symbol = SharedSymbol { shared, kind: *kind, indices: declared.sizes.len(), channel: *channel };
            if program.shared.contains_key(&declared.name) || program.functions.contains_key(&declared.name) {
                let message = format!("{} is already declared", declared.name);
                diagnostics.push(MacroDiagnostic::new(source, declared.span, DiagnosticNumber::REDECLARED, message));
            } else {
                program.shared.insert(declared.name.clone(), symbol);
            }
        }
    }
}
