//! Any macro that compiles runs to an end within small budgets.
#![no_main]

use counterpoint_lang::compile::{self, Options, Program};
use counterpoint_lang::host::Test;
use counterpoint_lang::source::Source;
use counterpoint_lang::value::Value;
use counterpoint_lang::vm::{self, Limits, State};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|text: &str| {
    let (mut program, mut host) = (Program::new(), Test::new());
    let options = Options { trace: text.len() % 8 == 0, ..Options::default() };
    let added = compile::add(&mut program, &mut host, Source::new("any", text), options);
    if added.has_errors() {
        return;
    }
    let limits = Limits { ticks: 20_000, depth: 8, text: 2_000, elements: 1_000, units: 3 };
    let mut state = State::new(limits);
    for index in added.macros {
        vm::run(&program, &mut state, &mut host, index, &mut [Value::Real(1.0), Value::text("a")]);
        assert_eq!(state.depth, 0, "every macro that is entered is left");
    }
    vm::close_all(&mut state, &mut host);
});
