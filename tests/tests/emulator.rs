//! The pages of `tests/spec/emulator`: what the emulated control does. One test an example.

use std::process::ExitCode;

fn main() -> ExitCode {
    counterpoint_tests::spec::suite("emulator").run()
}
