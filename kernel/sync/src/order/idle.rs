//! Kernels without a running program: others select their programs and start them.
//!
//! *Invariant:* an idle kernel is blocked, so it holds no kernel back, and it is woken once: by a start, or when no
//! kernel is left that could start it. Facts: reference channel-synchronisation.md 1.4, 2.1.

use std::sync::Arc;

use counterpoint_event::FileId;

use super::{Order, Wake};
use crate::tag::Tag;
use crate::wait::ChannelSet;

/// A program that a channel can be started with.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct StartableProgram {
    /// Its file.
    pub file: FileId,
    /// First and last line.
    pub lines: (u32, u32),
    /// Name for the log.
    pub name: Arc<str>,
}

impl Order {
    /// The program of a kernel that has the turn, or has not begun yet, does not run any more: others may start it.
    pub fn rest_idle(&mut self, channel: u16) {
        self.waits.places.rest(channel);
        self.block(channel);
    }

    /// The program of a channel for its next start, if it is idle; before the kernels run, of any channel.
    pub fn preselect(&mut self, channel: u16, program: StartableProgram) {
        if let Some(seat) = self.seat(channel) {
            seat.program = Some(program);
        }
    }

    /// Selects the program of an idle channel; none if there is no such program.
    ///
    /// # Errors
    /// Why it cannot be selected.
    pub fn select(&mut self, channel: u16, program: Option<StartableProgram>) -> Result<(), String> {
        self.can_start(channel)?;
        if let Some(seat) = self.seat(channel) {
            seat.program = program;
        }
        Ok(())
    }

    /// Starts the selected programs of idle channels after the operation at this tag.
    ///
    /// # Errors
    /// Why one of them cannot be started; then none is.
    pub fn start(&mut self, tag: Tag, channels: ChannelSet) -> Result<(), String> {
        let mut programs = Vec::new();
        for channel in channels.iter() {
            self.can_start(channel)?;
            let program = self.seat(channel).and_then(|seat| seat.program.clone());
            programs.push((channel, program.ok_or_else(|| format!("channel {channel} has no program selected"))?));
        }
        self.shared.met(channels.with(tag.channel));
        if let Some(races) = &mut self.races {
            races.start(channels, tag.channel);
        }
        for (channel, program) in programs {
            self.waits.places.start(channel);
            let tag = Tag { t: tag.t, micro: tag.micro + 1, channel };
            self.resume(channel, Wake::Started { tag, program });
        }
        Ok(())
    }

    fn can_start(&self, channel: u16) -> Result<(), String> {
        if self.waits.places.idle().has(channel) {
            return Ok(());
        }
        let ended = self.waits.places.end(channel).is_some();
        Err(format!("channel {channel} {}", if ended { "cannot be started any more" } else { "is running" }))
    }
}
