//! Arguments of `counterpointd`, with the environment.
//!
//! *Invariant:* an empty variable counts as absent, so it never overrides the configuration file. The message for a
//! wrong value names the variable if the value comes from one.

use std::ffi::OsString;

use clap::builder::Resettable;
use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{Arg, Command, Error, Parser};
use counterpoint_kernel::machine::similar;

/// Reads the command line and the environment; prints the message and exits if they are wrong.
#[must_use]
pub fn parse<T: Parser>() -> T {
    let given: Vec<OsString> = std::env::args_os().collect();
    let mut command = T::command().mut_args(without_empty_variable);
    let parsed = command
        .try_get_matches_from_mut(&given)
        .and_then(|mut matches| T::from_arg_matches_mut(&mut matches).map_err(|error| error.format(&mut command)));
    parsed.unwrap_or_else(|error| with_variable(error, &command, &given).exit())
}

/// Beginning of the variables of the server and its clients.
const PREFIX: &str = "COUNTERPOINT_";
/// Further variables: the filter of the log, and those of the clients.
const OTHERS: [&str; 6] = ["LOG", "SERVER", "TOKEN", "CA", "CLIENT_CERT", "CLIENT_KEY"];

/// A message for each unknown variable `COUNTERPOINT_…`, with a similar name if there is one.
#[must_use]
pub fn unknown<T: Parser>() -> Vec<String> {
    let command = T::command();
    let of_options = command.get_arguments().filter_map(|option| option.get_env()?.to_str());
    let known: Vec<&str> = of_options.filter_map(|name| name.strip_prefix(PREFIX)).collect();
    let given = std::env::vars_os().filter_map(|(name, _)| Some(name.to_str()?.strip_prefix(PREFIX)?.to_owned()));
    let is_unknown =
        |name: &String| !known.contains(&name.as_str()) && !OTHERS.contains(&name.as_str()) && !is_of_kubernetes(name);
    let mut unknown: Vec<String> = given.filter(is_unknown).collect();
    unknown.sort();
    unknown.iter().map(|name| text(name, &known)).collect()
}

fn text(name: &str, known: &[&str]) -> String {
    let near = match similar(name, known, 1).first() {
        Some(near) => format!("did you mean {PREFIX}{near}? "),
        None => String::new(),
    };
    format!("the variable '{PREFIX}{name}' has no effect: {near}docs/operations.md lists the variables")
}

/// Whether Kubernetes sets the variable for a service `counterpoint` or `counterpoint-…` of the same namespace.
fn is_of_kubernetes(name: &str) -> bool {
    let name = format!("_{name}");
    let ports = name.rsplit_once("_PORT_").is_some_and(|(_, rest)| rest.starts_with(|c: char| c.is_ascii_digit()));
    ports || name.ends_with("_SERVICE_HOST") || name.contains("_SERVICE_PORT") || name.ends_with("_PORT")
}

fn without_empty_variable(option: Arg) -> Arg {
    let is_empty = option.get_env().and_then(std::env::var_os).is_some_and(|value| value.is_empty());
    if is_empty { option.env(Resettable::Reset) } else { option }
}

/// The error with the variable of the wrong value, unless the value comes from the command line.
fn with_variable(mut error: Error, command: &Command, given: &[OsString]) -> Error {
    if !matches!(error.kind(), ErrorKind::InvalidValue | ErrorKind::ValueValidation) {
        return error;
    }
    let Some(ContextValue::String(shown)) = error.get(ContextKind::InvalidArg) else { return error };
    let Some(option) = command.get_arguments().find(|option| option.to_string() == *shown) else { return error };
    let Some(variable) = option.get_env().filter(|_| !is_given(option, given)) else { return error };
    let source = format!("{} (environment; option {shown})", variable.display());
    error.insert(ContextKind::InvalidArg, ContextValue::String(source));
    error
}

/// Whether the command line has the flag of an option.
fn is_given(option: &Arg, given: &[OsString]) -> bool {
    let Some(name) = option.get_long() else { return false };
    given
        .iter()
        .filter_map(|word| word.to_str()?.strip_prefix("--")?.strip_prefix(name))
        .any(|rest| rest.is_empty() || rest.starts_with('='))
}
