//! Live progress: one bar per channel on a terminal, plain lines otherwise.

use std::io::IsTerminal as _;
use std::path::Path;
use std::time::{Duration, Instant};

use counterpoint_proto::v1;
use indicatif::{MultiProgress, ProgressBar, ProgressStyle};

use crate::say;
use crate::text::time;

/// Shortest interval between plain lines.
const PLAIN_EVERY: Duration = Duration::from_secs(2);

/// Shows progress.
pub(crate) enum ProgressDisplay {
    Quiet,
    Plain { said: Instant },
    Bars { all: MultiProgress, bars: Vec<ProgressBar> },
}

impl ProgressDisplay {
    pub(crate) fn new(quiet: bool) -> Self {
        match () {
            () if quiet => Self::Quiet,
            () if std::io::stderr().is_terminal() => Self::Bars { all: MultiProgress::new(), bars: Vec::new() },
            () => Self::Plain { said: Instant::now() },
        }
    }

    pub(crate) fn show(&mut self, progress: &v1::Progress) {
        match self {
            Self::Quiet => {}
            Self::Plain { said } => {
                if said.elapsed() >= PLAIN_EVERY {
                    *said = Instant::now();
                    let line =
                        |c: &v1::ChannelProgress| format!("{} {}", c.name, describe(c, progress.cancel_requested));
                    progress.channels.iter().for_each(|channel| say::status_line(line(channel)));
                }
            }
            Self::Bars { all, bars } => {
                for (i, channel) in progress.channels.iter().enumerate() {
                    if bars.len() <= i {
                        bars.push(all.add(bar(&channel.name)));
                    }
                    if let Some(bar) = bars.get(i) {
                        bar.set_position(channel.percent as u64);
                        bar.set_message(describe(channel, progress.cancel_requested));
                    }
                }
            }
        }
    }

    /// Prints a line about the job.
    pub(crate) fn note(&self, line: &str) {
        match self {
            Self::Quiet => {}
            Self::Plain { .. } => say::status_line(line),
            Self::Bars { all, .. } => all.suspend(|| say::status_line(line)),
        }
    }

    /// Removes the bars.
    pub(crate) fn clear(&mut self) {
        if let Self::Bars { all, .. } = self {
            let _ = all.clear();
        }
    }
}

/// Shows which result is being written.
pub(crate) enum ResultProgress {
    Quiet,
    Plain { said: Instant },
    Spinner(ProgressBar),
}

impl ResultProgress {
    pub(crate) fn new(quiet: bool) -> Self {
        match () {
            () if quiet => Self::Quiet,
            () if std::io::stderr().is_terminal() => Self::Spinner(ProgressBar::new_spinner()),
            () => Self::Plain { said: Instant::now() },
        }
    }

    /// Shows that this file is being written.
    pub(crate) fn show(&mut self, file: &Path) {
        self.say(format!("writing {}", file.display()));
    }

    /// Shows what is done now.
    pub(crate) fn say(&mut self, text: String) {
        match self {
            Self::Quiet => {}
            Self::Plain { said } => {
                if said.elapsed() >= PLAIN_EVERY {
                    *said = Instant::now();
                    say::status_line(text);
                }
            }
            Self::Spinner(spinner) => {
                spinner.set_message(text);
                spinner.tick();
            }
        }
    }

    /// Removes the displayed line.
    pub(crate) fn clear(self) {
        if let Self::Spinner(spinner) = self {
            spinner.finish_and_clear();
        }
    }
}

fn bar(name: &str) -> ProgressBar {
    let style = ProgressStyle::with_template("{prefix:>8} {bar:24} {pos:>3}% {wide_msg}");
    let bar = ProgressBar::new(100).with_prefix(name.to_owned());
    if let Ok(style) = style {
        bar.set_style(style);
    }
    bar
}

/// The blocks, the simulated time and the state of a channel.
pub(crate) fn describe(channel: &v1::ChannelProgress, cancelling: bool) -> String {
    let state = match channel.state() {
        _ if cancelling => "cancelling".to_owned(),
        v1::ChannelState::Waiting if !channel.waiting_for.is_empty() => format!("waits for {}", channel.waiting_for),
        state => state.as_str_name().trim_start_matches("CHANNEL_STATE_").replace('_', " ").to_lowercase(),
    };
    format!("block {}  {}  {state}", channel.blocks, time(channel.t_ns))
}
