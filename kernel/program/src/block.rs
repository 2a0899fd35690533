//! One block as words.
//!
//! Invariant: buffers are reused from block to block; filling a block allocates nothing once they have grown.

use crate::line_up::LineUp;
use counterpoint_machine::ident::DataId;
use counterpoint_machine::index::{CodeRowId, REGISTERS, RegisterId};
use counterpoint_machine::rows::CodeRow;

/// A word: letter and number.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Word {
    /// Its register.
    pub register: RegisterId,
    /// Written with the register's second (incremental) name.
    pub incremental: bool,
    /// Taken by a code or an action.
    pub used: bool,
    /// Whether a pre-processor made the value. The value then has the digits that its register writes, and the text at
    /// the place of the word is an expression.
    pub made: bool,
    /// Number as read by the register's format, before any factor.
    pub value: f64,
    /// Start in the line.
    pub start: u32,
    /// End in the line.
    pub end: u32,
}

/// A code that is going to act.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PendingCode {
    /// Order of its row.
    pub order: u16,
    /// Row of the code table.
    pub row: CodeRowId,
    /// Value of the word (before factor), 0 for literal texts.
    pub value: f64,
    /// The modal code of its group that words fire; it is not written in the block.
    pub modal: bool,
    /// Acts only if some of its triggering data has not been consumed by then.
    pub only_if_data_left: bool,
}

/// A value removed from the block.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RetrievedValue {
    /// Value after factor and change of units.
    pub value: f64,
    /// Written with the incremental name.
    pub incremental: bool,
    /// Absolute even where the mode says incremental: a macro has said so.
    pub absolute: bool,
    /// Written without any fraction or as such: value before the factor.
    pub raw: f64,
}

/// Words of a block at most, and texts of other kinds.
const MOST_WORDS: usize = 255;

/// Irregularities in the text of a block.
pub mod irregular {
    /// A number with more whole digits than its register's format.
    pub const DIGITS: u8 = 1;
    /// A comment or message without its end.
    pub const OPEN_COMMENT: u8 = 2;
    /// Control characters.
    pub const BYTES: u8 = 4;
    /// A program name in angle brackets, which a call may take.
    pub const NAME: u8 = 8;
    /// A negative value in a register that has no sign.
    pub const SIGN: u8 = 16;
    /// A decimal point in a register that takes none.
    pub const POINT: u8 = 32;
    /// Irregularities of numbers.
    pub const NUMBERS: u8 = DIGITS | SIGN | POINT;
}

/// How a move beside a compensated contour comes to the next one.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub enum ContourEnd {
    /// Round or sharp outside, where the offsets cut each other inside.
    #[default]
    Meets,
    /// Where the offsets meet, outside too.
    Sharp,
    /// Outside both continue by a length, then an arc joins them.
    Extended(f64),
    /// At its own end.
    Open,
    /// Outside by an arc.
    Round,
    /// Perpendicular to this direction of the plane.
    Beside([f64; 2]),
}

/// Properties of a block as a whole.
#[derive(Debug, Clone, Copy, Default)]
pub struct BlockFlags {
    /// Irregularities of its text except unrecognised text, bit by bit.
    pub irregular: u8,
    /// This block's positions are in the machine frame.
    pub machine_frame: bool,
    /// Exact stop for this block.
    pub exact_stop: bool,
    /// How its move ends beside a compensated contour.
    pub end: ContourEnd,
    /// A motion code acted.
    pub moved: bool,
    /// Its first cut has been paired with that of another channel.
    pub paired: bool,
    /// One of its codes is swallowed or changes the length of the tool.
    pub special: bool,
    /// The axis moves by the current change of the frame: a change of the tool length.
    pub travels: bool,
    /// Whether a later motion code has removed its cycle.
    pub cycle_dropped: bool,
}

/// The block being processed.
#[derive(Debug)]
pub struct Block {
    /// Words, left to right.
    pub words: Vec<Word>,
    /// Codes, by order.
    pub pending: Vec<PendingCode>,
    /// Unrecognised spans of the line.
    pub unrecognised: Vec<(u32, u32)>,
    /// Spans of operator messages.
    pub messages: Vec<(u32, u32)>,
    /// Literal text codes found: row.
    pub texts: Vec<CodeRowId>,
    /// Position (plus one) of the last data word of each register.
    slots: [u8; REGISTERS],
    /// Registers of data words that nothing has taken yet, bit by register.
    pub present: u128,
    /// A register is written twice; its first word is never taken.
    doubled: bool,
    /// Data that macros have put in the block: value without factor and units.
    pub added: Vec<(DataId, f64)>,
    /// Position of the code that acts next, on a kernel with macros.
    pub next: usize,
    /// Span of the program name in angle brackets that `flags` tell of; one of the unrecognised ones until a call takes
    /// it.
    name: (u32, u32),
    /// Sequence number.
    pub sequence: Option<u32>,
    /// The word at which systems line up.
    pub line_up: Option<LineUp>,
    /// Properties of the block as a whole.
    pub flags: BlockFlags,
}

