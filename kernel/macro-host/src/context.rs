//! A running kernel as its macros see it: as the host of the language, and at the points where macros take part.
//!
//! *Invariant:* both views are borrowed from the same kernel for one call; neither has a state of its own.

use counterpoint_emulator::channel::Kernel;

/// A kernel as the host of its macros: their commands, functions and variables.
pub(crate) struct KernelHost<'k, 'a> {
    pub(crate) kernel: &'k mut Kernel<'a>,
}

/// A kernel at the points where macros take part in its work.
pub(crate) struct MacroHooks<'k, 'a> {
    pub(crate) kernel: &'k mut Kernel<'a>,
}

impl<'k, 'a> KernelHost<'k, 'a> {
    /// The host of the macros of a kernel.
    pub(crate) fn new(kernel: &'k mut Kernel<'a>) -> Self {
        Self { kernel }
    }

    /// The same kernel at the points where macros take part.
    pub(crate) fn hooks(&mut self) -> MacroHooks<'_, 'a> {
        MacroHooks { kernel: self.kernel }
    }
}

impl<'k, 'a> MacroHooks<'k, 'a> {
    /// The points of a kernel where macros take part.
    pub(crate) fn new(kernel: &'k mut Kernel<'a>) -> Self {
        Self { kernel }
    }

    /// The same kernel as the host of its macros.
    pub(crate) fn host(&mut self) -> KernelHost<'_, 'a> {
        KernelHost { kernel: self.kernel }
    }
}
