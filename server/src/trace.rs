//! The W3C trace context of a job: the trace of its client, continued.
//!
//! *Invariant:* a job has one trace and one span in all its runs and on all servers: both derive from the client's
//! request and from the id of the job.

use sha2::{Digest as _, Sha256};

/// Where a job belongs in a trace.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct TraceContext {
    /// The trace, 32 lower-case hexadecimal digits.
    pub(crate) trace: String,
    /// The span of the job, 16 lower-case hexadecimal digits.
    pub(crate) span: String,
    /// The span of its last run, likewise.
    pub(crate) run: String,
    /// The span of the client, likewise; empty = there is none.
    pub(crate) parent: String,
    /// Whether the client records its trace; so does one that has none.
    pub(crate) sampled: bool,
}

impl TraceContext {
    /// The context of a job whose client sent this `traceparent`. If it is absent or invalid, a new trace starts.
    pub(crate) fn of(job: &str, traceparent: &str) -> Self {
        let own = format!("{:x}", Sha256::digest(job));
        let (first, second) = own.split_at_checked(32).unwrap_or_default();
        let (span, run) = second.split_at_checked(16).unwrap_or_default();
        let (trace, parent, sampled) = parse(traceparent).unwrap_or((first, "", true));
        Self { trace: trace.to_owned(), span: span.to_owned(), run: run.to_owned(), parent: parent.to_owned(), sampled }
    }
}

/// Trace, parent, and whether the trace is recorded, of a `traceparent`: version, trace, span and flags, as W3C Trace
/// Context 3.2 has it.
pub(crate) fn parse(traceparent: &str) -> Option<(&str, &str, bool)> {
    let mut fields = traceparent.trim().split('-');
    let (version, trace, span, flags) = (fields.next()?, fields.next()?, fields.next()?, fields.next()?);
    let is_hex = |text: &str, digits: usize| {
        text.len() == digits && text.bytes().all(|b| b.is_ascii_digit() || (b'a'..=b'f').contains(&b))
    };
    let is_set = |text: &str| text.bytes().any(|b| b != b'0');
    let known = is_hex(version, 2) && version != "ff" && (version != "00" || fields.next().is_none());
    let valid = is_hex(trace, 32) && is_set(trace) && is_hex(span, 16) && is_set(span) && is_hex(flags, 2);
    let sampled = || u8::from_str_radix(flags, 16).is_ok_and(|flags| flags & 1 == 1);
    (known && valid).then(|| (trace, span, sampled()))
}

#[cfg(test)]
mod tests {
    use super::*;

    const TRACE: &str = "4bf92f3577b34da6a3ce929d0e0e4736";
    const SPAN: &str = "00f067aa0ba902b7";

    #[test]
    fn the_trace_of_the_client_is_continued() {
        let sent = format!("00-{TRACE}-{SPAN}-01");
        let context = TraceContext::of("job", &sent);
        assert_eq!((context.trace.as_str(), context.parent.as_str()), (TRACE, SPAN));
        assert_eq!(context, TraceContext::of("job", &sent), "every run has the same span");
        assert_ne!(context.span, TraceContext::of("other", &sent).span);
        let own = TraceContext::of("job", "");
        assert_eq!((own.trace.len(), own.span.len(), own.parent.as_str()), (32, 16, ""));
        assert!(own.run.len() == 16 && own.run != own.span && own.sampled && context.sampled);
        assert!(
            !TraceContext::of("job", &format!("00-{TRACE}-{SPAN}-02")).sampled,
            "the client does not record its trace"
        );
        assert_eq!(own.span, context.span);
    }

    #[test]
    fn what_is_not_a_traceparent_is_ignored() {
        for wrong in [
            String::new(),
            format!("00-{TRACE}-{SPAN}"),
            format!("ff-{TRACE}-{SPAN}-01"),
            format!("00-{TRACE}-{SPAN}-01-more"),
            format!("00-{}-{SPAN}-01", TRACE.to_uppercase()),
            format!("00-{}-{SPAN}-01", "0".repeat(32)),
            format!("00-{TRACE}-{}-01", "0".repeat(16)),
            format!("00-{TRACE}-{SPAN}-x1"),
        ] {
            assert_eq!(parse(&wrong), None, "{wrong}");
        }
        assert!(parse(&format!("01-{TRACE}-{SPAN}-01-more")).is_some(), "later versions may add fields");
    }
}
