//! Any macro that compiles runs to an end within small budgets, and short forms of instructions change nothing of it.
#![no_main]

use counterpoint_lang::bytecode::fast::Fast;
use counterpoint_lang::compile::{self, Options, Program};
use counterpoint_lang_standalone::Standalone;
use counterpoint_lang::source::Source;
use counterpoint_lang::value::Value;
use counterpoint_lang::vm::{self, Limits, State};
use libfuzzer_sys::fuzz_target;
use std::sync::Arc;

/// Everything that can be seen of a run, as text.
fn seen(program: &Program, macros: &[u16], host: &mut Standalone) -> String {
    let limits = Limits { ticks: 20_000, depth: 8, text: 2_000, elements: 1_000, units: 3, ..Limits::default() };
    let mut state = State::new(limits);
    let mut arguments = [Value::Real(1.0), Value::text("a")];
    let mut seen = String::new();
    for index in macros {
        let end = vm::run(program, &mut state, host, *index, &mut arguments);
        assert_eq!(state.depth, 0, "every macro that is entered is left");
        seen += &format!("{end:?} {arguments:?} {} ticks left\n", state.ticks);
    }
    vm::close_all(&mut state, host);
    seen + &format!("{:?} {:?} {:?} {:?}", host.output.printed, host.output.commands, host.output.diagnostics, host.output.traced)
}

fuzz_target!(|text: &str| {
    let (mut program, mut host) = (Program::new(), Standalone::new());
    let options = Options { trace: text.len() % 8 == 0, ..Options::default() };
    let added = compile::add(&mut program, &mut host, Source::new("any", text), options);
    if added.has_errors() {
        return;
    }
    let short = seen(&program, &added.macros, &mut host);
    let (mut program, mut host) = (Program::new(), Standalone::new());
    let added = compile::add(&mut program, &mut host, Source::new("any", text), options);
    program.macros.iter_mut().for_each(|code| Arc::make_mut(code).short.forms.fill(Fast::None));
    assert_eq!(short, seen(&program, &added.macros, &mut host));
});