impl Default for Block {
    fn default() -> Self {
        Self {
            words: Vec::with_capacity(32),
            pending: Vec::with_capacity(16),
            unrecognised: Vec::with_capacity(4),
            messages: Vec::new(),
            texts: Vec::new(),
            slots: [0; REGISTERS],
            present: 0,
            doubled: false,
            added: Vec::new(),
            next: 0,
            name: (0, 0),
            sequence: None,
            line_up: None,
            flags: BlockFlags::default(),
        }
    }
}

impl Block {
    /// Whether a free data word of one of these registers is in the block.
    #[must_use]
    pub fn has_any(&self, registers: u128) -> bool {
        self.present & registers != 0
    }

    /// Empties the block for the next line.
    pub fn clear(&mut self) {
        self.words.clear();
        self.pending.clear();
        self.unrecognised.clear();
        self.messages.clear();
        self.texts.clear();
        self.present = 0;
        self.doubled = false;
        self.added.clear();
        self.next = 0;
        self.sequence = None;
        self.line_up = None;
        self.flags = BlockFlags::default();
    }

    /// Adds a word; a block takes 255 at most, the rest is unrecognised text.
    #[inline(always)]
    pub fn push(&mut self, word: Word) {
        if self.words.len() >= MOST_WORDS {
            self.push_unrecognised((word.start, word.end));
            return;
        }
        self.words.push(word);
    }

    /// Marks a word as used.
    #[inline]
    pub fn use_word(&mut self, position: usize) {
        if let Some(word) = self.words.get_mut(position) {
            word.used = true;
        }
    }

    /// Queues the code of a row; `modal`: the modal code of its group, which is not written in the block.
    #[inline]
    pub fn queue(&mut self, index: CodeRowId, row: &CodeRow, value: f64, modal: bool) {
        self.flags.special |= row.special;
        self.pending.push(PendingCode { order: row.order, row: index, value, modal, only_if_data_left: false });
    }

    /// Adds text that is not a word. When there are very many such texts, the text between them becomes part of one.
    pub fn push_unrecognised(&mut self, (start, end): (u32, u32)) {
        let many = self.unrecognised.len() >= MOST_WORDS;
        match self.unrecognised.last_mut() {
            Some(last) if last.1 == start || many => last.1 = last.1.max(end),
            _ => self.unrecognised.push((start, end)),
        }
    }

    /// Adds a literal text code; a block takes as many as words.
    pub fn push_text(&mut self, row: CodeRowId, (start, end): (u32, u32)) {
        if self.texts.len() >= MOST_WORDS {
            self.push_unrecognised((start, end));
            return;
        }
        self.texts.push(row);
    }

    /// Span of a program name in angle brackets that nothing has taken.
    pub fn name(&self) -> Option<(u32, u32)> {
        (self.flags.irregular & irregular::NAME != 0).then_some(self.name)
    }

    /// Notes a program name.
    pub fn set_name(&mut self, span: (u32, u32)) {
        self.flags.irregular |= irregular::NAME;
        self.name = span;
        self.unrecognised.push(span);
    }

    /// Takes the program name off the block.
    pub fn take_name(&mut self) -> Option<(u32, u32)> {
        let name = self.name()?;
        self.flags.irregular &= !irregular::NAME;
        self.unrecognised.retain(|span| *span != name);
        Some(name)
    }

    /// Makes a word findable as data; of several words of one register the last one counts.
    #[inline(always)]
    pub fn index_word(&mut self, position: usize) {
        if let Some(word) = self.words.get(position)
            && let Some(slot) = self.slots.get_mut(word.register.index())
        {
            let bit = word.register.bit();
            self.doubled |= self.present & bit != 0;
            *slot = position.min(255) as u8;
            self.present |= bit;
        }
    }

    /// Takes the data word of a register, if it is there and still free.
    #[inline]
    pub fn take(&mut self, register: RegisterId) -> Option<Word> {
        let bit = register.bit();
        if self.present & bit == 0 {
            return None;
        }
        self.present ^= bit;
        let slot = *self.slots.get(register.index())?;
        let word = self.words.get_mut(usize::from(slot))?;
        word.used = true;
        Some(*word)
    }

    /// The data word that [`take`](Self::take) would take.
    pub fn look(&self, register: RegisterId) -> Option<Word> {
        let slot = self.slots.get(register.index()).filter(|_| self.has(register))?;
        self.words.get(usize::from(*slot)).copied()
    }

    /// Whether a free data word of this register is in the block.
    pub fn has(&self, register: RegisterId) -> bool {
        self.present & register.bit() != 0
    }

    /// Whether a word that nothing has taken is in the block.
    pub fn has_leftovers(&self) -> bool {
        self.present != 0 || self.doubled
    }

    /// Whether something about the text of the block is worth a message.
    pub fn has_remarks(&self) -> bool {
        self.flags.irregular != 0 || !self.unrecognised.is_empty()
    }
}
