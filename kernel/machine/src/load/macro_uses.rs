//! Findings about uses that the place of a macro does not support: arguments, values of EXEC, dialogs.
//!
//! Invariant: a finding follows from the text alone; a use that depends on a value is left to the run. Facts: reference
//! control-emulator.md 4, macro-language.md 7.

use counterpoint_lang::ast::{Expr, ExprKind, ParsedMacro, StatementKind, VariableName, WhenItem};
use counterpoint_lang::parse::parse;
use counterpoint_lang::source::{MacroSource, Span};

use crate::macros::model::Hook;
use crate::toml::check::FindingCollector;
use crate::toml::node::DefinitionPlace;

/// The inputs that a place gives to its macro.
#[derive(Debug, Clone, Copy)]
pub(super) struct Available {
    /// Name of the place in messages.
    pub(super) title: &'static str,
    /// Arguments `$P1` to this one.
    pub(super) arguments: u8,
    /// Arguments that a macro may read but not set.
    pub(super) read_only: &'static [u8],
    /// Whether the kernel runs no program (the master).
    pub(super) is_master: bool,
}

impl Available {
    /// A code macro.
    pub(super) const CODE: Self = Self { title: "code macro", arguments: 2, read_only: &[2], is_master: false };
    /// A data macro.
    pub(super) const DATA: Self = Self { title: "data macro", arguments: 5, read_only: &[3, 5], is_master: false };
    /// A file of functions.
    pub(super) const FUNCTIONS: Self = Self { title: "function", arguments: 0, read_only: &[], is_master: false };

    /// The macro of a hook.
    pub(super) const fn of(hook: Hook) -> Self {
        let arguments = match hook {
            Hook::Declaration
            | Hook::MachineStartup
            | Hook::MachineShutdown
            | Hook::ProgramStartup
            | Hook::ProgramShutdown => 0,
            Hook::SubprogramStartup | Hook::SubprogramShutdown => 10,
            Hook::PreprocessorStartup
            | Hook::PreprocessorShutdown
            | Hook::BlockStartup
            | Hook::BlockShutdown
            | Hook::Tool
            | Hook::Identification => 3,
            Hook::Motion => 8,
            Hook::Cycle => 6,
            Hook::Diagnostic => 5,
        };
        let read_only: &[u8] = match hook {
            Hook::SubprogramStartup => &[2, 3, 4, 5, 6, 7, 8],
            Hook::PreprocessorStartup | Hook::BlockStartup | Hook::Identification => &[3],
            Hook::BlockShutdown | Hook::PreprocessorShutdown => &[1, 3],
            Hook::Tool => &[1, 2, 3],
            Hook::Motion => &[3, 4, 5, 6, 7, 8],
            Hook::Cycle => &[1, 2],
            Hook::Diagnostic => &[4],
            _ => &[],
        };
        let is_master = matches!(hook, Hook::MachineStartup | Hook::MachineShutdown);
        Self { title: hook.title(), arguments, read_only, is_master }
    }
}

/// Looks through a file that compiles; the dialogs that it shows by name are added to `dialogs`.
pub(super) fn check(
    source: &MacroSource,
    given: Available,
    check: &FindingCollector,
    dialogs: &mut Vec<(String, DefinitionPlace)>,
) {
    let (macros, _) = parse(source);
    for found in &macros {
        let mut uses = MacroUseChecker { source, given, check, dialogs, set: 0, reported: 0, read: Some(0) };
        found.statements.iter().for_each(|statement| uses.statement(&statement.kind));
        let read = uses.read.take().unwrap_or(0);
        // An argument that the macro itself reads after it has set it is a variable like any other.
        let set = assigned(found);
        uses.set = set;
        for statement in &found.statements {
            uses.statement(&statement.kind);
            uses.without_effect(&statement.kind, statement.span, read);
        }
    }
}

/// Arguments that a macro assigns, bit by number: one that its place does not have is then a variable like any other.
fn assigned(found: &ParsedMacro) -> u128 {
    let mut set = 0;
    for statement in &found.statements {
        let targets = match &statement.kind {
            StatementKind::Assign { target, .. } => std::slice::from_ref(target),
            StatementKind::Do { variable, .. } => std::slice::from_ref(variable),
            StatementKind::Read { targets, .. } => targets,
            _ => &[],
        };
        targets.iter().filter_map(argument).for_each(|number| set |= 1_u128.wrapping_shl(u32::from(number)));
    }
    set
}

/// The argument that an expression is, or an element of.
fn argument(expression: &Expr) -> Option<u8> {
    match &expression.kind {
        ExprKind::Variable(VariableName::Param(number))
        | ExprKind::Element(VariableName::Param(number), _)
        | ExprKind::Range(VariableName::Param(number), ..) => Some(*number),
        _ => None,
    }
}

struct MacroUseChecker<'a> {
    source: &'a MacroSource,
    given: Available,
    check: &'a FindingCollector,
    dialogs: &'a mut Vec<(String, DefinitionPlace)>,
    set: u128,
    reported: u128,
    /// Arguments that are read, while they are collected and nothing is reported.
    read: Option<u128>,
}

