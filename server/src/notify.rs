//! Reports the state of the server to systemd: ready, alive, stopping (`Type=notify`).
//!
//! *Invariant:* without `NOTIFY_SOCKET` nothing is sent and nothing fails. Source: sd_notify(3).

use std::time::Duration;

/// The service manager, if one listens.
#[derive(Debug)]
pub struct Manager {
    #[cfg(unix)]
    socket: std::os::unix::net::UnixDatagram,
    /// Between two signs of life, if it wants any.
    watchdog: Option<Duration>,
}

impl Manager {
    /// The one that the environment names.
    #[cfg(unix)]
    #[must_use]
    pub fn from_environment() -> Option<Self> {
        let number = |name: &str| std::env::var(name).ok().and_then(|text| text.parse::<u64>().ok());
        let own = number("WATCHDOG_PID").is_none_or(|pid| pid == u64::from(std::process::id()));
        let watchdog = number("WATCHDOG_USEC").filter(|usec| own && *usec > 0).map(Duration::from_micros);
        Self::at(&std::env::var("NOTIFY_SOCKET").ok()?, watchdog)
    }

    /// Not requested here.
    #[cfg(not(unix))]
    #[must_use]
    pub fn from_environment() -> Option<Self> {
        None
    }

    /// One at a socket, `@` for a name without a file; `watchdog`: how long it waits for a sign of life.
    #[cfg(unix)]
    #[must_use]
    pub fn at(socket: &str, watchdog: Option<Duration>) -> Option<Self> {
        let sender = std::os::unix::net::UnixDatagram::unbound().ok()?;
        match socket.strip_prefix('@') {
            #[cfg(target_os = "linux")]
            Some(name) => {
                use std::os::linux::net::SocketAddrExt as _;
                sender.connect_addr(&std::os::unix::net::SocketAddr::from_abstract_name(name).ok()?).ok()?;
            }
            #[cfg(not(target_os = "linux"))]
            Some(_) => return None,
            None => sender.connect(socket).ok()?,
        }
        // Half the time, as systemd recommends.
        Some(Self { socket: sender, watchdog: watchdog.map(|time| time / 2) })
    }

    /// Says that the server accepts calls.
    pub fn ready(&self, address: &str) {
        self.send(&format!("READY=1\nSTATUS=listening on {address}"));
    }

    /// Says that the server goes down.
    pub fn stopping(&self) {
        self.send("STOPPING=1\nSTATUS=running jobs end or are queued again");
    }

    /// Says again and again that the server is alive, as long as `alive` says so. Never returns.
    pub async fn watch(&self, alive: impl Fn() -> bool) {
        let Some(every) = self.watchdog else { return std::future::pending().await };
        loop {
            if alive() {
                self.send("WATCHDOG=1");
            }
            tokio::time::sleep(every).await;
        }
    }

    fn send(&self, text: &str) {
        #[cfg(unix)]
        if let Err(error) = self.socket.send(text.as_bytes()) {
            tracing::debug!(%error, "the service manager cannot be notified");
        }
        #[cfg(not(unix))]
        let _ = text;
    }
}

#[cfg(test)]
#[cfg(unix)]
mod tests {
    use std::os::unix::net::UnixDatagram;
    use std::sync::atomic::{AtomicUsize, Ordering};

    use super::*;

    fn said(socket: &UnixDatagram) -> String {
        let mut text = [0; 256];
        let length = socket.recv(&mut text).unwrap();
        String::from_utf8_lossy(&text[..length]).into_owned()
    }

    #[tokio::test]
    async fn systemd_hears_that_the_server_is_ready_alive_and_stopping() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("notify");
        let socket = UnixDatagram::bind(&path).unwrap();
        socket.set_read_timeout(Some(Duration::from_secs(20))).unwrap();
        let manager = Manager::at(path.to_str().unwrap(), Some(Duration::from_millis(20))).unwrap();
        manager.ready("http://127.0.0.1:1");
        assert_eq!(said(&socket), "READY=1\nSTATUS=listening on http://127.0.0.1:1");
        let asked = AtomicUsize::new(0);
        // Alive the first time only: no second sign of life comes.
        let alive = || asked.fetch_add(1, Ordering::SeqCst) == 0;
        tokio::select! {
            () = manager.watch(alive) => {}
            () = async { while asked.load(Ordering::SeqCst) < 3 { tokio::task::yield_now().await } } => {}
        }
        assert_eq!(said(&socket), "WATCHDOG=1");
        manager.stopping();
        assert!(said(&socket).starts_with("STOPPING=1\n"));
        assert!(Manager::at(folder.path().join("none").to_str().unwrap(), None).is_none());
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn a_socket_may_have_a_name_without_a_file() {
        use std::os::linux::net::SocketAddrExt as _;
        let name = format!("counterpoint-test-{}", std::process::id());
        let address = std::os::unix::net::SocketAddr::from_abstract_name(&name).unwrap();
        let socket = UnixDatagram::bind_addr(&address).unwrap();
        Manager::at(&format!("@{name}"), None).unwrap().ready("x");
        assert!(said(&socket).starts_with("READY=1"));
    }
}
