//! Processor time, memory, descriptors, threads and data folder of the server when it runs on this machine.
//!
//! Source: proc(5). Linux counts processor time there in hundredths of a second on every architecture.

use std::time::Instant;

use serde::Serialize;

use super::folder::FolderGauge;

/// Ticks of a second.
const TICKS: f64 = 100.0;

/// Resources that a process used since the last time.
#[derive(Debug, Clone, Copy, Serialize)]
pub(super) struct Sample {
    /// Processors in use, 1.0 = one all the time.
    pub(super) cores: f64,
    /// Memory in use, bytes.
    pub(super) rss: u64,
    /// Open descriptors.
    pub(super) descriptors: u64,
    pub(super) threads: u64,
    /// Bytes of the data folder, where it is known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) folder: Option<u64>,
}

/// A process that is measured.
#[derive(Debug)]
pub(super) struct ServerProcess {
    pid: u32,
    last: (Instant, u64),
    folder: Option<FolderGauge>,
}

impl ServerProcess {
    /// The process with this id, or the one that listens on this port, if it may be looked at.
    pub(super) fn find(pid: Option<u32>, port: u16) -> Option<Self> {
        let pid = pid.or_else(|| listener(port))?;
        Some(Self { pid, last: (Instant::now(), ticks(pid)?), folder: FolderGauge::of(pid) })
    }

    /// Its use since the last call.
    pub(super) fn sample(&mut self) -> Option<Sample> {
        let (now, ticks) = (Instant::now(), ticks(self.pid)?);
        let (then, before) = std::mem::replace(&mut self.last, (now, ticks));
        let seconds = now.duration_since(then).as_secs_f64().max(1e-3);
        let status = std::fs::read_to_string(format!("/proc/{}/status", self.pid)).ok()?;
        let descriptors = std::fs::read_dir(format!("/proc/{}/fd", self.pid)).ok()?.count() as u64;
        Some(Sample {
            cores: ticks.saturating_sub(before) as f64 / TICKS / seconds,
            rss: field(&status, "VmRSS:")? * 1024,
            descriptors,
            threads: field(&status, "Threads:")?,
            folder: self.folder.as_ref().map(FolderGauge::bytes),
        })
    }
}

/// Processor time of a process: fields 14 and 15 of its `stat`, counted after its name, which may contain anything.
fn ticks(pid: u32) -> Option<u64> {
    let stat = std::fs::read_to_string(format!("/proc/{pid}/stat")).ok()?;
    let mut fields = stat.rsplit_once(')')?.1.split_ascii_whitespace().skip(11);
    let (user, system): (u64, u64) = (fields.next()?.parse().ok()?, fields.next()?.parse().ok()?);
    Some(user + system)
}

/// A number of the `status` of a process; sizes are in KiB.
fn field(status: &str, name: &str) -> Option<u64> {
    let line = status.lines().find_map(|line| line.strip_prefix(name))?;
    line.trim().trim_end_matches(" kB").trim().parse().ok()
}

/// The process that listens on a port.
fn listener(port: u16) -> Option<u32> {
    let tables =
        ["/proc/net/tcp", "/proc/net/tcp6"].into_iter().filter_map(|table| std::fs::read_to_string(table).ok());
    let inodes: Vec<String> = tables.flat_map(|table| inodes(&table, port)).collect();
    let wanted: Vec<String> = inodes.iter().map(|inode| format!("socket:[{inode}]")).collect();
    let processes = std::fs::read_dir("/proc").ok()?.filter_map(Result::ok);
    processes.filter_map(|entry| entry.file_name().to_str()?.parse().ok()).find(|pid| {
        let descriptors = std::fs::read_dir(format!("/proc/{pid}/fd")).into_iter().flatten().filter_map(Result::ok);
        descriptors
            .filter_map(|fd| std::fs::read_link(fd.path()).ok())
            .any(|to| wanted.iter().any(|w| to.as_os_str() == w.as_str()))
    })
}

/// Inodes of the sockets of a table that listen (state 0A) on a port.
fn inodes(table: &str, port: u16) -> Vec<String> {
    let end = format!(":{port:04X}");
    let row = |line: &str| {
        let fields: Vec<&str> = line.split_ascii_whitespace().collect();
        let listens = fields.get(1)?.ends_with(&end) && *fields.get(3)? == "0A";
        listens.then(|| fields.get(9).map(|inode| (*inode).to_owned())).flatten()
    };
    table.lines().skip(1).filter_map(row).collect()
}

#[cfg(all(test, target_os = "linux"))]
mod tests {
    use super::*;

    #[test]
    fn the_process_that_listens_on_a_port_is_found_and_measured() {
        let listener = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
        let mut process = ServerProcess::find(None, listener.local_addr().unwrap().port()).unwrap();
        assert_eq!(process.pid, std::process::id());
        let sample = process.sample().unwrap();
        assert!(sample.rss > 1 << 20 && sample.cores >= 0.0, "{sample:?}");
        assert!(sample.descriptors >= 3 && sample.threads >= 1 && sample.folder.is_none(), "{sample:?}");
    }

    #[test]
    fn only_sockets_that_listen_count() {
        let table = "  sl  local_address rem_address   st tx_queue rx_queue tr tm->when retrnsmt   uid  timeout inode\n   \
                     0: 0100007F:1EC6 00000000:0000 0A 00000000:00000000 00:00000000 00000000     0        0 77 1\n   \
                     1: 0100007F:1EC6 0100007F:C350 01 00000000:00000000 00:00000000 00000000     0        0 78 1\n";
        assert_eq!(inodes(table, 7878), ["77"]);
        assert!(inodes(table, 7879).is_empty());
    }
}
