//! System variables that live nowhere else in a kernel, and the indices of those that the kernel itself sets.

use std::sync::OnceLock;

use counterpoint_lang::diag::DiagnosticNumber;
use counterpoint_lang::fault::{MacroFault, Outcome};
use counterpoint_lang::value::MacroValue;
use rustc_hash::FxHashMap;

use counterpoint_machine::macros::model::HOOKS;
use counterpoint_machine::macros::system;

/// Elements of indexed variables that a kernel keeps.
const MOST_ELEMENTS: usize = 200_000;

/// Columns of the tool table that the control knows.
pub mod column {
    /// Number of the tool.
    pub const NUMBER: i64 = 1;
    /// Number of its offset.
    pub const OFFSET: i64 = 5;
    /// Length of the tool.
    pub const LENGTH: i64 = 6;
    /// Identifier of the tool.
    pub const ID: i64 = 9;
    /// Diameter of the tool.
    pub const DIAMETER: i64 = 11;
    /// Name of the tool.
    pub const NAME: i64 = 20;
}

/// Indices of variables that the kernel itself sets.
pub struct SystemVariableIndices {
    /// `$MCDRD`
    pub mcdrd: u32,
    /// `$DISPLY`
    pub display: u32,
    /// `$TPRINT`
    pub comment: u32,
    /// `$TLNAME`
    pub tool_name: u32,
    /// `$LT`
    pub last_tool: u32,
    /// `$FT`
    pub first_tool: u32,
    /// `$TLTAB`
    pub tool_table: u32,
    /// `$TI`
    pub tool_row: u32,
    /// `$TLSIZ`
    pub tool_rows: u32,
    /// `$TLSORT`
    pub tool_sort: u32,
    /// `$TOZ`
    pub tool_length: u32,
    /// `$MCEINP`
    pub kernel_program: u32,
    /// `$MCENAM`
    pub kernel_name: u32,
    /// `$MCECHN`
    pub kernel_channel: u32,
    /// Starting lines.
    pub kernel_line: u32,
    /// `$VMCHN`
    pub model_channel: u32,
    /// `$OPTAB`
    pub operation_table: u32,
    /// `$OPMERGE`
    pub operation_merge: u32,
    /// `$OPNAME`
    pub operation_name: u32,
    /// `$SUBEXT`
    pub extension: u32,
    /// `$UPARAM`
    pub parameters: u32,
    /// `$PARAM`
    pub command_line: u32,
}

/// Those indices, found once.
pub fn names() -> &'static SystemVariableIndices {
    static NAMES: OnceLock<SystemVariableIndices> = OnceLock::new();
    NAMES.get_or_init(|| {
        let index = |name: &str| {
            let at = system::table().iter().position(|variable| variable.name == name);
            at.and_then(|at| u32::try_from(at).ok()).unwrap_or(u32::MAX)
        };
        SystemVariableIndices {
            mcdrd: index("$MCDRD"),
            display: index("$DISPLY"),
            comment: index("$TPRINT"),
            tool_name: index("$TLNAME"),
            last_tool: index("$LT"),
            first_tool: index("$FT"),
            tool_table: index("$TLTAB"),
            tool_row: index("$TI"),
            tool_rows: index("$TLSIZ"),
            tool_sort: index("$TLSORT"),
            tool_length: index("$TOZ"),
            kernel_program: index("$MCEMCD"),
            kernel_name: index("$MCENAM"),
            kernel_channel: index("$MCECHN"),
            kernel_line: index("$MCESTA"),
            model_channel: index("$VMCHN"),
            operation_table: index("$OPTAB"),
            operation_merge: index("$OPMERGE"),
            operation_name: index("$OPNAME"),
            extension: index("$SUBEXT"),
            parameters: index("$UPARAM"),
            command_line: index("$PARAM"),
        }
    })
}

/// Variables that live nowhere else in the kernel.
#[derive(Debug, Default)]
pub struct SystemVariableStore {
    values: Vec<MacroValue>,
    /// Elements of indexed variables, by variable and indices.
    pub elements: FxHashMap<(u32, i64, i64), MacroValue>,
    /// Switches of the hooks.
    pub switches: [bool; HOOKS],
    /// `$ERRMSG`
    pub messages: bool,
    /// `$MSG00`, `$WRN04`, `$ERR08`, `$FTL16`
    pub counts: [f64; 4],
    /// `$DIAGLIST`
    pub listed: Vec<u32>,
    /// `$EMBMAC`: before the pre-processor, after it, end.
    pub embedding: [String; 3],
    /// `$MCDNO` after TAPERD, 0 for the block in process.
    pub number: u32,
    /// Settings made by `$FCEPP`.
    pub preprocessor: super::settings::PreprocessorSettings,
    /// Whether settings that are only possible before the end of Machine Startup are still open.
    pub starting: bool,
}

impl SystemVariableStore {
    /// The variables with the values that they have at the start.
    pub fn new() -> Self {
        Self {
            values: system::table().iter().map(|variable| variable.first.clone()).collect(),
            elements: FxHashMap::default(),
            switches: [true; HOOKS],
            messages: true,
            counts: [0.0; 4],
            listed: Vec::new(),
            embedding: ["#{".to_owned(), "!{".to_owned(), "}".to_owned()],
            number: 0,
            preprocessor: super::settings::PreprocessorSettings::default(),
            starting: false,
        }
    }

    /// Sets a single variable.
    pub fn set(&mut self, index: u32, value: MacroValue) {
        if let Some(place) = self.values.get_mut(index as usize) {
            *place = value;
        }
    }

    /// A single variable.
    pub fn get(&self, index: u32) -> &MacroValue {
        self.values.get(index as usize).unwrap_or(&MacroValue::Null)
    }

    /// The text of a single variable, empty if it is not a text.
    pub fn text(&self, index: u32) -> String {
        self.get(index).as_text().unwrap_or("").to_owned()
    }

    /// All values.
    pub fn all(&self) -> impl Iterator<Item = &MacroValue> {
        self.values.iter().chain(self.elements.values())
    }

    /// Continues the counts of another component.
    pub fn continue_counts(&mut self, of: &Self) {
        (self.counts, self.listed) = (of.counts, of.listed.clone());
    }

    /// Sets an element.
    pub fn set_element(&mut self, index: u32, (first, second): (i64, i64), value: MacroValue) {
        self.elements.insert((index, first, second), value);
    }

    /// Sets an element for a macro, unless there are too many.
    pub fn keep_element(&mut self, index: u32, (first, second): (i64, i64), value: MacroValue) -> Outcome<()> {
        if self.elements.len() >= MOST_ELEMENTS {
            return Err(MacroFault::new(DiagnosticNumber::SIZE, "there are too many elements of system variables"));
        }
        self.elements.insert((index, first, second), value);
        Ok(())
    }

    /// An element that was set.
    pub fn element(&self, index: u32, (first, second): (i64, i64)) -> Option<&MacroValue> {
        self.elements.get(&(index, first, second))
    }
}
