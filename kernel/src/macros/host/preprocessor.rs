//! Settings of the pre-processor: `$FCEPP`.
//!
//! Facts: reference functions.md 9, control-emulator.md 5.4. Invariant: a request that this machine's pre-processor
//! does not have changes nothing, answers false, and is told; one that belongs to another pre-processor names it.

use counterpoint_lang::diag::Number;
use counterpoint_lang::fault::Fault;
use counterpoint_lang::value::Value;
use counterpoint_lang::vm::State;
use rustc_hash::FxHashMap;

use crate::channel::Kernel;
use crate::dialect::{self, Setting};

/// What macros have set.
#[derive(Debug)]
pub(crate) struct Settings {
    /// Comments and messages are taken off the block.
    pub(crate) taken_off: [bool; 2],
    /// A variable without a value is vacant; otherwise it, and one that does not exist, is 0.
    null: bool,
    /// The identification macro is asked where to write a system variable; otherwise its value is kept.
    asks: bool,
    /// Values kept for system variables.
    kept: FxHashMap<u32, f64>,
}

impl Default for Settings {
    fn default() -> Self {
        Self { taken_off: [true; 2], null: true, asks: true, kept: FxHashMap::default() }
    }
}

/// Titles of the dialects that have a setting, none if there is no such one.
fn owners(setting: &str) -> Option<String> {
    let owners = dialect::all().filter(|dialect| dialect.settings().contains(&setting));
    let titles: Vec<&str> = owners.map(|dialect| dialect.title()).collect();
    (!titles.is_empty()).then(|| titles.join(" and "))
}

impl Kernel<'_> {
    /// `$FCEPP`: whether the setting was made.
    pub(super) fn preprocessor_setting(&mut self, state: &mut State, arguments: &[Value]) -> Value {
        let word = |at: usize| arguments.get(at).and_then(Value::as_text).map(|text| text.trim().to_ascii_uppercase());
        let first = word(0).unwrap_or_default();
        let (name, at) = match word(1).filter(|_| first == "PROCESS") {
            Some(second) => (format!("{first},{second}"), 2),
            None => (first, 1),
        };
        if let Some(interpreter) = self.dialect.interpreter.as_deref_mut() {
            let common = matches!(name.as_str(), "PROCESS,COMMENTS" | "PROCESS,MESSAGES");
            let made = interpreter.setting(&name, arguments.get(at..).unwrap_or_default());
            match made {
                Setting::Made => return Value::Logical(true),
                Setting::Wrong => {
                    let text = format!("the setting {name} of the pre-processor cannot have this value");
                    state.warn(Fault::new(Number::NO_SETTING, text));
                    return Value::Logical(false);
                }
                Setting::Unknown if !common => {
                    let text = format!("the pre-processor of this machine has no setting {name}");
                    state.warn(Fault::new(Number::NO_SETTING, text));
                    return Value::Logical(false);
                }
                Setting::Unknown => {}
            }
        }
        let on = arguments.get(at).and_then(Value::as_logical).filter(|_| arguments.len() == at + 1);
        let has = self.plan.scanner.has_preprocessor();
        let settings = self.macros.as_deref_mut().map(|runtime| &mut runtime.store.preprocessor).filter(|_| has);
        let slot = settings.and_then(|settings| match name.as_str() {
            "PROCESS,COMMENTS" => settings.taken_off.get_mut(0),
            "PROCESS,MESSAGES" => settings.taken_off.get_mut(1),
            "PROCESS,SYSVARASSIGNMENT" => Some(&mut settings.asks),
            "USENULL" => Some(&mut settings.null),
            _ => None,
        });
        let message = match (slot, on, owners(&name)) {
            (Some(slot), Some(on), _) => {
                *slot = on;
                return Value::Logical(true);
            }
            (Some(_), None, _) => format!("the setting {name} of the pre-processor is .TRUE. or .FALSE."),
            (None, _, Some(owner)) => format!("{name} is a setting of the pre-processor of {owner}"),
            (None, ..) => "the pre-processor of this machine has no such setting".to_owned(),
        };
        state.warn(Fault::new(Number::NO_SETTING, message));
        Value::Logical(false)
    }

    fn settings(&mut self) -> Option<&mut Settings> {
        self.macros.as_deref_mut().map(|runtime| &mut runtime.store.preprocessor)
    }

    /// What has no value counts as 0.
    pub(crate) fn reads_zero(&mut self) -> bool {
        self.settings().is_some_and(|settings| !settings.null)
    }

    /// The value kept for a system variable.
    pub(crate) fn kept_variable(&mut self, index: u32) -> Option<f64> {
        self.settings()?.kept.get(&index).copied()
    }

    /// Keeps the value of a system variable, if that is what writing it does.
    pub(crate) fn keep_variable(&mut self, index: u32, value: f64) -> bool {
        let Some(settings) = self.settings().filter(|settings| !settings.asks && index >= 1000) else { return false };
        settings.kept.insert(index, value);
        true
    }
}
