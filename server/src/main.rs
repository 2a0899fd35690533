//! `counterpointd`: settings, build, announce, serve, drain; also examines a folder without a server.

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Duration;

use clap::error::ErrorKind;
use clap::{CommandFactory as _, Parser, Subcommand};
use counterpoint_server::access::token_commands::TokenCommand;
use counterpoint_server::backup::{self, Contents};
use counterpoint_server::doctor;
use counterpoint_server::notify::Manager;
use counterpoint_server::options::{ServerFlags, ServerOptions, any_path};
use counterpoint_server::output;
use counterpoint_server::{environment, logging, man, service, start_threads};

/// The Counterpoint server: runs NC programs as the control would
#[derive(Debug, Parser)]
#[command(name = "counterpointd", version)]
struct ServerArgs {
    /// Configuration file; flags and environment override it
    #[arg(long, global = true, env = "COUNTERPOINT_CONFIG", value_name = "FILE.toml", value_parser = any_path())]
    config: Option<PathBuf>,
    /// Print the resulting configuration with a comment for each option, and exit
    #[arg(long)]
    print_config: bool,
    #[command(flatten)]
    flags: ServerFlags,
    #[command(subcommand)]
    command: Option<ServerCommand>,
}

#[derive(Debug, Subcommand)]
enum ServerCommand {
    /// Examine the data folder of a stopped server: list all damage with its remedies
    ///
    /// Exit code: 0 = no damage remains, 1 = there is damage or rows may be lost, 2 = wrong usage, 3 = the folder cannot
    /// be examined or repaired.
    Doctor {
        /// Data folder
        #[arg(long, value_name = "FOLDER")]
        data: Option<PathBuf>,
        /// Remove data that cannot be read or used; write a new ledger if its file is damaged
        #[arg(long)]
        repair: bool,
    },
    /// Copy the data folder, even while a server uses it
    Backup {
        /// New folder for the backup
        to: PathBuf,
        /// Data folder
        #[arg(long, value_name = "FOLDER")]
        data: Option<PathBuf>,
    },
    /// Copy a backup to the data folder, which must be new or empty
    Restore {
        /// Folder of the backup
        from: PathBuf,
        /// Restore the backup even if it is damaged
        #[arg(long)]
        damaged: bool,
        /// Data folder
        #[arg(long, value_name = "FOLDER")]
        data: Option<PathBuf>,
    },
    /// Create, list and revoke tokens in the file of identities
    #[command(subcommand)]
    Token(TokenCommand),
    /// Write man pages into a folder, or print the page of the server
    Man {
        /// Folder for the pages, such as /usr/local/share/man/man8 [default: print one page, for `man -l -`]
        #[arg(value_name = "DIR")]
        folder: Option<PathBuf>,
    },
}

fn write_pages(folder: Option<&Path>) -> Result<(), String> {
    let Some(folder) = folder else {
        return man::page(ServerArgs::command()).and_then(|page| output::line(format_args!("{}", page.trim_end())));
    };
    man::write(ServerArgs::command(), folder).and_then(|()| {
        let folder = folder.display();
        output::line(format_args!("man pages written to {folder}: `man -l {folder}/counterpointd.8` shows one"))
    })
}

/// Executes commands that need no server of their own.
fn run(command: &ServerCommand, options: &ServerOptions) -> ExitCode {
    let data = &options.data;
    output::show_steps();
    let done = match command {
        ServerCommand::Token(command) => command.run(&options.guard.access),
        ServerCommand::Man { folder } => write_pages(folder.as_deref()),
        ServerCommand::Doctor { data: own, repair } => {
            keep_private();
            return examine(own.as_deref().unwrap_or(data), *repair);
        }
        ServerCommand::Backup { to, data: own } => {
            keep_private();
            return back_up(own.as_deref().unwrap_or(data), to);
        }
        ServerCommand::Restore { from, damaged, data: own } => {
            keep_private();
            let to = own.as_deref().unwrap_or(data);
            backup::restore(from, to, *damaged).and_then(|()| output::line(format_args!("restored: {}", to.display())))
        }
    };
    outcome(done)
}

