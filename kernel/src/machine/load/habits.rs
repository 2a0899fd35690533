//! `[control]`: answers that are neither words nor formats.
//!
//! Invariant: answers of the machine's own are as many as their variables have room for. Facts: reference
//! control-emulator.md 1.5; system-variables.md 2 (`$TUDQ`, `$IUDQ`, `$WUDQ`).

use crate::machine::habits::{Habits, Home, Rotations};
use crate::machine::model::Preprocessor;
use crate::machine::toml::section::Section;

/// Elements of `$TUDQ`, `$IUDQ` and `$WUDQ`.
const ROOM: [usize; 3] = [10, 100, 50];

/// Reads `[control]` of a control with this pre-processor.
pub(super) fn read(top: &mut Section<'_>, preprocessor: Preprocessor) -> Habits {
    let mut habits = Habits { frame_increments: preprocessor == Preprocessor::Siemens, ..Habits::default() };
    let Some(mut section) = top.table("control", "[control]") else { return habits };
    habits.speed_word = section.flag("speed_word").unwrap_or(habits.speed_word);
    let homes = [("workpiece", Home::Workpiece), ("machine", Home::Machine)];
    habits.home = section.choice("home", &homes).unwrap_or(habits.home);
    let orders = Rotations::ALL.map(|order| (order.name, order));
    habits.rotations = section.choice("rotations", &orders).unwrap_or(habits.rotations);
    habits.least_feed = section.above_zero("least_feed");
    let increments = [("stay", false), ("travel", true)];
    habits.frame_increments = section.choice("frame_increments", &increments).unwrap_or(habits.frame_increments);
    let files = [("numbers", false), ("heads", true)];
    habits.heads_in_file = section.choice("programs", &files).unwrap_or(habits.heads_in_file);
    if let Some(mut answers) = section.table("answers", "[control.answers]") {
        read_answers(&mut answers, &mut habits);
        answers.finish();
    }
    section.finish();
    habits
}

fn read_answers(section: &mut Section<'_>, habits: &mut Habits) {
    let [texts, integers, numbers] = ROOM;
    let given = section.texts("texts").unwrap_or_default();
    if given.len() > texts {
        section.error("texts", format!("`texts` has room for {texts} answers, not for {}", given.len()));
    }
    habits.texts = given.into_iter().map(|(text, _)| text.to_owned()).collect();
    habits.integers = section.numbers("integers", 0..=integers).unwrap_or_default();
    if let Some(odd) = habits.integers.iter().find(|number| number.fract() != 0.0) {
        section.error("integers", format!("`integers` must be a list of whole numbers, not of {odd}"));
    }
    habits.numbers = section.numbers("numbers", 0..=numbers).unwrap_or_default();
}
