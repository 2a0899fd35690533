//! Okuma user task as a dialect.

use super::programs::{called, program_name, returns};
use super::{Okuma, line, quick_look};
use counterpoint_control_api::definition::Dialect;
use counterpoint_control_api::interpreter::Interpreter;
use counterpoint_control_api::outline::OutlineReader;
use counterpoint_machine::Machine;
use counterpoint_machine::rows::{CodeForm, CodeRow};
use counterpoint_program::syntax::{NamedPrograms, PLAIN, Syntax};

static SYNTAX: Syntax = Syntax {
    named_programs: Some(NamedPrograms {
        defined: program_name,
        called,
        is_header: line::is_header,
        returns,
        in_archive: None,
    }),
    needs_interpreter: Some(quick_look::needs_interpreter),
    ..PLAIN
};

/// OSP controls.
pub struct OkumaDialect;

impl Dialect for OkumaDialect {
    fn name(&self) -> &'static str {
        "okuma"
    }

    fn title(&self) -> &'static str {
        "Okuma"
    }

    fn syntax(&self) -> &'static Syntax {
        &SYNTAX
    }

    fn settings(&self) -> &'static [&'static str] {
        &[
            "PROCESS,SUBPROGRAMS",
            "PROCESS,SEQNAME",
            "PROCESS,EXECUTIONS",
            "PROCESS,CONTOURS",
            "PROCESS,DRAWING",
            "PROCESS,TOOLOFFSETS",
        ]
    }

    fn reader(&self, machine: &Machine) -> Option<Box<dyn OutlineReader>> {
        let macros = machine.macros.is_some();
        let drills = |row: &CodeRow| {
            row.enable
                && matches!(row.form, CodeForm::Register { register, min, max }
                if machine.registers[register].name == "G" && min <= 81.0 && max >= 81.0)
        };
        let contours = macros && !machine.codes.iter().any(drills);
        Some(Box::new(super::outline::OkumaOutlineReader::new(macros, contours)))
    }

    fn interpreter(&self, machine: &Machine) -> Option<Box<dyn Interpreter>> {
        Some(Box::new(Okuma::new(machine.macros.is_none())))
    }
}
