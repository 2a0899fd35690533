//! Words of macro calls, which the pre-processor of Fanuc controls reads without a row of the machine.
//!
//! Facts: custom macro of Fanuc controls, argument specification I. *Invariant:* a word of a table of codes is not
//! here.

use counterpoint_kernel::machine::Machine;
use serde_json::{Value, json};

/// Words of calls, without points.
const CALLS: [&str; 3] = ["G65", "G66", "G66.1"];

/// Letters of arguments with the numbers of their local variables.
pub(super) const LETTERS: [(char, u32); 21] = [
    ('A', 1),
    ('B', 2),
    ('C', 3),
    ('I', 4),
    ('J', 5),
    ('K', 6),
    ('D', 7),
    ('E', 8),
    ('F', 9),
    ('H', 11),
    ('M', 13),
    ('Q', 17),
    ('R', 18),
    ('S', 19),
    ('T', 20),
    ('U', 21),
    ('V', 22),
    ('W', 23),
    ('X', 24),
    ('Y', 25),
    ('Z', 26),
];

/// Words that a macro call reads; none for other words and controls.
pub(super) fn of(machine: &Machine, asked: &str) -> Vec<Value> {
    let call = CALLS.iter().any(|call| call.eq_ignore_ascii_case(asked));
    if !call || machine.preprocessor.row().name != "fanuc" {
        return Vec::new();
    }
    let row = |word: &str, meaning: String| json!({ "word": word, "meaning": meaning });
    let mut rows =
        vec![row("P", "number of the called program".to_owned()), row("L", "repeat count of the call".to_owned())];
    let argument =
        |(letter, number): &(char, u32)| row(&letter.to_string(), format!("argument, local variable #{number}"));
    rows.extend(LETTERS.iter().map(argument));
    rows.push(row("I J K", "repeated: triples of arguments, #4 to #6, #7 to #9 and so on up to #33".to_owned()));
    rows
}
