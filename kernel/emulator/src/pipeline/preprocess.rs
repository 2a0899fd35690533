//! Stage *pre-process*: a statement is executed, and the words that it makes continue as any others.
//!
//! Facts: reference control-emulator.md 2.2, 5.4.

use counterpoint_fault::Acted;

use crate::channel::Kernel;
use crate::pipeline::act_words;

impl Kernel<'_> {
    /// Continues with words that the pre-processor made.
    pub(crate) fn made_words(&mut self) -> Acted {
        if let Some(hooks) = self.plan.hooks {
            (hooks.block.made)(self)?;
        }
        act_words(self)
    }
}

/// Lets the pre-processor execute a statement; the words that it makes act on the way.
#[inline(never)]
pub(crate) fn statement_block(kernel: &mut Kernel<'_>, text: &[u8]) -> Acted {
    let hooks = kernel.plan.hooks;
    if let Some(hooks) = hooks {
        (hooks.block.statement)(kernel, text)?;
    }
    kernel.statement_line(text)?;
    hooks.map_or(Ok(()), |hooks| (hooks.block.consumed)(kernel))
}
