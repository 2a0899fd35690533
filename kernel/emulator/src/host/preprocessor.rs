//! Settings of the pre-processor: `$FCEPP`.
//!
//! Facts: reference functions.md 9, control-emulator.md 5.4. *Invariant:* a request that this machine's pre-processor
//! does not have changes nothing, answers false, and is reported; one that belongs to another pre-processor names it.

use counterpoint_lang::diag::Number;
use counterpoint_lang::fault::Fault;
use counterpoint_lang::value::Value;
use counterpoint_lang::vm::State;

use crate::channel::Kernel;
use counterpoint_dialect::{self, Setting};

/// Titles of the dialects that have a setting, none if there is no such one.
fn owners(setting: &str) -> Option<String> {
    let owners = counterpoint_dialect::all().filter(|dialect| dialect.settings().contains(&setting));
    let titles: Vec<&str> = owners.map(|dialect| dialect.title()).collect();
    (!titles.is_empty()).then(|| titles.join(" and "))
}

impl Kernel<'_> {
    /// `$FCEPP`: whether the setting was made.
    pub(crate) fn preprocessor_setting(&mut self, state: &mut State, arguments: &[Value]) -> Value {
        let word = |at: usize| arguments.get(at).and_then(Value::as_text).map(|text| text.trim().to_ascii_uppercase());
        let first = word(0).unwrap_or_default();
        let (name, at) = match word(1).filter(|_| first == "PROCESS") {
            Some(second) => (format!("{first},{second}"), 2),
            None => (first, 1),
        };
        let values = arguments.get(at..).unwrap_or_default();
        let made = self.with_interpreter(|interpreter, kernel| interpreter.setting(kernel, &name, values));
        let made = match made.unwrap_or(Setting::Unknown) {
            Setting::Unknown => self.common_setting(&name, values),
            made => made,
        };
        let message = match (made, owners(&name)) {
            (Setting::Made, _) => return Value::Logical(true),
            (Setting::Wrong, _) => format!("the setting {name} of the pre-processor cannot have this value"),
            (Setting::NotLogical, _) => format!("the setting {name} of the pre-processor is .TRUE. or .FALSE."),
            (Setting::Unknown, Some(owner)) => format!("{name} is a setting of the pre-processor of {owner}"),
            (Setting::Unknown, None) => "the pre-processor of this machine has no such setting".to_owned(),
        };
        state.warn(Fault::new(Number::NO_SETTING, message));
        Value::Logical(false)
    }

    /// A setting that all pre-processors have.
    fn common_setting(&mut self, name: &str, values: &[Value]) -> Setting {
        if !self.plan.scanner.has_preprocessor() {
            return Setting::Unknown;
        }
        let [comments, messages] = &mut self.macros.variables.store.preprocessor.taken_off;
        let slot = match name {
            "PROCESS,COMMENTS" => comments,
            "PROCESS,MESSAGES" => messages,
            _ => return Setting::Unknown,
        };
        let [value] = values else { return Setting::NotLogical };
        let Some(on) = value.as_logical() else { return Setting::NotLogical };
        *slot = on;
        Setting::Made
    }
}
