//! The settings of `$FCEPP`.
//!
//! Facts: Heidenhain pre-processor page (configurable options), reference functions.md 9. Decisions: blocks that end in
//! `~` are joined unless CONCATENATE is switched off, definitions of cycles are in any case; parameters of a cycle stay
//! in its block where a register of the machine takes them, until KEEPCYCLDEFQVARS says all or none. Invariant: a
//! setting that cannot be made changes nothing.

use counterpoint_lang::value::MacroValue;

use counterpoint_control_api::interpreter::SettingOutcome;
use counterpoint_machine::stored::StoredFile;

/// Settings of a kernel.
#[derive(Debug)]
pub(super) struct HeidenhainSettings {
    /// Blocks that end in `~` continue in the next line.
    pub(super) joins: bool,
    /// All parameters of a cycle stay in its block, or none; by default those that a register takes.
    pub(super) keeps: Option<bool>,
    /// Cycles that are subprograms of the machine.
    pub(super) cycles: Vec<u32>,
    /// Those of them that need the spindle on.
    pub(super) spindle_cycles: Vec<u32>,
    /// Where programs are looked for in the end.
    pub(super) root: String,
    /// ISO or conversational, regardless of the text of the program.
    pub(super) iso: Option<bool>,
}

impl Default for HeidenhainSettings {
    fn default() -> Self {
        Self {
            joins: true,
            keeps: None,
            cycles: Vec::new(),
            spindle_cycles: Vec::new(),
            root: StoredFile::ROOT.to_owned(),
            iso: None,
        }
    }
}

impl HeidenhainSettings {
    pub(super) fn make(&mut self, name: &str, values: &[MacroValue]) -> SettingOutcome {
        let logical = values.first().and_then(MacroValue::as_logical).filter(|_| values.len() == 1);
        let text = values.first().and_then(MacroValue::as_text).filter(|_| values.len() == 1);
        let made = match name {
            "CONCATENATE" => logical.map(|on| self.joins = on),
            "KEEPCYCLDEFQVARS" => logical.map(|on| self.keeps = Some(on)),
            "SETFILEROOT" => text.map(|root| {
                let root = root.trim().replace('\\', "/");
                self.root = if root.is_empty() || root.ends_with('/') { root } else { format!("{root}/") };
            }),
            "GRAMMAR" => text
                .and_then(|grammar| match grammar.trim().to_ascii_uppercase().as_str() {
                    "ISO" => Some(true),
                    "CONV" => Some(false),
                    _ => None,
                })
                .map(|iso| self.iso = Some(iso)),
            "CYCLEDEF" => cycles(values).map(|cycles| self.cycles = cycles),
            "SPINDLECYCLES" => cycles(values).map(|cycles| self.spindle_cycles = cycles),
            _ => return SettingOutcome::Unknown,
        };
        if made.is_some() { SettingOutcome::Made } else { SettingOutcome::Wrong }
    }
}

/// Numbers of cycles: a sequence, or one after the other.
fn cycles(values: &[MacroValue]) -> Option<Vec<u32>> {
    let mut out = Vec::new();
    for value in values {
        let several;
        let numbers = match value {
            MacroValue::Sequence(sequence) => sequence.as_slice(),
            other => {
                several = [other.clone()];
                &several
            }
        };
        for number in numbers {
            let number = number.as_real().filter(|n| *n >= 0.0 && n.fract() == 0.0 && *n < 1e6)?;
            out.push(number as u32);
        }
    }
    (!values.is_empty()).then_some(out)
}
