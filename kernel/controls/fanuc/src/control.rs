//! Fanuc custom macro as a dialect.

use super::Fanuc;
use super::vocabulary::{KEY_WORDS, macro_call};
use counterpoint_control_api::definition::{Dialect, Unknown};
use counterpoint_control_api::interpreter::{Interpreter, MacroCall};
use counterpoint_control_api::outline::OutlineReader;
use counterpoint_machine::Machine;
use counterpoint_program::syntax::{PLAIN, Syntax};

static SYNTAX: Syntax = Syntax { angle_names: true, call_words: &["G65", "G66"], key_words: Some(KEY_WORDS), ..PLAIN };

/// Fanuc controls and those with their macro language.
pub struct FanucDialect;

impl Dialect for FanucDialect {
    fn name(&self) -> &'static str {
        "fanuc"
    }

    fn title(&self) -> &'static str {
        "Fanuc"
    }

    fn syntax(&self) -> &'static Syntax {
        &SYNTAX
    }

    fn settings(&self) -> &'static [&'static str] {
        &["PROCESS,SYSVARASSIGNMENT", "USENULL"]
    }

    fn macro_call(&self, g: f64) -> Option<MacroCall> {
        macro_call(g)
    }

    fn interpreter(&self, _: &Machine) -> Option<Box<dyn Interpreter>> {
        self.nested()
    }

    fn reader(&self, _: &Machine) -> Option<Box<dyn OutlineReader>> {
        Some(Box::<Fanuc>::default())
    }

    fn nested(&self) -> Option<Box<dyn Interpreter>> {
        Some(Box::<Fanuc>::default())
    }

    fn lead_is_feed(&self) -> bool {
        true
    }

    fn unknown_g_code(&self) -> Option<&'static str> {
        Some("PS0010 improper G-code")
    }

    fn unknown_text(&self, text: &str, kind: Unknown) -> String {
        match kind {
            Unknown::Word => format!("PS0009 improper address: this control has no address for {text}"),
            Unknown::Address => format!("PS0005 no number: {text} has no number"),
            Unknown::Text if text.starts_with('.') => {
                format!("PS0007 decimal point: {text} comes after another point")
            }
            Unknown::Text => format!("PS0004 bad word: {text} is not a word"),
        }
    }
}
