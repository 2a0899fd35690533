//! The table of all dialects.
//!
//! *Invariant:* every pre-processor that a machine definition can name has its dialect here.

use super::plain;
use counterpoint_control_api::Dialect;
use counterpoint_control_fanuc::FanucDialect;
use counterpoint_control_heidenhain::HeidenhainDialect;
use counterpoint_control_isg::IsgDialect;
use counterpoint_control_okuma::OkumaDialect;
use counterpoint_control_rs274::{GRBL, GRBL_HAL, LINUX_CNC};
use counterpoint_control_siemens::SiemensDialect;
use counterpoint_machine::Machine;
use counterpoint_machine::preprocessor::Preprocessor;

/// A new control is one line here, one in the table of [`Preprocessor`], and its crate.
static DIALECTS: [&dyn Dialect; 9] = [
    &plain::PlainDialect,
    &FanucDialect,
    &OkumaDialect,
    &SiemensDialect,
    &HeidenhainDialect,
    &IsgDialect,
    &LINUX_CNC,
    &GRBL,
    &GRBL_HAL,
];

/// All dialects.
pub fn all() -> impl Iterator<Item = &'static dyn Dialect> {
    DIALECTS.into_iter()
}

/// The dialect of a machine.
pub fn of(machine: &Machine) -> &'static dyn Dialect {
    by_preprocessor(machine.preprocessor)
}

fn by_preprocessor(preprocessor: Preprocessor) -> &'static dyn Dialect {
    all().find(|dialect| dialect.name() == preprocessor.row().name).unwrap_or(&plain::PlainDialect)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_preprocessor_has_its_dialect() {
        assert_eq!(Preprocessor::all().len(), DIALECTS.len());
        for preprocessor in Preprocessor::all() {
            assert_eq!(by_preprocessor(preprocessor).name(), preprocessor.row().name);
        }
    }

    #[test]
    fn a_semicolon_never_ends_a_block_where_it_starts_a_comment() {
        // Blocks of controls with such comments go to their interpreters as whole lines.
        for preprocessor in Preprocessor::all().filter(|preprocessor| preprocessor.row().semicolon_comments) {
            assert!(by_preprocessor(preprocessor).syntax().needs_interpreter.is_some());
        }
    }
}
