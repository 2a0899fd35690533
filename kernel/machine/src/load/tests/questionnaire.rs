//! Answers become rows, rows of the file go over them, and the documentation lists every question.

use super::*;
use crate::ident;
use crate::load::questions::{AnswerConversion, SUBJECTS};
use crate::rows::CodeForm;

#[test]
fn answers_become_rows_with_their_own_lines() {
    let loaded = load_text(&format!(
        "{BASE}\n[questionnaire]\nstart = [\"motion.rapid\", \"position.absolute\"]\n[questionnaire.motion]\n\
         linear = [\"G1\", \"G01\"]\ndwell = {{ word = \"G4\", order = 50 }}\n[questionnaire.position]\n\
         absolute = \"G90\"\nincremental = \"\"\n[questionnaire.offsets]\nwork = \"G54-G59\"\n\
         [questionnaire.words]\nfeed = \"P\"\ndwell = {{ register = \"P\", mul = 0.001 }}\n"
    ));
    // G1 and G01 are one word: the second row can never match.
    assert_eq!(loaded.findings.len(), 1, "{:?}", loaded.findings);
    assert!(loaded.findings[0].text.contains("already written like this"), "{:?}", loaded.findings);
}

#[test]
fn values_and_numbers_of_answers() {
    let loaded = load_text(&format!(
        "{BASE}\n[questionnaire]\nstart = [\"motion.rapid\"]\n[questionnaire.motion]\n\
         dwell = {{ word = \"G4\", order = 50 }}\n[questionnaire.offsets]\nwork = \"G54-G59\"\n\
         [questionnaire.words]\nfeed = \"P\"\ndwell = {{ register = \"P\", mul = 0.001 }}\n"
    ));
    assert_eq!(loaded.findings, []);
    let machine = loaded.machine.unwrap();
    let row = |name: &str| machine.codes.iter().find(|r| machine.code_name(r.id) == name).unwrap();
    let base = BASE.lines().count() as u32;
    assert_eq!((row("CODE_DELAY").order, row("CODE_DELAY").line), (50, base + 5));
    let work = row("CODE_COMP_WORKP_ON");
    assert_eq!((work.mul, work.add, work.group), (1.0, -53.0, 14));
    assert!(matches!(work.form, CodeForm::RegisterAsData { min: 54.0, max: 59.0, .. }));
    let data: Vec<&str> = machine.data.iter().map(|r| machine.data_name(r.id)).collect();
    assert_eq!(data, ["REG_AXIS_X", "REG_FEED_UPM", "REG_FEED_UPR", "REG_FEED_1T", "REG_DELAY"]);
    assert_eq!(machine.data.as_slice()[4].mul, 0.001);
    assert_eq!(machine.initial, [ident::codes::RAPID]);
}

#[test]
fn rows_of_the_file_win() {
    let loaded = load_text(&format!(
        "{BASE}\n[[codes]]\nid = \"CODE_INTERP_LINEAR\"\nword = \"G1\"\norder = 499\n[[codes]]\nid = \"CODE_STOP\"\n\
         word = \"G2\"\n[questionnaire.motion]\nlinear = \"G1\"\narc_clockwise = \"G02\"\n"
    ));
    assert_eq!(loaded.findings, []);
    let machine = loaded.machine.unwrap();
    let words: Vec<(&str, u16)> = machine.codes.iter().map(|r| (machine.code_name(r.id), r.order)).collect();
    let expected = [("CODE_RAPID", 500), ("CODE_SPINDLE_CLW", 300), ("CODE_INTERP_LINEAR", 499), ("CODE_STOP", 900)];
    assert_eq!(words, expected);
}

#[test]
fn mistakes_name_the_line_of_the_answer() {
    let cases = [
        (
            "[questionnaire.motion]\nrapd = \"G0\"\n",
            "2:1: error: unknown key `rapd` in [questionnaire.motion]; did you mean \"rapid\"?",
        ),
        (
            "[questionnaire.motoin]\nrapid = \"G0\"\n",
            "1:16: error: unknown key `motoin` in [questionnaire]; did you mean \"motion\"?",
        ),
        (
            "[questionnaire.motion]\nlinear = 1\n",
            "2:10: error: `linear` must be a word in quotes, a table or a list, not a whole number",
        ),
        ("[questionnaire.motion]\nlinear = \"Q1\"\n", "2:10: error: no register has the name \"Q\""),
        ("[questionnaire.stop]\nend = { order = 1 }\n", "2:7: error: an answer to `end` that is a table needs `word`"),
        (
            "[questionnaire]\nstart = [\"words.x\"]\n",
            "2:10: error: `start` names questions that stand for codes, like \"motion.rapid\", not \"words.x\"",
        ),
    ];
    for (text, expected) in cases {
        let findings = after(text);
        assert!(findings.iter().any(|f| f.starts_with(expected)), "{text}: {findings:?}");
    }
}

#[test]
fn every_question_names_built_in_identifiers_and_is_documented() {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/machine-definition.md");
    let page = std::fs::read_to_string(path).unwrap();
    for subject in SUBJECTS {
        for question in subject.questions {
            let (codes, data): (Vec<&str>, Vec<&str>) = match question.kind {
                AnswerConversion::Code(id) => (vec![id], vec![]),
                AnswerConversion::AsData(id, data) | AnswerConversion::Numbered(id, data) => (vec![id], vec![data]),
                AnswerConversion::Data(ids) => (vec![], ids.to_vec()),
            };
            codes.iter().for_each(|id| assert!(ident::code(id).is_some(), "{id}"));
            data.iter().for_each(|id| assert!(ident::data(id).is_some(), "{id}"));
            let key = format!("`{}.{}`", subject.key, question.key);
            assert!(page.contains(&key), "{key} is not documented");
        }
    }
}
