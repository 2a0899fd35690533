//! The code of a macro.
//!
//! *Invariant:* an instruction is eight bytes and names registers, never places in memory; constants sit in registers
//! of their own that are filled once. Every instruction knows its statement, and some have a short form in [`fast`].

pub mod body;
pub mod fast;

use crate::func::BuiltInFunction;
use crate::source::{MacroSource, Span};
use crate::value::{MacroValue, ValueType};
use std::sync::Arc;

/// A register of a frame.
pub type Slot = u16;
/// A position in the code.
pub type Target = u16;
/// No register.
pub const NO_SLOT: Slot = Slot::MAX;
/// Most instructions and registers of a macro.
pub const MAX_CODE: usize = 60_000;

/// Comparison.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Relation {
    /// `.EQ.`
    Equal,
    /// `.NE.`
    NotEqual,
    /// `.LT.`
    Less,
    /// `.LE.`
    LessEqual,
    /// `.GT.`
    Greater,
    /// `.GE.`
    GreaterEqual,
}

/// Commands without a value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CommandCode {
    /// MATCH/ON
    MatchOn,
    /// MATCH/OFF
    MatchOff,
    /// At the start and after the end of a user function: MATCH is on.
    MatchAgain,
    /// OUTPUT
    Output,
    /// EXEC/NEXT of formatted text
    ExecNextFormat,
    /// EXEC/NOW of formatted text
    ExecNowFormat,
    /// EXEC/NEXT of values
    ExecNext,
    /// EXEC/NOW of values
    ExecNow,
    /// TAPERD
    TapeRead,
    /// TAPEWT
    TapeWrite,
    /// SEARCH
    Search,
    /// SAVMODAL
    SaveModal,
    /// RSTMODAL
    RestoreModal,
    /// LPRINT/ON
    ListingOn,
    /// LPRINT/OFF
    ListingOff,
    /// LPRINT/n
    Skip,
    /// PPRINT
    Print,
    /// OPEN
    Open,
    /// CLOSE
    Close,
    /// WRITE
    Write,
    /// ERROR
    Error,
    /// SYSTEM
    System,
}

/// Variables that the machine itself knows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BuiltInVariable {
    /// `$ERRNO`
    Status,
    /// `$MNEST`
    Nesting,
    /// `$CI`
    Channel,
    /// `$CHSIZ`, `$CHMAX`
    Channels,
}

/// One instruction. `list` is a position in [`CompiledMacro::lists`].
#[derive(Clone, Copy, Debug)]
#[allow(missing_docs, reason = "the operands are named the same way throughout: destination, operands, list, target")]
pub enum Instruction {
    Move {
        to: Slot,
        a: Slot,
    },
    Typed {
        to: Slot,
        a: Slot,
        kind: ValueType,
    },
    Add {
        to: Slot,
        a: Slot,
        b: Slot,
    },
    Subtract {
        to: Slot,
        a: Slot,
        b: Slot,
    },
    Multiply {
        to: Slot,
        a: Slot,
        b: Slot,
    },
    Divide {
        to: Slot,
        a: Slot,
        b: Slot,
    },
    Power {
        to: Slot,
        a: Slot,
        b: Slot,
    },
    Join {
        to: Slot,
        a: Slot,
        b: Slot,
    },
    Negate {
        to: Slot,
        a: Slot,
    },
    Number {
        to: Slot,
        a: Slot,
    },
    Not {
        to: Slot,
        a: Slot,
    },
    Truth {
        to: Slot,
        a: Slot,
    },
    Xor {
        to: Slot,
        a: Slot,
        b: Slot,
    },
    Compare {
        relation: Relation,
        to: Slot,
        a: Slot,
        b: Slot,
    },
    /// Adds to a number, text or sequence in place.
    AddTo {
        to: Slot,
        a: Slot,
    },
    Jump {
        target: Target,
    },
    JumpIf {
        a: Slot,
        target: Target,
    },
    JumpUnless {
        a: Slot,
        target: Target,
    },
    JumpUnlessCompare {
        relation: Relation,
        a: Slot,
        b: Slot,
        target: Target,
    },
    /// Jumps if the values have one type and are equal.
    JumpIfWhen {
        a: Slot,
        b: Slot,
        target: Target,
    },
    /// Jumps if `a` lies between the registers `low` and `low+1`.
    JumpIfThru {
        a: Slot,
        low: Slot,
        target: Target,
    },
    /// Checks the operands of a DO: variable, end in `end`, step in `end+1`; jumps if there is no pass.
    DoStart {
        variable: Slot,
        end: Slot,
        target: Target,
    },
    /// Steps and jumps to the body if there is another pass.
    DoNext {
        variable: Slot,
        end: Slot,
        target: Target,
    },
    Element {
        to: Slot,
        a: Slot,
        index: Slot,
    },
    Elements {
        to: Slot,
        a: Slot,
        list: u16,
    },
    SetElement {
        to: Slot,
        index: Slot,
        a: Slot,
    },
    SetElements {
        to: Slot,
        list: u16,
        a: Slot,
    },
    Range {
        to: Slot,
        a: Slot,
        list: u16,
    },
    Sequence {
        to: Slot,
        list: u16,
    },
    ReadShared {
        to: Slot,
        shared: u16,
    },
    WriteShared {
        shared: u16,
        a: Slot,
    },
    SharedElements {
        to: Slot,
        shared: u16,
        list: u16,
    },
    SetSharedElements {
        shared: u16,
        list: u16,
        a: Slot,
    },
    ReadSystem {
        to: Slot,
        system: u16,
        list: u16,
    },
    WriteSystem {
        system: u16,
        list: u16,
        a: Slot,
    },
    ReadOwn {
        to: Slot,
        own: BuiltInVariable,
    },
    Declare {
        to: Slot,
        declaration: u16,
    },
    DeclareShared {
        shared: u16,
        declaration: u16,
    },
    Math {
        to: Slot,
        a: Slot,
        function: u16,
    },
    Call {
        to: Slot,
        function: u16,
        list: u16,
    },
    CallMacro {
        to: Slot,
        callee: u16,
        list: u16,
    },
    Command {
        command: CommandCode,
        list: u16,
    },
    Read {
        list: u16,
        targets: u16,
        again: bool,
    },
    Trace {
        statement: u16,
    },
    Return,
}

