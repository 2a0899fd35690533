//! The text that every match of an expression contains.
//!
//! *Invariant:* a text without this literal holds no match, so that many expressions can be ruled out by one search for
//! their literals. Steps that a match may bypass are left out.

use super::{Class, Pattern, Step};

/// The longest literal that every match contains, empty when there is none.
pub(super) fn required(pattern: &Pattern) -> String {
    let mut best = String::new();
    let mut run = String::new();
    let mut free = 0;
    for (index, step) in pattern.steps.iter().enumerate() {
        if let Step::Split(target) | Step::Jump(target) = step
            && *target > index
        {
            // Alternatives before the target may be bypassed.
            free = free.max(*target);
        }
        let certain = index >= free;
        match step {
            Step::One(Class::One(one)) if certain => run.push(*one),
            Step::Run(Class::One(one), 1.., _) if certain => {
                run.push(*one);
                keep(&mut best, &run);
                run.clear();
            }
            Step::Save(_) | Step::Start | Step::End | Step::WordStart | Step::WordEnd if certain => {}
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
