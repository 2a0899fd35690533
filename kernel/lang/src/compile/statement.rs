//! Statements into instructions.

use super::{MacroCompiler, MacroRole};
use crate::ast::{CompoundStatement, Expr, ExprKind, MacroStatement, StatementKind};
use crate::bytecode::{CommandCode, Instruction, Relation, Slot};
use crate::diag::DiagnosticNumber;
use crate::format::StringFormat;
use crate::value::{MacroValue, ValueType};

impl MacroCompiler<'_> {
    pub(super) fn statement(&mut self, statement: &MacroStatement) {
        if let Some((label, span)) = &statement.label {
            self.label(label, *span);
        }
        self.allowed(&statement.kind);
        match &statement.kind {
            StatementKind::Empty => {}
            StatementKind::If(condition) => self.open_if(condition),
            StatementKind::ElseIf(condition) => self.else_if(condition),
            StatementKind::Else => self.else_branch(),
            StatementKind::Case(value) => self.open_case(value),
            StatementKind::When(items) => self.when(items),
            StatementKind::While(condition) => self.open_while(condition),
            StatementKind::Repeat => self.open_repeat(),
            StatementKind::Until(condition) => self.until(condition),
            StatementKind::Do { variable, start, end, step } => self.open_do(variable, [start, end], step.as_ref()),
            StatementKind::EndOf(block) => self.end_of(*block),
            other => {
                self.trace();
                self.simple(other);
            }
        }
    }

    /// Refuses statements that the kind of macro does not allow; functions have the rights of their callers.
    fn allowed(&mut self, kind: &StatementKind) {
        use StatementKind as K;
        if self.code.signature.is_function {
            return;
        }
        let message = match (self.options.place, kind) {
            (MacroRole::Data, K::Output) => "OUTPUT is not possible in a data macro",
            (MacroRole::Startup, K::Output) => "OUTPUT is not possible in a startup or shutdown macro",
            (
                MacroRole::Declaration,
                K::Declare { .. }
                | K::Include(_)
                | K::If(_)
                | K::ElseIf(_)
                | K::Else
                | K::Case(_)
                | K::When(_)
                | K::EndOf(CompoundStatement::If | CompoundStatement::Case)
                | K::EndMacro
                | K::Empty,
            ) => return,
            (MacroRole::Declaration, _) => {
                "a declaration macro holds declarations only: DECLAR and INCLUD, inside IF or CASE"
            }
            _ => return,
        };
        self.error(self.place, DiagnosticNumber::NOT_HERE, message);
    }

    fn simple(&mut self, kind: &StatementKind) {
        match kind {
            StatementKind::Assign { target, sign, value } => self.assign(target, *sign, value),
            StatementKind::Declare { scope, kind, channel, names } => self.declare(*scope, *kind, *channel, names),
            StatementKind::Exit(count) => self.exit(*count),
            StatementKind::Jump(label, span) => self.jump(label, *span),
            StatementKind::Terminate | StatementKind::EndMacro => {
                self.emit(Instruction::Return);
            }
            StatementKind::Match(on) => self.bare(if *on { CommandCode::MatchOn } else { CommandCode::MatchOff }),
            StatementKind::Output => self.bare(CommandCode::Output),
            StatementKind::TapeRead => self.bare(CommandCode::TapeRead),
            StatementKind::TapeWrite => self.bare(CommandCode::TapeWrite),
            StatementKind::SaveModal => self.bare(CommandCode::SaveModal),
            StatementKind::RestoreModal => self.bare(CommandCode::RestoreModal),
            StatementKind::Listing(on) => {
                self.bare(if *on { CommandCode::ListingOn } else { CommandCode::ListingOff });
            }
            StatementKind::Search(number) => self.one(CommandCode::Search, number, ValueType::Real),
            StatementKind::Skip(number) => self.one(CommandCode::Skip, number, ValueType::Real),
            StatementKind::Close(unit) => self.one(CommandCode::Close, unit, ValueType::Real),
            StatementKind::System(text) => self.one(CommandCode::System, text, ValueType::Text),
            StatementKind::Print(arguments) => self.formatted(CommandCode::Print, arguments, 0),
            StatementKind::Write(arguments) => self.formatted(CommandCode::Write, arguments, 1),
            StatementKind::Exec(now, arguments) => self.exec(*now, arguments),
            StatementKind::Open(arguments) => {
                let slots = arguments.iter().map(|argument| self.expression(argument, None).0).collect();
                self.command(CommandCode::Open, slots);
            }
            StatementKind::Error(arguments) => self.error_statement(arguments),
            StatementKind::Read { source, again, format, targets } => {
                self.read_statement(source, *again, format, targets)
            }
            _ => {}
        }
    }

    fn command(&mut self, command: CommandCode, slots: Vec<Slot>) {
        let list = self.list(slots);
        self.emit(Instruction::Command { command, list });
    }

    pub(super) fn bare(&mut self, command: CommandCode) {
        self.command(command, Vec::new());
    }

    fn one(&mut self, command: CommandCode, argument: &Expr, kind: ValueType) {
        let wanted = if kind == ValueType::Real { "a number" } else { "a text" };
        let slot = self.typed(argument, kind, wanted);
        self.command(command, vec![slot]);
    }

    /// A command with a format at `position` and its values after it.
    fn formatted(&mut self, command: CommandCode, arguments: &[Expr], position: usize) {
        if let Some(format) = arguments.get(position) {
            self.check_format(format, arguments.len() - position - 1, false);
            if position == 1
                && let Some(unit) = arguments.first()
            {
                self.typed(unit, ValueType::Real, "a unit number");
            }
        }
        let slots = arguments.iter().map(|argument| self.expression(argument, None).0).collect();
        self.command(command, slots);
    }

    /// Checks a format that is written as a constant.
    fn check_format(&mut self, format: &Expr, values: usize, input: bool) {
        let ExprKind::Text(text) = &format.kind else { return };
        let parsed = if input { StringFormat::input(text) } else { StringFormat::output(text) };
        match parsed {
            Err(fault) => self.error(format.span, fault.number, fault.message),
            Ok(parsed) if parsed.arguments != values => {
                let message = format!("this format has {} codes, but {values} values follow", parsed.arguments);
                self.error(format.span, DiagnosticNumber::WRONG_COUNT, message);
            }
            Ok(_) => {}
        }
    }

    fn exec(&mut self, now: bool, arguments: &[Expr]) {
        let literal = arguments.first().is_some_and(has_text);
        if literal || (arguments.len() > 1 && !is_item(arguments.first())) {
            let command = if now { CommandCode::ExecNowFormat } else { CommandCode::ExecNextFormat };
            self.formatted(command, arguments, 0);
            return;
        }
        let slots = arguments.iter().map(|argument| self.expression(argument, None).0).collect();
        self.command(if now { CommandCode::ExecNow } else { CommandCode::ExecNext }, slots);
    }

    fn error_statement(&mut self, arguments: &[Expr]) {
        if let [first, format, values @ ..] = arguments
            && matches!(first.kind, ExprKind::Real(number) if number <= 99.0)
        {
            self.check_format(format, values.len(), false);
        } else if let [first] = arguments
            && matches!(first.kind, ExprKind::Real(number) if number <= 99.0)
        {
            self.error(first.span, DiagnosticNumber::WRONG_COUNT, "a text must follow the severity");
        }
        let slots = arguments.iter().map(|argument| self.expression(argument, None).0).collect();
        self.command(CommandCode::Error, slots);
    }

    fn read_statement(&mut self, source: &Expr, again: bool, format: &Expr, targets: &[Expr]) {
        self.check_format(format, targets.len(), true);
        let (source, _) = self.expression(source, None);
        let format = self.typed(format, ValueType::Text, "a format");
        let temporaries: Vec<Slot> = targets.iter().map(|_| self.temporary()).collect();
        let list = self.list(vec![source, format]);
        let slots = self.list(temporaries.clone());
        self.emit(Instruction::Read { list, targets: slots, again });
        for (target, slot) in targets.iter().zip(temporaries) {
            let (reach, indices) = match &target.kind {
                ExprKind::Element(variable, indices) => {
                    let slots = self.indices(indices);
                    (self.reach(variable, target.span, true), Some(slots))
                }
                ExprKind::Variable(variable) => (self.reach(variable, target.span, true), None),
                _ => continue,
            };
            if Self::declared_kind(&reach, indices.is_some()).is_some() {
                self.null_to_unset(slot);
            }
            self.store(&reach, target.span, indices, slot, (None, target.span));
        }
    }
}

impl MacroCompiler<'_> {
    /// Turns `$NULL` in a register into the initial value of a declared variable: a value that could not be read is not
    /// a fault.
    fn null_to_unset(&mut self, slot: Slot) {
        let (null, unset) = (self.constant(MacroValue::Null), self.constant(MacroValue::Unset));
        let jump = self.emit(Instruction::JumpUnlessCompare { relation: Relation::Equal, a: slot, b: null, target: 0 });
        self.emit(Instruction::Move { to: slot, a: unset });
        self.patch(jump);
    }
}

fn has_text(expression: &Expr) -> bool {
    match &expression.kind {
        ExprKind::Text(_) => true,
        ExprKind::Binary(_, left, right) => has_text(left) || has_text(right),
        _ => false,
    }
}

fn is_item(expression: Option<&Expr>) -> bool {
    expression.is_some_and(|first| matches!(first.kind, ExprKind::Code(_) | ExprKind::Register(_)))
        || expression.is_some_and(|first| matches!(first.kind, ExprKind::Variable(_)))
}
