//! Functions that need what is not here: a machine model, a composite, a screen.
//!
//! Invariant: each of them reports once in a run that nothing is there for it (2910070), and returns as if it had failed.

use counterpoint_lang::host::HostFn;

/// Why a function has nothing to work on, if it has not.
#[must_use]
pub fn why(function: HostFn) -> Option<&'static str> {
    match function {
        HostFn::Apply => Some("needs a composite machine, and there is none here"),
        HostFn::TimeSync => Some("needs a machine model, and there is none here: channels always run in one time"),
        HostFn::Pause => Some("needs a screen, and a job runs in the background"),
        HostFn::Document => Some("needs a word processor, and there is none here"),
        function if function.needs_model() => Some("needs a machine model, and there is none here"),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn functions_of_offsets_work_without_a_model() {
        assert!(why(HostFn::ModelPosition).is_some_and(|why| why.contains("machine model")));
        for function in [HostFn::LengthOffset, HostFn::LocalFrame, HostFn::AddItem, HostFn::InverseKinematics] {
            assert_eq!(why(function), None, "{}", function.name());
        }
    }
}
