//! `[output]`: the file that printing statements of the program write.
//!
//! Invariant: its name is a plain file name. Facts: reference fanuc-variables-and-alarms.md 2.5.

use crate::model::PrintFileFormat;
use crate::toml::section::TableReader;

/// Reads the section.
pub(super) fn read(top: &mut TableReader<'_>) -> PrintFileFormat {
    let mut output =
        PrintFileFormat { file: "dprnt.txt".to_owned(), padded: true, sign_column: true, line_end: "\n", opened: true };
    let Some(mut section) = top.table("output", "[output]") else { return output };
    if let Some(name) = section.name("file", 80) {
        let plain = |c: char| c.is_ascii_alphanumeric() || "-_.".contains(c);
        if name.chars().all(plain) && !name.starts_with('.') {
            name.clone_into(&mut output.file);
        } else {
            section.error("file", "`file` must be a file name of letters, digits, `-`, `_` and `.`");
        }
    }
    let zeros = [("spaces", true), ("none", false)];
    output.padded = section.choice("leading_zeros", &zeros).unwrap_or(output.padded);
    let signs = [("column", true), ("minus", false)];
    output.sign_column = section.choice("sign", &signs).unwrap_or(output.sign_column);
    let ends = [("lf", "\n"), ("cr-lf", "\r\n"), ("cr", "\r")];
    output.line_end = section.choice("line_end", &ends).unwrap_or(output.line_end);
    let opens = [("needed", true), ("not-needed", false)];
    output.opened = section.choice("open", &opens).unwrap_or(output.opened);
    section.finish();
    output
}
