//! Pre-processors: what turns a program line with variables and statements into plain words.
//!
//! Facts: reference control-emulator.md 5.4. That of Fanuc is woven into the scanner, since its expressions stand among
//! the words of any block; the others are [`Interpreter`]s, which get the text of a block that is not plain words and
//! leave a text that is. Invariant: an interpreter reaches its kernel only through [`Host`].

pub(crate) mod fanuc;
mod heidenhain;
mod host;
pub(crate) mod kept;
mod numeric;
pub(crate) mod okuma;
mod siemens;
mod text;

pub(crate) use host::{Answer, AxisPlace, Call, Host, Interpreter, Modes, Place, Setting};

use crate::machine::Machine;
use crate::machine::model::Preprocessor;

/// A new interpreter; none for controls without one, and for custom macro.
pub(crate) fn interpreter(machine: &Machine) -> Option<Box<dyn Interpreter>> {
    Some(match machine.preprocessor {
        Preprocessor::None | Preprocessor::Fanuc => return None,
        Preprocessor::Okuma => Box::new(okuma::Okuma::new(machine.macros.is_none())),
        Preprocessor::Siemens => Box::new(siemens::Siemens::default()),
        Preprocessor::Heidenhain => Box::new(heidenhain::Heidenhain::default()),
    })
}

/// Which blocks are for the interpreter of a control: a quick look at the text, false for plain words.
pub(crate) fn concerns(preprocessor: Preprocessor) -> Option<fn(&[u8]) -> bool> {
    Some(match preprocessor {
        Preprocessor::None | Preprocessor::Fanuc => return None,
        Preprocessor::Okuma => okuma::concerns,
        Preprocessor::Siemens => siemens::concerns,
        Preprocessor::Heidenhain => heidenhain::concerns,
    })
}
