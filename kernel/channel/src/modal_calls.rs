//! Modal calls of custom macros, innermost last.

use crate::callee::Callee;
use crate::calling_words::CallingWord;

/// A macro that blocks call.
#[derive(Debug)]
pub struct ModalCall {
    /// The program.
    pub what: Callee,
    /// Passes of each call.
    pub passes: u32,
    /// Local variables of its macro: the arguments, and the values that the calls have left in them.
    pub arguments: Vec<(u8, f64)>,
    /// Every block calls, with its own words.
    pub each: bool,
    /// Macro calls that were running when it was made.
    pub level: usize,
    /// The word that made it, if that calls by itself.
    pub by: Option<CallingWord>,
}

/// The active modal calls, the last one made at the end.
#[derive(Debug, Default)]
pub struct ModalCalls {
    /// The calls, the last one made at the end.
    pub calls: Vec<ModalCall>,
    /// The modal call that makes the next call.
    pub calling: Option<usize>,
}

/// Maximum number of active modal calls; a further call replaces the last one.
const MOST: usize = 64;

impl ModalCalls {
    /// Whether no modal call is active.
    pub fn is_empty(&self) -> bool {
        self.calls.is_empty()
    }

    /// Makes a modal call active.
    pub fn push(&mut self, call: ModalCall) {
        if self.calls.len() >= MOST {
            self.calls.pop();
        }
        self.calls.push(call);
    }

    /// Takes the last one away.
    pub fn pop(&mut self) -> Option<ModalCall> {
        self.calls.pop()
    }

    /// Which one makes the call that begins; none for other calls.
    pub fn take_caller(&mut self) -> Option<usize> {
        self.calling.take()
    }

    /// A call by one of them is over: the next call finds its variables unchanged. Only G66 sets arguments.
    pub fn keep(&mut self, caller: usize, variables: impl Iterator<Item = (u8, f64)>) {
        if let Some(call) = self.calls.get_mut(caller).filter(|call| !call.each) {
            call.arguments.clear();
            call.arguments.extend(variables);
        }
    }

    /// Trigger of the calls: 66 for every block that moves, 66.1 for every block; none without a modal call.
    pub fn word(&self) -> Option<f64> {
        self.calls.last().map(|call| if call.each { 66.1 } else { 66.0 })
    }

    /// Ends those of macros that have ended.
    pub fn leave(&mut self, level: usize) {
        self.calls.retain(|call| call.level <= level);
    }
}
