//! Loops: `WHILE [condition] DO n`, `DO n` and `END n`.
//!
//! Facts: list of alarms of the OSP (wrong WHILE, DO or END; WHILE without its function). Decision: a loop lies in one
//! program, and the innermost open DO of a number has the END of that number. *Invariant:* a statement without its
//! partner stops the channel.

use counterpoint_fault as diag;
use counterpoint_fault::{Acted, Halt};

use super::Okuma;
use super::expr::Expr;
use super::line::{LineReadOptions, OkumaStatement, read};
use super::text::prepare;
use counterpoint_control_api::host::InterpreterHost;
use counterpoint_control_api::open_loops::OpenLoops;
use counterpoint_program::source::ProgramSource;

/// Lines of the statements of loops with those of their partners, ascending.
#[derive(Debug, Default)]
pub(super) struct LoopPartners {
    partners: Vec<(u32, u32)>,
}

/// Loops of a file in the making.
#[derive(Debug, Default)]
pub(super) struct LoopBuilder {
    loops: LoopPartners,
    open: OpenLoops<u32>,
}

impl LoopBuilder {
    /// Reads a line of the file; a line that defines a program starts anew.
    pub(super) fn line(&mut self, source: &ProgramSource, line: u32, defines: bool) {
        if defines {
            self.open = OpenLoops::default();
        }
        let text = source.line(line);
        if !may_hold_loop(text) {
            return;
        }
        match read(prepare(text), LineReadOptions { subprograms: true, drawing: false, offsets: false })
            .map(|line| line.statement)
        {
            Ok(OkumaStatement::Loop(_, number)) => self.open.begin(number, line),
            Ok(OkumaStatement::EndLoop(number)) => {
                if let Some(start) = self.open.end(number) {
                    self.loops.partners.extend([(start, line), (line, start)]);
                }
            }
            _ => {}
        }
    }

    /// The loops of the file.
    pub(super) fn close(mut self) -> LoopPartners {
        self.loops.partners.sort_unstable();
        self.loops
    }
}

impl LoopPartners {
    /// The line of the partner of a statement.
    pub(super) fn partner(&self, line: u32) -> Option<u32> {
        let at = self.partners.binary_search_by_key(&line, |(of, _)| *of).ok()?;
        self.partners.get(at).map(|(_, partner)| *partner)
    }

    pub(super) fn len(&self) -> usize {
        self.partners.len()
    }
}

impl Okuma {
    /// The begin of a loop, or of its next pass.
    pub(super) fn enter_loop(&mut self, host: &mut dyn InterpreterHost, condition: Option<&Expr>) -> Acted {
        let end = self.partner(host)?;
        let Some(condition) = condition else { return Ok(()) };
        host.tests_loop(true);
        let goes_on = self.value(host, condition);
        host.tests_loop(false);
        if goes_on? == 0.0 { host.go_to(end + 1) } else { Ok(()) }
    }

    /// The end of a pass.
    pub(super) fn end_loop(&mut self, host: &mut dyn InterpreterHost) -> Acted {
        let start = self.partner(host)?;
        self.caching = true;
        host.go_to(start)
    }

    fn partner(&mut self, host: &mut dyn InterpreterHost) -> Result<u32, Halt> {
        let place = host.place();
        match self.index(host, place.file).loops.partner(place.line) {
            Some(line) => Ok(line),
            None => {
                let text = format!("'{}' has no matching statement in the program", host.block_text());
                Err(host.alarm(&diag::MACRO_LOOP, text))
            }
        }
    }
}

/// Whether a line has the keywords of a loop.
fn may_hold_loop(text: &[u8]) -> bool {
    text.windows(2).any(|pair| pair.eq_ignore_ascii_case(b"DO") || pair.eq_ignore_ascii_case(b"EN"))
}
