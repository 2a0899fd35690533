//! Comments that have an effect: messages, printed values, files.
//!
//! Facts: LinuxCNC documentation, "Messages", "Probe logging", "Logging", "Comment parameters". Only the last comment of
//! a block has an effect. Decisions: PRINT writes to the log of the job, files are files of the job; a name without a
//! value is shown as `######`.

use counterpoint_fault as diag;

use super::block::AXES;
use super::evaluate::{Target, spelled};
use super::motion::work;
use super::text::Rs274Mistake;
use super::{Outcome, Rs274};
use counterpoint_control_api::host::{AxisPlace, InterpreterHost};
use counterpoint_control_api::words::{Span, part};

/// Files that comments have opened.
#[derive(Debug, Default)]
pub(super) struct CommentFiles {
    log: Option<String>,
    probe: Option<String>,
}

/// Largest number of decimals of a value.
const DECIMALS: usize = 9;

impl Rs274 {
    /// Executes the last comment of a block.
    pub(super) fn comment(&mut self, host: &mut dyn InterpreterHost, text: &[u8], span: Span) -> Outcome<()> {
        let comment = part(text, span).into_owned();
        let trimmed = comment.trim_start();
        let length = trimmed.bytes().take_while(|byte| byte.is_ascii_alphabetic()).count();
        let (word, rest) = trimmed.split_at(length);
        let after_comma = rest.trim_start().strip_prefix(',');
        match (word.to_ascii_lowercase().as_str(), after_comma) {
            ("msg", Some(message)) => host.show(message.trim()),
            ("debug", Some(message)) => {
                let message = self.filled(host, message);
                host.show(message.trim());
            }
            ("print", Some(message)) => {
                let message = self.filled(host, message);
                host.log_message(message.trim());
            }
            ("abort", Some(message)) => {
                let message = self.filled(host, message);
                let text = format!("the program has stopped: {}", message.trim());
                return Err(Rs274Mistake::new(&diag::MACRO_ALARM, 1, text).into());
            }
            ("log", Some(message)) => {
                if let Some(path) = self.files.log.clone() {
                    let message = self.filled(host, message);
                    host.append(&path, &format!("{message}\n"))?;
                }
            }
            ("logopen" | "logappend", Some(path)) => {
                let path = path.trim().to_owned();
                if word.eq_ignore_ascii_case("logopen") {
                    host.remove_written(&path)?;
                }
                self.files.log = Some(path);
            }
            ("logclose", _) => self.files.log = None,
            ("probeopen", _) => {
                let path = after_comma.unwrap_or(rest).trim().to_owned();
                host.remove_written(&path)?;
                self.files.probe = Some(path);
            }
            ("probeclose", _) => self.files.probe = None,
            _ => {}
        }
        Ok(())
    }

    /// Adds the result of a probing move to the file that is open for it.
    pub(super) fn record_probe(&mut self, host: &mut dyn InterpreterHost, places: &[AxisPlace]) -> Outcome<()> {
        let Some(path) = self.files.probe.clone() else { return Ok(()) };
        let values: Vec<String> = (0..AXES.len()).map(|at| format!("{:.6}", work(places, at))).collect();
        host.append(&path, &format!("{}\n", values.join(" ")))?;
        Ok(())
    }

    /// Replaces the parameters in a text by their values.
    fn filled(&mut self, host: &mut dyn InterpreterHost, text: &str) -> String {
        let (mut out, mut decimals, mut rest) = (String::new(), 6, text);
        while let Some(next) = rest.chars().next() {
            if next == '%'
                && let Some((places, length)) = format_of(rest)
            {
                decimals = places;
                rest = rest.get(length..).unwrap_or_default();
                continue;
            }
            if next == '#'
                && let Some((length, name)) = parameter(rest)
            {
                match self.shown(host, name) {
                    Some(value) => out.push_str(&format!("{value:.decimals$}")),
                    None => out.push_str("######"),
                }
                rest = rest.get(length..).unwrap_or_default();
                continue;
            }
            out.push(next);
            rest = rest.get(next.len_utf8()..).unwrap_or_default();
        }
        out
    }

    fn shown(&mut self, host: &mut dyn InterpreterHost, name: Target) -> Option<f64> {
        match name {
            Target::Number(number) => Some(self.read_number(host, number)),
            Target::Named(name) => self.named_value(host, &name),
        }
    }
}

/// The parameter at the start of a text, and the length of its name.
fn parameter(text: &str) -> Option<(usize, Target)> {
    let rest = text.get(1..)?;
    let length =
        if rest.starts_with('<') { rest.find('>')? + 1 } else { rest.bytes().take_while(u8::is_ascii_digit).count() };
    Some((length + 1, spelled(text.get(..length + 1)?)?))
}

/// Decimals and length of the format at the start of a text: `%d`, `%f`, `%lf`, `%.3f`.
fn format_of(text: &str) -> Option<(usize, usize)> {
    for (format, decimals) in [("%d", 0), ("%f", 4), ("%lf", 6)] {
        if text.starts_with(format) {
            return Some((decimals, format.len()));
        }
    }
    let digit = text.strip_prefix("%.")?.chars().next()?.to_digit(10)? as usize;
    (text.as_bytes().get(3) == Some(&b'f') && digit <= DECIMALS).then_some((digit, 4))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn formats() {
        assert_eq!(["%d", "%f", "%lf", "%.2f"].map(format_of), [(0, 2), (4, 2), (6, 3), (2, 4)].map(Some));
        assert_eq!(["%", "%s", "%.f", "%.2x"].map(format_of), [None; 4]);
        assert_eq!(parameter("#12 a"), Some((3, Target::Number(12))));
        assert_eq!(parameter("#<A b>c"), Some((6, Target::Named("ab".into()))));
        assert_eq!(parameter("# a"), None);
    }
}
