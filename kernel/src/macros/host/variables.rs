//! System variables of a running kernel, by index.
//!
//! Invariant: the table of what each index reads is made once from the names; while macros run nothing is looked up by
//! name. What the kernel does not know itself is kept here with its first value. Facts: reference system-variables.md;
//! positions and decisions: docs/emulation.md.

mod coolant;
mod cycles;
mod frames;
mod kernels;
mod offsets;
mod positions;
mod program;
mod spindles;
mod state;
mod threads;
mod tip;

use std::sync::OnceLock;

use counterpoint_lang::diag::Number;
use counterpoint_lang::fault::{Fault, Outcome};
use counterpoint_lang::value::Value;
use rustc_hash::FxHashMap;

use crate::channel::Kernel;
use crate::diag;
use crate::machine::macros::model::{HOOKS, Hook};
use crate::machine::macros::system::{self, Access, Variable};

/// Elements of indexed variables that a kernel keeps.
const MOST_ELEMENTS: usize = 200_000;

/// Reads a variable off the kernel.
type Read = fn(&Kernel<'_>, &[i64]) -> Value;

/// Writes a variable into the kernel.
type Write = fn(&mut Kernel<'_>, &[i64], &Value) -> Outcome<()>;

/// Where a variable comes from.
#[derive(Clone, Copy)]
enum Source {
    /// Kept in the store.
    Kept,
    /// Read off the kernel; written if there is a way.
    State(Read, Option<Write>),
    /// Position of an axis.
    Position(positions::Place),
    /// Switch of a hook.
    Switch(Hook),
}

struct Row {
    source: Source,
    variable: &'static Variable,
}

fn rows() -> &'static [Row] {
    static ROWS: OnceLock<Vec<Row>> = OnceLock::new();
    ROWS.get_or_init(|| {
        let row = |variable: &'static Variable| Row { source: source(&variable.name), variable };
        system::table().iter().map(row).collect()
    })
}

fn source(name: &str) -> Source {
    if let Some(hook) = Hook::ALL.into_iter().find(|hook| hook.switch() == Some(name)) {
        return Source::Switch(hook);
    }
    if let Some(place) = positions::place(name) {
        return Source::Position(place);
    }
    let own = [cycles::find, spindles::find, threads::find, coolant::find];
    let own = own.into_iter().chain([kernels::find, frames::find, offsets::find, tip::find]);
    let found = [program::find, state::find].into_iter().chain(own).find_map(|find| find(name));
    match found {
        Some((read, write)) => Source::State(read, write),
        None => Source::Kept,
    }
}

/// Indices of variables that the kernel itself sets.
pub(crate) struct Names {
    pub(crate) mcdrd: u32,
    pub(crate) display: u32,
    pub(crate) comment: u32,
    pub(crate) tool_name: u32,
    pub(crate) last_tool: u32,
    pub(crate) first_tool: u32,
    pub(crate) tool_table: u32,
    pub(crate) tool_row: u32,
    pub(crate) tool_rows: u32,
    pub(crate) tool_sort: u32,
    pub(crate) tool_length: u32,
    pub(crate) kernel_program: u32,
    pub(crate) kernel_name: u32,
    pub(crate) kernel_channel: u32,
    pub(crate) kernel_line: u32,
    pub(crate) model_channel: u32,
    pub(crate) operation_table: u32,
    pub(crate) operation_merge: u32,
    pub(crate) operation_name: u32,
    pub(crate) extension: u32,
    pub(crate) parameters: u32,
    pub(crate) command_line: u32,
}

/// Those indices, found once.
pub(crate) fn names() -> &'static Names {
    static NAMES: OnceLock<Names> = OnceLock::new();
    NAMES.get_or_init(|| {
        let index = |name: &str| {
            let at = system::table().iter().position(|variable| variable.name == name);
            at.and_then(|at| u32::try_from(at).ok()).unwrap_or(u32::MAX)
        };
        Names {
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
#[derive(Debug)]
pub(crate) struct Store {
    values: Vec<Value>,
    elements: FxHashMap<(u32, i64, i64), Value>,
    /// Switches of the hooks.
    pub(crate) switches: [bool; HOOKS],
    /// `$ERRMSG`
    pub(crate) messages: bool,
    /// `$MSG00`, `$WRN04`, `$ERR08`, `$FTL16`
    pub(crate) counts: [f64; 4],
    /// `$DIAGLIST`
    pub(crate) listed: Vec<u32>,
    /// `$EMBMAC`: before the pre-processor, after it, end.
    pub(crate) embedding: [String; 3],
    /// `$MCDNO` after TAPERD, 0 for the block in process.
    pub(crate) number: u32,
    /// `$CECODE`
    pub(crate) code: Option<crate::machine::ident::CodeId>,
    /// `$FEDTIM`, `$RAPTIM` in seconds.
    pub(crate) times: [f64; 2],
    /// What macros have added to `$MISTIM`, `$IDLTIM`, in seconds.
    pub(crate) added_times: [f64; 2],
    /// Time of all motions and of all waiting, in nanoseconds.
    pub(crate) moving: i64,
    pub(crate) idle: i64,
    /// What `$FCEPP` has set.
    pub(crate) preprocessor: super::preprocessor::Settings,
    /// What may be set before Machine Startup ends is still open.
    pub(crate) starting: bool,
}

impl Store {
    pub(crate) fn new() -> Self {
        Self {
            values: system::table().iter().map(|variable| variable.first.clone()).collect(),
            elements: FxHashMap::default(),
            switches: [true; HOOKS],
            messages: true,
            counts: [0.0; 4],
            listed: Vec::new(),
            embedding: ["#{".to_owned(), "!{".to_owned(), "}".to_owned()],
            number: 0,
            code: None,
            times: [0.0; 2],
            added_times: [0.0; 2],
            moving: 0,
            idle: 0,
            preprocessor: super::preprocessor::Settings::default(),
            starting: false,
        }
    }

    /// Sets a single variable.
    pub(crate) fn set(&mut self, index: u32, value: Value) {
        if let Some(place) = self.values.get_mut(index as usize) {
            *place = value;
        }
    }

    /// A single variable.
    pub(crate) fn get(&self, index: u32) -> &Value {
        self.values.get(index as usize).unwrap_or(&Value::Null)
    }

    /// All values.
    pub(crate) fn all(&self) -> impl Iterator<Item = &Value> {
        self.values.iter().chain(self.elements.values())
    }

    /// Sets an element.
    pub(crate) fn set_element(&mut self, index: u32, (first, second): (i64, i64), value: Value) {
        self.elements.insert((index, first, second), value);
    }

    /// Sets an element that a macro gave, as long as there is room.
    pub(crate) fn keep_element(&mut self, index: u32, (first, second): (i64, i64), value: Value) -> Outcome<()> {
        if self.elements.len() >= MOST_ELEMENTS {
            return Err(Fault::new(Number::SIZE, "there are too many elements of system variables"));
        }
        self.elements.insert((index, first, second), value);
        Ok(())
    }

    /// An element that was set.
    pub(crate) fn element(&self, index: u32, (first, second): (i64, i64)) -> Option<&Value> {
        self.elements.get(&(index, first, second))
    }
}

fn pair(indices: &[i64]) -> (i64, i64) {
    (indices.first().copied().unwrap_or(0), indices.get(1).copied().unwrap_or(0))
}

/// Refuses indices outside of what a variable has.
fn check_indices(variable: &Variable, indices: &[i64]) -> Outcome<()> {
    for (given, most) in indices.iter().zip(&variable.indices) {
        if *given < 1 || most.is_some_and(|most| *given > i64::from(most)) {
            let most = most.map_or_else(|| "no limit".to_owned(), |most| most.to_string());
            let text = format!("the index {given} of {} is not in 1 to {most}", variable.name);
            return Err(Fault::new(Number::OUT_OF_RANGE, text));
        }
    }
    Ok(())
}

/// The value as the variable takes it.
fn checked(variable: &Variable, value: Value) -> Outcome<Value> {
    let value = match (variable.kind, value) {
        (Some(kind), Value::Unset) => kind.initial(),
        (_, Value::Null) if matches!(variable.first, Value::Null) => Value::Null,
        (Some(kind), value) if value.kind() != Some(kind) => return Err(Fault::kind(kind.name(), &value)),
        (_, value) => value,
    };
    if let (Some((low, high)), Value::Real(number)) = (variable.range, &value)
        && !(low..=high).contains(number)
    {
        let text = format!("{} takes numbers from {low} to {high}, not {number}", variable.name);
        return Err(Fault::new(Number::BAD_VALUE, text));
    }
    Ok(value)
}

impl Kernel<'_> {
    pub(super) fn read_variable(&mut self, index: u32, indices: &[i64]) -> Outcome<Value> {
        let Some(row) = rows().get(index as usize) else { return Ok(Value::Null) };
        if !indices.is_empty() {
            check_indices(row.variable, indices)?;
        }
        Ok(match row.source {
            Source::State(read, _) => read(self, indices),
            Source::Position(place) => Value::Real(self.position_of(place)),
            Source::Switch(hook) => {
                let on = |runtime: &super::super::runtime::Runtime| runtime.store.switches.get(hook as usize).copied();
                Value::Logical(self.macros.as_deref().and_then(on).unwrap_or(true))
            }
            Source::Kept => {
                let Some(runtime) = self.macros.as_deref() else { return Ok(Value::Null) };
                let (first, second) = pair(indices);
                let element =
                    if indices.is_empty() { None } else { runtime.store.elements.get(&(index, first, second)) };
                element.unwrap_or_else(|| runtime.store.get(index)).clone()
            }
        })
    }

    pub(super) fn write_variable(&mut self, index: u32, indices: &[i64], value: Value) -> Outcome<()> {
        let Some(row) = rows().get(index as usize) else { return Ok(()) };
        let value = checked(row.variable, value)?;
        check_indices(row.variable, indices)?;
        let machine = self.channel.env.machine;
        let Some(runtime) = self.macros.as_deref_mut() else { return Ok(()) };
        if row.variable.access == Access::Start && !runtime.store.starting {
            let text = format!("{} has no effect after Machine Startup", row.variable.name);
            self.diagnose(&diag::START_ONLY, text);
            return Ok(());
        }
        match row.source {
            Source::State(_, Some(write)) => return write(self, indices, &value),
            Source::State(_, None) | Source::Position(_) => {
                let text = format!("{} is kept by this control itself and cannot be set here", row.variable.name);
                return Err(Fault::new(Number::NO_HOST, text));
            }
            Source::Switch(hook) => {
                let on = value.as_logical().unwrap_or(true);
                if let Some(slot) = runtime.store.switches.get_mut(hook as usize) {
                    *slot = on;
                }
                let code = machine.macros.as_deref().and_then(|macros| macros.hook(hook)).filter(|_| on);
                if let Some(slot) = runtime.hooks.get_mut(hook as usize) {
                    *slot = code;
                }
            }
            Source::Kept if indices.is_empty() => runtime.store.set(index, value),
            Source::Kept => {
                runtime.store.keep_element(index, pair(indices), value)?;
            }
        }
        Ok(())
    }

    /// Text of a kept variable.
    pub(crate) fn stored_text(&self, index: u32) -> String {
        let value = self.macros.as_deref().map(|runtime| runtime.store.get(index));
        value.and_then(Value::as_text).unwrap_or("").to_owned()
    }

    /// Sets a kept variable, if there are macros.
    pub(crate) fn store(&mut self, index: u32, value: impl FnOnce() -> Value) {
        if let Some(runtime) = self.macros.as_deref_mut() {
            runtime.store.set(index, value());
        }
    }
}
