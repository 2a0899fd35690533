//! Dense lookups compiled from the rows when a machine is loaded: what the block loop asks for every word.
//!
//! Invariant: rows that are switched off are in none of these tables, and candidates are in matching order: lowest
//! order first, equal orders as in the file. Facts: reference control-emulator.md 1.2, 1.3.

use rustc_hash::FxHashMap;

use super::ident::{DataId, Name};
use super::index::{CodeRowId, DataRowId, RegisterId, Table};
use super::rows::{CodeForm, CodeRow, DataRow, Register};

/// Register a letter belongs to, and whether it is its second, incremental name; `None` = no regular register.
pub type LetterEntry = Option<(RegisterId, bool)>;

/// Code numbers below this one may have one decimal and are looked up directly.
const DENSE: u32 = 1000;

/// How far a value may be from a code number.
const TOLERANCE: f64 = 1e-9;

/// The lookups.
#[derive(Debug, Clone, PartialEq)]
pub struct Tables {
    /// Per ASCII byte: the regular register it names.
    pub letter: [LetterEntry; 128],
    /// Enabled data rows of each register, in file order.
    pub data_of_register: Table<RegisterId, Vec<DataRowId>>,
    /// Enabled data rows of each data identifier, in file order.
    pub rows_of_data: Table<DataId, Vec<DataRowId>>,
    /// Enabled rows of literal text: longest text first, then in matching order.
    pub texts: Vec<CodeRowId>,
    codes: Table<RegisterId, Option<Codes>>,
}

/// Code rows of one register.
#[derive(Debug, Clone, PartialEq)]
struct Codes {
    /// Row lists; the first is empty.
    lists: Vec<Vec<CodeRowId>>,
    /// List per value times ten, below [`DENSE`].
    dense: Vec<u16>,
    /// List from a whole value on, ascending; from [`DENSE`] on.
    steps: Vec<(u32, u16)>,
}

impl Default for Tables {
    fn default() -> Self {
        Self::new(&Table::default(), &Table::default(), &Table::default(), &Table::default())
    }
}

impl Tables {
    /// Compiles the rows; `names` has all data identifiers.
    #[must_use]
    pub fn new(
        registers: &Table<RegisterId, Register>,
        codes: &Table<CodeRowId, CodeRow>,
        data: &Table<DataRowId, DataRow>,
        names: &Table<DataId, Name>,
    ) -> Self {
        Self {
            letter: letters(registers),
            data_of_register: data_of_register(registers, data),
            rows_of_data: rows_of_data(data, names),
            texts: texts(codes),
            codes: registers.map(|register, _| Codes::new(register, codes)),
        }
    }

