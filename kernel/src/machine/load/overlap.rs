//! Code rows that hide each other.
//!
//! Invariant: only a warning, because the order in the file decides. Facts: reference control-emulator.md 1.2.

use crate::machine::model::{CodeRow, Register};
use crate::machine::tables::{form_range, overlap};
use crate::machine::toml::check::Check;
use crate::machine::toml::node::Place;

/// Warns about rows of equal order for the same word, the later of which can never match there.
pub(super) fn check_codes(codes: &[CodeRow], registers: &[Register], check: &Check) {
    let mut by_word: Vec<(u8, f64, f64, &CodeRow)> = codes
        .iter()
        .filter(|row| row.enable)
        .filter_map(|row| form_range(&row.form).map(|(register, min, max)| (register, min, max, row)))
        .collect();
    by_word.sort_by_key(|(register, _, _, _)| *register);
    for same in by_word.chunk_by(|a, b| a.0 == b.0) {
        for (index, (register, min, max, later)) in same.iter().enumerate() {
            let hidden = same.iter().take(index).find(|(_, from, to, earlier)| {
                earlier.order == later.order && overlap((*min, *max), (*from, *to)) && hides(earlier, later)
            });
            if let Some((_, _, _, earlier)) = hidden {
                let letter = registers.get(usize::from(*register)).map_or("?", |register| register.name.as_str());
                warn(letter, (*min, *max), later, earlier, check);
            }
        }
    }
}

/// Whether the earlier row is taken whenever the later one could be.
fn hides(earlier: &CodeRow, later: &CodeRow) -> bool {
    if earlier.id == later.id && earlier.form == later.form {
        return false; // the same row twice is an error of its own
    }
    let always = earlier.with.is_empty() && earlier.without.is_empty();
    always || (earlier.with == later.with && earlier.without == later.without)
}

fn warn(letter: &str, (min, max): (f64, f64), later: &CodeRow, earlier: &CodeRow, check: &Check) {
    let written = if min == max { format!("{letter}{min}") } else { format!("{letter}{min}-{letter}{max}") };
    let order = later.order;
    let text = format!(
        "{written} overlaps the row at {}:{}, which has the same order {order} and comes first",
        earlier.file, earlier.line
    );
    check.warning(&Place { file: later.file.as_str().into(), line: later.line, column: 1 }, text);
}
