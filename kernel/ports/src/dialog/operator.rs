//! Dialogs with an operator who answers while the job runs.
//!
//! Invariants: a conversation ends after `MOST` answers; an answer that is refused changes nothing and is requested
//! again with the reason. The operator's answers are the only outside input of a run, so the same answers give the same
//! log.

use super::answers::{DialogAnswer, DialogValue};
use super::{ButtonKind, Dialog, DialogOutcome, Failure, evaluate, find};

/// Answers of one conversation at most, those to called dialogs included.
const MOST: u32 = 100;

/// A dialog that is open.
#[derive(Debug, Clone, PartialEq)]
pub struct OpenDialog<'a> {
    /// Channel whose macro asks; 0 = the master.
    pub channel: u16,
    /// File of the block.
    pub file: &'a str,
    /// Its line.
    pub line: u32,
    /// The shown content.
    pub dialog: &'a Dialog,
    /// Values that the fields begin with, by variable, in the order of the fields; then those of other variables that
    /// decide about fields.
    pub values: &'a [(String, DialogValue)],
    /// Why the answer before was refused.
    pub problem: Option<&'a str>,
}

/// Why a question has no answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Silence {
    /// The operator declined.
    Declined,
    /// No operator answered in time.
    Late,
    /// The run is to end.
    Closed,
}

impl Silence {
    /// The failure of a dialog with this name.
    fn of(self, dialog: &Dialog) -> Failure {
        let name = dialog.name.clone();
        match self {
            Self::Declined => Failure::Declined(name),
            Self::Late => Failure::Late(name),
            Self::Closed => Failure::Unanswered(name),
        }
    }
}

/// The operator who answers dialogs.
pub trait DialogOperator: Send + Sync {
    /// Asks a question and waits for the answer.
    ///
    /// # Errors
    /// The reason why there is no answer.
    fn ask(&self, question: &OpenDialog<'_>) -> Result<DialogAnswer, Silence>;
}

/// Puts a dialog, the values that its fields begin with, and the reason why the answer before was refused.
pub type Ask<'a> = dyn FnMut(&Dialog, &[(String, DialogValue)], Option<&str>) -> Result<DialogAnswer, Silence> + 'a;

/// Shows a dialog until a button ends it.
///
/// # Errors
/// The dialog does not exist, no operator answers, or the answers remain wrong.
pub fn converse(
    dialogs: &[Dialog],
    name: &str,
    ask: &mut Ask<'_>,
    current: &mut dyn FnMut(&str) -> Option<DialogValue>,
) -> Result<DialogOutcome, Failure> {
    let mut called = Vec::new();
    let mut left = MOST;
    let mut shown = open(dialogs, name, ask, current, &mut called, &mut left)?;
    called.append(&mut shown.values);
    Ok(DialogOutcome { values: called, ..shown })
}

fn open(
    dialogs: &[Dialog],
    name: &str,
    ask: &mut Ask<'_>,
    current: &mut dyn FnMut(&str) -> Option<DialogValue>,
    called: &mut Vec<(String, DialogValue)>,
    left: &mut u32,
) -> Result<DialogOutcome, Failure> {
    let dialog = find(dialogs, name).ok_or_else(|| Failure::Unknown(name.to_owned()))?;
    let mut problem: Option<String> = None;
    // Values that were entered before another dialog was called.
    let mut entered = DialogAnswer::default();
    loop {
        if *left == 0 {
            let why = problem.unwrap_or_else(|| format!("dialog '{name}': no button ended it in {MOST} answers"));
            return Err(Failure::Refused(why));
        }
        *left -= 1;
        let mut now = |variable: &str| {
            if let Some(value) = entered.value(variable) {
                return Some(value.clone());
            }
            let set = called.iter().rev().find(|(name, _)| name.eq_ignore_ascii_case(variable));
            set.map(|(_, value)| value.clone()).or_else(|| current(variable))
        };
        let values = dialog.start(&mut now);
        let answer = ask(dialog, &values, problem.as_deref());
        let answer = answer.map_err(|silence| silence.of(dialog))?;
        let wanted = answer.button.as_deref();
        let button = dialog.buttons.iter().find(|button| match wanted {
            Some(label) => button.label.eq_ignore_ascii_case(label),
            None => button.kind == ButtonKind::Ok,
        });
        match button.map(|button| &button.kind) {
            Some(ButtonKind::Call(other)) => {
                let shown = open(dialogs, other, ask, current, called, left)?;
                called.extend(shown.values);
                entered.values.extend(answer.values);
                problem = None;
            }
            Some(ButtonKind::Reset) => (entered, problem) = (DialogAnswer::default(), None),
            _ => match evaluate(dialog, &answer, &mut now) {
                Ok(shown) => return Ok(shown),
                Err(why) => problem = Some(why),
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Button, DialogField, FieldKind};
    use super::*;

    fn dialog(name: &str, variable: &str, buttons: &[(&str, ButtonKind)]) -> Dialog {
        let kind = FieldKind::Number { min: 1.0, max: 9.0, whole: true };
        let default = Some(DialogValue::Number(3.0));
        let field = DialogField {
            label: variable.into(),
            variable: variable.into(),
            kind,
            default,
            required: true,
            enabled: None,
        };
        let button = |(label, kind): &(&str, ButtonKind)| Button { label: (*label).into(), kind: kind.clone() };
        let buttons = buttons.iter().map(button).collect();
        Dialog { name: name.into(), title: name.into(), fields: vec![field], buttons }
    }

    fn dialogs() -> Vec<Dialog> {
        let more = ButtonKind::Call("Inner".into());
        let outer =
            [("OK", ButtonKind::Ok), ("Leave", ButtonKind::Cancel), ("More", more), ("Reset", ButtonKind::Reset)];
        vec![dialog("Outer", "A", &outer), dialog("Inner", "B", &[("Done", ButtonKind::Ok)])]
    }

    /// Button and values.
    type Said<'a> = (Option<&'a str>, &'a [(&'a str, f64)]);

