//! The tape editor of a machine on one line, rule by rule.
//!
//! *Invariant:* the last text is the line of a run with the rules that are on at the start of a program.

use counterpoint_lang::pattern::SearchMemory;
use counterpoint_machine::Machine;
use counterpoint_ports::control::StopSignal;
use counterpoint_ports::options::JobLimits;
use counterpoint_program::tape::{Tape, TapeRuleSet, Within};
use counterpoint_program::visible::RemarkDelimiters;

/// A rule that has changed the line.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct AppliedTapeRule {
    /// Its place in `Machine::tape_editor`.
    pub rule: usize,
    /// The line after it.
    pub text: Vec<u8>,
}

/// The rules that change a line, in the order in which they act: those that are on at the start of a program, or all of
/// them.
#[must_use]
pub fn steps(machine: &Machine, line: &[u8], all: bool) -> Vec<AppliedTapeRule> {
    let marks = RemarkDelimiters::new(&machine.format, counterpoint_controls::of(machine).syntax());
    let Some(tape) = Tape::new(&machine.tape_editor, marks) else { return Vec::new() };
    let (stop, longest) = (StopSignal::default(), JobLimits::default().block_length);
    let (mut memory, mut text, mut steps) = (SearchMemory::default(), line.to_vec(), Vec::new());
    for rule in (0..machine.tape_editor.len()).filter(|rule| all || tape.start.has(*rule)) {
        let mut on = TapeRuleSet::default();
        on.set(rule, true);
        let edited = tape.edit(&text, &Within { on: &on, longest, stop: &stop }, &mut memory);
        if let Some(changed) = edited.text {
            text.clone_from(&changed);
            steps.push(AppliedTapeRule { rule, text: changed });
        }
    }
    steps
}

#[cfg(test)]
mod tests {
    use super::*;
    use counterpoint_machine::load;
    use counterpoint_machine::package::Overlay;
    use counterpoint_ports::files::MemoryFiles;

    #[test]
    fn each_rule_acts_on_the_text_of_the_one_before() {
        let mut files = MemoryFiles::default();
        files.insert(
            "own/machine.toml",
            "extends = \"fanuc-mill\"\n[ce]\nname = \"own\"\n[[tape_editor]]\nfind = \"A1\"\nreplace = \"B2\"\n\
             [[tape_editor]]\nfind = \"C3\"\nreplace = \"D4\"\non = false\n[[tape_editor]]\nfind = \"B2\"\nreplace = \"C3\"\n",
        );
        let machine = load(&Overlay::over_shipped(files), "own").machine.expect("a machine");
        let texts = |line: &str, all: bool| {
            let steps = steps(&machine, line.as_bytes(), all);
            steps.into_iter().map(|step| (step.rule, String::from_utf8(step.text).expect("text"))).collect::<Vec<_>>()
        };
        assert_eq!(texts("A1 (A1)", false), [(0, "B2 (A1)".to_owned()), (2, "C3 (A1)".to_owned())]);
        assert_eq!(texts("C3", false), []);
        assert_eq!(texts("C3", true), [(1, "D4".to_owned())]);
    }
}
