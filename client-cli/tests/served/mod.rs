//! A server for tests of commands.

#![allow(dead_code, reason = "not every test uses all of it")]

use std::path::Path;
use std::process::{Command, Stdio};

use counterpoint_server::options::ServerOptions;
use counterpoint_server::service;

/// A server in this process until the test ends.
pub(crate) struct Server {
    pub(crate) runtime: tokio::runtime::Runtime,
    pub(crate) url: String,
}

impl Server {
    pub(crate) fn start(folder: &Path, options: ServerOptions) -> Self {
        let runtime = tokio::runtime::Builder::new_multi_thread().enable_all().build().unwrap();
        let options = ServerOptions { listen: "127.0.0.1:0".parse().unwrap(), data: folder.join("data"), ..options };
        let service = runtime.block_on(service::build(options)).unwrap();
        let url = service.handle().url();
        runtime.spawn(service.run(std::future::pending()));
        Self { runtime, url }
    }

    pub(crate) fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_counterpoint"));
        command.args(arguments).args(["--server", &self.url]).stdin(Stdio::null());
        command
    }

    /// Exit code, standard output and standard error of a command.
    pub(crate) fn call(&self, arguments: &[&str]) -> (i32, String, String) {
        let output = self.command(arguments).output().unwrap();
        let text = |bytes| String::from_utf8(bytes).unwrap();
        (output.status.code().unwrap(), text(output.stdout).trim_end().to_owned(), text(output.stderr))
    }

    pub(crate) fn submit(&self, program: &str) -> String {
        let (code, job, talk) = self.call(&["submit", "--machine", "fanuc-mill", program]);
        assert_eq!(code, 0, "{talk}");
        job
    }
}

/// Writes a program into a folder; returns its path.
pub(crate) fn program(folder: &Path, name: &str, text: &str) -> String {
    let path = folder.join(name);
    std::fs::write(&path, text).unwrap();
    path.display().to_string()
}
