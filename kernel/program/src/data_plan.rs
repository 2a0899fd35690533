//! Sources of the values of identifiers, determined once per machine.

use counterpoint_machine::Machine;
use counterpoint_machine::ident::dimension::Dimension;
use counterpoint_machine::ident::kind::data::DataKind;
use counterpoint_machine::ident::{DataId, codes, data, data_facts};
use counterpoint_machine::index::{DataRowId, IdTable, RegisterId};
use counterpoint_machine::model::AxisRole;
use counterpoint_machine::rows::DataRow;

/// Data that every request needs; other data have a second form or a default without the word.
pub const NEEDED: [DataId; 24] = [
    data::SPINDLE_RPM,
    data::SPINDLE_CSS,
    data::SPINDLE_RPM_MAX,
    data::FEED_UPM,
    data::FEED_UPR,
    data::FEED_1T,
    data::DELAY,
    data::DELAY_REV,
    data::INTERP_THREAD_PITCH,
    data::INTERP_THREAD_PITCH_VAR,
    data::TOOL,
    data::HEAD_ID,
    data::COMP_DIAM,
    data::COMP_LENGTH,
    data::COMP_WORKP,
    data::COMP_EXTFIXT_REG,
    data::OFFSET_NUMBER,
    data::OFFSET_VALUE,
    data::GOHOME_NTH,
    data::CALSUB_ID,
    data::SYNC,
    data::CYCLE_CLEAR,
    data::CYCLE_STEP,
    data::CYCLE_DWELL,
];

/// Represents a remembered value among the registers of an identifier; no register has this bit, and every block has
/// it.
pub const RECALLED: u128 = 1 << 127;

/// Where data come from.
#[derive(Debug)]
pub struct DataPlan {
    /// Registers that can supply each data identifier, bit by register.
    pub registers_of: IdTable<DataId, u128>,
    /// Where the values of each data identifier come from, in row order.
    pub sources: IdTable<DataId, Vec<DataSource>>,
    /// Data that are positions of X, where programs choose between diameter and radius.
    pub diameter_x: Vec<DataId>,
    /// Data rows that drop their word silently.
    pub ignore: IdTable<DataRowId, bool>,
    /// Data identifiers whose last value stands in when the word is missing; `None` when the machine has none.
    pub recall: Option<IdTable<DataId, bool>>,
    /// Registers whose word an identifier must not take (`process = false`), bit by register.
    pub refused: IdTable<DataId, u128>,
}

impl DataPlan {
    /// Sources of the data of a machine.
    pub fn new(machine: &Machine) -> Self {
        let diameter_x = diameter_x(machine);
        let refused = refused(machine);
        let recall = recall(machine);
        let registers_of = |id: DataId, rows: &Vec<DataRowId>| {
            let registers = rows.iter().filter_map(|&row| machine.data[row].register);
            let recalled = recall.as_ref().is_some_and(|recall| recall[id]);
            let remembered = if recalled { RECALLED } else { refused[id] & RECALLED };
            registers.fold(remembered, |bits, register| bits | register.bit())
        };
        Self {
            registers_of: machine.tables.rows_of_data.map(registers_of),
            sources: sources(machine, &diameter_x),
            ignore: machine.data.map(|_, row| !row.process),
            diameter_x,
            recall,
            refused,
        }
    }
}

/// Modal data that no action remembers by itself: those the machine made modal beyond axes, feeds, speeds and tools.
fn recall(machine: &Machine) -> Option<IdTable<DataId, bool>> {
    let own = |kind: DataKind| kind.is_modal() || kind == DataKind::ThreadLead;
    let of = |_, rows: &Vec<DataRowId>| {
        let mut rows = rows.iter().map(|&row| &machine.data[row]);
        rows.any(|row| row.modal && row.process && !own(row.id.kind()))
    };
    let recall = machine.tables.rows_of_data.map(of);
    recall.iter().any(|recalled| *recalled).then_some(recall)
}

