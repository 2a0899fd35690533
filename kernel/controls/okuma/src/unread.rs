//! Local variables that a block sets next to other words, and that no block reads.
//!
//! Facts: the control treats a name that is not a word of the machine as a local variable. Decisions: a name that its
//! file reads anywhere is a variable; otherwise a word of the control is an alarm, and a name next to other words is a
//! warning, once per name and file. Invariant: a name is searched for once.

use counterpoint_fault as diag;
use counterpoint_fault::Acted;

use super::Okuma;
use super::expr::OkumaVariable;
use super::line::OkumaItem;
use super::names::{LocalVariableName, is_word_of_control};
use super::text;
use counterpoint_control_api::host::InterpreterHost;

/// Most names that are kept.
const MOST: usize = 10_000;

/// Whether an item is anything but a value for a variable.
fn is_word(item: &OkumaItem) -> bool {
    !matches!(
        item,
        OkumaItem::Set {
            variable: Some(OkumaVariable::Local(_) | OkumaVariable::Common(..) | OkumaVariable::System(..)),
            ..
        } | OkumaItem::Text { .. }
    )
}

impl Okuma {
    /// Reports names of a block that are local variables by mistake.
    pub(super) fn check_names(&mut self, host: &mut dyn InterpreterHost, items: &[OkumaItem]) -> Acted {
        let mut beside = None;
        for item in items {
            let OkumaItem::Set { name, variable: Some(OkumaVariable::Local(local)), .. } = item else { continue };
            let of_control = is_word_of_control(name);
            if !of_control && items.len() == 1 {
                continue;
            }
            if self.is_word(host, name) {
                continue;
            }
            let beside = *beside.get_or_insert_with(|| {
                items.iter().any(|other| match other {
                    OkumaItem::Set { name, variable: Some(OkumaVariable::Local(_)), .. } => self.is_word(host, name),
                    other => is_word(other),
                })
            });
            if (of_control || beside) && !self.is_read(host, *local, name) {
                self.unread(host, (*local, name), of_control)?;
            }
        }
        Ok(())
    }

    /// Whether the file reads the name, or it has been reported.
    fn is_read(&mut self, host: &mut dyn InterpreterHost, local: LocalVariableName, name: &str) -> bool {
        let file = host.place().file;
        if let Some(read) = self.names.read.get(&(file, local)) {
            return *read;
        }
        let source = host.source(file);
        let read = source.is_none_or(|source| {
            source.walk(1, source.lines()).any(|line| {
                let line = source.line(line);
                may_name(line, name) && reads(&text::prepare(line).upper, name.as_bytes())
            })
        });
        if self.names.read.len() >= MOST {
            self.names.read.clear();
        }
        self.names.read.insert((file, local), read);
        read
    }

    fn unread(
        &mut self,
        host: &mut dyn InterpreterHost,
        (local, name): (LocalVariableName, &str),
        of_control: bool,
    ) -> Acted {
        if of_control {
            let text = format!(
                "{name}= is a word of the control that this machine does not have, and no block reads a variable {name}, \
                 in '{}'",
                host.block_text()
            );
            return Err(host.alarm(&diag::OKUMA_WORD, text));
        }
        let text = format!(
            "{name} is set as a local variable beside other words in '{}', and no block reads it: correct the name, or \
             add a register {name}= to the machine",
            host.block_text()
        );
        host.diagnose(&diag::OKUMA_UNREAD, text);
        let file = host.place().file;
        self.names.read.insert((file, local), true);
        Ok(())
    }
}

/// Quick look: whether the line has the letters of the name.
fn may_name(line: &[u8], name: &str) -> bool {
    line.windows(name.len()).any(|part| part.eq_ignore_ascii_case(name.as_bytes()))
}

/// Whether the line has the name without an equal sign after it.
fn reads(line: &[u8], name: &[u8]) -> bool {
    let is_name = |byte: &u8| byte.is_ascii_alphanumeric();
    let mut from = 0;
    while let Some(at) = line.get(from..).and_then(|rest| rest.windows(name.len()).position(|part| part == name)) {
        let (start, end) = (from + at, from + at + name.len());
        from = end;
        let begins = start == 0 || !line.get(start - 1).is_some_and(is_name);
        let rest = line.get(end..).unwrap_or_default();
        let ends = !rest.first().is_some_and(is_name);
        if begins && ends && rest.trim_ascii_start().first() != Some(&b'=') {
            return true;
        }
    }
    false
}

#[cfg(test)]
mod tests {
    use super::reads;

    #[test]
    fn a_name_is_read_where_no_value_follows() {
        for (line, is) in [
            ("X=QB", true),
            ("G1 X[QB+1]", true),
            ("QB=QB-1", true),
            ("IF [QB EQ 1] N5", true),
            ("G1 X5 QB=45", false),
            ("G1 X5 QB = 45", false),
            ("X=QB1", false),
            ("X=LQB", false),
            ("", false),
        ] {
            assert_eq!(reads(line.as_bytes(), b"QB"), is, "{line}");
        }
    }
}
