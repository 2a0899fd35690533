//! Stage *pre-process*: a statement is executed, and the words that it makes continue as any others.
//!
//! Facts: reference control-emulator.md 2.2, 5.4.

use counterpoint_fault::Acted;

use crate::channel::Kernel;

impl Kernel<'_> {
    /// Lets the pre-processor execute a statement; the words that it makes act on the way.
    #[inline(never)]
    pub(crate) fn statement_block(&mut self, text: &[u8]) -> Acted {
        let hooks = self.plan.hooks;
        if let Some(hooks) = hooks {
            (hooks.block.statement)(self, text)?;
        }
        self.statement_line(text)?;
        hooks.map_or(Ok(()), |hooks| (hooks.block.consumed)(self))
    }

    /// Continues with words that the pre-processor made.
    pub(crate) fn made_words(&mut self) -> Acted {
        if let Some(hooks) = self.plan.hooks {
            (hooks.block.made)(self)?;
        }
        self.words()
    }
}
