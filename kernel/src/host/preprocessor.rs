//! Settings of the pre-processor: `$FCEPP`.
//!
//! Facts: reference functions.md 9, control-emulator.md 5.4. Invariant: a request that this machine's pre-processor
//! does not have changes nothing, answers false, and is told; one that belongs to another pre-processor names it.

use counterpoint_lang::diag::Number;
use counterpoint_lang::fault::Fault;
use counterpoint_lang::value::Value;
use counterpoint_lang::vm::State;

use crate::channel::Kernel;
use crate::dialect::Setting;
use crate::macros::settings::Settings;

/// Settings that belong to other pre-processors than custom macro.
const FOREIGN: &[(&str, &str)] = &[
    ("PROCESS,SUBPROGRAMS", "Okuma and Siemens"),
    ("PROCESS,SEQNAME", "Okuma"),
    ("APPLYFRAMES", "Siemens"),
    ("GLOBALDEF", "Siemens"),
    ("PROCESSGUDFILES", "Siemens"),
    ("SETFILEROOT", "Siemens and Heidenhain"),
    ("COLLAPSEASSIGNSPACES", "Siemens"),
    ("COLLAPSEASSIGNS", "Siemens"),
    ("SETALSEVERITY", "Siemens"),
    ("CYCLEDEF", "Heidenhain"),
    ("GRAMMAR", "Heidenhain"),
    ("CONCATENATE", "Heidenhain"),
    ("KEEPCYCLDEFQVARS", "Heidenhain"),
];

impl Kernel<'_> {
    /// `$FCEPP`: whether the setting was made.
    pub(crate) fn preprocessor_setting(&mut self, state: &mut State, arguments: &[Value]) -> Value {
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
        let settings = has.then_some(&mut self.macros.variables.store.preprocessor);
        let slot = settings.and_then(|settings| match name.as_str() {
            "PROCESS,COMMENTS" => settings.taken_off.get_mut(0),
            "PROCESS,MESSAGES" => settings.taken_off.get_mut(1),
            "PROCESS,SYSVARASSIGNMENT" => Some(&mut settings.asks),
            "USENULL" => Some(&mut settings.null),
            _ => None,
        });
        let foreign = FOREIGN.iter().find(|(setting, _)| *setting == name);
        let message = match (slot, on, foreign) {
            (Some(slot), Some(on), _) => {
                *slot = on;
                return Value::Logical(true);
            }
            (Some(_), None, _) => format!("the setting {name} of the pre-processor is .TRUE. or .FALSE."),
            (None, _, Some((_, owner))) => format!("{name} is a setting of the pre-processor of {owner}"),
            (None, ..) => "the pre-processor of this machine has no such setting".to_owned(),
        };
        state.warn(Fault::new(Number::NO_SETTING, message));
        Value::Logical(false)
    }

    fn settings(&mut self) -> &mut Settings {
        &mut self.macros.variables.store.preprocessor
    }

    /// What has no value counts as 0.
    pub(crate) fn reads_zero(&mut self) -> bool {
        !self.settings().null
    }

    /// The value kept for a system variable.
    pub(crate) fn kept_variable(&mut self, index: u32) -> Option<f64> {
        self.settings().kept.get(&index).copied()
    }

    /// Keeps the value of a system variable, if that is what writing it does.
    pub(crate) fn keep_variable(&mut self, index: u32, value: f64) -> bool {
        let settings = self.settings();
        let keeps = !settings.asks && index >= 1000;
        if keeps {
            settings.kept.insert(index, value);
        }
        keeps
    }
}
