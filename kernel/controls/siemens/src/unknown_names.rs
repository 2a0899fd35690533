//! Names that neither the interpreter nor a macro knows.

use counterpoint_control_api::host::{InterpreterHost, ProgramHost};

/// A program of the control uses one of its own words that the machine does not have, so the machine lacks a function
/// of the program.
pub(super) fn lacks(host: &dyn ProgramHost, asked: &str) -> Option<String> {
    let source = asked.starts_with("SC_").then(|| host.source(host.place().file)).flatten()?;
    let stem = source.name.strip_prefix("//ICAMFS/")?.rsplit('/').next()?.split('.').next()?.to_ascii_uppercase();
    Some(format!(
        "12550 name not defined or option missing: this machine has no {stem}, whose axes or options it lacks; no part of the \
         block acts"
    ))
}

/// The missing emulation that a word would need, and an alternative.
pub(super) fn limit(name: &str) -> Option<&'static str> {
    Some(match name {
        "MEAS" | "MEAW" | "MEASA" | "MEAWA" | "MEAC" => {
            "measuring is not emulated; write the measured values into the variables that the program reads, and skip the block"
        }
        _ => return None,
    })
}

/// Whether a word of the machine may begin with this name.
pub(super) fn words_address(host: &dyn InterpreterHost, name: &str) -> bool {
    let forms = [name.to_owned(), format!("{name}="), format!("{name}[")];
    forms.iter().any(|form| host.is_register(form)) || super::evaluate::words_name(host, name)
}
