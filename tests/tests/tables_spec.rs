//! The pages of `tests/spec/tables`: the meaning of the tables of a machine definition. One test per example.

use std::process::ExitCode;

fn main() -> ExitCode {
    counterpoint_tests::spec::suite("tables").run()
}
