//! summary.json for programs that show its diagnostics to people: with the remedy of each.
//!
//! *Invariant:* everything else is as in the file.

use serde_json::Value;

use crate::macros::{remedy, remedy_for};

/// The number of the diagnostic of a deadlock, which a verdict is.
const DEADLOCK: u32 = 2_900_071;

/// Adds `remedy` to every diagnostic that has one, and to the verdict. A text that cannot be read as JSON stays as it is.
pub(crate) fn with_remedies(text: &[u8]) -> Vec<u8> {
    let Ok(mut summary) = serde_json::from_slice::<Value>(text) else { return text.to_vec() };
    let diagnostics = summary.get_mut("diagnostics").and_then(Value::as_array_mut);
    for diagnostic in diagnostics.into_iter().flatten() {
        let number = diagnostic.get("number").and_then(Value::as_u64).and_then(|number| u32::try_from(number).ok());
        put(diagnostic, number.and_then(remedy));
    }
    if let Some(verdict) = summary.get_mut("verdict") {
        let kind = verdict.get("kind").and_then(Value::as_str);
        let found = kind.filter(|kind| *kind != "LIMIT").and_then(|kind| remedy_for(DEADLOCK, kind));
        put(verdict, found);
    }
    let mut out = summary.to_string().into_bytes();
    out.push(b'\n');
    out
}

fn put(at: &mut Value, remedy: Option<String>) {
    if let (Some(fields), Some(remedy)) = (at.as_object_mut(), remedy) {
        fields.insert("remedy".to_owned(), Value::String(remedy));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn diagnostics_and_the_verdict_get_their_remedies() {
        let text = br#"{"state":"FAILED","verdict":{"kind":"PARTNER_ALARMED","text":"a"},
            "diagnostics":[{"number":2900021,"text":"b"},{"number":4000000000,"text":"c"}],"waits":[]}"#;
        let summary: Value = serde_json::from_slice(&with_remedies(text)).unwrap();
        assert_eq!(summary["verdict"]["remedy"], "Correct the alarm of the other channel first");
        assert_eq!(summary["diagnostics"][0]["remedy"], Value::String(remedy(2_900_021).unwrap()));
        assert_eq!(summary["diagnostics"][1].get("remedy"), None);
        assert_eq!((&summary["state"], &summary["waits"]), (&Value::from("FAILED"), &Value::Array(Vec::new())));
        let clean = br#"{"verdict":null,"diagnostics":[]}"#;
        let same: Value = serde_json::from_slice(&with_remedies(clean)).unwrap();
        assert_eq!(same, serde_json::from_slice::<Value>(clean).unwrap());
        assert_eq!(with_remedies(b"no summary"), b"no summary");
    }
}
