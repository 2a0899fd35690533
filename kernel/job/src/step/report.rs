//! Reports the positions of everything to the operator.

use counterpoint_event::info::{self, BLOCK_TEXT};
use counterpoint_ports::control::ChannelActivity;
use counterpoint_ports::dialog::answers::DialogValue;
use counterpoint_ports::step::{ChannelReport, Common, StepReport};

use super::{Director, StepState, SteppedChannel};

impl Director<'_> {
    /// Where everything is, and why the run is paused.
    pub(super) fn report(
        &self,
        state: &StepState,
        (channel, reason): (u16, &str),
        common: &mut Common<'_>,
    ) -> StepReport {
        StepReport {
            reason: reason.to_owned(),
            channel,
            channels: self.info.channels.iter().zip(&state.channels).map(|(of, one)| self.channel(of, one)).collect(),
            variables: common(),
            breakpoints: state.breakpoints.all(),
        }
    }

    fn channel(&self, of: &info::JobChannel, one: &SteppedChannel) -> ChannelReport {
        let index = self.info.channel_index(of.number);
        let progress = index.and_then(|index| self.control.progress().get(index));
        let state = progress.map_or(ChannelActivity::NotStarted, |now| now.state());
        let seen = one.seen.clone().unwrap_or_default();
        let reached = progress.map_or(0, |now| now.t_ns.load(std::sync::atomic::Ordering::Relaxed));
        let axes = of.axes.iter().zip(seen.position).filter(|_| one.seen.is_some());
        ChannelReport {
            channel: of.number,
            state,
            file: one.seen.as_ref().map_or_else(String::new, |seen| self.info.file_name(seen.file).to_owned()),
            line: seen.line,
            block: self.info.block_text(seen.file, seen.line, BLOCK_TEXT).into_owned(),
            t_ns: seen.t_ns.max(reached),
            wait: progress.and_then(|now| now.waiting_for()),
            held: one.held,
            in_block: !one.at_block && matches!(state, ChannelActivity::Running | ChannelActivity::Waiting),
            positions: axes.map(|(axis, value)| (axis.name.clone(), value)).collect(),
            words: seen.words,
            variables: seen.variables.iter().map(|(n, value)| (format!("#{n}"), DialogValue::Number(*value))).collect(),
        }
    }
}
