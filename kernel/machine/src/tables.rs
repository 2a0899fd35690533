//! Dense lookups compiled from the rows when a machine is loaded; the block loop uses them for every word.
//!
//! Invariant: rows that are switched off are in none of these tables, and candidates are in matching order: lowest
//! order first, equal orders as in the file. Facts: reference control-emulator.md 1.2, 1.3.

use rustc_hash::FxHashMap;

use super::ident::{DataId, Name};
use super::index::{CodeRowId, DataRowId, IdTable, RegisterId};
use super::rows::{CodeForm, CodeRow, DataRow, Register};

/// Register a letter belongs to, and whether it is its second, incremental name; `None` = no regular register.
pub type LetterEntry = Option<(RegisterId, bool)>;

/// Code numbers below this one may have one decimal and are looked up directly.
const DENSE: u32 = 1000;

/// How far a value may be from a code number.
const TOLERANCE: f64 = 1e-9;

/// The lookups.
#[derive(Debug, Clone, PartialEq)]
pub struct LookupTables {
    /// Per ASCII byte: the regular register it names.
    pub letter: [LetterEntry; 128],
    /// Enabled data rows of each register, in file order.
    pub data_of_register: IdTable<RegisterId, Vec<DataRowId>>,
    /// Enabled data rows of each data identifier, in file order.
    pub rows_of_data: IdTable<DataId, Vec<DataRowId>>,
    /// Enabled rows of literal text: longest text first, then in matching order.
    pub texts: Vec<CodeRowId>,
    codes: IdTable<RegisterId, Option<CodeLookup>>,
}

/// Code rows of one register.
#[derive(Debug, Clone, PartialEq)]
struct CodeLookup {
    /// Row lists; the first is empty.
    lists: Vec<Vec<CodeRowId>>,
    /// List per value times ten, below [`DENSE`].
    dense: Vec<u16>,
    /// List from a whole value on, ascending; from [`DENSE`] on.
    steps: Vec<(u32, u16)>,
}

impl Default for LookupTables {
    fn default() -> Self {
        Self::new(&IdTable::default(), &IdTable::default(), &IdTable::default(), &IdTable::default())
    }
}

impl LookupTables {
    /// Compiles the rows; `names` has all data identifiers.
    #[must_use]
    pub fn new(
        registers: &IdTable<RegisterId, Register>,
        codes: &IdTable<CodeRowId, CodeRow>,
        data: &IdTable<DataRowId, DataRow>,
        names: &IdTable<DataId, Name>,
    ) -> Self {
        Self {
            letter: letters(registers),
            data_of_register: data_of_register(registers, data),
            rows_of_data: rows_of_data(data, names),
            texts: texts(codes),
            codes: registers.map(|register, _| CodeLookup::new(register, codes)),
        }
    }

    /// Code rows that a word of this register and value may mean, in matching order; empty when it is not a code. The
    /// rows' conditions on other words (`with`, `without`) are the caller's to check.
    #[must_use]
    pub fn code(&self, register: RegisterId, value: f64) -> &[CodeRowId] {
        self.codes[register].as_ref().map_or(&[], |codes| codes.at(value))
    }

    /// Whether any code is written with this register.
    #[must_use]
    pub fn has_codes(&self, register: RegisterId) -> bool {
        self.codes[register].is_some()
    }

    /// Enabled rows of a data identifier.
    #[must_use]
    pub fn data(&self, id: DataId) -> &[DataRowId] {
        &self.rows_of_data[id]
    }

    /// Enabled data rows of a register.
    #[must_use]
    pub fn data_of(&self, register: RegisterId) -> &[DataRowId] {
        &self.data_of_register[register]
    }
}

impl CodeLookup {
    fn new(register: RegisterId, codes: &IdTable<CodeRowId, CodeRow>) -> Option<Self> {
        let rows = rows_of_register(register, codes);
        if rows.is_empty() {
            return None;
        }
        let mut lists = Lists::default();
        let dense = lists.dense(&rows);
        let mut starts: Vec<u32> =
            rows.iter().flat_map(CodeValueRange::breaks).filter(|start| *start > DENSE).collect();
        starts.push(DENSE);
        starts.sort_unstable();
        starts.dedup();
        let steps = starts
            .into_iter()
            .map(|start| (start, lists.intern(&rows, |row| row.matches(u64::from(start) * 10))))
            .collect();
        Some(Self { lists: lists.lists, dense, steps })
    }