/// A declaration executed at run time.
#[derive(Clone, Debug)]
pub struct RuntimeDeclaration {
    /// Type.
    pub kind: Option<ValueType>,
    /// Registers of the sizes.
    pub sizes: Vec<Slot>,
    /// With the hidden channel dimension.
    pub channel: bool,
    /// Register of the first value.
    pub value: Option<Slot>,
}

/// Where a shared variable lives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SharedVariable {
    /// In the object's store.
    Object(u32),
    /// In the host's store.
    Global(u32),
}

/// Short forms of a macro.
#[derive(Clone, Debug, Default)]
pub struct ShortForms {
    /// One for each instruction.
    pub forms: Vec<fast::Fast>,
    /// Small functions that they execute in place of a call.
    pub bodies: Vec<body::Body>,
}

/// Registers of a macro.
#[derive(Clone, Debug, Default)]
pub struct RegisterLayout {
    /// How many there are.
    pub count: usize,
    /// Those that hold constants.
    pub constants: Vec<(Slot, MacroValue)>,
    /// Those cleared at entry.
    pub locals: Vec<Slot>,
}

/// The inputs and outputs of a macro.
#[derive(Clone, Debug, Default)]
pub struct Signature {
    /// It is a user function.
    pub is_function: bool,
    /// Registers of `$P` arguments.
    pub arguments: Vec<(u8, Slot)>,
    /// Registers and types of the parameters of a function.
    pub parameters: Vec<(Slot, Option<ValueType>)>,
    /// Register and type of the result of a function.
    pub result: Option<(Slot, Option<ValueType>)>,
}

/// Compiled macro.
#[derive(Clone, Debug)]
pub struct CompiledMacro {
    /// Name shown in diagnostics and traces.
    pub name: String,
    /// Its file.
    pub source: Arc<MacroSource>,
    /// Instructions.
    pub ops: Vec<Instruction>,
    /// Short forms.
    pub short: ShortForms,
    /// Place of the statement of each instruction.
    pub places: Vec<Span>,
    /// Registers.
    pub registers: RegisterLayout,
    /// Arguments, parameters and result.
    pub signature: Signature,
    /// Register lists.
    pub lists: Vec<Vec<Slot>>,
    /// Declarations.
    pub declarations: Vec<RuntimeDeclaration>,
    /// Shared variables used.
    pub shared: Vec<(SharedVariable, Option<ValueType>)>,
    /// Home of each of them: the register that holds it while short forms run.
    pub homes: Vec<Slot>,
    /// Functions used.
    pub functions: Vec<&'static BuiltInFunction>,
    /// Statements in standard style, for the trace.
    pub statements: Vec<String>,
}

impl CompiledMacro {
    /// Whether it reads a system variable.
    #[must_use]
    pub fn reads(&self, variable: u16) -> bool {
        self.ops.iter().any(|op| matches!(op, Instruction::ReadSystem { system, .. } if *system == variable))
    }

    pub(crate) fn empty(source: &Arc<MacroSource>) -> CompiledMacro {
        CompiledMacro {
            name: String::new(),
            source: Arc::clone(source),
            ops: Vec::new(),
            short: ShortForms::default(),
            places: Vec::new(),
            registers: RegisterLayout::default(),
            signature: Signature::default(),
            lists: Vec::new(),
            declarations: Vec::new(),
            shared: Vec::new(),
            homes: Vec::new(),
            functions: Vec::new(),
            statements: Vec::new(),
        }
    }
}
