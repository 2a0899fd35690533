// replaced when kernel::log::{timeline, toolpath, listing, jsonl} lands
//! Stand-ins for what is read off the event log: right in form, thin in content.

pub(crate) mod timeline {
    use std::sync::Arc;

    use counterpoint_kernel::log::event::{Event, Kind, MotionKind};
    use counterpoint_kernel::log::info::Info;
    use serde_json::{Value, json};

    #[derive(serde::Serialize)]
    #[serde(transparent)]
    pub(crate) struct Timeline(Value);

    pub(crate) struct Builder {
        info: Arc<Info>,
        bars: Vec<(u16, Value)>,
        end: i64,
    }

    impl Builder {
        pub(crate) fn new(info: &Arc<Info>) -> Self {
            Self { info: info.clone(), bars: Vec::new(), end: 0 }
        }

        pub(crate) fn event(&mut self, _seq: u64, e: &Event) {
            let (kind, start, dur) = match &e.kind {
                Kind::Motion(m) if m.kind == MotionKind::Rapid => ("rapid", e.t_ns, e.dur_ns),
                Kind::Motion(_) => ("feed", e.t_ns, e.dur_ns),
                Kind::Tool { .. } => ("tool", e.t_ns, e.dur_ns),
                Kind::Dwell => ("dwell", e.t_ns, e.dur_ns),
                Kind::Release(r) => ("wait", r.since_ns, e.t_ns - r.since_ns),
                _ => return,
            };
            self.end = self.end.max(e.t_ns + e.dur_ns);
            if dur > 0 && self.bars.len() < 10_000 {
                let bar = json!({"kind": kind, "t_ns": start, "dur_ns": dur, "line": e.line, "end_line": e.line});
                self.bars.push((e.channel, bar));
            }
        }

        pub(crate) fn finish(self) -> Timeline {
            let bars = |number| self.bars.iter().filter(|b| b.0 == number).map(|b| b.1.clone()).collect::<Vec<_>>();
            let channels: Vec<Value> = (self.info.channels.iter())
                .map(|c| json!({"channel": c.number, "name": c.name, "bars": bars(c.number)}))
                .collect();
            Timeline(json!({"unit": "ns", "makespan_ns": self.end, "channels": channels, "waits": []}))
        }
    }

    impl Timeline {
        pub(crate) fn svg(&self) -> String {
            "<svg xmlns=\"http://www.w3.org/2000/svg\"/>\n".to_owned()
        }
    }
}

pub(crate) mod toolpath {
    use std::sync::Arc;

    use counterpoint_kernel::log::event::{Event, Kind};
    use counterpoint_kernel::log::info::Info;

    #[derive(serde::Serialize)]
    pub(crate) struct Toolpath {
        motions: u64,
    }

    pub(crate) struct Builder(u64);

    impl Builder {
        pub(crate) fn new(_info: &Arc<Info>) -> Self {
            Self(0)
        }

        pub(crate) fn event(&mut self, _seq: u64, e: &Event) {
            self.0 += u64::from(matches!(e.kind, Kind::Motion(_)));
        }

        pub(crate) fn finish(self) -> Toolpath {
            Toolpath { motions: self.0 }
        }
    }

    impl Toolpath {
        pub(crate) fn svg(&self) -> String {
            "<svg xmlns=\"http://www.w3.org/2000/svg\"/>\n".to_owned()
        }
    }
}

pub(crate) mod listing {
    use std::io::{self, Write};

    use counterpoint_kernel::log::event::Event;
    use counterpoint_kernel::log::info::Info;

    use counterpoint_kernel::log::summary::Summary;

    pub(crate) fn render(
        info: &Info,
        channel: u16,
        _summary: &Summary,
        events: &mut dyn Iterator<Item = (u64, Event)>,
        out: &mut dyn Write,
    ) -> io::Result<()> {
        for (seq, event) in events.filter(|(_, e)| e.channel == channel) {
            writeln!(out, "{seq:6} {:>12} {}", event.t_ns, info.line_text(event.file, event.line))?;
        }
        Ok(())
    }
}

pub(crate) mod jsonl {
    use counterpoint_kernel::log::event::Event;
    use counterpoint_kernel::log::info::Info;

    pub(crate) fn write_event(_info: &Info, seq: u64, e: &Event, out: &mut Vec<u8>) {
        let line = format!(
            "{{\"seq\":{seq},\"t_ns\":{},\"dur_ns\":{},\"channel\":{},\"line\":{}}}\n",
            e.t_ns, e.dur_ns, e.channel, e.line
        );
        out.extend_from_slice(line.as_bytes());
    }
}
