//! `[compensation]`: how cutter and nose radius compensation starts, ends and goes around corners; `[corners]`:
//! permissions of corner words of the program.
//!
//! Invariant: the angle is one of 0 to 180 degrees.

use crate::model::{
    Between, CompensationRules, CornerShape, Corners, LengthInMachineFrame, LengthRules, LengthThere, OutsideCorner,
};
use crate::toml::section::TableReader;

/// Reads `[compensation]`.
pub(super) fn read(top: &mut TableReader<'_>) -> CompensationRules {
    let mut made = CompensationRules {
        rapid: true,
        arcs: false,
        corner: OutsideCorner::Angle,
        corner_angle: 90.0,
        corner_shape: None,
        corner_after: false,
        numbers_alone: false,
        between: Between { looked_through: 2, alarm_beyond: false, past_stops: false, zero_move: 1 },
        needs_tool: false,
        wall: false,
        vector: false,
        zero_cancels: false,
        length: LengthRules::default(),
    };
    let Some(mut section) = top.table("compensation", "[compensation]") else { return made };
    made.rapid = section.flag("rapid").unwrap_or(made.rapid);
    made.arcs = section.flag("arcs").unwrap_or(made.arcs);
    let corners = [("angle", OutsideCorner::Angle), ("linear", OutsideCorner::Linear), ("arc", OutsideCorner::Arc)];
    made.corner = section.choice("corner", &corners).unwrap_or(made.corner);
    if let Some(angle) = section.at_least_zero("corner_angle") {
        if angle > 180.0 {
            section.error("corner_angle", format!("`corner_angle` is 0 to 180 degrees, not {angle}"));
        }
        made.corner_angle = angle.min(180.0);
    }
    made.corner_shape = shape(&mut section);
    let order = [("before", false), ("after", true)];
    made.corner_after = section.choice("corner_circle", &order).unwrap_or(made.corner_after);
    let numbers = [("with-code", false), ("alone", true)];
    made.numbers_alone = section.choice("numbers", &numbers).unwrap_or(made.numbers_alone);
    if let Some(blocks) = section.integer("looked_through", 0..=100) {
        made.between.looked_through = blocks as u32;
    }
    let beyond = [("ends", false), ("alarm", true)];
    made.between.alarm_beyond = section.choice("beyond_looked_through", &beyond).unwrap_or(made.between.alarm_beyond);
    let stops = [("ends", false), ("looked-through", true)];
    made.between.past_stops = section.choice("program_stop", &stops).unwrap_or(made.between.past_stops);
    let tools = [("contour", false), ("alarm", true)];
    made.needs_tool = section.choice("without_tool", &tools).unwrap_or(made.needs_tool);
    if let Some(blocks) = section.integer("zero_move", 1..=100) {
        made.between.zero_move = blocks as u32;
    }
    made.wall = section.choice("end_words", &[("unused", false), ("wall", true)]).unwrap_or(made.wall);
    made.vector = section.choice("start_words", &[("unused", false), ("vector", true)]).unwrap_or(made.vector);
    made.zero_cancels =
        section.choice("number_zero", &[("no-radius", false), ("cancels", true)]).unwrap_or(made.zero_cancels);
    made.length = length(&mut section);
    section.finish();
    made
}

/// Limits of sharp and round corners.
fn shape(section: &mut TableReader<'_>) -> Option<CornerShape> {
    let mut limit = |key: &'static str, most: f64| {
        let value = section.at_least_zero(key)?;
        if value > most {
            section.error(key, format!("`{key}` is 0 to {most}, not {value}"));
        }
        Some(value.min(most))
    };
    let [sharp, flat] = ["corner_sharp", "corner_flat"].map(|key| limit(key, 150.0));
    let distortion = limit("corner_distortion", 100.0);
    if sharp.is_none() && flat.is_none() && distortion.is_none() {
        return None;
    }
    Some(CornerShape { sharp: sharp.unwrap_or(90.0), flat: flat.unwrap_or(0.0), distortion: distortion.unwrap_or(0.0) })
}

fn length(section: &mut TableReader<'_>) -> LengthRules {
    let mut made = LengthRules::default();
    let there = [("stays", LengthThere::Stays), ("off", LengthThere::Off), ("ends", LengthThere::Ends)];
    made.at_reference = section.choice("length_at_reference", &there).unwrap_or(made.at_reference);
    let there = [
        ("stays", LengthInMachineFrame::Stays),
        ("off", LengthInMachineFrame::Off),
        ("added", LengthInMachineFrame::Added),
    ];
    made.in_machine_frame = section.choice("length_in_machine_frame", &there).unwrap_or(made.in_machine_frame);
    let values = [("at-once", false), ("by-word", true)];
    made.by_word = section.choice("length_values", &values).unwrap_or(made.by_word);
    let changes = [("shift", false), ("move", true)];
    made.moves = section.choice("length_change", &changes).unwrap_or(made.moves);
    made
}

/// Reads `[corners]`.
pub(super) fn corners(top: &mut TableReader<'_>) -> Corners {
    let mut made = Corners { between: 1, dwell_only: false, reduces: false, rapid: false };
    let Some(mut section) = top.table("corners", "[corners]") else { return made };
    if let Some(between) = section.integer("between", 0..=100) {
        made.between = between as u32;
    }
    made.dwell_only = section.choice("blocks", &[("any", false), ("dwell", true)]).unwrap_or(made.dwell_only);
    made.reduces = section.choice("too_long", &[("error", false), ("reduce", true)]).unwrap_or(made.reduces);
    made.rapid = section.flag("rapid").unwrap_or(made.rapid);
    section.finish();
    made
}
