//! Rules by which a machine refuses blocks, as masks of registers and rows, determined once.

use crate::block::Block;
use counterpoint_machine::Machine;
use counterpoint_machine::ident::{CodeId, codes};
use counterpoint_machine::index::{CodeRowId, IdTable, RegisterId};
use counterpoint_machine::refusals::{BlockRefusal, CodeReference};
use counterpoint_machine::rows::CodeRow;
use counterpoint_machine::tables::form_range;

/// The rules of a machine, by their subjects.
#[derive(Debug)]
pub struct Refusals {
    /// Rules that look for each code row, bit by rule.
    pub rows: IdTable<CodeRowId, u64>,
    /// Rules without codes that look for words of each register, bit by rule.
    pub free: IdTable<RegisterId, u64>,
    /// Those registers, bit by register.
    pub registers: u128,
    /// Rules that count while taps are rigid only, bit by rule: most of them look at every move.
    pub rigid: u64,
    /// The same while the path is on a face or a cylinder: these rules test every circle and rapid move.
    pub wrapped: u64,
    /// Conditions of the first 63 rules for the words of a block.
    pub words: Vec<WordCondition>,
}

/// A value below this is zero.
pub const NOTHING: f64 = 0.000_1;

/// Stands among the registers of a block for a rule that looks for none; no register has this bit.
const ANY_BLOCK: u128 = 1 << 127;

/// Condition of a rule for the words of a block, bit by register.
#[derive(Debug)]
pub struct WordCondition {
    /// One of these is there.
    pub one: u128,
    /// All of these are.
    pub all: u128,
    /// None of these is.
    none: u128,
}

impl WordCondition {
    /// The condition of a rule for words.
    pub fn of(rule: &BlockRefusal) -> Self {
        let one = if rule.with == 0 { ANY_BLOCK } else { rule.with };
        Self { one, all: rule.all | rule.word.map_or(0, |word| word.register.bit()), none: rule.without }
    }

    /// Whether the words of a block, bit by register, fulfil the condition.
    #[inline(always)]
    pub fn fit(&self, words: u128) -> bool {
        words & self.one != 0 && words & self.all == self.all && words & self.none == 0
    }
}

impl Refusals {
    /// `None` where the machine has no rules.
    pub fn new(machine: &Machine) -> Option<Box<Self>> {
        if machine.diagnostics.refusals.is_empty() {
            return None;
        }
        let rules = |of: &dyn Fn(&BlockRefusal) -> bool| {
            let found = machine.diagnostics.refusals.iter().enumerate().filter(|(_, rule)| of(rule));
            found.fold(0, |bits, (at, _)| bits | bit(at))
        };
        let looks = |row: &CodeRow| {
            rules(&|rule| {
                let word = rule.word.filter(|_| rule.codes.is_empty());
                let own = word.is_some_and(|word| form_range(&row.form).is_some_and(|(at, ..)| at == word.register));
                own || rule.codes.iter().any(|code| may_be(code, row))
            })
        };
        let free =
            |of: RegisterId| rules(&|rule| rule.codes.is_empty() && rule.word.is_some_and(|word| word.register == of));
        let free = machine.registers.map(|register, _| free(register));
        let registers =
            free.entries().filter(|(_, rules)| **rules != 0).fold(0, |bits, (register, _)| bits | register.bit());
        let rows = machine.codes.map(|_, row| looks(row));
        let words = machine.diagnostics.refusals.iter().take(63).map(WordCondition::of).collect();
        let only_while = |of: &[CodeId]| {
            rules(&|rule| !rule.active.is_empty() && rule.active.iter().all(|state| of.contains(&state.id))) & !bit(63)
        };
        let rigid = only_while(&[codes::RIGID_ON]);
        let wrapped = only_while(&[codes::C2P_CART_ON, codes::CYLINDER_ON]);
        Some(Box::new(Self { rows, free, registers, rigid, wrapped, words }))
    }

    /// Registers of the block, bit by register, and the rules without codes that look for them.
    #[inline(always)]
    pub fn looked_for(&self, block: &Block) -> (u128, u64) {
        let words = block.words.iter().map(|word| word.register);
        words.fold((ANY_BLOCK, 0), |(words, rules), register| (words | register.bit(), rules | self.free[register]))
    }

    /// Of these rules those whose wants of the words of a block are met; the last bit stays as it is.
    pub fn fitting(&self, rules: u64, words: u128) -> u64 {
        let (mut left, mut fitting) = (rules & !bit(63), rules & bit(63));
        while left != 0 {
            let rule = left & left.wrapping_neg();
            left ^= rule;
            if self.words.get(rule.trailing_zeros() as usize).is_some_and(|wants| wants.fit(words)) {
                fitting |= rule;
            }
        }
        fitting
    }
}

/// The bit of a rule; the last one stands for all rules that have none of their own.
pub fn bit(rule: usize) -> u64 {
    1 << rule.min(63)
}

/// Whether some value of the row is named by the rule.
fn may_be(code: &CodeReference, row: &CodeRow) -> bool {
    match *code {
        CodeReference::Id(id) => row.id == id,
        CodeReference::Word { register, min, max } => {
            form_range(&row.form).is_some_and(|(own, from, to)| own == register && from <= max && min <= to)
        }
    }
}
