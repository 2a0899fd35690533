//! Checks of the options of a job.

use counterpoint_event::{Letters, letters};
use counterpoint_machine::finding::Finding;

use crate::spec::Spec;

/// Characters that the user's parameters of a job may have.
const MOST_PARAMETERS: usize = 1000;

/// Reports each option that the machine of the job cannot take.
pub(crate) fn check(spec: &Spec, findings: &mut Vec<Finding>) {
    let mut wrong = |text: String| findings.push(Finding::error("job", 0, 0, text));
    for level in &spec.options.opskip {
        if *level > 9 {
            wrong(format!("block skip level {level} is not valid: expected 1 to 9, or 0 for the level of the machine"));
        }
    }
    let parameters = &spec.options.parameters;
    if parameters.chars().count() > MOST_PARAMETERS || parameters.chars().any(char::is_control) {
        wrong(format!("the parameters must be one line of at most {MOST_PARAMETERS} characters"));
    }
    if let Err(letter) = Letters::parse(&spec.options.trace) {
        wrong(format!("'{}' is not a valid trace letter: expected any of {}", letter.escape_debug(), letters::ALL));
    }
    counterpoint_ports::dialog::answers::check(&spec.machine.dialogs, &spec.options.answers)
        .into_iter()
        .for_each(&mut wrong);
    for channel in &spec.options.ignore_waits {
        if !spec.machine.channels.iter().any(|c| c.number == *channel) {
            wrong(format!("channel {channel} of ignore_waits is not on machine {}", spec.machine.name));
        }
    }
}
