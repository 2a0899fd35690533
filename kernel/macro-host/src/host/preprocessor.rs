//! Settings of the pre-processor: `$FCEPP`.
//!
//! Facts: reference functions.md 9, control-emulator.md 5.4. *Invariant:* a request that this machine's pre-processor
//! does not have changes nothing, answers false, and is reported; one that belongs to another pre-processor names it.

use counterpoint_lang::diag::DiagnosticNumber;
use counterpoint_lang::fault::MacroFault;
use counterpoint_lang::value::MacroValue;
use counterpoint_lang::vm::MacroState;

use crate::context::KernelHost;
use counterpoint_control_api::{self, SettingOutcome};

/// Titles of the dialects that have a setting, none if there is no such one.
fn owners(setting: &str) -> Option<String> {
    let owners = counterpoint_controls::all().filter(|dialect| dialect.settings().contains(&setting));
    let titles: Vec<&str> = owners.map(|dialect| dialect.title()).collect();
    (!titles.is_empty()).then(|| titles.join(" and "))
}

impl KernelHost<'_, '_> {
    /// `$FCEPP`: whether the setting was made.
    pub(crate) fn preprocessor_setting(&mut self, state: &mut MacroState, arguments: &[MacroValue]) -> MacroValue {
        let word =
            |at: usize| arguments.get(at).and_then(MacroValue::as_text).map(|text| text.trim().to_ascii_uppercase());
        let first = word(0).unwrap_or_default();
        let (name, at) = match word(1).filter(|_| first == "PROCESS") {
            Some(second) => (format!("{first},{second}"), 2),
            None => (first, 1),
        };
        let values = arguments.get(at..).unwrap_or_default();
        let made = self.kernel.with_interpreter(|interpreter, kernel| interpreter.setting(kernel, &name, values));
        let made = match made.unwrap_or(SettingOutcome::Unknown) {
            SettingOutcome::Unknown => self.common_setting(&name, values),
            made => made,
        };
        let message = match (made, owners(&name)) {
            (SettingOutcome::Made, _) => return MacroValue::Logical(true),
            (SettingOutcome::Wrong, _) => format!("the setting {name} of the pre-processor cannot have this value"),
            (SettingOutcome::NotLogical, _) => format!("the setting {name} of the pre-processor is .TRUE. or .FALSE."),
            (SettingOutcome::Unknown, Some(owner)) => format!("{name} is a setting of the pre-processor of {owner}"),
            (SettingOutcome::Unknown, None) => "the pre-processor of this machine has no such setting".to_owned(),
        };
        state.warn(MacroFault::new(DiagnosticNumber::NO_SETTING, message));
        MacroValue::Logical(false)
    }

    /// A setting that all pre-processors have.
    fn common_setting(&mut self, name: &str, values: &[MacroValue]) -> SettingOutcome {
        if !self.kernel.channel.tables.scanner.has_preprocessor() {
            return SettingOutcome::Unknown;
        }
        let [comments, messages] = &mut self.kernel.macros.variables.store.preprocessor.taken_off;
        let slot = match name {
            "PROCESS,COMMENTS" => comments,
            "PROCESS,MESSAGES" => messages,
            _ => return SettingOutcome::Unknown,
        };
        let [value] = values else { return SettingOutcome::NotLogical };
        let Some(on) = value.as_logical() else { return SettingOutcome::NotLogical };
        *slot = on;
        SettingOutcome::Made
    }
}
