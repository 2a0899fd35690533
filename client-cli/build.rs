//! The pages of the diagnostics are part of the program.

fn main() {
    println!("cargo:rerun-if-changed=../docs/diagnostics");
}
