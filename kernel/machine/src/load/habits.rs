//! `[control]`: answers that are neither words nor formats.
//!
//! Invariant: answers of the machine's own are as many as their variables have room for. Facts: reference
//! control-emulator.md 1.5; system-variables.md 2 (`$TUDQ`, `$IUDQ`, `$WUDQ`).

use super::registers::CoordinateSettings;
use crate::habits::{FileLayout, Forbidden, Habits, Home, Rotations};
use crate::preprocessor::Preprocessor;
use crate::rows::Excess;
use crate::toml::section::TableReader;

/// Elements of `$TUDQ`, `$IUDQ` and `$WUDQ`.
const ROOM: [usize; 3] = [10, 100, 50];

/// Reads `[control]` of a control with this pre-processor, and its settings for numbers of coordinates.
pub(super) fn read(top: &mut TableReader<'_>, preprocessor: Preprocessor) -> (Habits, CoordinateSettings) {
    let mut habits = Habits { frame_increments: preprocessor.row().frame_increments, ..Habits::default() };
    let Some(mut section) = top.table("control", "[control]") else { return (habits, CoordinateSettings::default()) };
    let numbers = [("as-written", false), ("increments", true)];
    let excess = [("kept", Excess::Kept), ("cut", Excess::Cut), ("rounded", Excess::Rounded)];
    let coordinates = CoordinateSettings {
        increments: section.choice("numbers", &numbers).unwrap_or(false),
        excess: section.choice("excess_digits", &excess).unwrap_or_default(),
        nine: section.integer("digits", 8..=9) == Some(9),
    };
    habits.speed_word = section.flag("speed_word").unwrap_or(habits.speed_word);
    let homes = [("workpiece", Home::Workpiece), ("machine", Home::Machine)];
    habits.home = section.choice("home", &homes).unwrap_or(habits.home);
    // Which rows of `[[codes]]` count has been settled with those rows.
    section.node("system");
    let orders = Rotations::ALL.map(|order| (order.name, order));
    habits.rotations = section.choice("rotations", &orders).unwrap_or(habits.rotations);
    habits.least_feed = section.above_zero("least_feed");
    let axes = [("all", false), ("geometry", true)];
    habits.feed_of_geometry = section.choice("feed_axes", &axes).unwrap_or(habits.feed_of_geometry);
    let increments = [("stay", false), ("travel", true)];
    habits.frame_increments = section.choice("frame_increments", &increments).unwrap_or(habits.frame_increments);
    let files = [("numbers", FileLayout::Numbers), ("heads", FileLayout::Heads), ("sections", FileLayout::Sections)];
    habits.programs = section.choice("programs", &files).unwrap_or(habits.programs);
    let groups = [("all", (false, false)), ("last", (true, true)), ("last-modal", (true, false))];
    if let Some(groups) = section.choice("same_group", &groups) {
        (habits.last_of_group, habits.one_shots_of_group) = groups;
    }
    let values = [("exact", false), ("rounded", true)];
    habits.rounded = section.choice("expressions", &values).unwrap_or(habits.rounded);
    let sums = [("in-brackets", false), ("bare", true)];
    habits.bare_sums = section.choice("sums", &sums).unwrap_or(habits.bare_sums);
    let conditions = [("then", false), ("bare", true)];
    habits.bare_conditions = section.choice("conditions", &conditions).unwrap_or(habits.bare_conditions);
    habits.loops = section.integer("loops", 1..=127).map(|loops| loops as u8);
    let statements = [("several", (false, false)), ("one", (true, false)), ("macro", (true, true))];
    if let Some(statements) = section.choice("then", &statements) {
        (habits.one_then, habits.macro_then) = statements;
    }
    let numbers = [("values", false), ("digits", true)];
    habits.digits_of_numbers = section.choice("sequence_numbers", &numbers).unwrap_or(habits.digits_of_numbers);
    habits.rotation_angle = section.number("rotation_angle");
    habits.scale_factor = section.above_zero("scale_factor");
    let factors = [("as-written", false), ("factor", true)];
    habits.pointed_factors = section.choice("factor_with_point", &factors).unwrap_or(habits.pointed_factors);
    let words = [("error", false), ("last", true)];
    habits.last_of_address = section.choice("same_address", &words).unwrap_or(habits.last_of_address);
    let angles = [("signed", false), ("full-turn", true)];
    habits.full_angles = section.choice("angles", &angles).unwrap_or(habits.full_angles);
    habits.brackets = section.integer("brackets", 1..=32).map(|levels| levels as u8);
    let homes = [("nothing", false), ("all", true)];
    habits.bare_home = section.choice("home_without_axes", &homes).unwrap_or(habits.bare_home);
    let dwells = [("as-written", false), ("seconds", true)];
    habits.dwell.pointed = section.choice("dwell_with_point", &dwells).unwrap_or(habits.dwell.pointed);
    let dwells = [("missing", false), ("exact-stop", true)];
    habits.dwell.bare = section.choice("dwell_without_time", &dwells).unwrap_or(habits.dwell.bare);
    let unknown = [("warn", false), ("alarm", true)];
    habits.unknown_alarms = section.choice("unknown_code", &unknown).unwrap_or(habits.unknown_alarms);
    let moves = [("by-mode", false), ("rapid", true)];
    habits.machine_frame_rapid = section.choice("machine_frame", &moves).unwrap_or(habits.machine_frame_rapid);
    habits.feed_needs_spindle = section.flag("feed_needs_spindle").unwrap_or(habits.feed_needs_spindle);
    let speeds = [("active-spindle", false), ("alarm", true)];
    habits.guards_speed = section.choice("speed_beside_functions", &speeds).unwrap_or(habits.guards_speed);
    let owners = [("active", false), ("commanded", true)];
    habits.speed_follows_codes = section.choice("speed_owner", &owners).unwrap_or(habits.speed_follows_codes);
    let owners = [("commanded", false), ("side", true)];
    habits.surface_of_side = section.choice("surface_owner", &owners).unwrap_or(habits.surface_of_side);
    let centers = [("as-programmed", false), ("scaled", true)];
    habits.scaled_center = section.choice("rotation_center", &centers).unwrap_or(habits.scaled_center);
    let numbers = [("missing", false), ("first", true)];
    habits.first_extended = section.choice("extended_without_number", &numbers).unwrap_or(habits.first_extended);
    let presets = [("stays", false), ("ends", true)];
    habits.preset_ends_shift = section.choice("shift_at_preset", &presets).unwrap_or(habits.preset_ends_shift);
    let shifted = [("all", false), ("each", true)];
    habits.shift_of_each = section.choice("shifted_offsets", &shifted).unwrap_or(habits.shift_of_each);
    habits.work_area = section.flag("work_area").unwrap_or(habits.work_area);
    let sides = [("inside", Forbidden::Inside), ("outside", Forbidden::Outside)];
    if let Some(mut limits) = section.table("stored_limits", "[control.stored_limits]") {
        habits.stored_limits.forbidden = limits.choice("forbidden", &sides).unwrap_or_default();
        let frames = [("machine", false), ("work", true)];
        habits.stored_limits.in_work_frame = limits.choice("frame", &frames).unwrap_or(false);
        limits.finish();
    }
    habits.stops = section.flag("stops").unwrap_or(habits.stops);
    if let Some(mut answers) = section.table("answers", "[control.answers]") {
        read_answers(&mut answers, &mut habits);
        answers.finish();
    }
    section.finish();
    (habits, coordinates)
}

fn read_answers(section: &mut TableReader<'_>, habits: &mut Habits) {
    let [texts, integers, numbers] = ROOM;
    let given = section.texts("texts").unwrap_or_default();
    if given.len() > texts {
        section.error("texts", format!("`texts` has room for {texts} answers, not for {}", given.len()));
    }
    habits.texts = given.into_iter().map(|(text, _)| text.to_owned()).collect();
    habits.integers = section.numbers("integers", 0..=integers).unwrap_or_default();
    if let Some(broken) = habits.integers.iter().find(|number| number.fract() != 0.0) {
        section.error("integers", format!("`integers` must be a list of whole numbers, not of {broken}"));
    }
    habits.numbers = section.numbers("numbers", 0..=numbers).unwrap_or_default();
}
