//! The vocabulary of the control: keywords, statements, and G words that call a macro.

use counterpoint_control_api::interpreter::MacroCall;
use counterpoint_control_api::statement::{CLOSE_OUTPUT, OPEN_OUTPUT, Statements};
use counterpoint_program::key_words::KeyWords;

/// Key words: those of statements that other controls have too, each with its statement, and the control's own.
macro_rules! key_words {
    ([$($word:literal => $statement:expr),* $(,)?], [$($own:literal),*]) => {
        pub(super) const STATEMENTS: Statements<&str> = &[$(($word, &$statement)),*];
        pub(super) const KEY_WORDS: KeyWords = KeyWords { all: &[$($own,)* $($word),*], joined: "THEN" };
    };
}

key_words!(
    ["POPEN" => OPEN_OUTPUT, "PCLOS" => CLOSE_OUTPUT],
    ["IF", "WHILE", "GOTO", "DO", "END", "ENDIF", "ELSE", "THEN", "BPRNT", "DPRNT"]
);

/// How a G word calls.
pub(super) fn macro_call(g: f64) -> Option<MacroCall> {
    Some(match g {
        65.0 => MacroCall::Once,
        66.0 => MacroCall::AfterMoves,
        66.1 => MacroCall::EachBlock,
        67.0 => MacroCall::End,
        _ => return None,
    })
}
