//! Checks that the system allows the threads that a server needs to start.
//!
//! Invariant: the check comes before the runtime is built, which would panic or wait indefinitely.

use std::io;
use std::sync::Arc;
use std::sync::mpsc;
use std::thread::Builder;

/// Threads besides those of the runtime: ledger, housekeeping, tick, ends, flush, spans, probe, and one that may block.
const OTHERS: usize = 8;

/// Starts as many threads at once as a server with this number of runtime threads needs, and ends them.
///
/// # Errors
/// A text with the number of threads that the system allows.
pub fn can_start(runtime: usize) -> Result<(), String> {
    let wanted = runtime + OTHERS;
    let (release, held) = mpsc::channel::<()>();
    let held = Arc::new(std::sync::Mutex::new(held));
    let mut threads = Vec::new();
    let mut refusal: Option<io::Error> = None;
    for _ in 0..wanted {
        let held = held.clone();
        // Ends when the sender is gone.
        let wait = move || drop(held.lock().map(|held| held.recv()));
        match Builder::new().name("start".to_owned()).spawn(wait) {
            Ok(thread) => threads.push(thread),
            Err(error) => {
                refusal = Some(error);
                break;
            }
        }
    }
    let given = threads.len();
    drop(release);
    for thread in threads {
        let _ = thread.join();
    }
    refusal.map_or(Ok(()), |error| {
        Err(format!(
            "the system allows {given} more threads, and the server needs {wanted} to start ({error}): raise the limit \
             of processes (ulimit -u, TasksMax of a unit) or of memory (ulimit -v)"
        ))
    })
}
