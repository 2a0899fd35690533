//! Completion scripts for shells, with the names of the shipped machines.
//!
//! *Invariant:* wherever a machine is expected, a folder can be completed, too.

use clap::builder::PossibleValuesParser;
use clap::{Command, CommandFactory as _};
use clap_complete::Shell;
use counterpoint_kernel::machine::package;

use crate::arguments::CliArgs;

/// The script for a shell.
pub(crate) fn script(shell: Shell) -> String {
    let names: Vec<&'static str> = package::shipped_names().into_iter().map(|name| &*name.leak()).collect();
    // `mut_arg` would move a positional argument to the end.
    let named = |command: Command| {
        command.mut_args(|argument| match argument.get_id().as_str() {
            "machine" | "a" | "b" => argument.value_parser(PossibleValuesParser::new(names.clone())),
            _ => argument,
        })
    };
    let mut command = CliArgs::command();
    for name in ["run", "submit", "lint", "explain", "calibrate"] {
        command = command.mut_subcommand(name, named);
    }
    command = command.mut_subcommand("machine", |machine| {
        ["check", "show", "diff", "edit"].into_iter().fold(machine, |machine, name| machine.mut_subcommand(name, named))
    });
    let mut script = Vec::new();
    clap_complete::generate(shell, &mut command, "counterpoint", &mut script);
    with_folders(shell, &String::from_utf8_lossy(&script), &names)
}

/// Lets folders be completed where machines are.
fn with_folders(shell: Shell, script: &str, names: &[&str]) -> String {
    let all = names.join(" ");
    match shell {
        Shell::Bash => script.replace(&format!("compgen -W \"{all}\""), &format!("compgen -d -W \"{all}\"")),
        Shell::Zsh => script.replace(&format!(":({all})"), &format!(":{{compadd -- {all}; _files -/}}")),
        Shell::Fish => {
            let first = names.first().copied().unwrap_or_default();
            script.replace(&format!("-r -f -a \"{first}"), &format!("-r -a \"{first}"))
        }
        _ => script.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn machines_are_completed_by_name_and_folder() {
        let all = package::shipped_names();
        let (first, names) = (all.first().cloned().unwrap_or_default(), all.join(" "));
        for (shell, folders) in [
            (Shell::Bash, format!("compgen -d -W \"{names}\"")),
            (Shell::Zsh, format!(":{{compadd -- {names}; _files -/}}")),
            (Shell::Fish, format!("-r -a \"{first}")),
        ] {
            let script = script(shell);
            assert!(script.contains(&folders), "{shell}: {script}");
            // The option of run, submit, lint, explain and calibrate; zsh also completes arguments.
            let least = match shell {
                Shell::Bash => 5,
                Shell::Zsh => 10,
                _ => 1,
            };
            assert!(script.matches(&folders).count() >= least, "{shell}");
        }
    }
}
