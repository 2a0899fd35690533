//! A machine's rules for diagnostics: severity, text, whether the channel stops.
//!
//! Facts: reference control-emulator.md 7.5.

use counterpoint_fault::DiagnosticFacts;

use crate::model::{DiagnosticRule, Diagnostics, Machine};

/// The machine's own text in place of the kernel's text.
const ORIGINAL: &str = "!(*)";

/// Severity of alarms.
const ALARM: u8 = 8;

/// Severity by the machine's rule: its own, and at least that of alarms for an alarm of this control.
fn severity_of(rule: Option<&DiagnosticRule>, severity: u8) -> u8 {
    let least = if rule.is_some_and(|rule| rule.alarm) { ALARM } else { 0 };
    rule.and_then(|rule| rule.severity).unwrap_or(severity.max(least))
}

impl Diagnostics {
    /// Whether nothing is changed.
    #[must_use]
    pub fn is_plain(&self) -> bool {
        self.rules.is_empty() && self.min_severity == 0
    }

    /// Rule of a number.
    #[must_use]
    pub fn rule(&self, number: u32) -> Option<&DiagnosticRule> {
        let index = self.rules.binary_search_by_key(&number, |rule| rule.number).ok()?;
        self.rules.get(index)
    }

    /// Whether the machine stops at a number, if it says so.
    #[must_use]
    pub fn stops(&self, number: u32) -> Option<bool> {
        self.rule(number)?.stops
    }

    /// Whether the machine says that a number is an alarm of its control.
    #[must_use]
    pub fn is_alarm(&self, number: u32) -> bool {
        self.rule(number).is_some_and(|rule| rule.alarm)
    }

    /// Severity and text of a diagnostic on this machine, `None` when it is switched off or below the floor. `before`
    /// counts how often the number was raised before; the last one that is shown says so.
    #[must_use]
    pub fn custom(&self, number: u32, severity: u8, text: String, before: u32) -> Option<(u8, String)> {
        let rule = self.rule(number);
        let least = severity_of(rule, severity);
        if least < self.min_severity {
            return None;
        }
        let Some(rule) = rule else { return Some((least, text)) };
        if !rule.enable || rule.repeat.is_some_and(|most| before >= most) {
            return None;
        }
        let (severity, mut text) = self.shown(rule, severity, text)?;
        if rule.repeat == Some(before.saturating_add(1)) {
            text.push_str(" (further ones are not shown)");
        }
        Some((severity, text))
    }

    /// The same for a number that is shown, regardless of its rule.
    #[must_use]
    pub fn shown(&self, rule: &DiagnosticRule, severity: u8, text: String) -> Option<(u8, String)> {
        let severity = severity_of(Some(rule), severity);
        let text = match &rule.text {
            Some(own) => own.replace(ORIGINAL, &text),
            None => text,
        };
        (severity >= self.min_severity).then_some((severity, text))
    }
}

impl Machine {
    /// Whether a diagnostic is an alarm of real controls, or of the control of this machine.
    #[must_use]
    pub fn is_alarm(&self, facts: &DiagnosticFacts) -> bool {
        facts.alarm || self.diagnostics.is_alarm(facts.number)
    }

    /// Whether the channel stops at a diagnostic.
    #[must_use]
    pub fn stops_at(&self, facts: &DiagnosticFacts) -> bool {
        self.diagnostics.stops(facts.number).unwrap_or_else(|| self.habits.stops && self.is_alarm(facts))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table(rule: DiagnosticRule, min_severity: u8) -> Diagnostics {
        Diagnostics { rules: vec![rule], min_severity, refusals: Vec::new() }
    }

    fn rule() -> DiagnosticRule {
        DiagnosticRule { number: 7, severity: None, text: None, enable: true, repeat: None, stops: None, alarm: false }
    }

    #[test]
    fn severity_text_and_floor() {
        let own = table(DiagnosticRule { severity: Some(9), text: Some("see: !(*)".into()), ..rule() }, 4);
        assert_eq!(own.custom(7, 4, "x".into(), 0), Some((9, "see: x".into())));
        assert_eq!(own.custom(8, 4, "y".into(), 0), Some((4, "y".into())));
        assert_eq!(own.custom(8, 3, "y".into(), 0), None);
        assert_eq!(table(DiagnosticRule { enable: false, ..rule() }, 0).custom(7, 15, "x".into(), 0), None);
    }

    #[test]
    fn the_last_one_of_a_repeat_count_says_so() {
        let two = table(DiagnosticRule { repeat: Some(2), ..rule() }, 0);
        assert_eq!(two.custom(7, 4, "x".into(), 0), Some((4, "x".into())));
        assert_eq!(two.custom(7, 4, "x".into(), 1), Some((4, "x (further ones are not shown)".into())));
        assert_eq!(two.custom(7, 4, "x".into(), 2), None);
    }
}
