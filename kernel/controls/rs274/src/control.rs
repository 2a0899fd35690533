//! LinuxCNC, GRBL and grblHAL as dialects.

use super::Rs274;
use super::codes::Rs274Kind;
use counterpoint_control_api::definition::{Dialect, Unknown};
use counterpoint_control_api::interpreter::Interpreter;
use counterpoint_control_api::outline::OutlineReader;
use counterpoint_machine::Machine;
use counterpoint_program::syntax::{PLAIN, Syntax};

static SYNTAX: Syntax =
    Syntax { numbered_programs: false, needs_interpreter: Some(needs_interpreter), keeps_names: true, ..PLAIN };

/// The interpreter gets every block: it keeps the active motion and refuses the blocks that the control refuses.
fn needs_interpreter(text: &[u8]) -> bool {
    !text.trim_ascii().is_empty()
}

/// LinuxCNC.
pub struct LinuxCncDialect;

/// GRBL 1.1.
pub struct GrblDialect;

/// grblHAL.
pub struct GrblHalDialect;

fn interpreter(machine: &Machine, kind: Rs274Kind) -> Rs274 {
    Rs274::new(kind, machine.variables.system.initial.iter().copied())
}

impl Dialect for LinuxCncDialect {
    fn name(&self) -> &'static str {
        "linuxcnc"
    }

    fn title(&self) -> &'static str {
        "LinuxCNC"
    }

    fn syntax(&self) -> &'static Syntax {
        &SYNTAX
    }

    fn unknown_text(&self, text: &str, _: Unknown) -> String {
        format!("{text} is not known to this control")
    }

    fn reader(&self, machine: &Machine) -> Option<Box<dyn OutlineReader>> {
        Some(Box::new(interpreter(machine, Rs274Kind::LinuxCnc)))
    }

    fn interpreter(&self, machine: &Machine) -> Option<Box<dyn Interpreter>> {
        Some(Box::new(interpreter(machine, Rs274Kind::LinuxCnc)))
    }
}

impl Dialect for GrblDialect {
    fn name(&self) -> &'static str {
        "grbl"
    }

    fn title(&self) -> &'static str {
        "GRBL"
    }

    fn syntax(&self) -> &'static Syntax {
        &SYNTAX
    }

    fn unknown_text(&self, text: &str, _: Unknown) -> String {
        format!("error:20 {text} is not known to this control")
    }

    fn reader(&self, machine: &Machine) -> Option<Box<dyn OutlineReader>> {
        Some(Box::new(interpreter(machine, Rs274Kind::Grbl)))
    }

    fn interpreter(&self, machine: &Machine) -> Option<Box<dyn Interpreter>> {
        Some(Box::new(interpreter(machine, Rs274Kind::Grbl)))
    }
}

impl Dialect for GrblHalDialect {
    fn name(&self) -> &'static str {
        "grblhal"
    }

    fn title(&self) -> &'static str {
        "grblHAL"
    }

    fn syntax(&self) -> &'static Syntax {
        &SYNTAX
    }

    fn unknown_text(&self, text: &str, _: Unknown) -> String {
        format!("error:20 {text} is not known to this control")
    }

    fn reader(&self, machine: &Machine) -> Option<Box<dyn OutlineReader>> {
        Some(Box::new(interpreter(machine, Rs274Kind::GrblHal)))
    }

    fn interpreter(&self, machine: &Machine) -> Option<Box<dyn Interpreter>> {
        Some(Box::new(interpreter(machine, Rs274Kind::GrblHal)))
    }
}
