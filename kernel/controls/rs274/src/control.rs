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

/// A control with this language.
pub struct Rs274Dialect {
    kind: Rs274Kind,
    name: &'static str,
    title: &'static str,
}

/// LinuxCNC.
pub static LINUX_CNC: Rs274Dialect = Rs274Dialect { kind: Rs274Kind::LinuxCnc, name: "linuxcnc", title: "LinuxCNC" };

/// GRBL 1.1.
pub static GRBL: Rs274Dialect = Rs274Dialect { kind: Rs274Kind::Grbl, name: "grbl", title: "GRBL" };

/// grblHAL.
pub static GRBL_HAL: Rs274Dialect = Rs274Dialect { kind: Rs274Kind::GrblHal, name: "grblhal", title: "grblHAL" };

impl Rs274Dialect {
    fn new_interpreter(&self, machine: &Machine) -> Rs274 {
        Rs274::new(self.kind, machine.variables.system.initial.iter().copied())
    }
}

impl Dialect for Rs274Dialect {
    fn name(&self) -> &'static str {
        self.name
    }

    fn title(&self) -> &'static str {
        self.title
    }

    fn syntax(&self) -> &'static Syntax {
        &SYNTAX
    }

    fn unknown_text(&self, text: &str, _: Unknown) -> String {
        let error = if self.kind.is_firmware() { "error:20 " } else { "" };
        format!("{error}{text} is not known to this control")
    }

    fn reader(&self, machine: &Machine) -> Option<Box<dyn OutlineReader>> {
        Some(Box::new(self.new_interpreter(machine)))
    }

    fn interpreter(&self, machine: &Machine) -> Option<Box<dyn Interpreter>> {
        Some(Box::new(self.new_interpreter(machine)))
    }
}
