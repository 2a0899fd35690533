//! A host without a machine that has the tables of this control.

use counterpoint_kernel::diag;
use counterpoint_kernel::machine::ident::codes;
use counterpoint_kernel::machine::macros::{identifiers, system};
use counterpoint_lang::value::MacroValue;
use counterpoint_lang_standalone::{Domain, Standalone};

/// A host that knows the control's variables, identifiers, modal groups and diagnostics, but no machine and no program.
pub(super) fn standalone() -> Standalone {
    let mut host = Standalone::bare();
    for variable in system::table() {
        let nullable = matches!(variable.first, MacroValue::Null);
        let domain = Domain { indices: variable.indices.clone(), values: variable.range, nullable };
        host.system_variable(variable.symbol(), variable.first.clone(), domain);
    }
    host.foreign_variables(system::product_of);
    host.only_identifiers(identifiers::names().map(str::to_owned), identifiers::canonical);
    for facts in codes::TABLE.iter().filter(|facts| facts.group != 0) {
        host.group(facts.name, facts.group);
    }
    for facts in diag::ALL {
        host.add_diagnostic(facts.number, facts.severity, facts.title);
    }
    host
}

#[cfg(test)]
mod tests;
