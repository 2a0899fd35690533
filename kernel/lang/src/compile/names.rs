//! Local names: declarations, first uses, near misses.

use super::arms::Arms;
use super::{DeclarationStrictness, LocalSymbol, MacroCompiler};
use crate::ast::{ExprKind, MacroVariableScope, ParsedMacro, StatementKind, VariableName};
use crate::bytecode::Slot;
use crate::diag::DiagnosticNumber;
use crate::ident;
use crate::source::Span;
use crate::value::ValueType;

impl MacroCompiler<'_> {
    /// Collects the locals that the macro declares, so that their types are known everywhere in it.
    pub(super) fn declare_locals(&mut self, one: &ParsedMacro) {
        let mut arms = Arms::default();
        for statement in &one.statements {
            arms.pass(statement);
            let StatementKind::Declare { scope: MacroVariableScope::Local, kind, channel, names } = &statement.kind
            else {
                continue;
            };
            for declared in names {
                let said = (MacroVariableScope::Local, *kind, declared.sizes.len(), *channel);
                let again = arms.again(&declared.name, said);
                arms.declared(&declared.name, said);
                if again {
                    continue;
                }
                let taken = self.locals.contains_key(&declared.name)
                    || self.program.shared.contains_key(&declared.name)
                    || self.program.functions.contains_key(&declared.name)
                    || one.header.as_ref().is_some_and(|header| {
                        header.name == declared.name || header.parameters.iter().any(|(name, _)| *name == declared.name)
                    });
                if taken {
                    let message = format!("{} is already declared", declared.name);
                    self.error(declared.span, DiagnosticNumber::REDECLARED, message);
                    continue;
                }
                self.new_local(&declared.name, *kind, Some(declared.span.start));
                if let Some(local) = self.locals.get_mut(&declared.name) {
                    local.indices = declared.sizes.len();
                    local.channel = *channel;
                    local.written = true;
                }
            }
        }
    }

    /// Collects the names that the macro assigns as a whole.
    pub(super) fn note_assigned(&mut self, one: &ParsedMacro) {
        for statement in &one.statements {
            let targets = match &statement.kind {
                StatementKind::Assign { target, .. } => std::slice::from_ref(target),
                StatementKind::Read { targets, .. } => targets.as_slice(),
                _ => continue,
            };
            for target in targets {
                if let ExprKind::Variable(VariableName::User(name)) = &target.kind {
                    self.assigned.insert(name.clone());
                }
            }
        }
    }

    pub(super) fn new_local(&mut self, name: &str, kind: Option<ValueType>, declared: Option<u32>) -> Slot {
        let slot = self.slot();
        self.code.registers.locals.push(slot);
        let user = !name.starts_with(['%', '$']);
        let local = LocalSymbol { slot, kind, indices: 0, channel: false, declared, written: false, read: None, user };
        self.locals.insert(name.to_owned(), local);
        slot
    }

    /// Finds or makes a local; notes whether it is read or written.
    pub(super) fn local(&mut self, name: &str, span: Span, write: bool) -> LocalSymbol {
        if !self.locals.contains_key(name) {
            self.new_local(name, None, None);
        }
        let strong = self.options.strong == DeclarationStrictness::Full;
        let mut undeclared = false;
        let mut found = None;
        if let Some(local) = self.locals.get_mut(name) {
            local.written |= write;
            if !write && local.read.is_none() {
                local.read = Some(span);
            }
            undeclared = strong && local.user && local.declared.is_none_or(|at| at > span.start);
            found = Some(local.clone());
        }
        if undeclared {
            let help = self.near_name(name);
            self.error_with(span, DiagnosticNumber::UNDECLARED, format!("{name} is not declared before this"), help);
        }
        found.unwrap_or(LocalSymbol {
            slot: 0,
            kind: None,
            indices: 0,
            channel: false,
            declared: None,
            written: true,
            read: None,
            user: false,
        })
    }

    pub(super) fn near_name(&self, name: &str) -> Option<String> {
        let locals = self.locals.iter().filter(|(_, local)| local.user && local.written).map(|(name, _)| name.as_str());
        let shared = self.program.shared.keys().map(String::as_str);
        let functions = self.program.functions.keys().map(String::as_str);
        let mut all: Vec<&str> = locals.chain(shared).chain(functions).collect();
        all.sort_unstable();
        ident::nearest(name, all).map(|near| format!("did you mean {near}?"))
    }

    pub(super) fn warn_uninitialised(&mut self) {
        if !self.options.uninitialised {
            return;
        }
        let unset = self.locals.iter().filter(|(_, local)| local.user && !local.written);
        let mut unset: Vec<(String, Span)> =
            unset.filter_map(|(name, local)| Some((name.clone(), local.read?))).collect();
        unset.sort_by_key(|(_, span)| span.start);
        for (name, span) in unset {
            let help = self.near_name(&name);
            let message = format!("{name} is read here, but nothing in this macro assigns it");
            self.error_with(span, DiagnosticNumber::UNINITIALISED, message, help);
        }
    }
}
