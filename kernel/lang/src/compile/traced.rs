//! A program compiled a second time, for the trace.
//!
//! *Invariant:* code that ran without a trace runs with one, under the same index. Facts: reference
//! listing-and-trace.md 6.

use std::sync::Arc;

use super::{Added, CompileOptions, MacroProgram, load};
use crate::host::CompileEnvironment;
use crate::source::MacroSource;

/// The program compiled once more, with trace instructions in it: every macro has the index that it has here. `program`
/// holds no embedded code.
#[must_use]
pub fn traced(program: &MacroProgram, environment: &mut dyn CompileEnvironment) -> MacroProgram {
    let mut kept = RecompileEnvironment { environment, included: &program.included };
    let mut again = MacroProgram::new();
    for (source, options) in &program.sources {
        let options = CompileOptions { trace: true, ..*options };
        load(&mut again, &mut kept, source, options, &mut Added::default(), 0);
    }
    // With trace instructions a macro may have become too large; then it goes without.
    for (traced, plain) in again.macros.iter_mut().zip(&program.macros) {
        if traced.ops.is_empty() {
            *traced = Arc::new(super::inline::undone(plain));
        }
    }
    again
}

/// An environment whose included files are those of an earlier compilation.
struct RecompileEnvironment<'a> {
    environment: &'a mut dyn CompileEnvironment,
    included: &'a [(String, Option<Arc<MacroSource>>)],
}

impl CompileEnvironment for RecompileEnvironment<'_> {
    fn system(&self) -> &[crate::host::SystemVariable] {
        self.environment.system()
    }

    fn code(&self, name: &str) -> Option<u32> {
        self.environment.code(name)
    }

    fn register(&self, name: &str) -> Option<u32> {
        self.environment.register(name)
    }

    fn identifiers(&self) -> Vec<String> {
        self.environment.identifiers()
    }

    fn include(&mut self, name: &str, _: &str) -> Option<MacroSource> {
        let (_, source) = self.included.iter().find(|(known, _)| known == name)?;
        source.as_deref().cloned()
    }
}
