//! `$FCEPP` settings of this control, and names as macros write them.
//!
//! Facts: reference functions.md 9. Decision: unless COLLAPSEASSIGNS is set, `=` is removed if the machine has a
//! register for the address alone and not for the address with its `=`. Invariant: blanks around `=` are always removed
//! from a word.

use counterpoint_lang::value::MacroValue;

use super::compiled::{Expression, IndexedName, as_name};
use super::expression::whole;
use super::value::Data;
use counterpoint_control_api::interpreter::SettingOutcome;

/// Settings.
#[derive(Debug)]
pub(super) struct SiemensSettings {
    /// MSG is executed here.
    pub(super) messages: bool,
    /// Subprograms are called here.
    pub(super) subprograms: bool,
    /// Definitions without a scope are those of the channel.
    pub(super) global: bool,
    /// Frames that are assigned act.
    pub(super) applies_frames: bool,
    /// Whether `X=5` becomes `X5`.
    pub(super) collapse: Option<bool>,
    /// Severity of SETAL; without one the number of the alarm determines the effect.
    pub(super) severity: Option<u8>,
    /// Folder of the control's files.
    pub(super) root: String,
    /// Definition files that are still to be read, and whether a missing one is reported.
    pub(super) definitions: Vec<(String, bool)>,
}

/// Definition files that are looked for without being named.
const DEFINITIONS: [&str; 14] = [
    "SMAC_DEF", "MMAC_DEF", "UMAC_DEF", "PMAC_DEF", "SGUD_DEF", "MGUD_DEF", "UGUD_DEF", "GUD4_DEF", "GUD5_DEF",
    "GUD6_DEF", "GUD7_DEF", "GUD8_DEF", "GUD9_DEF", "PGUD_DEF",
];

impl Default for SiemensSettings {
    fn default() -> Self {
        Self {
            messages: true,
            subprograms: true,
            global: false,
            applies_frames: true,
            collapse: None,
            severity: None,
            root: String::new(),
            definitions: Vec::new(),
        }
    }
}

impl SiemensSettings {
    /// Sets one by its name.
    pub(super) fn set(&mut self, name: &str, values: &[MacroValue]) -> SettingOutcome {
        let truth = match values {
            [value] => value.as_logical(),
            _ => None,
        };
        let slot = match name {
            "PROCESS,MESSAGES" => {
                // The kernel keeps it too.
                self.messages = truth.unwrap_or(self.messages);
                return SettingOutcome::Unknown;
            }
            "PROCESS,SUBPROGRAMS" => &mut self.subprograms,
            "GLOBALDEF" => &mut self.global,
            "APPLYFRAMES" => &mut self.applies_frames,
            // Blanks around `=` are removed in any case.
            "COLLAPSEASSIGNSPACES" => {
                return if truth.is_some() { SettingOutcome::Made } else { SettingOutcome::Wrong };
            }
            "COLLAPSEASSIGNS" => {
                self.collapse = truth.or(self.collapse);
                return if truth.is_some() { SettingOutcome::Made } else { SettingOutcome::Wrong };
            }
            "SETALSEVERITY" => return self.set_severity(values),
            "SETFILEROOT" => return self.set_root(values),
            "PROCESSGUDFILES" => return self.set_definitions(values),
            _ => return SettingOutcome::Unknown,
        };
        match truth {
            Some(truth) => {
                *slot = truth;
                SettingOutcome::Made
            }
            None => SettingOutcome::Wrong,
        }
    }

    fn set_severity(&mut self, values: &[MacroValue]) -> SettingOutcome {
        match values {
            [value] => match value.as_real() {
                Some(severity) if severity.fract() == 0.0 && (0.0..100.0).contains(&severity) => {
                    self.severity = Some(severity as u8);
                    SettingOutcome::Made
                }
                _ => SettingOutcome::Wrong,
            },
            _ => SettingOutcome::Wrong,
        }
    }

    fn set_root(&mut self, values: &[MacroValue]) -> SettingOutcome {
        match values {
            [MacroValue::Text(text)] => {
                self.root = text.trim().replace('\\', "/").trim_end_matches('/').to_owned();
                SettingOutcome::Made
            }
            _ => SettingOutcome::Wrong,
        }
    }

    fn set_definitions(&mut self, values: &[MacroValue]) -> SettingOutcome {
        let text = |value: &MacroValue| value.as_text().map(|text| (text.trim().to_owned(), true));
        match values {
            [] => self.definitions.extend(DEFINITIONS.map(|name| (name.to_owned(), false))),
            [MacroValue::Sequence(names)] => match names.iter().map(text).collect::<Option<Vec<_>>>() {
                Some(names) => self.definitions.extend(names),
                None => return SettingOutcome::Wrong,
            },
            [value] => match text(value) {
                Some(name) => self.definitions.push(name),
                None => return SettingOutcome::Wrong,
            },
            _ => return SettingOutcome::Wrong,
        }
        SettingOutcome::Made
    }
}

/// A variable in native spelling, with further indices after it.
pub(super) fn named(text: &str, indices: &[f64]) -> Option<IndexedName> {
    let mut name = as_name(&whole(text.trim()).ok()?)?.clone();
    name.index.extend(indices.iter().map(|index| Expression::constant(Data::Real(*index))));
    let sound = indices.iter().all(|index| index.is_finite());
    sound.then_some(name)
}
