//! Runs a test on chosen processors, and beside others that want them too.

use std::sync::atomic::{AtomicBool, Ordering::Relaxed};

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
