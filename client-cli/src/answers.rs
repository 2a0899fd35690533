//! Answers to dialogs from a file.
//!
//! *Invariant:* the sent answers are those of the file; the server decides whether they fit the machine.

use std::path::Path;

use counterpoint_kernel::dialog::answers::{DialogAnswer, DialogValue};
use counterpoint_proto::v1;
use serde::Deserialize;

use crate::error::Error;
use crate::standard_input;

/// The file.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct AnswerFile {
    answers: Vec<DialogAnswer>,
}

/// Reads a file of answers.
pub(crate) fn read(path: &Path) -> Result<Vec<v1::DialogAnswer>, Error> {
    standard_input::refuse("--answers", path)?;
    let text = std::fs::read_to_string(path).map_err(Error::file(path))?;
    let file: AnswerFile =
        toml::from_str(&text).map_err(|error| Error::Usage(format!("{}: {}", path.display(), error.message())))?;
    Ok(file.answers.into_iter().map(wire).collect())
}

fn wire(answer: DialogAnswer) -> v1::DialogAnswer {
    use v1::dialog_value::Value as Wire;
    let value = |value: DialogValue| v1::DialogValue {
        value: Some(match value {
            DialogValue::Flag(flag) => Wire::Flag(flag),
            DialogValue::Number(number) => Wire::Number(number),
            DialogValue::Text(text) => Wire::Text(text),
        }),
    };
    v1::DialogAnswer {
        dialog: answer.dialog,
        button: answer.button.unwrap_or_default(),
        values: answer.values.into_iter().map(|(name, v)| (name, value(v))).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_of_answers() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("answers.toml");
        let text = "[[answers]]\ndialog = \"Clamp\"\nvalues = { FORCE = 12, NOTE = \"a\", WET = true }\n";
        std::fs::write(&path, text).unwrap();
        let answers = read(&path).unwrap();
        assert_eq!((answers[0].dialog.as_str(), answers[0].button.as_str()), ("Clamp", ""));
        let number = v1::dialog_value::Value::Number(12.0);
        assert_eq!(answers[0].values["FORCE"].value, Some(number));
        std::fs::write(&path, "[[answers]]\ndialg = 1\n").unwrap();
        assert!(read(&path).is_err());
    }
}
