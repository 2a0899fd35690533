//! Where the kernel is, and the texts of its programs.

use std::sync::Arc;

use counterpoint_channel::block_places::block_start;
use counterpoint_channel::channel_context::ChannelContext;
use counterpoint_channel::macros::runtime::Runtime;
use counterpoint_control_api::{ProgramHost, ProgramPlace};
use counterpoint_event::event::FileId;
use counterpoint_fault::Acted;
use counterpoint_program::block::Block;
use counterpoint_program::key_words::StatementVocabulary;
use counterpoint_program::scan::LineScanner;
use counterpoint_program::shape::ProgramRange;
use counterpoint_program::source::ProgramSource;
use counterpoint_program::spot::BlockStart;

use crate::channel::Kernel;
use crate::channel::macro_queries::block_scanner;
use crate::channel::plan::ExecutionPlan;

/// The scanner for the text of the block in process.
fn scanner_of_block<'p>(plan: &ExecutionPlan, channel: &'p ChannelContext<'_>, macros: &'p Runtime) -> &'p LineScanner {
    if plan.hooks.is_none() {
        return &channel.tables.scanner;
    }
    let own = match &channel.tables.unmarked {
        Some(scanner) if channel.context.made => return scanner,
        _ => &macros.reading.switched,
    };
    own.as_deref().unwrap_or(&channel.tables.scanner)
}

impl ProgramHost for Kernel<'_> {
    fn place(&self) -> ProgramPlace {
        let frame = self.flow.frames.last();
        let range = frame.map_or(ProgramRange { number: None, first: 1, last: 0 }, |frame| frame.range);
        ProgramPlace {
            file: self.channel.at.file,
            line: self.channel.at.line,
            range,
            as_read: self.unchanged_line().is_some(),
            repeats: self.flow.repeats,
        }
    }

    #[inline]
    fn unchanged_line(&self) -> Option<(FileId, u32)> {
        let as_read = self.channel.text.edited.is_none() && self.channel.context.text.is_none();
        as_read.then_some((self.channel.at.file, self.channel.at.line))
    }

    fn level(&self) -> usize {
        self.flow.level()
    }

    fn spot(&self) -> BlockStart {
        block_start(&self.channel, &self.flow)
    }

    fn program(&self) -> Option<(FileId, ProgramRange)> {
        self.flow.frames.last().map(|frame| (frame.file, frame.range))
    }

    fn callers(&self) -> Vec<(FileId, ProgramRange)> {
        self.flow.frames.iter().rev().map(|frame| (frame.file, frame.range)).collect()
    }

    fn shares_programs(&self) -> bool {
        self.channel.env.whole.components.len() > 1
    }

    fn source(&self, file: FileId) -> Option<Arc<ProgramSource>> {
        self.channel.env.sources.shared(file)
    }

    fn files(&self) -> Vec<String> {
        self.channel.env.info.files.iter().map(|file| file.name.clone()).collect()
    }

    fn load(&mut self, file: FileId) -> Acted {
        Kernel::load(self, file)
    }

    fn main_file(&self) -> FileId {
        self.flow.frames.first().map_or(self.channel.at.file, |frame| frame.file)
    }

    fn block_text(&self) -> String {
        self.channel.block_text()
    }

    fn part(&self, span: (u32, u32)) -> String {
        self.channel.span_text(span)
    }

    fn strip(&mut self, text: &[u8], displays: bool, into: &mut Vec<u8>) -> Box<[(u32, u32)]> {
        let (tables, own) = (self.channel.tables, block_scanner(self.plan, &self.channel, &self.macros));
        own.as_deref().unwrap_or(&tables.scanner).strip(text, into, &mut self.channel.block);
        let messages = self.channel.block.messages.as_slice().into();
        if displays && self.plan.hooks.is_none() {
            self.show_messages(text);
        }
        self.channel.block.messages.clear();
        messages
    }

    fn display_again(&mut self, text: &[u8], messages: &[(u32, u32)]) {
        // A machine with macros has seen to them before.
        if self.plan.hooks.is_none() {
            self.channel.block.messages.extend_from_slice(messages);
            self.show_messages(text);
        }
    }

    fn names(&self) -> StatementVocabulary<'_> {
        scanner_of_block(self.plan, &self.channel, &self.macros).names()
    }

    fn each_block(&self, line: &[u8], visit: &mut dyn FnMut(usize, &[u8], StatementVocabulary<'_>)) {
        let (tables, switched) = (self.channel.tables, self.macros.reading.switched.clone());
        let scanner = switched.as_deref().unwrap_or(&tables.scanner);
        let (mut stripped, mut scratch) = (Vec::new(), Block::default());
        for offset in scanner.block_starts(line) {
            let rest = line.get(offset..).unwrap_or_default();
            let block = rest.get(..scanner.block_end(rest).unwrap_or(rest.len())).unwrap_or_default();
            scanner.strip(block, &mut stripped, &mut scratch);
            visit(offset, &stripped, scanner.names());
        }
    }

    fn skips(&self, level: Option<u8>) -> bool {
        scanner_of_block(self.plan, &self.channel, &self.macros).skips(level)
    }

    fn work(&mut self, elements: usize) -> Acted {
        Kernel::work(self, elements)
    }

    fn clock(&self) -> i64 {
        self.channel.now()
    }

    fn channel(&self) -> u16 {
        self.channel.at.channel
    }
}
