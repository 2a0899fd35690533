//! Output, reports and trace of macros, and the commands that would go to a control.

use counterpoint_lang::diag::MacroDiagnostic;

/// The output of macros while nothing was attached.
#[derive(Debug, Default)]
pub struct MacroOutput {
    /// Text printed by PPRINT and text written to the console.
    pub printed: Vec<String>,
    /// Commands for the control, one line each.
    pub commands: Vec<String>,
    /// Reported diagnostics.
    pub diagnostics: Vec<MacroDiagnostic>,
    /// Lines of the trace.
    pub traced: Vec<String>,
    /// The attached output accepts no more lines.
    pub(crate) closed: bool,
}
