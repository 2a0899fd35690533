//! State that survives from macro to macro: variables of the object, registers of macros, open units, budgets, caches.
//!
//! *Invariant:* it knows values only, neither code nor host, so that hosts and functions may be handed it.

mod compiled;
mod frame;
pub(crate) mod memory;
mod unit;
mod values;

pub use compiled::Compiled;
pub use memory::MemoryTally;
pub use values::{range, sequence_of};

pub(crate) use frame::{FrameTable, MacroFrame};
pub(crate) use unit::{LINE, OpenUnit, unit_number};
pub(crate) use values::{
    detached, pay_if_shared, pay_to_append, pay_to_look, pay_to_look_inside, pay_to_write, typed, weight, whole,
};

use crate::diag::DiagnosticNumber;
use crate::fault::{MacroFault, Outcome};
use crate::format::StringFormat;
use crate::pattern::TextPattern;
use crate::value::MacroValue;
use rustc_hash::FxHashMap;
use std::sync::Arc;

/// The resource limits of macros.
#[derive(Clone, Copy, Debug)]
pub struct MacroLimits {
    /// Instructions of one run of a macro with everything it calls.
    pub ticks: u64,
    /// Macros active at once.
    pub depth: u32,
    /// Bytes of a text.
    pub text: usize,
    /// Elements of a sequence or an array.
    pub elements: usize,
    /// Units open at once.
    pub units: usize,
    /// Bytes that the values of all macros may keep.
    pub memory: usize,
}

impl Default for MacroLimits {
    fn default() -> MacroLimits {
        MacroLimits {
            ticks: 50_000_000,
            depth: 100_000,
            text: 1 << 20,
            elements: 1_000_000,
            units: 10,
            memory: 256 << 20,
        }
    }
}

/// Everything that lives from macro to macro: the object's variables, open units, budgets, caches.
#[derive(Debug)]
pub struct MacroState {
    /// Budgets.
    pub limits: MacroLimits,
    /// Ticks left; set by `vm::run` for the outermost macro.
    pub ticks: u64,
    /// Macros active now.
    pub depth: u32,
    /// `$ERRNO`
    pub status: i32,
    /// `$CI`, 1-based.
    pub channel: u32,
    /// `$CHSIZ`
    pub channels: u32,
    /// A diagnostic of severity 8 or more was reported.
    pub failed: bool,
    pub(crate) objects: Objects,
    pub(crate) calls: FrameTable,
    pub(crate) units: FxHashMap<u8, OpenUnit>,
    compiled: Compiled,
    /// Arguments of a function, kept for the next one.
    pub(crate) buffer: Vec<MacroValue>,
    pub(crate) notes: Vec<MacroFault>,
    /// Ticks left when it was last asked whether the run is to end.
    pub(crate) looked: u64,
    pub(crate) memory: memory::MacroMemory,
}

/// Variables of the object's store.
#[derive(Debug, Default)]
pub(crate) struct Objects {
    pub(crate) values: Vec<MacroValue>,
    /// Shared variables that lie in registers of the running macro, a bit each.
    pub(crate) at_home: u64,
}

impl MacroState {
    /// A fresh state.
    #[must_use]
    pub fn new(limits: MacroLimits) -> MacroState {
        MacroState {
            limits,
            ticks: limits.ticks,
            depth: 0,
            status: 0,
            channel: 1,
            channels: 1,
            failed: false,
            objects: Objects::default(),
            calls: FrameTable::default(),
            units: FxHashMap::default(),
            compiled: Compiled::default(),
            buffer: Vec::new(),
            notes: Vec::new(),
            looked: limits.ticks,
            memory: memory::MacroMemory::new(limits.memory),
        }
    }

    /// A variable of the object's store.
    pub fn object(&mut self, index: u32) -> Option<&mut MacroValue> {
        let index = index as usize;
        if self.objects.values.len() <= index {
            self.objects.values.resize(index + 1, MacroValue::Unset);
        }
        self.objects.values.get_mut(index)
    }

    /// The compiled form of a format text, remembered.
    ///
    /// # Errors
    /// The format is malformed.
    pub fn format(&mut self, text: &str, input: bool) -> Outcome<Arc<StringFormat>> {
        if let Some(format) = self.compiled.format(text, input) {
            return Ok(format);
        }
        self.spend(text.len() / 16)?;
        let format = Arc::new(if input { StringFormat::input(text)? } else { StringFormat::output(text)? });
        self.compiled.remember_format(text, input, &format);
        Ok(format)
    }

    /// The compiled form of a regular expression, remembered.
    ///
    /// # Errors
    /// The expression is malformed.
    pub fn pattern(&mut self, text: &str) -> Outcome<Arc<TextPattern>> {
        if let Some(pattern) = self.compiled.pattern(text) {
            return Ok(pattern);
        }
        self.spend(text.len() / 16)?;
        let pattern = Arc::new(TextPattern::new(text)?);
        self.spend(pattern.size() / 64)?;
        self.compiled.remember_pattern(text, &pattern);
        Ok(pattern)
    }

    /// Refuses a text that is too long.
    ///
    /// # Errors
    /// The text is larger than the budget.
    pub fn check_text(&self, length: usize) -> Outcome<()> {
        if length <= self.limits.text {
            return Ok(());
        }
        Err(MacroFault::new(DiagnosticNumber::SIZE, format!("a text has more than {} bytes", self.limits.text)))
    }

    /// Refuses a sequence or array that is too long.
    ///
    /// # Errors
    /// There are more elements than the budget allows.
    pub fn check_elements(&self, length: usize) -> Outcome<()> {
        if length <= self.limits.elements {
            return Ok(());
        }
        Err(MacroFault::new(DiagnosticNumber::SIZE, format!("there are more than {} elements", self.limits.elements)))
    }

    /// Notes a warning of a function that continues with `$NULL`; it is reported with the place of the
    /// call, as a warning at most.
    pub fn warn(&mut self, fault: MacroFault) {
        self.notes.push(fault);
    }

    /// Uses up ticks for work done inside one instruction.
    ///
    /// # Errors
    /// None are left.
    #[inline]
    pub fn spend(&mut self, ticks: usize) -> Outcome<()> {
        let ticks = ticks as u64;
        if self.ticks < ticks {
            self.ticks = 0;
            return Err(MacroFault::new(
                DiagnosticNumber::TICKS,
                format!("the budget of {} steps is exhausted", self.limits.ticks),
            ));
        }
        self.ticks -= ticks;
        Ok(())
    }
}
