//! Tests of the tables.

use super::super::ident::dimension::Dimension;
use super::super::ident::{codes, data_names};
use super::super::index::{nth, places};
use super::super::rows::{DecimalPointRule, Excess, Modality, NumberFormat, ZeroRule};
use super::*;

fn register(name: &str, second: Option<&str>) -> Register {
    let format = NumberFormat {
        whole: 4,
        frac: 3,
        point: DecimalPointRule::Keep,
        lead: ZeroRule::Omit,
        trail: ZeroRule::Omit,
        plus: false,
        excess: Excess::Kept,
    };
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
        counts: false,
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
        turns_no_spindle: false,
        also: false,
        special: false,
        seconds: 0.0,
        overlap: crate::rows::TimeOverlap::None,
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
        increment: None,
        line: 0,
        file: String::new(),
    }
}

fn of_registers<const N: usize>(registers: [Register; N]) -> LookupTables {
    LookupTables::new(&registers.into_iter().collect(), &IdTable::default(), &IdTable::default(), &data_names())
}

fn of_codes(codes: &[CodeRow]) -> LookupTables {
    LookupTables::new(
        &[register("G", None), register("M", None)].into_iter().collect(),
        &codes.iter().cloned().collect(),
        &IdTable::default(),
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
    let tables = LookupTables::new(&registers, &codes, &rows.into_iter().collect(), &names);
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
