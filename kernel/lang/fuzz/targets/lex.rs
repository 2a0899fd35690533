//! Any bytes become lines of tokens.
#![no_main]

use counterpoint_lang::lex;
use counterpoint_lang::source::Source;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let source = Source::from_bytes("any", bytes);
    let (lines, diagnostics) = lex::lex(&source);
    std::hint::black_box((lines, diagnostics));
});
