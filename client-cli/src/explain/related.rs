//! Macros and refusals that belong to a code or a register.
//!
//! *Invariant:* everything comes from the checked machine, with the file and the line that define it.

use counterpoint_kernel::machine::Machine;
use counterpoint_kernel::machine::index::{CodeRowId, RegisterId};
use counterpoint_kernel::machine::refusals::{Active, BlockRefusal, CodeReference};
use counterpoint_kernel::machine::rows::CodeRow;
use counterpoint_kernel::machine::show::{self, Show};
use counterpoint_kernel::machine::tables::form_range;
use serde_json::Value;

use crate::fields::JsonFields as _;

/// Macros that the identifier triggers.
pub(super) fn macros(machine: &Machine, identifier: &str) -> Vec<Value> {
    let all = show::json_part(machine, Show::Macros);
    let fires = |row: &&Value| {
        row.at("match").as_array().is_some_and(|names| names.iter().any(|name| name.as_str() == Some(identifier)))
    };
    all.at("macros").as_array().into_iter().flatten().filter(fires).cloned().collect()
}

/// The refusals that the caller selects.
pub(super) fn refusals(machine: &Machine, is: impl Fn(&BlockRefusal) -> bool) -> Vec<Value> {
    let all = show::json_part(machine, Show::Refusals);
    let rows = all.at("refusals").as_array().cloned().unwrap_or_default();
    let picked = machine.diagnostics.refusals.iter().zip(rows).filter(|(rule, _)| is(rule));
    picked.map(|(_, value)| value).collect()
}

/// Whether a refusal names the code: in its block, as active, or as not active.
pub(super) fn of_code(rule: &BlockRefusal, row: &CodeRow) -> bool {
    let written = |code: &CodeReference| match *code {
        CodeReference::Id(id) => id == row.id,
        CodeReference::Word { register, min, max } => {
            form_range(&row.form).is_some_and(|(of, first, last)| of == register && first <= max && min <= last)
        }
    };
    let state = |states: &[Active]| states.iter().any(|state| state.id == row.id);
    rule.codes.iter().any(written) || state(&rule.active) || state(&rule.inactive)
}

/// Whether a refusal tests words of a register, in blocks with one of the codes if there are any.
pub(super) fn looks_at(machine: &Machine, rule: &BlockRefusal, register: RegisterId, codes: &[CodeRowId]) -> bool {
    if !codes.is_empty() && !codes.iter().any(|id| of_code(rule, &machine.codes[*id])) {
        return false;
    }
    let bit = register.bit();
    (rule.with | rule.all | rule.without) & bit != 0 || rule.word.is_some_and(|word| word.register == register)
}
