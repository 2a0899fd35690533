//! `load`: submits a mix of jobs to a server at a rate or by callers, follows them, and reports how that went.
//!
//! *Invariants:* a latency counts from the moment at which its job was due, so a server that falls behind cannot hide
//! it; jobs that started during the warm-up are in no figure.

pub(crate) mod arguments;
mod drive;
mod folder;
mod growth;
mod measure;
mod mix;
mod page;
mod plot;
mod process;
mod report;
mod table;
mod thresholds;

use std::net::{SocketAddr, ToSocketAddrs as _};
use std::path::Path;
use std::sync::{Arc, Mutex};
use std::time::Duration;

use counterpoint_client::{Client, ClientSettings};
use tokio::sync::watch;
use tokio::time::{Instant, MissedTickBehavior, interval_at};

use crate::error::Error;
use crate::say::{self, BAD, GOOD, styled};
use arguments::LoadArgs;
use drive::ArrivalSchedule;
use measure::{Measured, lock};
use mix::Mix;
use process::ServerProcess;
use report::LoadReport;
use table::LiveDisplay;
use thresholds::thresholds;

/// Callers that share a connection: each may hold a watch and a submit, and a server allows 256 calls on one.
const CALLERS: usize = 100;
/// Connections at a rate.
const CONNECTIONS: usize = 4;

/// Executes the command; returns the exit code.
pub(crate) async fn load(arguments: LoadArgs) -> Result<u8, Error> {
    let settings = ClientSettings::from_environment(&arguments.remote.server)?;
    let at = address(settings.address())?;
    if !at.ip().is_loopback() && !arguments.allow_remote {
        return Err(Error::Usage(format!(
            "{} is not this machine: --allow-remote says that its owner knows about the load",
            arguments.remote.server
        )));
    }
    let mix = Mix::read(&arguments.mix)?;
    let pace = match (arguments.rate, arguments.callers) {
        (Some(rate), _) => ArrivalSchedule::Rate(rate),
        (None, callers) => ArrivalSchedule::Callers(callers.unwrap_or(1)),
    };
    let wanted = arguments.connections.unwrap_or(match pace {
        ArrivalSchedule::Rate(_) => CONNECTIONS,
        ArrivalSchedule::Callers(callers) => callers.div_ceil(CALLERS),
    });
    let mut clients = Vec::new();
    for _ in 0..wanted.max(1) {
        clients.push(Client::connect(&settings).await?);
    }
    for client in clients.iter().take(1) {
        client.upload(&mix.blobs()).await?;
    }
    let process = if at.ip().is_loopback() { ServerProcess::find(arguments.server_pid, at.port()) } else { None };
    let report = run(&arguments, mix, pace, clients, process).await?;
    say::data(report.text().as_bytes())?;
    for (path, text) in [(&arguments.output.json, report.json()), (&arguments.output.html, page::page(&report))] {
        if let Some(path) = path {
            std::fs::write(path, text).map_err(Error::file(path))?;
        }
    }
    let mut code = 0;
    for threshold in &report.thresholds {
        let (style, word) = if threshold.kept { (GOOD, "kept") } else { (BAD, "missed") };
        say::status_line(format_args!("{} {threshold}", styled(style, word)));
        code |= u8::from(!threshold.kept);
    }
    Ok(code)
}

/// The load itself: warm-up, measured time, and the ends of the jobs in progress. It stops at the first refusal that a
/// retry cannot change.
async fn run(
    arguments: &LoadArgs,
    mix: Mix,
    pace: ArrivalSchedule,
    clients: Vec<Client>,
    mut process: Option<ServerProcess>,
) -> Result<LoadReport, Error> {
    let start = Instant::now();
    let window = (start + arguments.warm_up, start + arguments.warm_up + arguments.time);
    let measured = Arc::new(Mutex::new(Measured::new(window)));
    let mut live = LiveDisplay::new(arguments.output.quiet);
    let until = window.1;
    let refused = Arc::new(watch::Sender::new(None));
    let mut refusal = refused.subscribe();
    let mut driven = std::pin::pin!(drive::drive(drive::LoadRun {
        mix,
        pace,
        clients,
        until,
        jobs: arguments.jobs,
        patience: arguments.patience,
        delete: arguments.delete,
        measured: measured.clone(),
        refused: refused.clone(),
    }));
    let mut seconds = interval_at(start + Duration::from_secs(1), Duration::from_secs(1));
    seconds.set_missed_tick_behavior(MissedTickBehavior::Delay);
    loop {
        tokio::select! {
            () = &mut driven => break,
            now = seconds.tick() => {
                let sample = process.as_mut().and_then(ServerProcess::sample);
                let mut measured = lock(&measured);
                measured.tick(now, sample);
                live.show(&measured, now);
            }
            _ = refusal.wait_for(Option::is_some) => break,
            _ = tokio::signal::ctrl_c() => break,
        }
    }
    live.clear();
    if let Some(error) = refused.send_replace(None) {
        say::status_line("load stopped: the server refuses a job of the mix, and would refuse it again");
        return Err(error.into());
    }
    let measured = lock(&measured);
    let growth = growth::growth(&measured.seconds);
    let thresholds = thresholds(&arguments.thresholds, &measured, &growth);
    Ok(LoadReport::new(name(&arguments.mix), &arguments.remote.server, pace, &measured, (thresholds, growth)))
}

fn name(path: &Path) -> String {
    path.file_stem().map_or_else(String::new, |stem| stem.to_string_lossy().into_owned())
}

/// Where an address leads.
fn address(url: &str) -> Result<SocketAddr, Error> {
    let bad = || Error::Usage(format!("server address '{url}' is not an http address: expected http://HOST:PORT"));
    let (scheme, rest) = url.split_once("://").ok_or_else(bad)?;
    let host = rest.split('/').next().unwrap_or_default();
    let port = if scheme.eq_ignore_ascii_case("https") { 443 } else { 80 };
    let with_port = host.rsplit_once(':').is_some_and(|(_, port)| port.parse::<u16>().is_ok());
    let full = if with_port { host.to_owned() } else { format!("{host}:{port}") };
    let found = full.to_socket_addrs().map_err(|error| Error::Usage(format!("server address '{url}': {error}")));
    // An address that leads to this machine and elsewhere counts as elsewhere.
    let all: Vec<SocketAddr> = found?.collect();
    all.iter().find(|at| !at.ip().is_loopback()).or(all.first()).copied().ok_or_else(bad)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn addresses_of_this_machine_are_known() {
        for (url, loopback) in [
            ("http://127.0.0.1:7878", true),
            ("http://127.8.0.1:1/", true),
            ("https://[::1]:7878", true),
            ("http://192.0.2.1:7878", false),
            ("http://0.0.0.0:7878", false),
        ] {
            assert_eq!(address(url).unwrap().ip().is_loopback(), loopback, "{url}");
        }
        assert_eq!(address("https://127.0.0.1").unwrap().port(), 443);
        assert!(address("127.0.0.1:7878").is_err());
    }
}
