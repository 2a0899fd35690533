//! Lines: an expression, a replacement, the text. Compiling, finding and editing end. The only fault at run time is the
//! used-up budget of steps, and a search never takes more time than its budget allows.
#![no_main]

use counterpoint_lang::diag::Number;
use counterpoint_lang::fault::Outcome;
use counterpoint_lang::pattern::Pattern;
use libfuzzer_sys::fuzz_target;
use std::time::{Duration, Instant};

const STEPS: u64 = 100_000;

fn within<T>(result: Outcome<T>) -> Option<T> {
    result.map_err(|fault| assert_eq!(fault.number, Number::BACKTRACKING, "{}", fault.message)).ok()
}

fuzz_target!(|input: &str| {
    let mut lines = input.splitn(3, '\n');
    let (expression, with, text) =
        (lines.next().unwrap_or(""), lines.next().unwrap_or(""), lines.next().unwrap_or("X1.5 Y-2"));
    let Ok(pattern) = Pattern::new(expression) else { return };
    let (mut budget, start) = (STEPS, Instant::now());
    let found = within(pattern.find(text, 0, &mut budget)).flatten();
    assert!(start.elapsed() < Duration::from_secs(10), "{} steps took too long", STEPS - budget);
    if let Some(found) = found {
        for (from, to) in found.groups.into_iter().flatten() {
            assert!(text.get(from..to).is_some(), "a group lies in the text, between characters");
        }
        let (from, to) = found.whole();
        assert_eq!(within(pattern.nth(text, None, 1)).flatten().as_deref(), text.get(from..to));
    }
    within(pattern.replace(text, with, 0));
    within(pattern.replace(text, with, 2));
    if let Some(pieces) = within(pattern.split(text, 0)) {
        assert!(!pieces.is_empty());
    }
});