    #[inline(always)]
    fn at(&self, value: f64) -> &[CodeRowId] {
        // The usual code is a small whole number; `as` saturates.
        let whole = value as u32;
        let small = f64::from(whole) == value && whole < DENSE;
        let list = if small && let Some(&list) = self.dense.get(whole as usize * 10) {
            Some(list)
        } else {
            self.any_list(value)
        };
        list.and_then(|list| self.lists.get(usize::from(list))).map_or(&[], Vec::as_slice)
    }

    #[inline(never)]
    fn any_list(&self, value: f64) -> Option<u16> {
        if value < f64::from(DENSE) { self.dense_list(value) } else { self.step_list(value) }
    }

    fn dense_list(&self, value: f64) -> Option<u16> {
        if value < -TOLERANCE {
            return None;
        }
        // Rounds to the nearest tenth; `as` saturates and turns NaN into 0, which never gets here because it is not
        // below DENSE.
        let index = (value * 10.0 + 0.5) as u32 as usize;
        if (index as f64 / 10.0 - value).abs() > TOLERANCE {
            return None;
        }
        if index == self.dense.len() { self.step_list(f64::from(DENSE)) } else { self.dense.get(index).copied() }
    }

    fn step_list(&self, value: f64) -> Option<u16> {
        let whole = value.round();
        if (whole - value).abs() <= TOLERANCE && whole <= f64::from(u32::MAX) {
            let number = whole as u32;
            let after = self.steps.partition_point(|(start, _)| *start <= number);
            return self.steps.get(after.checked_sub(1)?).map(|(_, list)| *list);
        }
        None
    }
}

/// Each list of rows once.
struct Lists {
    lists: Vec<Vec<CodeRowId>>,
    known: FxHashMap<Vec<CodeRowId>, u16>,
}

impl Default for Lists {
    fn default() -> Self {
        Self { lists: vec![Vec::new()], known: FxHashMap::from_iter([(Vec::new(), 0)]) }
    }
}

impl Lists {
    /// List of every tenth below [`DENSE`]: only tenths that a row covers are looked at.
    fn dense(&mut self, rows: &[CodeValueRange]) -> Vec<u16> {
        let mut covered: FxHashMap<usize, Vec<CodeRowId>> = FxHashMap::default();
        for row in rows {
            let step = if row.decimals { 1 } else { 10 };
            let first = if row.decimals { row.min } else { row.min.div_ceil(10) * 10 };
            for tenth in (first..=row.max.min(u64::from(DENSE) * 10 - 1)).step_by(step) {
                covered.entry(tenth as usize).or_default().push(row.row);
            }
        }
        let mut dense = vec![0; DENSE as usize * 10];
        for (tenth, list) in covered {
            if let Some(slot) = dense.get_mut(tenth) {
                *slot = self.list(list);
            }
        }
        dense
    }

    fn intern(&mut self, rows: &[CodeValueRange], matches: impl Fn(&CodeValueRange) -> bool) -> u16 {
        self.list(rows.iter().filter(|row| matches(row)).map(|row| row.row).collect())
    }

    fn list(&mut self, list: Vec<CodeRowId>) -> u16 {
        if let Some(known) = self.known.get(&list) {
            return *known;
        }
        let number = u16::try_from(self.lists.len()).unwrap_or(0);
        self.lists.push(list.clone());
        self.known.insert(list, number);
        number
    }
}

/// Values of a code row in tenths.
struct CodeValueRange {
    row: CodeRowId,
    order: u16,
    min: u64,
    max: u64,
    /// Values with a decimal match too.
    decimals: bool,
}

impl CodeValueRange {
    fn matches(&self, tenth: u64) -> bool {
        (self.min..=self.max).contains(&tenth) && (self.decimals || tenth.is_multiple_of(10))
    }