impl MacroUseChecker<'_> {
    fn place(&self, span: Span) -> DefinitionPlace {
        let (line, column) = self.source.place(span.start);
        DefinitionPlace { file: self.source.name.as_str().into(), line, column }
    }

    /// Reports a statement that does nothing at its place.
    fn without_effect(&self, statement: &StatementKind, span: Span, read: u128) {
        let title = self.given.title;
        if let StatementKind::Assign { target, .. } = statement
            && let Some(number) = argument(target).filter(|number| self.given.read_only.contains(number))
            && read & 1_u128.wrapping_shl(u32::from(number)) == 0
        {
            let text = format!("$P{number} of the {title} is read-only; the assignment has no effect");
            self.check.warning(&self.place(target.span), text);
        }
        let command = match statement {
            StatementKind::Exec(..) => "EXEC",
            StatementKind::TapeRead => "TAPERD",
            StatementKind::TapeWrite => "TAPEWT",
            StatementKind::Search(_) => "SEARCH",
            StatementKind::SaveModal => "SAVMODAL",
            StatementKind::RestoreModal => "RSTMODAL",
            _ => return,
        };
        if self.given.is_master {
            let text = format!("{command} has no effect in the {title}: its kernel runs no program");
            self.check.warning(&self.place(span), text);
        }
    }

    fn statement(&mut self, statement: &StatementKind) {
        match statement {
            StatementKind::Assign { target, value, .. } => {
                let own = argument(target).map_or(0, |number| 1_u128.wrapping_shl(u32::from(number)));
                let before = self.read;
                self.expression(target);
                self.expression(value);
                // A variable used only for its own next value is not read.
                self.read = self.read.zip(before).map(|(now, before)| now & (!own | before));
            }
            StatementKind::Declare { names, .. } => {
                for name in names {
                    name.sizes.iter().chain(&name.value).for_each(|part| self.expression(part));
                }
            }
            StatementKind::If(value)
            | StatementKind::ElseIf(value)
            | StatementKind::Case(value)
            | StatementKind::While(value)
            | StatementKind::Until(value)
            | StatementKind::Search(value)
            | StatementKind::Skip(value)
            | StatementKind::Close(value)
            | StatementKind::System(value) => self.expression(value),
            StatementKind::When(list) => {
                for one in list {
                    match one {
                        WhenItem::One(value) => self.expression(value),
                        WhenItem::Thru(from, to) => [from, to].into_iter().for_each(|value| self.expression(value)),
                    }
                }
            }
            StatementKind::Do { variable, start, end, step } => {
                [variable, start, end].into_iter().chain(step).for_each(|part| self.expression(part));
            }
            StatementKind::Exec(_, items) => {
                self.items(items);
                items.iter().for_each(|item| self.expression(item));
            }
            StatementKind::Print(list)
            | StatementKind::Open(list)
            | StatementKind::Write(list)
            | StatementKind::Error(list) => list.iter().for_each(|part| self.expression(part)),
            StatementKind::Read { source, format, targets, .. } => {
                [source, format].into_iter().chain(targets).for_each(|part| self.expression(part));
            }
            _ => {}
        }
    }

    /// Checks items of EXEC: data need their value after them.
    fn items(&self, items: &[Expr]) {
        if self.read.is_some() {
            return;
        }
        let mut rest = items.iter().peekable();
        while let Some(item) = rest.next() {
            match &item.kind {
                ExprKind::Code(_) => {}
                ExprKind::Register(name) => match rest.peek().map(|next| &next.kind) {
                    None | Some(ExprKind::Code(_) | ExprKind::Register(_)) => {
                        let text = format!("EXEC needs a value after {name}: {name},value");
                        self.check.error(&self.place(item.span), text);
                    }
                    Some(_) => {
                        rest.next();
                    }
                },
                // The value of a variable is known only in the run.
                _ => return,
            }
        }
    }

    fn expression(&mut self, expression: &Expr) {
        if let Some(number) = argument(expression) {
            self.uses(number, expression.span);
        }
        match &expression.kind {
            ExprKind::Element(_, parts) | ExprKind::Sequence(parts) => {
                parts.iter().for_each(|part| self.expression(part));
            }
            ExprKind::Call(name, parts) => {
                if let ("$FDIALOG", Some(ExprKind::Text(dialog))) =
                    (name.as_str(), parts.first().map(|part| &part.kind))
                    && parts.len() == 1
                    && self.read.is_none()
                {
                    let place = self.place(expression.span);
                    self.dialogs.push((dialog.clone(), place));
                }
                parts.iter().for_each(|part| self.expression(part));
            }
            ExprKind::Range(_, from, to) => from.iter().chain(to).for_each(|part| self.expression(part)),
            ExprKind::Unary(_, operand) => self.expression(operand),
            ExprKind::Binary(_, left, right) => [left, right].into_iter().for_each(|part| self.expression(part)),
            _ => {}
        }
    }

    fn uses(&mut self, number: u8, span: Span) {
        let bit = 1_u128.wrapping_shl(u32::from(number));
        if let Some(read) = &mut self.read {
            *read |= bit;
            return;
        }
        if (1..=self.given.arguments).contains(&number) || (self.set | self.reported) & bit != 0 {
            return;
        }
        self.reported |= bit;
        let Available { title, arguments, .. } = self.given;
        let has = match arguments {
            0 => "no arguments".to_owned(),
            last => format!("$P1 to $P{last}"),
        };
        self.check.warning(&self.place(span), format!("$P{number} has no value here: a {title} has {has}"));
    }
}