/// Registers of rows that are recognised but not processed.
fn refused(machine: &Machine) -> IdTable<DataId, u128> {
    let of = |_, rows: &Vec<DataRowId>| {
        let rows = rows.iter().map(|&row| &machine.data[row]);
        let registers = rows.filter(|row| !row.process).filter_map(|row| row.register);
        registers.fold(0, |bits, register| bits | register.bit())
    };
    let mut refused = machine.tables.rows_of_data.map(of);
    // Data that actions need and whose rows are all off: every request is refused, regardless of the block.
    for row in machine.data.iter().filter(|row| !row.enable && NEEDED.contains(&row.id)) {
        if machine.tables.rows_of_data[row.id].is_empty() {
            refused[row.id] = RECALLED;
        }
    }
    refused
}

/// A data row, reduced to the fields for taking a value.
#[derive(Debug, Clone, Copy)]
pub struct DataSource {
    /// The register.
    pub register: RegisterId,
    /// The value stays active for later blocks.
    pub modal: bool,
    /// Factor of the value.
    pub mul: f64,
    /// Addend of the value.
    pub add: f64,
    /// Smallest value.
    pub min: f64,
    /// Largest value.
    pub max: f64,
    /// Its dimension, which decides how units change it.
    pub dimension: Dimension,
    /// Value of one increment of a number without a point in primary and secondary units, if it is not one in the last
    /// digit of the register.
    pub one: Option<[f64; 2]>,
    /// A position of X, which may be programmed as a diameter or as a radius.
    pub diameter_x: bool,
    /// Row of the data table.
    pub row: DataRowId,
}

/// Data that are positions of X; none on machines whose programs cannot choose between diameter and radius.
fn diameter_x(machine: &Machine) -> Vec<DataId> {
    let chooses = |id| id == codes::XAXIS_DIAMETER || id == codes::XAXIS_RADIUS;
    if !machine.codes.iter().any(|row| row.enable && chooses(row.id)) {
        return Vec::new();
    }
    let axes = machine.axes.iter().filter(|axis| axis.role == AxisRole::X).map(|axis| axis.data);
    let own = [
        data::ARC_3D_POINT_X,
        data::LCS_TRANS_X,
        data::LCS_ROT_CENTER_X,
        data::LCS_SCALE_CENTER_X,
        data::THREAD_SINGLE_START_X,
        data::THREAD_SINGLE_END_X,
        data::THREAD_MULTI_START_X,
        data::THREAD_MULTI_END_X,
    ];
    axes.chain(own).collect()
}

/// Sources of each identifier, in the order of their rows.
pub fn sources(machine: &Machine, diameter_x: &[DataId]) -> IdTable<DataId, Vec<DataSource>> {
    let source = |&index: &DataRowId| {
        let row = Some(&machine.data[index]).filter(|row| row.process)?;
        Some(DataSource {
            register: row.register?,
            modal: row.modal,
            mul: row.mul,
            add: row.add,
            min: row.min.unwrap_or(f64::NEG_INFINITY),
            max: row.max.unwrap_or(f64::INFINITY),
            dimension: row.dimension,
            one: one(machine, row),
            diameter_x: diameter_x.contains(&row.id),
            row: index,
        })
    };
    machine.tables.rows_of_data.map(|_, rows| rows.iter().filter_map(source).collect())
}

/// Value of one increment of a number without a point for a row whose register counts least increments. Words with a
/// factor of their own and plain numbers are as written, and the unit of angles and times does not change with that of
/// lengths.
pub fn one(machine: &Machine, row: &DataRow) -> Option<[f64; 2]> {
    if row.increment.is_some() {
        return row.increment;
    }
    let register = &machine.registers[row.register?];
    if !register.counts {
        return None;
    }
    match row.dimension {
        Dimension::Increments => Some([1.0; 2]),
        _ if row.mul != 1.0 => Some([1.0; 2]),
        Dimension::None if data_facts(row.id).is_some() => Some([1.0; 2]),
        Dimension::Angle | Dimension::Time if register.format.frac != register.secondary.frac => {
            Some([10_f64.powi(-i32::from(register.format.frac)); 2])
        }
        _ => None,
    }
}
