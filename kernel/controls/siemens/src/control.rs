//! Siemens 840D as a dialect.

use super::{Siemens, needs_interpreter};
use counterpoint_control_api::definition::{Dialect, Unknown};
use counterpoint_control_api::interpreter::Interpreter;
use counterpoint_control_api::outline::OutlineReader;
use counterpoint_machine::Machine;
use counterpoint_program::syntax::{PLAIN, Syntax};

static SYNTAX: Syntax = Syntax {
    numbered_programs: false,
    named_programs: Some(super::archive::PROGRAMS),
    needs_interpreter: Some(needs_interpreter),
    keeps_names: true,
    ..PLAIN
};

/// 840D controls.
pub struct SiemensDialect;

impl Dialect for SiemensDialect {
    fn name(&self) -> &'static str {
        "siemens"
    }

    fn title(&self) -> &'static str {
        "Siemens"
    }

    fn syntax(&self) -> &'static Syntax {
        &SYNTAX
    }

    fn settings(&self) -> &'static [&'static str] {
        &[
            "PROCESS,SUBPROGRAMS",
            "APPLYFRAMES",
            "GLOBALDEF",
            "PROCESSGUDFILES",
            "SETFILEROOT",
            "COLLAPSEASSIGNSPACES",
            "COLLAPSEASSIGNS",
            "SETALSEVERITY",
        ]
    }

    fn reads_contours(&self) -> bool {
        true
    }

    fn unknown_g_code(&self) -> Option<&'static str> {
        Some("12470 unknown G function")
    }

    fn unknown_text(&self, text: &str, _: Unknown) -> String {
        format!("12550 name not defined or option missing: {text} is not known")
    }

    fn reader(&self, _: &Machine) -> Option<Box<dyn OutlineReader>> {
        Some(Box::<super::outline::SiemensOutlineReader>::default())
    }

    fn interpreter(&self, _: &Machine) -> Option<Box<dyn Interpreter>> {
        Some(Box::<Siemens>::default())
    }
}
