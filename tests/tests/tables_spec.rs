//! The pages of `tests/spec/tables`: what the tables of a machine definition mean. One test an example.

use std::process::ExitCode;

fn main() -> ExitCode {
    counterpoint_tests::spec::suite("tables").run()
}
