//! Formatting twice is formatting once, and the formatted macro has the code of the macro.
#![no_main]

use counterpoint_lang::compile::{self, Options, Program};
use counterpoint_lang_standalone::Standalone;
use counterpoint_lang::source::Source;
use counterpoint_lang::layout::{self, Style};
use libfuzzer_sys::fuzz_target;

/// Meaning of a text: the numbers of its errors, otherwise its instructions and constants.
fn meaning(text: &str) -> Result<Vec<String>, Vec<u32>> {
    let mut program = Program::new();
    let added = compile::add(&mut program, &mut Standalone::new(), Source::new("any", text), Options::default());
    if added.has_errors() {
        let mut numbers: Vec<u32> = added.diagnostics.iter().map(|diagnostic| diagnostic.number.0).collect();
        numbers.sort_unstable();
        return Err(numbers);
    }
    let code = |code: &std::sync::Arc<counterpoint_lang::bytecode::Code>| {
        format!("{} {:?} {:?} {:?} {:?}", code.name, code.ops, code.constants, code.lists, code.declarations)
    };
    Ok(program.macros.iter().map(code).collect())
}

fuzz_target!(|text: &str| {
    for style in [Style::Standard, Style::C] {
        let Ok(once) = layout::format(text, style) else { continue };
        assert_eq!(layout::format(&once, style).as_ref(), Ok(&once), "formatting twice changes it again");
        assert_eq!(meaning(&once), meaning(text), "formatting changes the meaning: {once}");
    }
});
