//! Definitions of programs that the flow meets, and text that belongs to no program.
//!
//! Facts: reference control-emulator.md 5.7 (a definition met in normal flow cannot be skipped). Decisions: that holds
//! where subprograms are at the end of the main file or where defined (`same-file`). It does not hold for a program
//! that another channel runs: there the text ends as at the end of the file. *Invariant:* text that no program owns is
//! reported once for each file and channel.

use counterpoint_channel::at::BlockPlace;
use counterpoint_channel::flow::ProgramFlow;
use counterpoint_event::SourcePlace;
use counterpoint_event::event::FileId;
use counterpoint_fault as diag;
use counterpoint_machine::model::{Placement, RewindStop};
use counterpoint_program::callers::Callers;
use counterpoint_program::shape::ProgramRange;
use counterpoint_program::source::ProgramSource;

use crate::channel::Kernel;

impl Kernel<'_> {
    /// Reports text before the rewind-stop that starts a main program.
    pub(crate) fn report_leader(&mut self, file: FileId, range: ProgramRange) {
        let format = &self.channel.env.machine.format;
        let sources = self.channel.env.sources;
        // Where a rewind-stop is expected, everything before it is ignored by rule (reference 5.1).
        let Some(source) = sources.get(file).filter(|_| format.rws_at != RewindStop::Start) else {
            return;
        };
        if range.first > 1 && format.is_rewind_stop(source.line(range.first)) {
            report_unowned(self, file, source, (1, range.first - 1));
        }
    }
}

/// Continues with the definition after the text of the program, where the control does so.
pub(crate) fn runs_into_definition(kernel: &mut Kernel<'_>) -> bool {
    if kernel.channel.env.machine.subprograms.placement != Placement::SameFile {
        return false;
    }
    let info = kernel.channel.env.info;
    let Some((file, range, name)) = kernel.flow.frame().map(|f| (f.file, f.range, f.name.to_string())) else {
        return false;
    };
    let next = kernel
        .channel
        .env
        .sources
        .get(file)
        .and_then(|source| source.programs().iter().find(|r| r.first == range.last + 1));
    let runs_elsewhere = |next: &ProgramRange| {
        info.channels.iter().any(|c| !c.program.is_empty() && c.file == file && c.lines.1 == next.last)
    };
    let Some(next) = next.filter(|next| !runs_elsewhere(next)) else { return false };
    if let Some(frame) = kernel.flow.frame() {
        frame.range.last = next.last;
    }
    if first_time(&mut kernel.flow, file, next.first) {
        let text =
            format!("the text of {name} has no end code and continues with the definition in line {}", next.first);
        kernel.diagnose(&diag::RUNS_INTO_DEFINITION, text);
    }
    true
}

/// Reports text before the definitions of a file when one of them is called and nothing runs that text.
pub(crate) fn report_heading(kernel: &mut Kernel<'_>, file: FileId, called: ProgramRange) {
    let info = kernel.channel.env.info;
    let Some(source) = kernel.channel.env.sources.get(file) else { return };
    let [heading, _, ..] = source.programs() else { return };
    if !source.is_plain(*heading) || !first_time(&mut kernel.flow, file, heading.first) {
        return;
    }
    let runs = |(first, last): (u32, u32)| (first..=last).contains(&heading.first);
    let mut channels = info.channels.iter().filter(|c| !c.program.is_empty() && c.file == file).peekable();
    // In a file of main programs it is one of them if it ends, whether a channel runs it or not.
    let is_main =
        channels.peek().is_some() && Callers::of(kernel.channel.env.machine, source.syntax()).ends_in(source, *heading);
    let is_run = is_main || channels.any(|c| runs(c.lines));
    if !is_run && !runs((called.first, called.last)) {
        report_unowned(kernel, file, source, (heading.first, heading.last));
    }
}

/// Reports another program of the file with the number of one that is called: it never runs.
pub(crate) fn report_twice(kernel: &mut Kernel<'_>, file: FileId, called: ProgramRange) {
    let Some(source) = kernel.channel.env.sources.get(file).filter(|_| called.number.is_some()) else { return };
    // A call from a sequence number begins inside its program.
    let is_called = |range: &ProgramRange| (range.first..=range.last).contains(&called.first);
    let same = |range: &&ProgramRange| range.number == called.number && !is_called(range);
    let Some(number) = called.number else { return };
    let Some(other) = source.programs().iter().find(same).map(|range| range.first) else { return };
    if !first_time(&mut kernel.flow, file, called.first) {
        return;
    }
    let name = kernel.channel.env.info.file_name(file);
    let text = format!(
        "program {number} is in line {} and again in line {other} of {name}: the one in line {} runs; give one of them \
         another number, since the control loads a number once",
        called.first, called.first
    );
    kernel.diagnose(&diag::PROGRAM_TWICE, text);
}

fn report_unowned(kernel: &mut Kernel<'_>, file: FileId, source: &ProgramSource, (first, last): (u32, u32)) {
    let mut lines = source.walk(first, last).filter(|&line| source.has_text(line));
    let Some(from) = lines.next() else { return };
    let to = lines.next_back().unwrap_or(from);
    let name = kernel.channel.env.info.file_name(file);
    let text = if from == to {
        format!("line {from} of {name} is before the program and belongs to no program")
    } else {
        format!("lines {from} to {to} of {name} are before the program and belong to no program")
    };
    let place = kernel.channel.at.block_place();
    kernel.channel.at.go_to(BlockPlace { file, line: from, caller: SourcePlace::NONE });
    kernel.diagnose(&diag::TEXT_OF_NO_PROGRAM, text);
    kernel.channel.at.go_to(place);
}

/// Whether this place is reported for the first time.
fn first_time(flow: &mut ProgramFlow, file: FileId, line: u32) -> bool {
    let new = !flow.reported.contains(&(file, line));
    if new {
        flow.reported.push((file, line));
    }
    new
}
