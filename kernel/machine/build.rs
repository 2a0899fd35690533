//! Compiles the kernel again when a shipped machine is added or removed; their texts are embedded.

fn main() {
    println!("cargo:rerun-if-changed=../../machines");
}
