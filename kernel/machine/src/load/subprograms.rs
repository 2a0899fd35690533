//! `[subprograms]`: how a called program is found.
//!
//! Invariant: an extension is a plain file extension. Facts: reference control-emulator.md 5.7.

use super::calls::{self, Around};
use crate::model::{CallForm, CallLevels, MacroWords, MainReturn, NestedCalls, Placement, Subprograms, Triples};
use crate::toml::section::TableReader;

/// Reads the section.
pub(super) fn read(top: &mut TableReader<'_>, around: &Around<'_>) -> Subprograms {
    let mut subprograms = Subprograms {
        placement: Placement::SameFile,
        extension: "tps".to_owned(),
        call: CallForm::Number,
        repeat_is_executions: true,
        main_return: MainReturn::End,
        end_ends: false,
        calls: Vec::new(),
        nested: NestedCalls::OtherKind,
        levels: CallLevels::default(),
        macro_words: MacroWords::Anywhere,
        ijk: Triples::ByLetter,
    };
    let Some(mut section) = top.table("subprograms", "[subprograms]") else { return subprograms };
    let placements =
        [("same-file", Placement::SameFile), ("one-file", Placement::OneFile), ("file-each", Placement::FileEach)];
    subprograms.placement = section.choice("placement", &placements).unwrap_or(Placement::SameFile);
    if let Some(extension) = section.name("extension", 16) {
        if extension.chars().all(|c| c.is_ascii_alphanumeric() || c == '_') {
            extension.clone_into(&mut subprograms.extension);
        } else {
            section.error("extension", "`extension` must be letters and digits without a dot");
        }
    }
    let calls = [("number", CallForm::Number), ("repeat-and-number", CallForm::RepeatAndNumber)];
    subprograms.call = section.choice("call", &calls).unwrap_or(CallForm::Number);
    subprograms.repeat_is_executions = section.flag("repeat_is_executions").unwrap_or(true);
    let returns = [("end", MainReturn::End), ("restart", MainReturn::Restart)];
    subprograms.main_return = section.choice("main_return", &returns).unwrap_or(MainReturn::End);
    let ends = [("returns", false), ("ends", true)];
    subprograms.end_ends = section.choice("end", &ends).unwrap_or(false);
    let nested = [("other-kind", NestedCalls::OtherKind), ("never", NestedCalls::Never)];
    subprograms.nested = section.choice("nested_calls", &nested).unwrap_or(NestedCalls::OtherKind);
    if let Some(mut levels) = section.table("levels", "levels of [subprograms]") {
        let mut level = |key| levels.integer(key, 1..=999).map(|level| level as u16);
        let (subs, macros, all) = (level("subprograms"), level("macros"), level("all"));
        subprograms.levels = CallLevels { subprograms: subs, macros, all };
        levels.finish();
    }
    let words =
        [("anywhere", MacroWords::Anywhere), ("behind", MacroWords::Behind), ("act-before", MacroWords::ActBefore)];
    subprograms.macro_words = section.choice("macro_words", &words).unwrap_or(MacroWords::Anywhere);
    let triples = [("by-letter", Triples::ByLetter), ("in-order", Triples::InOrder), ("first", Triples::First)];
    subprograms.ijk = section.choice("ijk", &triples).unwrap_or(Triples::ByLetter);
    subprograms.calls = calls::read(&mut section, around);
    section.finish();
    subprograms
}