/// Copies a folder and prints the content of the copy.
fn back_up(from: &Path, to: &Path) -> ExitCode {
    let copied = match backup::backup(from, to) {
        Ok(copied) => copied,
        Err(error) => return fail(3, &error),
    };
    let Contents { jobs, blobs, missing, left_out } = copied;
    let listed = output::line(format_args!("{jobs} jobs, {blobs} blobs, {left_out} jobs left out: {}", to.display()));
    if let Err(error) = listed {
        return fail(3, &error);
    }
    if missing == 0 {
        return ExitCode::SUCCESS;
    }
    let from = from.display();
    fail(
        1,
        &format!(
            "{missing} blobs are missing in '{from}', so the backup is damaged: `counterpointd doctor --data '{from}'` \
             names them"
        ),
    )
}

fn outcome(done: Result<(), String>) -> ExitCode {
    done.map_or_else(|error| fail(3, &error), |()| ExitCode::SUCCESS)
}

/// Examines a folder and prints the findings.
fn examine(folder: &Path, repair: bool) -> ExitCode {
    let found = match doctor::examine(folder, repair) {
        Ok(found) => found,
        Err(error) => {
            let what = if repair { "repaired" } else { "examined" };
            output::failure(format_args!("counterpointd: the data folder cannot be {what}: {error}"));
            return ExitCode::from(3);
        }
    };
    let damaged = found.iter().filter(|damage| !damage.note).count();
    let repaired = found.iter().filter(|damage| damage.repaired).count();
    let (left, folder) = (damaged - repaired, folder.display());
    let listed = found.iter().try_for_each(|damage| output::line(format_args!("{damage}")));
    let total = || output::line(format_args!("{damaged} damaged, {repaired} repaired: {folder}"));
    if let Err(error) = listed.and_then(|()| total()) {
        output::failure(format_args!("counterpointd: {error}"));
    }
    ExitCode::from(u8::from(left > 0))
}

/// A thread for work that may block ends when it had none for so long. Idle threads take turns, so under steady load a
/// longer time would keep as many indefinitely as the largest burst has needed.
const IDLE_THREAD: Duration = Duration::from_millis(100);
/// Maximum time for reads that are still in progress when the server has stopped.
const LAST_READS: Duration = Duration::from_secs(1);

fn main() -> ExitCode {
    let arguments: ServerArgs = environment::parse();
    if arguments.print_config && arguments.command.is_some() {
        let text = "--print-config cannot be combined with a command";
        ServerArgs::command().error(ErrorKind::ArgumentConflict, text).exit();
    }
    if let Some(ServerCommand::Man { folder }) = &arguments.command {
        // The pages do not depend on the configuration.
        return outcome(write_pages(folder.as_deref()));
    }
    let config = arguments.config.filter(|path| !path.as_os_str().is_empty());
    let base = match &config {
        Some(path) => ServerOptions::from_file(path),
        None => Ok(ServerOptions::default()),
    };
    let options = match base.and_then(|base| arguments.flags.over(base).checked()) {
        Ok(options) => options,
        Err(error) => return fail(2, &error),
    };
    let unknown = environment::unknown::<ServerArgs>();
    if arguments.print_config {
        unknown.iter().for_each(|text| output::remark(format_args!("{text}")));
        return match output::line(format_args!("{}", options.to_commented_toml().trim_end())) {
            Ok(()) => ExitCode::SUCCESS,
            Err(error) => fail(3, &error),
        };
    }
    if let Some(command) = arguments.command {
        return run(&command, &options);
    }
    let format = options.log_format;
    if let Err(error) = logging::start(format) {
        return fail(2, &error);
    }
    unknown.iter().for_each(|text| tracing::warn!("{text}"));
    keep_private();
    match start(options, config.as_deref()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            logging::end(format, &error);
            let error: Option<&service::Error> = error.downcast_ref();
            ExitCode::from(if error.is_some_and(service::Error::is_of_configuration) { 2 } else { 3 })
        }
    }
}

