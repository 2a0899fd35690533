//! Suspending and resuming a job does not change its log.
//!
//! The tests force suspension at shared operations of kernels and at reads of files. Another thread resumes the job.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::time::Duration;

use counterpoint_kernel::control::StopSignal;
use counterpoint_kernel::files::{Bytes, FileError, JobFiles};
use counterpoint_kernel::job::{Job, ProgramSelection, Spec};
use counterpoint_kernel::options::JobOptions;
use counterpoint_tests::{Work, machine};

/// Suspends a job at each forced point, and resumes the job from another thread.
struct Suspender {
    stop: StopSignal,
    suspended: Sender<()>,
    count: Arc<AtomicUsize>,
}

impl Suspender {
    fn new(stop: &StopSignal) -> Self {
        let (suspended, resume) = channel();
        let (stop, count) = (stop.clone(), Arc::new(AtomicUsize::new(0)));
        std::thread::spawn({
            let stop = stop.clone();
            move || resume_all(&stop, &resume)
        });
        Self { stop, suspended, count }
    }

    fn suspend(&self) {
        self.count.fetch_add(1, Ordering::Relaxed);
        self.stop.suspend();
        self.suspended.send(()).unwrap();
    }
}

/// Resumes the job after each suspension. Threads of the job may go to sleep before or after.
fn resume_all(stop: &StopSignal, suspended: &Receiver<()>) {
    while suspended.recv().is_ok() {
        std::thread::yield_now();
        stop.resume();
    }
}

/// Two channels that meet and share variables, with a loop and a call.
fn pair() -> Work {
    let text = |own: u16| {
        let mut text = format!("O{own}\nG98 F200.\n#501=1\n#502=2\n");
        for round in 0..40 {
            text.push_str(&format!("G1 X{round}. Z-{own}.\n#50{own}=#50{}+1\nM101\n", 3 - own));
            text.push_str("#1=0\nWHILE[#1LT5]DO1\n#1=#1+1\nG4 P1\nEND1\n");
        }
        text.push_str("M30\n");
        text
    };
    Work::texts(machine("fanuc-2path-lathe", ""), &[text(1), text(2)], JobOptions::default())
}

#[test]
fn a_job_that_is_suspended_at_its_shared_operations_has_the_same_log() {
    let mut work = pair();
    for threads in [1, 2] {
        work.options.threads = threads;
        let plain = work.run(None).unwrap();
        assert!(plain.events.len() > 500 && plain.summary.verdict.is_none(), "{:#?}", plain.summary);
        let stop = StopSignal::default();
        let suspender = Suspender::new(&stop);
        let count = suspender.count.clone();
        let with = |control: counterpoint_kernel::control::JobControl| {
            let suspender = std::sync::Mutex::new(suspender);
            control.with_stop(stop.clone()).with_jitter(move |_| suspender.lock().unwrap().suspend())
        };
        let suspended = work.run_with(with, false).unwrap();
        assert!(count.load(Ordering::Relaxed) > 100, "{} suspensions", count.load(Ordering::Relaxed));
        assert_eq!(suspended.events, plain.events);
        assert_eq!(suspended.summary.log_digest, plain.summary.log_digest);
    }
}

/// Files that suspend the job at each read.
#[derive(Debug)]
struct Suspending<'f, F>(&'f F, StopSignal);

impl<F: JobFiles> JobFiles for Suspending<'_, F> {
    fn read(&self, path: &str) -> Result<Bytes, FileError> {
        self.1.suspend();
        self.0.read(path)
    }

    fn list(&self) -> Vec<String> {
        self.0.list()
    }
}

fn long() -> Work {
    Work::texts(
        machine("fanuc-mill", ""),
        &[format!("O1\n{}M30\n", "G1 X1. Y2.\n".repeat(2000))],
        JobOptions::default(),
    )
}

fn spec(work: &Work) -> Spec {
    let programs = vec![ProgramSelection { file: "p1.nc".into(), number: None, section: None, channel: None }];
    Spec { machine: work.machine.clone(), programs, options: work.options.clone() }
}

#[test]
fn a_preparation_waits_while_it_is_suspended_and_ends_on_a_cancel() {
    let plain = long().info();
    for cancelled in [false, true] {
        let stop = StopSignal::default();
        let (done, ended) = channel();
        std::thread::spawn({
            let stop = stop.clone();
            move || {
                let work = long();
                let job = Job::prepare_until(spec(&work), &Suspending(&work.files, stop.clone()), &stop);
                let _ = done.send(job.map(|job| job.info().clone()));
            }
        });
        let early = ended.recv_timeout(Duration::from_millis(50));
        assert_eq!(early.err(), Some(RecvTimeoutError::Timeout), "it waits");
        if cancelled {
            stop.ask()
        } else {
            stop.resume()
        }
        let prepared = ended.recv_timeout(Duration::from_secs(60)).expect("it continues");
        match prepared {
            Ok(info) => {
                assert_eq!((cancelled, format!("{:?}", info.channels)), (false, format!("{:?}", plain.channels)))
            }
            Err(error) => assert!(cancelled && error.cancelled),
        }
    }
}
