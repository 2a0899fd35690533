//! Names of commands in other programs.

use clap::Error;
use clap::error::{ContextKind, ContextValue};

/// Commands of other programs, each with the equivalent command.
const ELSEWHERE: [(&str, &str); 5] = [
    ("check", "lint"),
    ("diff", "machine diff"),
    ("optimise", "analyse"),
    ("optimize", "analyse"),
    ("simulate", "run"),
];

/// Adds the equivalent command to the message about an unknown command.
pub(crate) fn with_similar_command(mut error: Error) -> Error {
    let Some(ContextValue::String(word)) = error.get(ContextKind::InvalidSubcommand) else { return error };
    let found = ELSEWHERE.iter().find(|(other, _)| other == word).map(|(_, command)| (*command).to_owned());
    // The same word after another command (`macro diff`) means something else.
    let is_first = std::env::args().nth(1).as_deref() == Some(word.as_str());
    if let Some(command) = found.filter(|_| is_first) {
        error.insert(ContextKind::SuggestedSubcommand, ContextValue::Strings(vec![command]));
    }
    error
}