    /// Code rows that a word of this register and value may mean, in matching order; empty when it is no code. The
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

impl Codes {
    fn new(register: RegisterId, codes: &Table<CodeRowId, CodeRow>) -> Option<Self> {
        let rows = rows_of_register(register, codes);
        if rows.is_empty() {
            return None;
        }
        let mut lists = Lists::default();
        let dense = lists.dense(&rows);
        let mut starts: Vec<u32> = rows.iter().flat_map(Range::breaks).filter(|start| *start > DENSE).collect();
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
    fn dense(&mut self, rows: &[Range]) -> Vec<u16> {
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

    fn intern(&mut self, rows: &[Range], matches: impl Fn(&Range) -> bool) -> u16 {
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
struct Range {
    row: CodeRowId,
    order: u16,
    min: u64,
    max: u64,
    /// Values with a decimal match too.
    decimals: bool,
}

impl Range {
    fn matches(&self, tenth: u64) -> bool {
        (self.min..=self.max).contains(&tenth) && (self.decimals || tenth.is_multiple_of(10))
    }

    /// Whole values at which matching may change.
    fn breaks(&self) -> [u32; 2] {
        let whole = |tenth: u64| u32::try_from(tenth.div_ceil(10)).unwrap_or(u32::MAX);
        [whole(self.min), whole(self.max + 1)]
    }
}

fn rows_of_register(register: RegisterId, codes: &Table<CodeRowId, CodeRow>) -> Vec<Range> {
    let mut rows: Vec<Range> = Vec::new();
    for (row, code) in codes.entries() {
        if let Some((of, min, max)) = form_range(&code.form)
            && code.enable
            && of == register
        {
            let (min, max) = (tenths(min), tenths(max));
            let decimals = !(min.is_multiple_of(10) && max.is_multiple_of(10));
            rows.push(Range { row, order: code.order, min, max, decimals });
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

fn letters(registers: &Table<RegisterId, Register>) -> [LetterEntry; 128] {
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
    registers: &Table<RegisterId, Register>,
    data: &Table<DataRowId, DataRow>,
) -> Table<RegisterId, Vec<DataRowId>> {
    let mut lists = registers.map(|_, _| Vec::new());
    for (row, definition) in data.entries() {
        if let Some(register) = definition.register.filter(|_| definition.enable) {
            lists[register].push(row);
        }
    }
    lists
}

fn rows_of_data(data: &Table<DataRowId, DataRow>, names: &Table<DataId, Name>) -> Table<DataId, Vec<DataRowId>> {
    let mut lists = names.map(|_, _| Vec::new());
    for (row, definition) in data.entries().filter(|(_, definition)| definition.enable) {
        lists[definition.id].push(row);
    }
    lists
}

fn texts(codes: &Table<CodeRowId, CodeRow>) -> Vec<CodeRowId> {
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
mod tests {
    use super::super::ident::dimension::Dimension;
    use super::super::ident::{codes, data_names};
    use super::super::index::{nth, places};
    use super::super::rows::{Modality, NumberFormat, Point, Zeros};
    use super::*;

    fn register(name: &str, second: Option<&str>) -> Register {
        let format =
            NumberFormat { whole: 4, frac: 3, point: Point::Keep, lead: Zeros::Omit, trail: Zeros::Omit, plus: false };
        let second = second.map(str::to_owned);
        let (before, after) = (name.into(), String::new());
        Register {
            index: 1,
            name: name.into(),
            second,
            before,
            after,
            format,
            secondary: format,
            increment: None,
            signed: true,
            pointed: true,
            names: false,
        }
    }

    fn code(register: usize, min: f64, max: f64, order: u16) -> CodeRow {
        CodeRow {
            id: codes::RAPID,
            form: CodeForm::Register { register: nth(register), min, max },
            enable: true,
            process: true,
            order,
            group: 0,
            modality: Modality::NonModal,
            mul: 1.0,
            add: 0.0,
            with: Vec::new(),
            without: Vec::new(),
            ignores: Vec::new(),
            owns_axes: false,
            seconds: 0.0,
            overlap: crate::rows::Overlap::None,
            axis: None,
            line: 0,
            file: String::new(),
        }
    }
    fn data(id: DataId, register: Option<usize>, enable: bool) -> DataRow {
        DataRow {
            id,
            register: register.map(nth),
            enable,
            process: true,
            modal: false,
            min: None,
            max: None,
            mul: 1.0,
            add: 0.0,
            dimension: Dimension::None,
            line: 0,
            file: String::new(),
        }
    }

    fn of_registers<const N: usize>(registers: [Register; N]) -> Tables {
        Tables::new(&registers.into_iter().collect(), &Table::default(), &Table::default(), &data_names())
    }

    fn of_codes(codes: &[CodeRow]) -> Tables {
        Tables::new(
            &[register("G", None), register("M", None)].into_iter().collect(),
            &codes.iter().cloned().collect(),
            &Table::default(),
            &data_names(),
        )
    }

    #[test]
    fn letters_name_registers_and_second_names_are_incremental() {
        let tables = of_registers([register("X", Some("U")), register("Z", Some("W"))]);
        let letter = |c: char| tables.letter[c as usize];
        assert_eq!(letter('X'), Some((nth(0), false)));
        assert_eq!(letter('U'), Some((nth(0), true)));
        assert_eq!(letter('W'), Some((nth(1), true)));
        assert_eq!(letter('x'), None);
        assert_eq!(letter('G'), None);
    }

    #[test]
    fn a_first_name_wins_over_a_second_name_and_special_names_are_no_letters() {
        let tables = of_registers([register("X", Some("U")), register("U", None), register("C1=", None)]);
        assert_eq!(tables.letter[usize::from(b'U')], Some((nth(1), false)));
        assert_eq!(tables.letter[usize::from(b'C')], None);
    }

    #[test]
    fn the_lowest_order_comes_first_then_the_file() {
        let tables = of_codes(&[code(0, 50.0, 50.0, 450), code(0, 50.0, 50.0, 100), code(0, 1.0, 99.0, 450)]);
        assert_eq!(places(tables.code(nth(0), 50.0)), [1, 0, 2]);
        assert_eq!(places(tables.code(nth(0), 51.0)), [2]);
        assert_eq!(places(tables.code(nth(0), 100.0)), [0; 0]);
        assert_eq!(places(tables.code(nth(1), 50.0)), [0; 0]);
        assert!(tables.has_codes(nth(0)) && !tables.has_codes(nth(1)));
    }

    #[test]
    fn decimals_match_only_rows_with_decimals() {
        let tables = of_codes(&[code(0, 54.0, 59.0, 100), code(0, 54.1, 54.1, 100), code(0, 60.0, 60.5, 100)]);
        assert_eq!(places(tables.code(nth(0), 54.0)), [0]);
        assert_eq!(places(tables.code(nth(0), 54.1)), [1]);
        assert_eq!(places(tables.code(nth(0), 54.1 + 1e-12)), [1]);
        assert_eq!(places(tables.code(nth(0), 54.100_001)), [0; 0]);
        assert_eq!(places(tables.code(nth(0), 55.5)), [0; 0]);
        assert_eq!(places(tables.code(nth(0), 60.0)), [2]);
        assert_eq!(places(tables.code(nth(0), 60.3)), [2]);
        assert_eq!(places(tables.code(nth(0), 60.6)), [0; 0]);
    }

    #[test]
    fn large_numbers_match_whole_values_up_to_both_ends() {
        let tables =
            of_codes(&[code(1, 900.0, 1100.0, 100), code(1, 0.0, 99_999_999.0, 200), code(1, 2000.0, 2000.0, 100)]);
        assert_eq!(places(tables.code(nth(1), 899.0)), [1]);
        assert_eq!(places(tables.code(nth(1), 999.0)), [0, 1]);
        assert_eq!(places(tables.code(nth(1), 1000.0)), [0, 1]);
        assert_eq!(places(tables.code(nth(1), 1000.0 - 1e-12)), [0, 1]);
        assert_eq!(places(tables.code(nth(1), 1100.0)), [0, 1]);
        assert_eq!(places(tables.code(nth(1), 1101.0)), [1]);
        assert_eq!(places(tables.code(nth(1), 2000.0)), [2, 1]);
        assert_eq!(places(tables.code(nth(1), 2000.5)), [0; 0]);
        assert_eq!(places(tables.code(nth(1), 99_999_999.0)), [1]);
        assert_eq!(places(tables.code(nth(1), 100_000_000.0)), [0; 0]);
    }

    #[test]
    fn nonsense_is_no_code() {
        let tables = of_codes(&[code(0, 0.0, 99_999_999.0, 100)]);
        for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, -1.0, -0.04, 1e300, 0.05, 999.96] {
            assert_eq!(places(tables.code(nth(0), value)), [0; 0], "{value}");
        }
        assert_eq!(places(tables.code(nth(0), -0.0)), [0]);
    }

    #[test]
    fn rows_that_are_off_are_nowhere() {
        let mut off = code(0, 5.0, 5.0, 100);
        off.enable = false;
        let mut text = code(0, 0.0, 0.0, 300);
        text.form = CodeForm::Text("G7".into());
        let mut longer = text.clone();
        longer.form = CodeForm::Text("G710".into());
        let mut off_text = text.clone();
        off_text.enable = false;
        let rows = [
            data(DataId::built_in(3), Some(1), true),
            data(DataId::built_in(3), None, true),
            data(DataId::built_in(4), Some(1), false),
        ];
        let registers = [register("G", None), register("M", None)].into_iter().collect();
        let codes = [off, text, longer, off_text].into_iter().collect();
        let mut names = data_names();
        names.push("REG_OWN".into());
        let tables = Tables::new(&registers, &codes, &rows.into_iter().collect(), &names);
        assert_eq!(places(tables.code(nth(0), 5.0)), [0; 0]);
        assert_eq!(places(&tables.texts), [2, 1]);
        assert_eq!(places(tables.data_of(nth(1))), [0]);
        assert_eq!(places(tables.data_of(nth(0))), [0; 0]);
        assert_eq!(places(tables.data(DataId::built_in(3))), [0, 1]);
        assert_eq!(places(tables.data(DataId::built_in(4))), [0; 0]);
        assert_eq!(tables.rows_of_data.len(), names.len());
    }

    #[test]
    fn overlap_needs_a_common_value_that_both_match() {
        assert!(overlap((54.0, 59.0), (59.0, 60.0)));
        assert!(!overlap((54.0, 59.0), (54.1, 54.1)));
        assert!(overlap((54.0, 54.5), (54.2, 54.9)));
        assert!(!overlap((1.0, 2.0), (3.0, 4.0)));
    }
}
