//! Any bytes are parsed and checked, and every diagnostic can be shown; the first byte chooses how.
#![no_main]

use counterpoint_lang::compile::{self, Options, Place, Program, Strong};
use counterpoint_lang_standalone::Standalone;
use counterpoint_lang::source::Source;
use libfuzzer_sys::fuzz_target;

fn options(byte: u8) -> Options {
    Options {
        strong: [Strong::Off, Strong::Partial, Strong::Full, Strong::Off][usize::from(byte & 3)],
        uninitialised: byte & 4 != 0,
        trace: byte & 8 != 0,
        place: [Place::Any, Place::Declaration, Place::Data, Place::Startup][usize::from(byte >> 4 & 3)],
        globals_are_objects: byte & 64 != 0,
    }
}

fuzz_target!(|bytes: &[u8]| {
    let Some((first, text)) = bytes.split_first() else { return };
    let (mut program, mut host) = (Program::new(), Standalone::new());
    let added = compile::add(&mut program, &mut host, Source::from_bytes("any", text), options(*first));
    for diagnostic in &added.diagnostics {
        std::hint::black_box(diagnostic.to_string());
    }
    let (mut program, source) = (Program::new(), Source::from_bytes("any", text));
    std::hint::black_box(compile::embedded(&mut program, &mut host, source, options(*first)));
});
