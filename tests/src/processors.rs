//! Runs a test on chosen processors, and beside others that want them too.

use std::process::{Command, Stdio};
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::time::{Duration, Instant};

/// Which processors a test may use.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Place {
    /// Processors; 0: all that there are.
    pub processors: usize,
    /// Threads beside the test that never stop computing.
    pub busy: usize,
}

/// One, two and all processors, free and beside busy threads.
pub const PLACES: [Place; 6] = [
    Place { processors: 1, busy: 0 },
    Place { processors: 1, busy: 2 },
    Place { processors: 2, busy: 0 },
    Place { processors: 2, busy: 3 },
    Place { processors: 0, busy: 0 },
    Place { processors: 0, busy: 4 },
];

/// Runs `test` on a thread of its own at this place. Where the system has no way to choose processors, all are used.
///
/// # Panics
/// When `test` panics.
pub fn at<R: Send>(place: Place, test: impl FnOnce() -> R + Send) -> R {
    let over = AtomicBool::new(false);
    std::thread::scope(|scope| {
        for _ in 0..place.busy {
            scope.spawn(|| {
                pin(place.processors);
                while !over.load(Relaxed) {
                    std::hint::spin_loop();
                }
            });
        }
        let run = scope.spawn(|| {
            pin(place.processors);
            test()
        });
        let result = run.join();
        over.store(true, Relaxed);
        result.unwrap_or_else(|panic| std::panic::resume_unwind(panic))
    })
}

#[cfg(target_os = "linux")]
fn pin(processors: usize) {
    use rustix::thread::{CpuSet, sched_getaffinity, sched_setaffinity};
    if processors == 0 {
        return;
    }
    if let Ok(all) = sched_getaffinity(None) {
        let mut some = CpuSet::new();
        (0..CpuSet::MAX_CPU).filter(|&cpu| all.is_set(cpu)).take(processors).for_each(|cpu| some.set(cpu));
        let _ = sched_setaffinity(None, &some);
    }
}

#[cfg(not(target_os = "linux"))]
fn pin(_processors: usize) {}

/// Where and how the tests of an executable are run once more.
#[derive(Debug, Clone, Copy)]
pub struct Setting {
    /// Where.
    pub place: Place,
    /// Threads that the kernels of every job get, regardless of the test.
    pub threads: u16,
}

const fn setting(processors: usize, busy: usize, threads: u16) -> Setting {
    Setting { place: Place { processors, busy }, threads }
}

/// Every number of threads on one processor, free and beside busy threads, and on two beside busy threads.
pub const SETTINGS: [Setting; 9] = [
    setting(1, 0, 0),
    setting(1, 0, 1),
    setting(1, 0, 2),
    setting(1, 2, 0),
    setting(1, 2, 1),
    setting(1, 2, 2),
    setting(2, 3, 0),
    setting(2, 3, 1),
    setting(2, 3, 2),
];

/// Fewer for every day: each place once, with the number of threads that is hardest on it.
pub const FEW_SETTINGS: [Setting; 3] = [setting(1, 0, 2), setting(1, 2, 0), setting(2, 3, 2)];

/// Number of threads that all jobs of this process get.
const THREADS: &str = "COUNTERPOINT_TEST_THREADS";

/// A process that has not ended after this time hangs.
const PATIENCE: Duration = Duration::from_secs(300);

/// Number of threads that jobs get instead of the number that their test requests.
#[must_use]
pub fn forced_threads() -> Option<u16> {
    std::env::var(THREADS).ok()?.parse().ok()
}

/// Runs all tests of this executable but `except` once more in each setting, in a process of its own. Such a process
/// runs no further ones. `EVERYWHERE=all` takes all [`SETTINGS`], `TIMES=1` prints how long each took. Where the system
/// has no way to choose processors, nothing is run.
///
/// # Panics
/// When a test fails or does not end.
pub fn everywhere(settings: &[Setting], except: &str, environment: &[(&str, &str)]) {
    if forced_threads().is_some() {
        return;
    }
    if !cfg!(target_os = "linux") {
        eprintln!("skipped: this system has no way to choose processors for a test");
        return;
    }
    let all = std::env::var("EVERYWHERE").is_ok_and(|which| which == "all");
    let settings = if all { &SETTINGS } else { settings };
    let program = std::env::current_exe().expect("a test knows its executable");
    for setting in settings {
        let since = Instant::now();
        let (ended, output) = at(setting.place, || {
            let mut command = Command::new(&program);
            command.args(["--skip", except, "--test-threads=2"]).env(THREADS, setting.threads.to_string());
            command.envs(environment.iter().copied()).stdout(Stdio::piped()).stderr(Stdio::piped());
            ended(command)
        });
        assert!(ended, "{setting:?}:\n{output}");
        if std::env::var_os("TIMES").is_some() {
            eprintln!("{}: {setting:?}: {:?}", program.display(), since.elapsed());
        }
    }
}

/// Success of a process at its end, and its output.
fn ended(mut command: Command) -> (bool, String) {
    let mut child = command.spawn().expect("the process starts");
    // Read at once, or a process that prints much would wait indefinitely.
    let readers = [
        child.stdout.take().map(|out| std::thread::spawn(|| read(out))),
        child.stderr.take().map(|out| std::thread::spawn(|| read(out))),
    ];
    let since = Instant::now();
    let status = loop {
        match child.try_wait().expect("the process can be waited for") {
            Some(status) => break Some(status),
            None if since.elapsed() > PATIENCE => {
                let _ = child.kill();
                let _ = child.wait();
                break None;
            }
            None => std::thread::sleep(Duration::from_millis(20)),
        }
    };
    let texts = readers.into_iter().flatten().map(|reader| reader.join().unwrap_or_default());
    let mut output = texts.collect::<Vec<_>>().join("\n");
    if status.is_none() {
        output.push_str(&format!("\nit has not ended after {} s", PATIENCE.as_secs()));
    }
    (status.is_some_and(|status| status.success()), output)
}

fn read(mut from: impl std::io::Read) -> String {
    let mut bytes = Vec::new();
    let _ = from.read_to_end(&mut bytes);
    String::from_utf8_lossy(&bytes).into_owned()
}
