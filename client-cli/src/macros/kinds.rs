//! The kinds of macros by name: when each one runs, and its arguments.
//!
//! *Invariant:* every hook of the control has a row; a test compares them.

use std::fmt::Write as _;

use counterpoint_kernel::machine::macros::model::Hook;

use super::terms::arguments_of;

/// Key in machine.toml, the kind under which the arguments are listed, and when the macro runs.
type Row = (&'static str, &'static str, &'static str);

const HOOKS: &[Row] = &[
    (
        "declaration",
        "",
        "Runs before all other macros, in the master and in every channel; it declares what all macros share.",
    ),
    ("machine_startup", "", "Runs in the master kernel of a machine with several channels, before the first of them."),
    ("machine_shutdown", "", "Runs in the master kernel of a machine with several channels, after the last of them."),
    ("program_startup", "", "Runs in every channel before its first block."),
    ("program_shutdown", "", "Runs in every channel after its last block."),
    ("subprogram_startup", "subprogram startup and shutdown", "Runs before each pass of a subprogram."),
    ("subprogram_shutdown", "subprogram startup and shutdown", "Runs after each pass of a subprogram."),
    ("preprocessor_startup", "pre-processor startup and shutdown", "Runs before the pre-processor processes a block."),
    (
        "preprocessor_shutdown",
        "pre-processor startup and shutdown",
        "Runs after the pre-processor has processed a block.",
    ),
    ("block_startup", "block startup and shutdown", "Runs before a block is split into codes and data."),
    ("block_shutdown", "block startup and shutdown", "Runs after the codes of a block."),
    ("motion", "motion event", "Runs before a motion; OUTPUT executes the motion."),
    ("cycle", "cycle event", "Runs before the moves of each hole of a canned cycle; OUTPUT executes the moves."),
    ("tool", "tool event", "Runs before a tool or head is selected or loaded; OUTPUT executes the change."),
    ("diagnostic", "diagnostic event", "Runs before a diagnostic is issued; OUTPUT issues the diagnostic at once."),
    (
        "preprocessor_identification",
        "pre-processor identification",
        "Runs when the pre-processor finds an unknown variable or function.",
    ),
];

const NAMED: &[Row] = &[
    (
        "code",
        "code macro",
        "A row of [[macros.code]]: runs in place of the codes that it matches; OUTPUT executes the code.",
    ),
    ("data", "data macro", "A row of [[macros.data]]: runs when an action takes a value, and may change the value."),
];

/// The name without the part that all such names have.
fn plain(name: &str) -> String {
    let name = name.to_lowercase().replace("pre-processor", "preprocessor").replace('_', " ");
    let name = name.trim();
    let name = name.strip_suffix("macro").unwrap_or(name).trim();
    name.strip_suffix("event").unwrap_or(name).trim().to_owned()
}

/// Description of a kind of macro.
pub(super) fn kind(what: &str) -> Option<String> {
    let wanted = plain(what);
    let title = |key: &str| Hook::ALL.into_iter().find(|hook| hook.key() == key).map(Hook::title);
    let hook = HOOKS.iter().find(|(key, ..)| plain(key) == wanted || title(key).is_some_and(|t| plain(t) == wanted));
    // The words alone mean other things, too.
    let named = || NAMED.iter().find(|(_, kind, _)| what.trim().eq_ignore_ascii_case(kind));
    let (key, arguments, about) = hook.or_else(named)?;
    let mut out = match title(key) {
        Some(title) => format!("{title}\n`{key}` of [macros] in the machine file\n\n{about}\n"),
        None => format!("{arguments}\n\n{about}\n"),
    };
    for (number, about) in arguments_of(arguments) {
        let may = if about.starts_with('*') { ", may be set" } else { "" };
        let _ = writeln!(out, "$P{number}: {}{may}", about.trim_start_matches("* "));
    }
    Some(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_hook_is_explained_by_its_key_and_by_its_title() {
        assert_eq!(HOOKS.len(), Hook::ALL.len());
        for hook in Hook::ALL {
            let by_key = kind(hook.key());
            assert!(by_key.as_ref().is_some_and(|text| text.starts_with(hook.title())), "{hook:?}");
            assert_eq!(kind(hook.title()), by_key, "{hook:?}");
        }
        assert_eq!(kind("motion event"), kind("Motion"));
        assert!(kind("tool").is_some_and(|text| text.contains("$P3: the tool or head\n")));
        assert!(kind("block startup macro").is_some_and(|text| text.contains("$P2: the block, may be set\n")));
        assert!(kind("Data Macro").is_some_and(|text| text.contains("$P2: the value, may be set\n")));
        assert_eq!((kind("code"), kind(""), kind("macro")), (None, None, None));
    }
}
