//! Methods by which a kernel waits.

use corosensei::Yielder;

/// Why a kernel lets its thread run another one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum YieldReason {
    /// It has nothing to do until it is signalled.
    Sleep,
    /// It needs an empty chunk, which the merger gives back.
    Chunk,
    /// An operator steps through the job and chooses the next kernel.
    Step,
    /// The kernel is about to ask an operator, which may take long: the events so far go into the log first.
    Question,
}

/// How a kernel waits.
#[derive(Clone, Copy)]
pub enum WaitMethod<'a> {
    /// Its thread sleeps.
    Thread,
    /// Its thread runs another kernel.
    Coroutine(&'a Yielder<(), YieldReason>),
}