/// Runs the server to its end.
fn start(options: ServerOptions, config: Option<&Path>) -> Result<(), Box<dyn std::error::Error>> {
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    start_threads::can_start(threads)?;
    let runtime = tokio::runtime::Builder::new_multi_thread()
        .enable_all()
        .worker_threads(threads)
        .thread_name("rpc")
        .thread_keep_alive(IDLE_THREAD)
        .build()?;
    let served = runtime.block_on(serve(options, config));
    // Reads for disconnected clients do not delay the end.
    runtime.shutdown_timeout(LAST_READS);
    Ok(served?)
}

/// Files and folders that the server makes are for its own user only.
fn keep_private() {
    #[cfg(unix)]
    rustix::process::umask(rustix::fs::Mode::from_raw_mode(0o077));
}

fn fail(code: u8, error: &dyn std::fmt::Display) -> ExitCode {
    output::failure(format_args!("counterpointd: {error}"));
    ExitCode::from(code)
}

async fn serve(options: ServerOptions, config: Option<&Path>) -> Result<(), service::Error> {
    let data = std::path::absolute(&options.data).unwrap_or_else(|_| options.data.clone());
    let service = service::build(options).await?;
    let handle = service.handle();
    log_start(&handle, &data);
    output::announce(format_args!("listening on {}", handle.url()));
    let manager = Manager::from_environment();
    if let Some(manager) = &manager {
        manager.ready(&handle.url());
    }
    tokio::select! {
        result = service.run(std::future::pending()) => result,
        () = signals(handle.clone(), config) => Ok(()),
        () = tell(manager.as_ref(), &handle) => Ok(()),
    }
}

/// Logs the version, the data folder and the bound addresses.
fn log_start(handle: &service::Handle, data: &Path) {
    // The path may contain a line break; the log escapes line breaks in text values.
    let (version, data, url) = (env!("CARGO_PKG_VERSION"), &*data.to_string_lossy(), handle.url());
    let metrics = handle.metrics().map(|address| format!("http://{address}/metrics"));
    tracing::info!(version, data, unfinished_jobs = handle.unfinished_jobs(), url, metrics, "started");
}

/// Tells the service manager that the server is alive, and when it stops. Never returns.
async fn tell(manager: Option<&Manager>, handle: &service::Handle) {
    let Some(manager) = manager else { return std::future::pending().await };
    let stopping = async {
        handle.stopping().await;
        manager.stopping();
        std::future::pending::<()>().await;
    };
    tokio::join!(manager.watch(|| handle.alive()), stopping);
}

/// Reads the tables of tenants again; the old ones stay when the file has an error. `before`: the file at the start.
#[cfg(unix)]
fn tenants_again(handle: &service::Handle, config: &Path, before: &ServerOptions) {
    match ServerOptions::from_file(config) {
        Ok(options) => {
            let others = before.names_of_other_changes(&options);
            handle.set_tenants(options.tables.tenants);
            tracing::info!("tables of tenants read again");
            if !others.is_empty() {
                let options = others.join(", ");
                tracing::warn!(options, "other options of the file have changed: they take effect at a restart");
            }
        }
        Err(error) => tracing::error!(
            %error,
            "tables of tenants cannot be read again, the old ones stay; a restart with this file would fail"
        ),
    }
}

/// Passes signals on to the server. If signal handlers cannot be installed, waits forever.
#[cfg(unix)]
async fn signals(handle: service::Handle, config: Option<&Path>) {
    let before = config.and_then(|config| ServerOptions::from_file(config).ok()).unwrap_or_default();
    use tokio::signal::unix::{SignalKind, signal};
    if let (Ok(mut terminate), Ok(mut interrupt), Ok(mut hangup)) =
        (signal(SignalKind::terminate()), signal(SignalKind::interrupt()), signal(SignalKind::hangup()))
    {
        loop {
            tokio::select! {
                _ = terminate.recv() => handle.stop(),
                _ = interrupt.recv() => handle.stop(),
                _ = hangup.recv() => {
                    handle.reload();
                    config.into_iter().for_each(|config| tenants_again(&handle, config, &before));
                }
            }
        }
    }
    std::future::pending().await
}

/// Passes signals on to the server. If signal handlers cannot be installed, waits forever.
#[cfg(not(unix))]
async fn signals(handle: service::Handle, _config: Option<&Path>) {
    while tokio::signal::ctrl_c().await.is_ok() {
        handle.stop();
    }
    std::future::pending().await
}
