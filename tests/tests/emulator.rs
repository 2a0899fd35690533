//! The pages of `tests/spec/emulator`: the behaviour of the emulated control. One test per example.

use std::process::ExitCode;

fn main() -> ExitCode {
    counterpoint_tests::spec::suite("emulator").run()
}
