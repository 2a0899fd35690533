//! Blocks, loops and jumps.

use super::MacroCompiler;
use super::expression::ResolvedVariable;
use crate::ast::{CompoundStatement, Expr, ExprKind, MAX_BLOCKS, WhenItem};
use crate::bytecode::{Instruction, Slot};
use crate::diag::DiagnosticNumber;
use crate::source::Span;
use crate::value::{MacroValue, ValueType};

/// An open block.
pub(super) struct OpenBlock {
    block: CompoundStatement,
    span: Span,
    /// Jumps to the next branch.
    next: Vec<usize>,
    /// Jumps to the end of the block.
    ends: Vec<usize>,
    top: u16,
    /// Register of the CASE value or of the end of a DO; the loop variable.
    value: Slot,
    variable: Slot,
    /// Loop variable that is not a register.
    outside: Option<Expr>,
    /// ELSE or OTHERS was seen; a WHEN was seen.
    last: bool,
    branches: usize,
}

impl MacroCompiler<'_> {
    /// Makes a jump lead here.
    pub(super) fn patch(&mut self, jump: usize) {
        let here = self.here();
        self.patch_to(jump, here);
    }

    fn patch_to(&mut self, jump: usize, to: u16) {
        if let Some(
            Instruction::Jump { target }
            | Instruction::JumpIf { target, .. }
            | Instruction::JumpUnless { target, .. }
            | Instruction::JumpUnlessCompare { target, .. }
            | Instruction::JumpIfWhen { target, .. }
            | Instruction::JumpIfThru { target, .. }
            | Instruction::DoStart { target, .. }
            | Instruction::DoNext { target, .. },
        ) = self.code.ops.get_mut(jump)
        {
            *target = to;
        }
    }

    fn patch_all(&mut self, jumps: Vec<usize>) {
        jumps.into_iter().for_each(|jump| self.patch(jump));
    }

    fn open(&mut self, block: CompoundStatement, set: impl FnOnce(&mut OpenBlock)) {
        if self.blocks.len() == MAX_BLOCKS {
            self.error(
                self.place,
                DiagnosticNumber::TOO_DEEP,
                format!("blocks are nested more than {MAX_BLOCKS} levels deep"),
            );
        }
        let top = self.here();
        let mut open = OpenBlock {
            block,
            span: self.place,
            next: Vec::new(),
            ends: Vec::new(),
            top,
            value: 0,
            variable: 0,
            outside: None,
            last: false,
            branches: 0,
        };
        set(&mut open);
        self.blocks.push(open);
    }

    pub(super) fn open_if(&mut self, condition: &Expr) {
        self.trace();
        let mut next = Vec::new();
        self.branch(condition, false, &mut next);
        self.open(CompoundStatement::If, |open| open.next = next);
    }

    /// Ends the running branch of an IF and begins the next one.
    fn next_branch(&mut self, what: &str) -> bool {
        let span = self.place;
        match self.blocks.last() {
            Some(open) if open.block == CompoundStatement::If && !open.last => {}
            Some(open) if open.block == CompoundStatement::If => {
                self.error(span, DiagnosticNumber::UNBALANCED, format!("{what} cannot follow the ELSE of its IF"));
                return false;
            }
            _ => {
                self.error(span, DiagnosticNumber::UNBALANCED, format!("{what} is outside of an IF"));
                return false;
            }
        }
        let jump = self.emit(Instruction::Jump { target: 0 });
        let next = match self.blocks.last_mut() {
            Some(open) => {
                open.ends.push(jump);
                std::mem::take(&mut open.next)
            }
            None => Vec::new(),
        };
        self.patch_all(next);
        true
    }

    pub(super) fn else_if(&mut self, condition: &Expr) {
        if self.next_branch("ELSEIF") {
            self.trace();
            let mut next = Vec::new();
            self.branch(condition, false, &mut next);
            if let Some(open) = self.blocks.last_mut() {
                open.next = next;
            }
        }
    }

    pub(super) fn else_branch(&mut self) {
        if self.next_branch("ELSE") {
            self.trace();
            if let Some(open) = self.blocks.last_mut() {
                open.last = true;
            }
        }
    }

    pub(super) fn open_case(&mut self, value: &Expr) {
        self.trace();
        let slot = self.slot();
        self.expression(value, Some(slot));
        let skip = self.emit(Instruction::Jump { target: 0 });
        self.open(CompoundStatement::Case, |open| {
            open.value = slot;
            open.next.push(skip);
        });
    }

    pub(super) fn when(&mut self, items: &[WhenItem]) {
        let span = self.place;
        let value = match self.blocks.last() {
            Some(open) if open.block == CompoundStatement::Case && !open.last => open.value,
            Some(open) if open.block == CompoundStatement::Case => {
                self.error(span, DiagnosticNumber::BAD_WHEN, "WHEN/OTHERS is the last branch of a CASE");
                return;
            }
            _ => {
                self.error(span, DiagnosticNumber::UNBALANCED, "WHEN is outside of a CASE");
                return;
            }
        };
        let first = self.blocks.last().is_some_and(|open| open.branches == 0);
        let end = if first { None } else { Some(self.emit(Instruction::Jump { target: 0 })) };
        let next = match self.blocks.last_mut() {
            Some(open) => {
                open.ends.extend(end);
                open.branches += 1;
                open.last = items.is_empty();
                std::mem::take(&mut open.next)
            }
            None => Vec::new(),
        };
        self.patch_all(next);
        if !items.is_empty() {
            let mut hits = Vec::new();
            for item in items {
                hits.extend(self.when_item(value, item));
            }
            let miss = self.emit(Instruction::Jump { target: 0 });
            self.patch_all(hits);
            if let Some(open) = self.blocks.last_mut() {
                open.next.push(miss);
            }
        }
        self.trace();
    }

    fn when_item(&mut self, a: Slot, item: &WhenItem) -> Option<usize> {
        match item {
            WhenItem::One(constant) => {
                let value = self.when_constant(constant)?;
                let b = self.constant(value);
                Some(self.emit(Instruction::JumpIfWhen { a, b, target: 0 }))
            }
            WhenItem::Thru(from, to) => {
                let (low, high) = (self.when_constant(from)?, self.when_constant(to)?);
                if low.kind() != high.kind() || low.order(&high).is_none() {
                    self.error(
                        from.span.to(to.span),
                        DiagnosticNumber::BAD_WHEN,
                        "both ends of THRU have one type with an order",
                    );
                    return None;
                }
                let (low_slot, high_slot) = (self.slot(), self.slot());
                self.code.registers.constants.push((low_slot, low));
                self.code.registers.constants.push((high_slot, high));
                Some(self.emit(Instruction::JumpIfThru { a, low: low_slot, target: 0 }))
            }
        }
    }

    fn when_constant(&mut self, expression: &Expr) -> Option<MacroValue> {
        let value = match &expression.kind {
            ExprKind::Real(number) => MacroValue::Real(*number),
            ExprKind::Unary(crate::lex::Sign::Minus, operand) => match operand.kind {
                ExprKind::Real(number) => MacroValue::Real(-number),
                _ => MacroValue::Unset,
            },
            ExprKind::Unary(crate::lex::Sign::Plus, operand) => match operand.kind {
                ExprKind::Real(number) => MacroValue::Real(number),
                _ => MacroValue::Unset,
            },
            ExprKind::Text(text) => MacroValue::text(text.as_str()),
            ExprKind::Logical(truth) => MacroValue::Logical(*truth),
            ExprKind::Null => MacroValue::Null,
            ExprKind::Keyword(code) => MacroValue::Keyword(*code),
            ExprKind::Record(record) => MacroValue::Record(*record),
            ExprKind::Code(_) | ExprKind::Register(_) => {
                let (slot, _) = self.expression(expression, None);
                let found = self.code.registers.constants.iter().find(|(other, _)| *other == slot);
                found.map_or(MacroValue::Unset, |(_, value)| value.clone())
            }
            ExprKind::Sequence(parts) => {
                MacroValue::sequence(parts.iter().filter_map(|part| self.when_constant(part)).collect())
            }
            _ => MacroValue::Unset,
        };
        if matches!(value, MacroValue::Unset) {
            self.error(expression.span, DiagnosticNumber::BAD_WHEN, "a WHEN list takes constants only");
            return None;
        }
        Some(value)
    }

    pub(super) fn open_while(&mut self, condition: &Expr) {
        let top = self.here();
        self.trace();
        let mut ends = Vec::new();
        self.branch(condition, false, &mut ends);
        self.open(CompoundStatement::While, |open| {
            open.ends = ends;
            open.top = top;
        });
    }

    pub(super) fn open_repeat(&mut self) {
        self.trace();
        self.open(CompoundStatement::Repeat, |_| {});
    }

    pub(super) fn until(&mut self, condition: &Expr) {
        if self.blocks.last().is_none_or(|open| open.block != CompoundStatement::Repeat) {
            self.error(self.place, DiagnosticNumber::UNBALANCED, "UNTIL has no REPEAT");
            return;
        }
        self.trace();
        let mut again = Vec::new();
        self.branch(condition, false, &mut again);
        if let Some(open) = self.blocks.pop() {
            again.into_iter().for_each(|jump| self.patch_to(jump, open.top));
            self.patch_all(open.ends);
        }
    }

    pub(super) fn open_do(&mut self, variable: &Expr, range: [&Expr; 2], step: Option<&Expr>) {
        self.trace();
        let (end, step_slot) = (self.slot(), self.slot());
        let reach = match &variable.kind {
            ExprKind::Variable(name) => self.reach(name, variable.span, true),
            _ => ResolvedVariable::Nowhere,
        };
        let (counter, outside) = match reach {
            ResolvedVariable::Local(local) if local.indices == 0 && !local.channel => {
                if let Some(found) = local.kind.filter(|kind| *kind != ValueType::Real) {
                    self.wrong(variable.span, "a number", found);
                }
                (local.slot, None)
            }
            _ => (self.slot(), Some(variable.clone())),
        };
        // All three are evaluated before the variable gets its first value: each may read it.
        let [start, last] = range;
        let first = self.temporary();
        self.number_to(start, first);
        self.number_to(last, end);
        match step {
            Some(step) => self.number_to(step, step_slot),
            None => {
                let one = self.constant(MacroValue::Real(1.0));
                self.emit(Instruction::Move { to: step_slot, a: one });
            }
        }
        self.emit(Instruction::Move { to: counter, a: first });
        let skip = self.emit(Instruction::DoStart { variable: counter, end, target: 0 });
        self.open(CompoundStatement::Do, |open| {
            open.next.push(skip);
            open.value = end;
            open.variable = counter;
            open.outside.clone_from(&outside);
        });
        if let Some(target) = outside {
            self.copy_out(&target, counter);
        }
    }

    /// Compiles a number of a DO.
    fn number_to(&mut self, expression: &Expr, slot: Slot) {
        let (_, kind) = self.expression(expression, Some(slot));
        if let Some(found) = kind.filter(|kind| *kind != ValueType::Real) {
            self.wrong(expression.span, "a number", found);
        }
    }

    fn copy_out(&mut self, target: &Expr, slot: Slot) {
        let (reach, slots) = match &target.kind {
            ExprKind::Variable(variable) => (self.reach(variable, target.span, true), None),
            ExprKind::Element(variable, indices) => {
                let slots = self.indices(indices);
                (self.reach(variable, target.span, true), Some(slots))
            }
            _ => return,
        };
        self.store(&reach, target.span, slots, slot, (Some(ValueType::Real), target.span));
    }

    pub(super) fn end_of(&mut self, block: CompoundStatement) {
        match self.blocks.last() {
            Some(open) if open.block == block => {}
            Some(open) => {
                let line = self.source.line(open.span.start);
                let message = format!("this ends {}, but {} of line {line} is open", name(block), name(open.block));
                self.error(self.place, DiagnosticNumber::UNBALANCED, message);
                if !self.blocks.iter().any(|open| open.block == block) {
                    return;
                }
                while self.blocks.last().is_some_and(|open| open.block != block) {
                    self.blocks.pop();
                }
            }
            None => {
                self.error(self.place, DiagnosticNumber::UNBALANCED, format!("there is no open {}", name(block)));
                return;
            }
        }
        let Some(open) = self.blocks.pop() else { return };
        match block {
            CompoundStatement::If | CompoundStatement::Case => {
                self.patch_all(open.next);
                self.patch_all(open.ends);
                self.trace();
            }
            CompoundStatement::While => {
                self.trace();
                self.emit(Instruction::Jump { target: open.top });
                self.patch_all(open.ends);
            }
            CompoundStatement::Do => {
                self.trace();
                if let Some(outside) = &open.outside {
                    self.expression(outside, Some(open.variable));
                }
                self.emit(Instruction::DoNext { variable: open.variable, end: open.value, target: open.top });
                self.patch_all(open.next);
                if let Some(outside) = &open.outside {
                    self.copy_out(outside, open.variable);
                }
                // EXIT leaves the variable as the body has left it.
                self.patch_all(open.ends);
            }
            CompoundStatement::Repeat => {}
        }
    }

    pub(super) fn exit(&mut self, count: u32) {
        let is_loop = |open: &&mut OpenBlock| {
            matches!(open.block, CompoundStatement::While | CompoundStatement::Repeat | CompoundStatement::Do)
        };
        let jump = self.emit(Instruction::Jump { target: 0 });
        match self.blocks.iter_mut().rev().filter(is_loop).nth(count as usize - 1) {
            Some(open) => open.ends.push(jump),
            None => {
                let message = format!("there are not {count} loops around this EXIT");
                self.error(self.place, DiagnosticNumber::BAD_EXIT, message);
            }
        }
    }

    pub(super) fn label(&mut self, name: &str, span: Span) {
        let here = self.code.ops.len();
        if self.labels.insert(name.to_owned(), here).is_some() {
            self.error(span, DiagnosticNumber::BAD_LABEL, format!("the label {name} is defined twice in this macro"));
        }
    }

    pub(super) fn jump(&mut self, label: &str, span: Span) {
        let jump = self.emit(Instruction::Jump { target: 0 });
        self.jumps.push((jump, label.to_owned(), span));
    }

    pub(super) fn finish_jumps(&mut self) {
        for (jump, label, span) in std::mem::take(&mut self.jumps) {
            match self.labels.get(&label) {
                Some(to) => self.patch_to(jump, u16::try_from(*to).unwrap_or(u16::MAX)),
                None => {
                    let mut labels: Vec<&str> = self.labels.keys().map(String::as_str).collect();
                    labels.sort_unstable();
                    let help = crate::ident::nearest(&label, labels).map(|near| format!("did you mean {near}?"));
                    self.error_with(
                        span,
                        DiagnosticNumber::BAD_LABEL,
                        format!("this macro has no label {label}"),
                        help,
                    );
                }
            }
        }
    }

    pub(super) fn finish_blocks(&mut self) {
        for open in std::mem::take(&mut self.blocks) {
            self.error(open.span, DiagnosticNumber::UNBALANCED, format!("this {} has no end", name(open.block)));
        }
    }
}

fn name(block: CompoundStatement) -> &'static str {
    match block {
        CompoundStatement::If => "IF",
        CompoundStatement::Case => "CASE",
        CompoundStatement::While => "WHILE",
        CompoundStatement::Repeat => "REPEAT",
        CompoundStatement::Do => "DO",
    }
}