    /// Whole values at which matching may change.
    fn breaks(&self) -> [u32; 2] {
        let whole = |tenth: u64| u32::try_from(tenth.div_ceil(10)).unwrap_or(u32::MAX);
        [whole(self.min), whole(self.max + 1)]
    }
}

fn rows_of_register(register: RegisterId, codes: &IdTable<CodeRowId, CodeRow>) -> Vec<CodeValueRange> {
    let mut rows: Vec<CodeValueRange> = Vec::new();
    for (row, code) in codes.entries() {
        if let Some((of, min, max)) = form_range(&code.form)
            && code.enable
            && of == register
        {
            let (min, max) = (tenths(min), tenths(max));
            let decimals = !(min.is_multiple_of(10) && max.is_multiple_of(10));
            rows.push(CodeValueRange { row, order: code.order, min, max, decimals });
        }
    }
    rows.sort_by_key(|row| (row.order, row.row));
    rows
}

/// Register and value range of a code's form.
#[must_use]
pub fn form_range(form: &CodeForm) -> Option<(RegisterId, f64, f64)> {
    match form {
        CodeForm::Register { register, min, max } | CodeForm::RegisterAsData { register, min, max, .. } => {
            Some((*register, *min, *max))
        }
        CodeForm::NotApplicable | CodeForm::Text(_) => None,
    }
}

/// Whether two rows have a value in common that both match.
pub(super) fn overlap(a: (f64, f64), b: (f64, f64)) -> bool {
    let (from, to) = (tenths(a.0).max(tenths(b.0)), tenths(a.1).min(tenths(b.1)));
    let decimals = |range: (f64, f64)| !(tenths(range.0).is_multiple_of(10) && tenths(range.1).is_multiple_of(10));
    if decimals(a) && decimals(b) { from <= to } else { from.div_ceil(10) * 10 <= to }
}

fn tenths(value: f64) -> u64 {
    (value * 10.0).round() as u64
}

fn letters(registers: &IdTable<RegisterId, Register>) -> [LetterEntry; 128] {
    let mut letters = [None; 128];
    for (register, incremental) in [(registers, true), (registers, false)] {
        for (id, definition) in register.entries() {
            let name = if incremental { definition.second.as_deref() } else { Some(definition.before.as_str()) };
            let name = name.filter(|_| definition.after.is_empty());
            if let Some(slot) = name.and_then(single_capital).and_then(|byte| letters.get_mut(usize::from(byte))) {
                *slot = Some((id, incremental));
            }
        }
    }
    letters
}

fn single_capital(name: &str) -> Option<u8> {
    match name.as_bytes() {
        [byte] if byte.is_ascii_uppercase() => Some(*byte),
        _ => None,
    }
}

fn data_of_register(
    registers: &IdTable<RegisterId, Register>,
    data: &IdTable<DataRowId, DataRow>,
) -> IdTable<RegisterId, Vec<DataRowId>> {
    let mut lists = registers.map(|_, _| Vec::new());
    for (row, definition) in data.entries() {
        if let Some(register) = definition.register.filter(|_| definition.enable) {
            lists[register].push(row);
        }
    }
    lists
}

fn rows_of_data(data: &IdTable<DataRowId, DataRow>, names: &IdTable<DataId, Name>) -> IdTable<DataId, Vec<DataRowId>> {
    let mut lists = names.map(|_, _| Vec::new());
    for (row, definition) in data.entries().filter(|(_, definition)| definition.enable) {
        lists[definition.id].push(row);
    }
    lists
}

fn texts(codes: &IdTable<CodeRowId, CodeRow>) -> Vec<CodeRowId> {
    let mut rows: Vec<(usize, u16, CodeRowId)> = codes
        .entries()
        .filter_map(|(row, code)| match &code.form {
            CodeForm::Text(text) if code.enable => Some((usize::MAX - text.len(), code.order, row)),
            _ => None,
        })
        .collect();
    rows.sort_unstable();
    rows.into_iter().map(|(_, _, row)| row).collect()
}

#[cfg(test)]
mod tests;
