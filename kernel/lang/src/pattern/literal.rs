//! The text that every match of an expression contains.
//!
//! *Invariant:* a text without this literal holds no match, so that many expressions can be ruled out by one search for
//! their literals. Steps that a match may bypass are left out.

use super::{CharClass, PatternStep, TextPattern};

/// The longest literal that every match contains, empty when there is none.
pub(super) fn required(pattern: &TextPattern) -> String {
    let mut best = String::new();
    let mut run = String::new();
    let mut free = 0;
    for (index, step) in pattern.steps.iter().enumerate() {
        if let PatternStep::Split(target) | PatternStep::Jump(target) = step
            && *target > index
        {
            // Alternatives before the target may be bypassed.
            free = free.max(*target);
        }
        let certain = index >= free;
        match step {
            PatternStep::One(CharClass::One(one)) if certain => run.push(*one),
            PatternStep::Run(CharClass::One(one), 1.., _) if certain => {
                run.push(*one);
                keep(&mut best, &run);
                run.clear();
            }
            PatternStep::Save(_)
            | PatternStep::Start
            | PatternStep::End
            | PatternStep::WordStart
            | PatternStep::WordEnd
                if certain => {}
            _ => {
                keep(&mut best, &run);
                run.clear();
            }
        }
    }
    keep(&mut best, &run);
    best
}

fn keep(best: &mut String, run: &str) {
    if run.len() > best.len() {
        run.clone_into(best);
    }
}
