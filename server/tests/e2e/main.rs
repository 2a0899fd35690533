//! The server through its wire contract, over loopback, with a scripted runner.

#![allow(
    missing_docs,
    unreachable_pub,
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::indexing_slicing,
    clippy::print_stdout
)]

mod admin;
mod answers;
mod audited;
mod backup;
#[cfg(target_os = "linux")]
mod bad_disk;
#[cfg(target_os = "linux")]
mod cache;
mod collect;
#[cfg(unix)]
mod commands;
#[cfg(target_os = "linux")]
mod compact;
mod connections;
mod contract;
#[cfg(target_os = "linux")]
mod crash_log;
mod cut;
mod damage;
#[cfg(target_os = "linux")]
mod descriptors;
mod dialogs;
mod doctor;
mod door;
#[cfg(target_os = "linux")]
mod each_step;
mod exchanged;
#[cfg(target_os = "linux")]
mod faults;
mod find;
#[cfg(target_os = "linux")]
mod flips;
mod floods;
mod folder;
mod foreign;
mod guard;
mod guarded;
mod gzip;
#[cfg(target_os = "linux")]
mod host;
#[cfg(target_os = "linux")]
mod hostile;
#[cfg(target_os = "linux")]
mod killed;
mod life;
mod limited;
mod limits;
mod long_calls;
mod many;
#[cfg(target_os = "linux")]
mod memory;
mod messages;
mod metrics;
mod neighbours;
mod operator;
mod operator_wait;
mod otlp;
#[cfg(target_os = "linux")]
mod output;
#[cfg(target_os = "linux")]
mod paths;
mod pause;
mod rate;
mod reads;
mod refusals;
mod repeats;
mod rerun;
mod roles;
mod share;
mod signed;
mod slices;
#[cfg(target_os = "linux")]
mod stalled;
mod standing;
mod start;
mod step;
mod storage;
mod submit;
mod support;
mod tenants;
#[cfg(target_os = "linux")]
mod threads;
mod tls;
mod tokens;
mod traces;
mod trouble;
mod unfinished;
mod upgrade;
mod watch;
mod watch_jobs;
mod web;
mod webhooks;
