//! An event of a followed job as a line. *Invariant:* the line has words for people, no names of the interface.

use counterpoint_proto::v1;
use counterpoint_proto::v1::event::Kind;

use crate::severity;
use crate::text::time;

/// Formats an event of a job with these files as a line; `None` for events that are not printed.
pub(crate) fn event_line(event: &v1::Event, files: &[String]) -> Option<String> {
    let text = match event.kind.as_ref()? {
        Kind::Diagnostic(d) => {
            let origin = d.origin.as_ref().map(|o| format!(" ({}:{})", o.file, o.line)).unwrap_or_default();
            format!("{} {} {}{origin}", severity::word(d.severity).0, d.number, d.text)
        }
        Kind::Verdict(v) => format!("verdict {}", v.text),
        Kind::Message(m) => format!("message {}", m.text),
        Kind::Wait(w) => format!("waits for {}", w.key),
        Kind::Release(r) => format!("continues after {}, waited {}", r.key, time(event.t_ns - r.since_ns)),
        Kind::Lifecycle(l) => phase(l.phase())?.to_owned(),
        _ => return None,
    };
    let channel = if event.channel > 0 { format!(" channel {}", event.channel) } else { String::new() };
    Some(format!("{}{channel}{}: {text}\n", time(event.t_ns), place(event, files)))
}

/// The block in the user's programs; inside a shipped cycle, the block that called it.
fn place(event: &v1::Event, files: &[String]) -> String {
    let (file, line) =
        if event.caller_line > 0 { (event.caller_file, event.caller_line) } else { (event.file, event.line) };
    match files.get(file as usize) {
        _ if line == 0 => String::new(),
        Some(file) => format!(" {file}:{line}"),
        None => format!(" line {line}"),
    }
}

fn phase(phase: v1::Phase) -> Option<&'static str> {
    Some(match phase {
        v1::Phase::Unspecified => return None,
        v1::Phase::MachineStart => "the machine starts",
        v1::Phase::ProgramStart => "the program starts",
        v1::Phase::NotStarted => "no program",
        v1::Phase::ProgramEnd => "the program has ended",
        v1::Phase::Alarmed => "stopped by an alarm",
        v1::Phase::Stopped => "stopped before the end of its program",
        v1::Phase::Blocked => "waits without end",
        v1::Phase::MachineEnd => "the machine shuts down",
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(channel: u32, line: u32, kind: Kind) -> Option<String> {
        let event = v1::Event { channel, line, t_ns: 1_500_000_000, kind: Some(kind), ..v1::Event::default() };
        event_line(&event, &["upper.nc".to_owned()])
    }

    #[test]
    fn events_are_told_in_words() {
        let diagnostic = |severity| {
            let text = "no feed".to_owned();
            Kind::Diagnostic(v1::Diagnostic { number: 2_019_001, severity, text, ..v1::Diagnostic::default() })
        };
        for (severity, word) in [(0, "note"), (3, "note"), (4, "warning"), (7, "warning"), (8, "error"), (16, "fatal")]
        {
            let expected = format!("00:01.500 channel 1 upper.nc:3: {word} 2019001 no feed\n");
            assert_eq!(of(1, 3, diagnostic(severity)), Some(expected));
        }
        let kind = Some(diagnostic(8));
        let inside = v1::Event { file: 1, line: 23, caller_line: 4, kind, ..v1::Event::default() };
        let files = ["lower.nc", "cycle.spf"].map(str::to_owned);
        assert_eq!(event_line(&inside, &files), Some("00:00.000 lower.nc:4: error 2019001 no feed\n".to_owned()));
        assert_eq!(event_line(&inside, &[]), Some("00:00.000 line 4: error 2019001 no feed\n".to_owned()));
        let lifecycle = |phase: v1::Phase| Kind::Lifecycle(v1::Lifecycle { phase: phase.into() });
        assert_eq!(of(0, 0, lifecycle(v1::Phase::MachineStart)), Some("00:01.500: the machine starts\n".to_owned()));
        let alarmed = "00:01.500 channel 2: stopped by an alarm\n".to_owned();
        assert_eq!(of(2, 0, lifecycle(v1::Phase::Alarmed)), Some(alarmed));
        assert_eq!(of(2, 0, lifecycle(v1::Phase::Unspecified)), None);
    }
}
