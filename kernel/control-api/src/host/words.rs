//! Words of the machine: their names, the formats of their numbers, and the block that is made of them.

use counterpoint_machine::index::{CodeRowId, RegisterId};
use counterpoint_machine::model::{MacroWords, Triples};
use counterpoint_program::key_words::WrittenNumber;

/// A word that the interpreter made.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MadeWord {
    /// Register.
    pub register: RegisterId,
    /// It is the incremental form.
    pub incremental: bool,
    /// Value.
    pub value: f64,
    /// The value is this number as written, which the register reads by its format.
    pub written: Option<WrittenNumber>,
    /// Start and end in the text of the block.
    pub span: (u32, u32),
}

/// Words and codes of the machine.
pub trait WordHost {
    /// Whether words may begin with this text: a register of the machine has the name.
    fn is_register(&self, name: &str) -> bool;

    /// The word of a register with a value: as it is spelled, otherwise so that the register reads this value, rounded
    /// to its digits. None if no register has the name, with or without `=` at its end.
    fn word(&self, name: &str, value: f64, spelled: Option<&str>) -> Option<String>;

    /// Name of the incremental form of a register.
    fn second(&self, register: &str) -> Option<String>;

    /// A literal text of the machine's code table, letter case ignored.
    fn is_code_text(&self, text: &str) -> bool;

    /// Row of a literal text in the machine's code table, letter case ignored.
    fn literal(&self, text: &str) -> Option<CodeRowId>;

    /// Whether the machine has a code for the word of a letter with this value.
    fn knows_code(&self, letter: u8, value: f64) -> bool;

    /// Lengths are in inches.
    fn is_inch(&self) -> bool;

    /// Units of positions in one unit of the program's lengths.
    fn length_factor(&self) -> f64;

    /// Register of a letter, and whether the letter is its incremental form.
    fn register(&self, letter: u8) -> Option<(RegisterId, bool)>;

    /// Register of a name, with or without a final `=`, and whether the name is its incremental form.
    fn register_named(&self, name: &str) -> Option<(RegisterId, bool)>;

    /// Register of words that begin with this text, and whether this is the incremental form. `None` unless such words
    /// are data for every value: no code and no literal text of the machine begins with this text.
    fn data_register(&self, before: &str) -> Option<(RegisterId, bool)>;

    /// Register of words that begin with this text, and whether it is the incremental form, if each number after the
    /// text is its value: no literal text and no other register begins with the text and a number.
    fn value_register(&self, before: &str) -> Option<(RegisterId, bool)>;

    /// Row of a literal text that is read as one, whatever follows it after a blank.
    fn separate_text(&self, text: &str) -> Option<CodeRowId>;

    /// Whether a literal text, or the text before the numbers of a register, begins with this text.
    fn begins_name(&self, text: &str) -> bool;

    /// Steps of one unit that the value of an expression is rounded to at a register, if the machine rounds.
    fn steps(&self, register: RegisterId) -> Option<f64>;

    /// Value of a number as a register reads it. Faults of the number are kept with the block.
    fn read(&mut self, register: RegisterId, number: WrittenNumber) -> f64;

    /// Makes the value the sequence number of the block, if the register is that of sequence numbers and the block has
    /// none; whether it did.
    fn take_sequence(&mut self, register: RegisterId, value: f64) -> bool;

    /// The sequence number of the block.
    fn set_sequence(&mut self, number: u32);

    /// Place of a program name in angle brackets in the block.
    fn set_program_name(&mut self, span: (u32, u32));

    /// Adds a word to the block.
    fn push(&mut self, word: MadeWord);

    /// Adds a value as a word of a register, which may be its incremental form. The register reads a number as
    /// `spelled`, and any other value with the digits of its format.
    fn push_value(&mut self, register: (RegisterId, bool), value: f64, spelled: Option<&str>, span: (u32, u32));

    /// Adds a computed value as a word of a register. The register reads the shortest number that has the value, with at
    /// most nine digits after the point.
    fn push_computed(&mut self, register: (RegisterId, bool), value: f64, span: (u32, u32));

    /// Adds a literal text of the machine, by its row in the code table, which replaces a part of the block.
    fn push_literal(&mut self, row: CodeRowId, span: (u32, u32));

    /// Ends the block. The words that follow form a block of their own, which acts after it.
    fn end_block(&mut self);

    /// Adds the words of a part of the block that the interpreter leaves unchanged. `text` is the block, or a copy that
    /// has blanks in place of comments, so places in `text` are places in the block.
    fn push_plain(&mut self, text: &[u8], span: (u32, u32));

    /// Adds a value that replaces a part of the block; its register reads `number`, and `word` is its text for the
    /// trace. False if `number` is not a number.
    fn push_number(&mut self, register: (RegisterId, bool), number: &str, word: &str, span: (u32, u32)) -> bool;

    /// Adds words that replace a part of the block, with its place.
    fn push_written(&mut self, words: &str, span: (u32, u32));

    /// Adds a part of the block that is not a word of the machine.
    fn push_unknown(&mut self, text: &[u8], span: (u32, u32));

    /// Sets the text of a block that continues on further lines.
    fn join_lines(&mut self, text: &[u8]);

    /// Adds a literal text of the machine, by its row in the code table.
    fn push_text(&mut self, row: CodeRowId);

    /// A part of the text remains in the block for the tables of the machine.
    fn keep_text(&mut self, span: (u32, u32));

    /// All words of the block are made: the trace shows them.
    fn words_are_made(&mut self);

    /// Which words of a block are arguments of its macro call.
    fn macro_words(&self) -> MacroWords;

    /// Which variables I, J and K of a macro call give values.
    fn triples(&self) -> Triples;
}
