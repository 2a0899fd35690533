//! Checks whether a dialog accepts an answer.
//!
//! *Invariant:* an answer with a value that its dialog can never accept is refused before it is stored. Its question
//! stays open.

use counterpoint_proto::v1;
use counterpoint_proto::v1::dialog_field::Kind;
use counterpoint_proto::v1::dialog_value::Value;

use crate::reason::Refusal;

/// Refuses an answer with a value that has no field, or whose field does not accept its type or length. `field` is the
/// place of the answer in the request.
pub(super) fn check(field: &str, question: &v1::Question, answer: &v1::DialogAnswer) -> Result<(), Refusal> {
    let no_dialog = v1::Dialog::default();
    let dialog = question.dialog.as_ref().unwrap_or(&no_dialog);
    answer.values.iter().try_for_each(|(variable, value)| {
        let same = |name: &str| name.eq_ignore_ascii_case(variable);
        let mut kinds = dialog.fields.iter().filter(|field| same(&field.variable)).filter_map(|f| f.kind.as_ref());
        let rule = match kinds.next() {
            Some(kind) => broken(kind, value.value.as_ref()),
            // Variables that decide which fields are shown.
            None if question.values.keys().any(|name| same(name)) => None,
            None => Some(format!("be a variable of a field: the dialog '{}' has no such field", dialog.name)),
        };
        let place = || format!("{field}.values");
        rule.map_or(Ok(()), |rule| Err(Refusal::field(place(), format!("'{variable}' must {rule}"))))
    })
}

/// The rule that a value breaks.
fn broken(kind: &Kind, value: Option<&Value>) -> Option<String> {
    match (kind, value) {
        // An empty text means no value.
        (_, None) => None,
        (_, Some(Value::Text(text))) if text.is_empty() => None,
        (Kind::LongestText(longest), Some(Value::Text(text))) => {
            let longest = *longest as usize;
            (text.chars().count() > longest).then(|| format!("have at most {longest} characters"))
        }
        (Kind::LongestText(_), Some(Value::Number(_) | Value::Flag(_))) => Some("be a text".to_owned()),
        (Kind::Number(_), Some(Value::Text(_) | Value::Flag(_))) => Some("be a number".to_owned()),
        (Kind::Check(_), Some(Value::Text(_) | Value::Number(_))) => Some("be true or false".to_owned()),
        _ => None,
    }
}
