//! Okuma.

use counterpoint_lang::value::Value;

use super::{Host, Interpreter, Setting};
use crate::channel::Halt;

/// The pre-processor with its variables.
#[derive(Debug, Default)]
pub(crate) struct Okuma {}

/// Whether a block is anything but plain words.
pub(crate) fn concerns(_text: &[u8]) -> bool {
    false
}

impl Interpreter for Okuma {
    fn block(&mut self, _host: &mut dyn Host, _text: &[u8]) -> Result<Option<String>, Halt> {
        Ok(None)
    }

    fn begin(&mut self, _reset: bool) {}

    fn entered(&mut self, _host: &mut dyn Host) {}

    fn left(&mut self, _host: &mut dyn Host) {}

    fn variable(&mut self, _: &mut dyn Host, _: &str, _: &[f64]) -> Result<Option<Value>, Halt> {
        Ok(None)
    }

    fn set_variable(&mut self, _: &mut dyn Host, _: &str, _: &[f64], _: &Value) -> Result<bool, Halt> {
        Ok(false)
    }

    fn setting(&mut self, _: &str, _: &[Value]) -> Setting {
        Setting::Unknown
    }
}
