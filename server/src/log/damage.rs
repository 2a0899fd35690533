//! Damage to an event log: the error, the job, and the remedy.
//!
//! *Invariant:* damage has the same text in every call that finds it, and the text names the job.

use std::fmt;
use std::io;

/// Damage to a log; without a job until [`of_job`] adds it.
#[derive(Debug)]
struct LogDamage {
    job: Option<String>,
    what: String,
}

impl fmt::Display for LogDamage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let of = self.job.as_ref().map_or_else(String::new, |job| format!(" of job '{job}'"));
        let what = &self.what;
        write!(f, "the event log{of} is damaged: {what}; submit the job again, the same job gives the same log")
    }
}

impl std::error::Error for LogDamage {}

/// A damage error with the remedy; [`of_job`] adds the job.
pub(crate) fn damage(what: &str) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, LogDamage { job: None, what: what.to_owned() })
}

/// Adds the job to a damage error; other errors stay as they are.
pub(crate) fn of_job(error: io::Error, job: &str) -> io::Error {
    match error.downcast::<LogDamage>() {
        Ok(LogDamage { what, .. }) => {
            io::Error::new(io::ErrorKind::InvalidData, LogDamage { job: Some(job.to_owned()), what })
        }
        Err(error) => error,
    }
}

/// The log ends before its last event.
pub(crate) fn cut_short(job: &str, last: u64, expected: u64) -> io::Error {
    of_job(damage(&format!("it ends at event {last} of {expected}")), job)
}

/// The log is missing.
pub(crate) fn gone(job: &str) -> io::Error {
    of_job(damage("it is missing"), job)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_damage_names_its_job_and_other_errors_stay_as_they_are() {
        let text =
            "the event log of job 'j' is damaged: it is missing; submit the job again, the same job gives the same log";
        assert_eq!(gone("j").to_string(), text);
        assert_eq!(gone("j").kind(), io::ErrorKind::InvalidData);
        let other = of_job(io::Error::from(io::ErrorKind::NotFound), "j");
        assert!(other.kind() == io::ErrorKind::NotFound && !other.to_string().contains('j'));
    }
}
