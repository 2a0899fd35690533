//! The approach of a cycle call to its position.

use counterpoint_control_api::host::InterpreterHost;

use super::q_parameter::{ParameterKind, QParameter};
use super::words::{EvaluatedWord, LeftBlock, headed};

/// Q204, the second clearance.
pub(super) const SECOND_CLEARANCE: QParameter = QParameter { kind: ParameterKind::Q, index: 204 };

/// How a call of a cycle leads to its position: straight, without compensation, at the feed of its block or at rapid.
pub(super) struct CallApproach {
    pub(super) feed: Option<EvaluatedWord>,
    rapid: &'static str,
    /// The first words of straight blocks, with a feed and at rapid.
    line: [&'static str; 2],
    off: &'static str,
}

impl CallApproach {
    /// As the words of a call say.
    pub(super) fn of(host: &dyn InterpreterHost, seen: &[EvaluatedWord]) -> Self {
        let text = |text: &'static str| if host.is_code_text(text) { text } else { "" };
        let feed = seen.iter().find(|word| word.is_rate() && word.is("F")).cloned();
        let line = if host.is_code_text("L") { ["L"; 2] } else { ["G1", "G0"] };
        Self { feed, rapid: text("FMAX"), line, off: text("R0") }
    }

    /// Whether the call has a feed of its own.
    pub(super) fn has_feed(&self) -> bool {
        self.feed.is_some()
    }

    /// A block to some positions; `rapid` overrides the feed.
    pub(super) fn block(&self, words: impl IntoIterator<Item = EvaluatedWord>, rapid: bool) -> LeftBlock {
        let feed = self.feed.as_ref().filter(|_| !rapid);
        let line = if feed.is_some() { self.line[0] } else { self.line[1] };
        let text = |text: &str| (!text.is_empty()).then(|| EvaluatedWord::text(text));
        let last = feed.cloned().or_else(|| text(self.rapid));
        headed(line, words.into_iter().chain(text(self.off)).chain(last))
    }
}
