//! Functions that need what is not here: a machine model, a composite, a screen.
//!
//! Invariant: each of them reports once in a run that nothing is there for it (2910070), and returns as if it had failed.

/// Functions named after the model that work without one: they read and set offsets and the local frame.
const HERE: [&str; 9] =
    ["$FMSGDCV", "$FMSGRCV", "$FMSGLCV", "$FMSGFCV", "$FMSSDCV", "$FMSSRCV", "$FMSSLCV", "$FMSSFCV", "$FMSLCS"];

/// Why a function has nothing to work on, if it has not.
#[must_use]
pub fn why(function: &str) -> Option<&'static str> {
    match function {
        "$FAPPLY" => Some("needs a composite machine, and there is none here"),
        "$FCETIMESYNC" => Some("needs a machine model, and there is none here: channels always run in one time"),
        "$FPAUSE" => Some("needs a screen, and a job runs in the background"),
        "$FDOC" => Some("needs a word processor, and there is none here"),
        name if name.starts_with("$FMS") && !HERE.contains(&name) => {
            Some("needs a machine model, and there is none here")
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn functions_of_offsets_work_without_a_model() {
        for name in HERE {
            assert!(counterpoint_lang::func::named(name).is_some(), "{name}");
            assert_eq!(why(name), None, "{name}");
        }
        assert!(why("$FMSGPOS").is_some_and(|why| why.contains("machine model")));
        assert_eq!((why("$FCEADD"), why("$FIK")), (None, None));
    }
}
