//! No pre-processor: plain words only.

use counterpoint_control_api::Dialect;
use counterpoint_program::syntax::{PLAIN, Syntax};

/// A control that understands words and nothing else.
pub(crate) struct PlainDialect;

impl Dialect for PlainDialect {
    fn name(&self) -> &'static str {
        "none"
    }

    fn title(&self) -> &'static str {
        ""
    }

    fn syntax(&self) -> &'static Syntax {
        &PLAIN
    }
}
