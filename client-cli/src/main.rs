//! `counterpoint`: run NC programs, submit them to a server, watch them, read results.
//!
//! Invariants: data goes to standard output, status to standard error; the exit code says how the command ended (0
//! clean, 1 the job or macro ended with an error or a verdict, 2 bad usage or machine, 3 server or connection).

mod admin;
mod analyse;
mod answers;
mod arguments;
mod attend;
mod calibrate;
mod changed_machine;
mod client;
mod codes;
mod commands;
mod completions;
mod draft;
mod encoding;
mod error;
mod event_line;
mod explain;
mod fields;
mod findings;
mod guess;
mod instant;
mod job_names;
mod job_status;
mod jobs;
mod json_summary;
mod known;
mod lint;
mod load;
mod local_machine;
mod machine_diff;
mod machine_folder;
mod machine_view;
mod machines;
mod macros;
mod man;
mod many;
mod numbered;
mod outcome;
mod output_folder;
mod own_machine;
mod pack;
mod problems;
mod progress;
mod remote;
mod report;
mod results;
mod reused;
mod run;
mod say;
mod settings;
mod severity;
mod standard_input;
mod status;
mod step;
mod subprograms;
mod summary;
mod tape_trial;
mod text;
mod timeline;
mod tools;
mod visible;
mod watch_all;

use std::process::ExitCode;

use clap::Parser as _;

fn main() -> ExitCode {
    let arguments = match arguments::CliArgs::try_parse() {
        Ok(arguments) => arguments,
        Err(error) => {
            let error = arguments::with_similar_command(error);
            let code = codes::of_command_line().filter(|_| error.use_stderr());
            let _ = error.print();
            return code.map_or_else(|| ExitCode::from(error.exit_code() as u8), ExitCode::from);
        }
    };
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build();
    let result = match runtime {
        Ok(runtime) => {
            let result = runtime.block_on(commands::dispatch(arguments.command));
            // Remaining connections, and the server in this process, end with the process.
            std::mem::forget(runtime);
            result
        }
        Err(error) => Err(error::Error::Connection(error.to_string())),
    };
    match result {
        Ok(code) => ExitCode::from(code),
        Err(error::Error::Closed) => ExitCode::SUCCESS,
        Err(error) => {
            say::error(&error);
            ExitCode::from(error.code())
        }
    }
}
