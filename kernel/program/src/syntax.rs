//! Treatment of program text by the pre-processor of a control, as data: the programs and names in a file, and the
//! blocks that are not plain words.
//!
//! The search for programs and the scanner ask this and know no pre-processor. Facts: reference control-emulator.md
//! 5.4, 5.7. *Invariant:* nothing here depends on the machine, only on its pre-processor.

use super::key_words::KeyWords;

/// The rules by which one pre-processor reads program text.
#[derive(Debug)]
pub struct Syntax {
    /// `O` and `:` with a number define programs; elsewhere `:` is the number of a main block.
    pub numbered_programs: bool,
    /// Names in angle brackets define programs and call them.
    pub angle_names: bool,
    /// Programs that have names of letters and digits.
    pub named_programs: Option<NamedPrograms>,
    /// Words that call by number besides those of the machine's code table.
    pub call_words: &'static [&'static str],
    /// Key words of the statements that are mixed with words (custom macro). Then a variable or an expression may be
    /// the value of any word.
    pub key_words: Option<KeyWords>,
    /// Whether a block is more than plain words: a quick look at the text. For pre-processors whose statements are
    /// blocks of their own.
    pub needs_interpreter: Option<fn(&[u8]) -> bool>,
    /// An unknown name of two letters or more remains one piece of text, with the contents of its brackets.
    pub keeps_names: bool,
}

/// Programs by name, in the text of a file.
#[derive(Debug, Clone, Copy)]
pub struct NamedPrograms {
    /// The name by which a line defines a program.
    pub defined: fn(&[u8]) -> Option<&[u8]>,
    /// The name or number of the program that a line without comments, in capitals, calls.
    pub called: fn(&[u8]) -> Option<String>,
    /// A line belongs to its file and to no program.
    pub is_header: fn(&[u8]) -> bool,
    /// A line says that its program is a subprogram.
    pub returns: fn(&[u8]) -> bool,
    /// The channel of a job archive named by the line that defines a program, and the number of the program there. 0 is
    /// the main program of the channel, others are data.
    pub in_archive: Option<ReadArchiveHead>,
}

/// Reads the channel and the number of a program off the line of a job archive that defines it.
pub type ReadArchiveHead = fn(&[u8]) -> Option<(u16, u32)>;

/// Of a control without a pre-processor.
pub static PLAIN: Syntax = Syntax {
    numbered_programs: true,
    angle_names: false,
    named_programs: None,
    call_words: &[],
    key_words: None,
    needs_interpreter: None,
    keeps_names: false,
};

impl Syntax {
    /// Whether there is something besides plain words.
    #[must_use]
    pub fn has_preprocessor(&self) -> bool {
        self.key_words.is_some() || self.needs_interpreter.is_some()
    }
}
