//! Rows of `[[waits]]`: waits and acts as the control of the machine writes them.
//!
//! Facts: reference channel-synchronisation.md 1.1 to 1.9.

use counterpoint_event::event::Primitive;

use crate::rows::CodeForm;

/// A word, a text or a statement at which a channel waits for others, or lets them continue.
#[derive(Debug, Clone, PartialEq)]
pub struct WaitRow {
    /// Form of its row in the code table; none of a statement of the pre-processor.
    pub form: Option<CodeForm>,
    /// The text, the letters of the word, or the name of the statement.
    pub word: String,
    /// Primitive.
    pub primitive: Primitive,
    /// The effect of the word.
    pub act: WaitAct,
    /// Number of the mark of a text.
    pub mark: u32,
    /// Highest mark of a statement.
    pub highest: u32,
    /// Channels that a count needs; 0: all.
    pub need: u16,
    /// A channel that has ended or has no program counts as arrived.
    pub absent_counts: bool,
    /// A partner that waits at a word of this primitive counts as arrived.
    pub met_by: Option<Primitive>,
    /// The text is followed by systems, more such texts with systems, and L with a label.
    pub line_up: bool,
    /// The path stops at it; otherwise only if the others are not there when it would have to brake.
    pub stops: bool,
    /// Which pairs of waits are refused.
    pub mismatch: MismatchRule,
    /// The special rules of signals.
    pub signals: SignalRow,
}

/// The data of a row about signals.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct SignalRow {
    /// The statement has keywords in brackets, and a channel may send to itself.
    pub keys: bool,
    /// A signal to all channels stays until it is removed; otherwise each receiver uses up its own.
    pub stays: bool,
    /// A wait while an older signal of the sender has not been used is a warning.
    pub in_order: bool,
}

impl WaitRow {
    /// Whether its row in the code table has this form.
    #[must_use]
    pub fn is_of(&self, form: &CodeForm) -> bool {
        self.form.as_ref() == Some(form)
    }
}

/// The effect of a word of `[[waits]]`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum WaitAct {
    /// Waits.
    Wait,
    /// Sets the own flag.
    Set,
    /// Deletes the own flag.
    Clear,
    /// Sends a signal.
    Signal,
    /// Releases a resource that the channel holds.
    Release,
    /// Takes a resource that another channel holds.
    Take,
    /// Passes on a resource that the channel holds.
    Give,
    /// Selects the program of a channel.
    Select,
    /// Starts the selected programs of channels.
    Start,
}

/// The control whose rule refuses pairs of waits.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MismatchRule {
    /// None: waits that do not match wait.
    Free,
    /// Fanuc: alarms PS0160 and PS0161.
    Fanuc,
    /// Siemens: warning 16949.
    Siemens,
}
