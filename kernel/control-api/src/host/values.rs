//! Values outside the interpreter: those of the kernel by number, those shared by all channels, and those that only the
//! machine's identification macro knows.

use counterpoint_fault::{Acted, Halt};
use counterpoint_lang::value::MacroValue;

/// Answer of the identification macro about an unknown variable, function or text.
#[derive(Debug, Clone, PartialEq)]
pub enum IdentificationAnswer {
    /// There is no macro, or it leaves the matter to the control, which reports it.
    Unknown,
    /// Nothing happens and nothing is reported; inside an expression the value is 0.
    Drop,
    /// This text is evaluated instead.
    Instead(String),
    /// The text remains in the block as it is.
    Keep,
}

impl IdentificationAnswer {
    /// The answer, unless it is the text that was asked: evaluating that again would ask forever.
    pub fn unless(self, asked: &str) -> Self {
        match self {
            Self::Instead(answer) if answer.trim() == asked.trim() => Self::Unknown,
            answer => answer,
        }
    }
}

/// Why a numbered variable cannot be read or written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NotThere {
    /// There is no such variable.
    Missing,
    /// It can be read only.
    ReadOnly,
    /// The value is not possible.
    TooBig,
    /// The job was stopped.
    Halt(Halt),
}

/// Variables of the kernel and of the machine.
pub trait ValueHost {
    /// A variable that all channels share, by name, if it has a value.
    ///
    /// # Errors
    /// The job was stopped.
    fn shared(&mut self, name: &str) -> Result<Option<MacroValue>, Halt>;

    /// The number of a variable that all channels share, by name, if it has one.
    ///
    /// # Errors
    /// The job was stopped.
    fn shared_number(&mut self, name: &str) -> Result<Option<f64>, Halt>;

    /// Sets a variable that all channels share; none takes its value away.
    ///
    /// # Errors
    /// The job was stopped.
    fn set_shared(&mut self, name: &str, value: Option<MacroValue>) -> Acted;

    /// Whether the machine gives common variables to each channel instead of sharing them.
    fn has_own_common(&self) -> bool;

    /// Value of a local variable of the running program (`#1` to `#33`), which most expressions read; vacant without a
    /// value and for every other number.
    fn local_number(&self, index: u32) -> f64;

    /// Value of a numbered variable (`#n`): local, common or of the system; vacant without a value.
    ///
    /// # Errors
    /// It does not exist, or the job was stopped.
    fn number(&mut self, index: u32) -> Result<f64, NotThere>;

    /// Sets a numbered variable.
    ///
    /// # Errors
    /// It does not exist or cannot be written, or the job was stopped.
    fn set_number(&mut self, index: u32, value: f64) -> Result<(), NotThere>;

    /// Number of an alarm that a program raises with 0.
    fn program_alarm(&self) -> u32;

    /// Whether a numbered variable is common, of all channels or of this one.
    fn is_common(&self, index: u32) -> bool;

    /// A numbered variable without a value is vacant, otherwise it is 0, as is one that does not exist.
    fn set_vacant(&mut self, on: bool);

    /// The identification macro is asked where to write a system variable, otherwise its value is kept.
    fn set_asking(&mut self, on: bool);

    /// Whether there is an identification macro that may be asked now.
    fn identifies(&self) -> bool;

    /// Asks the identification macro about a text, with the value that is being assigned to it.
    ///
    /// # Errors
    /// The macro stopped the channel.
    fn identify(&mut self, text: &str, assigned: Option<&MacroValue>) -> Result<IdentificationAnswer, Halt>;
}
