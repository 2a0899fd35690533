//! Separate common variables of channels: those that a channel reads or polls in vain while another channel writes
//! them.
//!
//! *Invariant:* a report changes nothing; programs are searched only when a channel has reached its end or a limit.

use super::Kernel;
use counterpoint_channel::channel_variables::within;
use counterpoint_fault as diag;
use counterpoint_sync::verdict;

/// Maximum number of variables that a channel reports at its end as read in vain.
const MOST_IN_VAIN: usize = 20;

/// Maximum number of lines of a loop that are searched for variables.
const MOST_LINES: u32 = 200;

impl Kernel<'_> {
    /// Reports at the end of the channel the variables that one channel has read in vain and only another channel has
    /// written.
    pub(super) fn report_separate(&mut self) {
        let uses = std::mem::take(&mut self.dialect.variables.uses);
        if uses.is_empty() {
            return;
        }
        let channel = self.channel.at.channel;
        let found = self.shared(|order| order.shared.separate.end(channel, uses)).unwrap_or_default();
        for one in found.into_iter().take(MOST_IN_VAIN) {
            let place = |(file, line)| verdict::place(self.channel.env.info, file, line);
            let ((reader, read), (writer, written)) = (one.reader, one.writer);
            let text = format!(
                "channel {reader} reads #{index} at {}, and only channel {writer} writes it, at {}: each channel has a #{index} \
                 of its own here; if the control shares it (parameters 6036, 6037), run with --set shared={index}-{index} or \
                 list it in [variables] shared",
                place(read),
                place(written),
                index = one.index,
            );
            self.diagnose(&diag::SEPARATE_VARIABLE, text);
        }
    }

    /// Reports at a limit the variables that a loop reads, that it never writes, and that another program writes.
    #[cold]
    pub(super) fn report_polled(&mut self) {
        let pass = self.flow.pass.last();
        let (file, first, last) = pass.key;
        if pass.count < 2 || self.ports.coordinator.is_single() || last.saturating_sub(first) > MOST_LINES {
            return;
        }
        let env = &self.channel.env;
        let (info, own) = (env.info, self.channel.at.channel);
        let Some(source) = env.sources.get(file) else { return };
        let uses: Vec<Use> = (first..=last).flat_map(|line| uses(source.line(line), line)).collect();
        let polled = uses.iter().filter(|one| {
            within(&env.machine.variables.channel, one.number)
                && !uses.iter().any(|other| other.number == one.number && other.writes)
        });
        let mut numbers: Vec<u32> = polled.map(|one| one.number).collect();
        numbers.sort_unstable();
        numbers.dedup();
        let mut texts = Vec::new();
        for index in numbers {
            let others = info.channels.iter().filter(|channel| channel.number != own && !channel.program.is_empty());
            let found = others.into_iter().find_map(|channel| {
                let source = env.sources.get(channel.file)?;
                let (first, last) = (channel.lines.0, channel.lines.1.min(source.lines()));
                let writes = |line: &u32| uses_of(source.line(*line), index);
                Some((channel, (first..=last).find(writes)?))
            });
            let Some((writer, line)) = found else { continue };
            let read = uses_line(&uses, index);
            texts.push(format!(
                "channel {own} loops over #{index} at {}, and channel {} writes it, at {}: each channel has a #{index} of its \
                 own here; if the control shares it (parameters 6036, 6037), run with --set shared={index}-{index} or list it \
                 in [variables] shared",
                verdict::place(info, file, read),
                writer.number,
                verdict::place(info, writer.file, line),
            ));
        }
        for text in texts {
            self.diagnose(&diag::SEPARATE_VARIABLE, text);
        }
    }
}

/// A variable in a line of a program.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Use {
    number: u32,
    line: u32,
    /// Whether the line gives it a value.
    writes: bool,
}

/// The first line among some uses that has a variable.
fn uses_line(uses: &[Use], number: u32) -> u32 {
    uses.iter().find(|one| one.number == number).map_or(0, |one| one.line)
}

/// Whether a line gives a variable a value.
fn uses_of(text: &[u8], number: u32) -> bool {
    uses(text, 0).iter().any(|one| one.number == number && one.writes)
}

/// The variables of a line by their numbers, outside of comments.
fn uses(text: &[u8], line: u32) -> Vec<Use> {
    let mut found = Vec::new();
    let mut deep = 0_u32;
    let mut rest = text;
    while let Some((byte, after)) = rest.split_first() {
        rest = after;
        match byte {
            b'(' => deep += 1,
            b')' => deep = deep.saturating_sub(1),
            b'#' if deep == 0 => {
                let digits = after.iter().take_while(|byte| byte.is_ascii_digit()).count();
                let Some((number, behind)) = after.split_at_checked(digits) else { continue };
                let number = std::str::from_utf8(number).ok().and_then(|text| text.parse().ok());
                let writes = behind.iter().find(|byte| !byte.is_ascii_whitespace()) == Some(&b'=');
                found.extend(number.map(|number| Use { number, line, writes }));
            }
            _ => {}
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn variables_of_a_line_are_those_outside_of_comments() {
        let all = |text: &str| uses(text.as_bytes(), 3).iter().map(|one| (one.number, one.writes)).collect::<Vec<_>>();
        assert_eq!(all("WHILE[#500EQ0]DO1"), [(500, false)]);
        assert_eq!(all("N10 #501 = #502+1 (#503=1)"), [(501, true), (502, false)]);
        assert_eq!(all("#=1 ##1"), [(1, false)]);
    }
}
