//! The code of the repository is as it must be; `cargo xtask tidy` prints the same.

use std::path::Path;

#[test]
fn the_code_is_tidy() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let findings = xtask::tidy::check(&root, false).expect("the code can be read");
    assert!(findings.is_empty(), "{}", findings.join("\n"));
}
