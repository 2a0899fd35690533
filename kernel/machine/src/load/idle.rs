//! Macros of hooks whose event never comes on this machine.
//!
//! Invariant: only a warning, and none for families, since missing parts may come with the machine. Facts: reference
//! control-emulator.md 4.

use crate::ident::codes;
use crate::ident::kind::CodeKind;
use crate::macros::model::Hook;
use crate::preprocessor::Preprocessor;
use crate::rows::CodeRow;
use crate::toml::check::FindingCollector;
use crate::toml::section::TableReader;

/// Warns about each of them at its key.
pub(super) fn check(
    top: &mut TableReader<'_>,
    rows: &[CodeRow],
    preprocessor: Preprocessor,
    channels: usize,
    check: &FindingCollector,
) {
    let Some(mut section) = top.table("macros", "[macros]") else { return };
    for hook in Hook::ALL {
        if section.node(hook.key()).is_none() {
            continue;
        }
        if let Some(why) = why(hook, rows, preprocessor, channels) {
            check.idle(section.place_of(hook.key()), format!("the {} never runs: {why}", hook.title()));
        }
    }
}

fn why(hook: Hook, rows: &[CodeRow], preprocessor: Preprocessor, channels: usize) -> Option<&'static str> {
    let any = |wanted: &dyn Fn(&CodeRow) -> bool| rows.iter().any(|row| row.enable && row.process && wanted(row));
    let heads = [codes::HEAD_ID, codes::HEAD_MAIN, codes::HEAD_SIDE];
    match hook {
        Hook::MachineStartup | Hook::MachineShutdown if channels < 2 => Some(
            "a machine with one channel has no master; `program_startup` and `program_shutdown` run in the channel",
        ),
        Hook::PreprocessorStartup | Hook::PreprocessorShutdown | Hook::Identification
            if preprocessor == Preprocessor::NONE =>
        {
            Some("this machine has no pre-processor; `preprocessor` of [ce] is expected")
        }
        Hook::SubprogramStartup | Hook::SubprogramShutdown
            if preprocessor == Preprocessor::NONE
                && !any(&|row| [codes::CALSUB_ID, codes::CALSUB_RANGE].contains(&row.id)) =>
        {
            Some("no row of [[codes]] calls a subprogram (CODE_CALSUB_ID, CODE_CALSUB_RANGE)")
        }
        Hook::Cycle if !any(&|row| matches!(row.id.kind(), CodeKind::Cycle(_)) || row.id == codes::CYCLE_ON) => {
            Some("no row of [[codes]] has a canned cycle (CODE_CYCLE_…)")
        }
        Hook::Tool
            if !any(&|row| matches!(row.id.kind(), CodeKind::Tool | CodeKind::Head(_)) || heads.contains(&row.id)) =>
        {
            Some("no row of [[codes]] has a tool or a head (CODE_TOOL_…, CODE_HEAD_…)")
        }
        _ => None,
    }
}
