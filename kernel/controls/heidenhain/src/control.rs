//! Heidenhain as a dialect.

use super::{Heidenhain, iso};
use counterpoint_control_api::definition::Dialect;
use counterpoint_control_api::interpreter::Interpreter;
use counterpoint_machine::Machine;
use counterpoint_program::syntax::{PLAIN, Syntax};

static SYNTAX: Syntax = Syntax { needs_interpreter: Some(iso::needs_interpreter), ..PLAIN };

/// TNC controls.
pub struct HeidenhainDialect;

impl Dialect for HeidenhainDialect {
    fn name(&self) -> &'static str {
        "heidenhain"
    }

    fn title(&self) -> &'static str {
        "Heidenhain"
    }

    fn syntax(&self) -> &'static Syntax {
        &SYNTAX
    }

    fn settings(&self) -> &'static [&'static str] {
        &["SETFILEROOT", "CYCLEDEF", "SPINDLECYCLES", "GRAMMAR", "CONCATENATE", "KEEPCYCLDEFQVARS"]
    }

    fn reads_contours(&self) -> bool {
        true
    }

    fn interpreter(&self, _: &Machine) -> Option<Box<dyn Interpreter>> {
        Some(Box::<Heidenhain>::default())
    }
}