    /// Gives answers in turn; returns the result, and the text shown for each answer.
    fn talk(answers: &[Said<'_>]) -> (Result<DialogOutcome, Failure>, Vec<String>) {
        let mut turn = answers.iter();
        let mut seen = Vec::new();
        let mut ask = |dialog: &Dialog, values: &[(String, DialogValue)], problem: Option<&str>| {
            let values: Vec<String> = values.iter().map(|(name, value)| format!("{name}={value}")).collect();
            seen.push(format!("{} {} {}", dialog.name, values.join(","), problem.unwrap_or("-")));
            let (button, values) = turn.next().ok_or(Silence::Declined)?;
            let value = |(name, value): &(&str, f64)| ((*name).to_owned(), DialogValue::Number(*value));
            let values = values.iter().map(value).collect();
            Ok(DialogAnswer { dialog: dialog.name.clone(), button: button.map(str::to_owned), values })
        };
        let shown = converse(&dialogs(), "outer", &mut ask, &mut |_| None);
        (shown, seen)
    }

    fn number(name: &str, value: f64) -> (String, DialogValue) {
        (name.to_owned(), DialogValue::Number(value))
    }

    #[test]
    fn an_answer_that_is_refused_is_asked_for_again() {
        let (shown, seen) = talk(&[(None, &[("A", 12.0)]), (Some("Nothing"), &[]), (Some("ok"), &[("A", 4.0)])]);
        assert_eq!(shown.unwrap().values, [number("A", 4.0)]);
        assert_eq!(seen[0], "Outer A=3 -");
        assert_eq!(seen[1], "Outer A=3 dialog 'Outer': A must be 1 to 9, not 12");
        assert_eq!(seen[2], "Outer A=3 dialog 'Outer' has no button 'Nothing'");
    }

    #[test]
    fn buttons_call_reset_and_leave() {
        let (shown, seen) =
            talk(&[(Some("More"), &[("A", 7.0)]), (None, &[("B", 5.0)]), (Some("Reset"), &[]), (None, &[])]);
        let shown = shown.unwrap();
        assert_eq!((shown.button.as_str(), shown.values), ("OK", vec![number("B", 5.0), number("A", 3.0)]));
        assert_eq!(seen, ["Outer A=3 -", "Inner B=3 -", "Outer A=7 -", "Outer A=3 -"]);
        let (shown, _) = talk(&[(Some("More"), &[]), (None, &[("B", 5.0)]), (Some("Leave"), &[])]);
        let shown = shown.unwrap();
        assert_eq!((shown.button.as_str(), shown.values), ("Leave", vec![number("B", 5.0)]), "the called one was OK");
    }

    #[test]
    fn silence_and_endless_nonsense_end_it() {
        assert_eq!(talk(&[]).0, Err(Failure::Declined("Outer".into())));
        let late = converse(&dialogs(), "outer", &mut |_, _, _| Err(Silence::Late), &mut |_| None);
        assert_eq!(late, Err(Failure::Late("Outer".into())));
        let nonsense = vec![(None, &[("A", 99.0)][..]); 200];
        let (shown, seen) = talk(&nonsense);
        assert!(matches!(shown, Err(Failure::Refused(_))));
        assert_eq!(seen.len(), 100);
    }
}
