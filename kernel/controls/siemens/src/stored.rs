//! System variables that keep the values of programs, and constant ones.
//!
//! Facts: reference siemens-cycles.md 4 (variables programs read) and 3 (data of tools). Decisions: markers,
//! parameters, parts and setting data belong to the channel, data of the PLC interface and outputs to all channels;
//! inputs are 0 unless a macro of the machine answers. Of the data of tools only those are kept that change no path.
//! *Invariants:* nothing that would move an axis is kept here, so that it is reported instead of ignored; the number of
//! kept values is bounded.

use rustc_hash::FxHashMap;

use super::compiled::IndexedName;
use super::item::AssignmentValue;
use super::value::{Data, Type};
use super::{Outcome, Siemens, syntax, wrong_type};
use counterpoint_control_api::host::InterpreterHost;

/// Most values that are kept.
const MOST: usize = 100_000;

/// Whose values they are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum FamilyScope {
    /// Of the channel, gone at a reset.
    Channel,
    /// Of all channels.
    All,
    /// Inputs: a program cannot set them.
    Input,
    /// Of the channel; reading an unwritten value is an error.
    Setting,
}

/// A family of variables.
#[derive(Debug, Clone, Copy)]
struct VariableFamily {
    name: &'static str,
    kind: Type,
    scope: FamilyScope,
    /// Smallest and largest index of each dimension.
    sizes: &'static [(i64, i64)],
}

const fn row(name: &'static str, kind: Type, scope: FamilyScope, sizes: &'static [(i64, i64)]) -> VariableFamily {
    VariableFamily { name, kind, scope, sizes }
}

const ONE: &[(i64, i64)] = &[(1, 1000)];
const ZERO: &[(i64, i64)] = &[(0, 999)];
const PLC: &[(i64, i64)] = &[(0, 1023)];
const TOOL: &[(i64, i64)] = &[(1, 32_000)];
const EDGE: &[(i64, i64)] = &[(1, 32_000), (1, 12)];

const ROWS: &[VariableFamily] = &[
    row("$AC_MARKER", Type::Int, FamilyScope::Channel, ZERO),
    row("$AC_PARAM", Type::Real, FamilyScope::Channel, ZERO),
    row("$AC_TOTAL_PARTS", Type::Real, FamilyScope::Channel, &[]),
    row("$AC_REQUIRED_PARTS", Type::Real, FamilyScope::Channel, &[]),
    row("$AC_ACTUAL_PARTS", Type::Real, FamilyScope::Channel, &[]),
    row("$AC_SPECIAL_PARTS", Type::Real, FamilyScope::Channel, &[]),
    row("$A_DBB", Type::Int, FamilyScope::All, PLC),
    row("$A_DBW", Type::Int, FamilyScope::All, PLC),
    row("$A_DBD", Type::Int, FamilyScope::All, PLC),
    row("$A_DBR", Type::Real, FamilyScope::All, PLC),
    // R parameters of all channels.
    row("RG", Type::Real, FamilyScope::All, &[(0, 32_535)]),
    row("$A_OUT", Type::Bool, FamilyScope::All, ONE),
    row("$A_OUTA", Type::Real, FamilyScope::All, ONE),
    row("$A_IN", Type::Bool, FamilyScope::Input, ONE),
    row("$A_INA", Type::Real, FamilyScope::Input, ONE),
    row("$TC_DP10", Type::Real, FamilyScope::Channel, EDGE),
    row("$TC_DP11", Type::Real, FamilyScope::Channel, EDGE),
    row("$TC_DP24", Type::Real, FamilyScope::Channel, EDGE),
    row("$TC_DP25", Type::Real, FamilyScope::Channel, EDGE),
    row("$TC_DPH", Type::Int, FamilyScope::Channel, EDGE),
    row("$TC_DPNT", Type::Real, FamilyScope::Channel, EDGE),
    row("$TC_TP1", Type::Int, FamilyScope::Channel, TOOL),
    row("$TC_TP3", Type::Int, FamilyScope::Channel, TOOL),
    row("$TC_TP4", Type::Int, FamilyScope::Channel, TOOL),
    row("$TC_TP5", Type::Int, FamilyScope::Channel, TOOL),
    row("$TC_TP6", Type::Int, FamilyScope::Channel, TOOL),
    row("$TC_TP7", Type::Int, FamilyScope::Channel, TOOL),
    row("$TC_TP8", Type::Int, FamilyScope::Channel, TOOL),
    row("$TC_TP9", Type::Int, FamilyScope::Channel, TOOL),
    row("$TC_TP10", Type::Int, FamilyScope::Channel, TOOL),
    row("$TC_TP11", Type::Int, FamilyScope::Channel, TOOL),
    row("$TC_TPG1", Type::Int, FamilyScope::Channel, TOOL),
    row("$TC_TPG2", Type::Int, FamilyScope::Channel, TOOL),
    row("$TC_TPG3", Type::Real, FamilyScope::Channel, TOOL),
    row("$TC_TPG4", Type::Real, FamilyScope::Channel, TOOL),
    row("$TC_TPG5", Type::Real, FamilyScope::Channel, TOOL),
    row("$TC_TPG6", Type::Real, FamilyScope::Channel, TOOL),
    row("$TC_TPG7", Type::Real, FamilyScope::Channel, TOOL),
    row("$TC_MOP1", Type::Real, FamilyScope::Channel, EDGE),
    row("$TC_MOP2", Type::Real, FamilyScope::Channel, EDGE),
    row("$TC_MOP3", Type::Int, FamilyScope::Channel, EDGE),
    row("$TC_MOP4", Type::Int, FamilyScope::Channel, EDGE),
];

/// Setting data of the control, the channel and its axes: kept as they are written.
const SETTINGS: [&str; 3] = ["$SN_", "$SC_", "$SA_"];
/// Those that would change paths or offsets: they are not kept but reported.
const EFFECTIVE: [&str; 4] =
    ["$SC_FRAME_OFFSET_INCR_PROG", "$SC_TOOL_OFFSET_INCR_PROG", "$SC_MIRROR_TOOL_LENGTH", "$SC_TOOL_LENGTH_CONST"];

fn row_of(name: &str) -> Option<VariableFamily> {
    let setting = || {
        let is = SETTINGS.iter().any(|prefix| name.starts_with(prefix)) && !EFFECTIVE.contains(&name);
        is.then(|| row("", Type::Real, FamilyScope::Setting, &[]))
    };
    ROWS.iter().find(|row| row.name == name).copied().or_else(setting)
}

/// Value of a working area limit that is not set.
const UNLIMITED: f64 = 1e8;

/// A setting of the working area: which side, and whether it is the limit or enables it.
#[derive(Debug, Clone, Copy)]
struct WorkAreaSetting {
    high: bool,
    enable: bool,
}

impl WorkAreaSetting {
    fn named(name: &str) -> Option<Self> {
        let (high, enable) = match name {
            "$SA_WORKAREA_LIMIT_PLUS" => (true, false),
            "$SA_WORKAREA_LIMIT_MINUS" => (false, false),
            "$SA_WORKAREA_PLUS_ENABLE" => (true, true),
            "$SA_WORKAREA_MINUS_ENABLE" => (false, true),
            _ => return None,
        };
        Some(Self { high, enable })
    }
}

/// Values that were written.
#[derive(Debug, Default)]
pub(super) struct StoredVariables {
    /// Timers `$AC_TIMER`: value, and the time at which it had it while it runs.
    pub(super) timers: FxHashMap<i64, (f64, Option<i64>)>,
    values: FxHashMap<String, Data>,
}

impl StoredVariables {
    /// How many there are.
    pub(super) fn len(&self) -> usize {
        self.timers.len() + self.values.len()
    }
}

impl Siemens {
    /// Value of such a variable; none if it is not one.
    pub(super) fn stored_value(&mut self, host: &mut dyn InterpreterHost, name: &IndexedName) -> Outcome<Option<Data>> {
        let fixed = match name.name.as_str() {
            "$P_NUM_SPINDLES" | "$MN_SCALING_SYSTEM_IS_METRIC" => Some(1),
            "$P_TRAFO" => Some(0),
            "$P_MC" => Some(i64::from(self.modal.is_some())),
            _ => None,
        };
        if let Some(value) = fixed {
            return Ok(Some(Data::Int(value)));
        }
        if matches!(name.name.as_str(), "$AC_DTEW" | "$AA_DTEW") {
            // A block is read when it starts, and then nothing is left of the previous block.
            return Ok(Some(Data::Real(0.0)));
        }
        if let Some(side) = WorkAreaSetting::named(&name.name) {
            let letter = self.area_axis(host, name)?;
            return Ok(host.area_side(&letter, side.high).map(|(limit, counts)| match side.enable {
                true => Data::Bool(counts),
                false => Data::Real(limit.unwrap_or(if side.high { UNLIMITED } else { -UNLIMITED })),
            }));
        }
        let Some(row) = row_of(&name.name) else { return Ok(None) };
        let key = self.key(host, name, &row)?;
        match row.scope {
            FamilyScope::Input | FamilyScope::All => {
                let found = host.shared(&key)?;
                Ok(Some(found.and_then(|value| row.kind.taken_from(&value)).unwrap_or_else(|| row.kind.initial())))
            }
            FamilyScope::Channel => {
                Ok(Some(self.stored.values.get(&key).cloned().unwrap_or_else(|| row.kind.initial())))
            }
            FamilyScope::Setting => Ok(self.stored.values.get(&key).cloned()),
        }
    }

    /// `RG[n]=…`
    pub(super) fn set_global_parameter(
        &mut self,
        host: &mut dyn InterpreterHost,
        name: &IndexedName,
        value: &AssignmentValue,
    ) -> Outcome<()> {
        let AssignmentValue::One(value, _) = value else { return syntax("RG[n] takes a number") };
        let value = self.evaluate(host, value)?;
        self.store_value(host, name, &value).map(|_| ())
    }

    /// Keeps a value; false if the variable is not one that keeps it.
    pub(super) fn store_value(
        &mut self,
        host: &mut dyn InterpreterHost,
        name: &IndexedName,
        value: &Data,
    ) -> Outcome<bool> {
        if let Some(side) = WorkAreaSetting::named(&name.name) {
            let letter = self.area_axis(host, name)?;
            let number = super::conversions::number(value)?;
            let (limit, counts) = if side.enable { (None, Some(number != 0.0)) } else { (Some(number), None) };
            host.effect();
            return Ok(host.set_area_side(&letter, side.high, limit, counts));
        }
        let Some(row) = row_of(&name.name).filter(|row| row.scope != FamilyScope::Input) else { return Ok(false) };
        let key = self.key(host, name, &row)?;
        let value = match row.kind.hold(value.clone()) {
            Ok(value) => value,
            Err(text) => return wrong_type(format!("{text}, for {}", name.name)),
        };
        host.effect();
        if row.scope == FamilyScope::All {
            host.set_shared(&key, Some(value.value()))?;
            return Ok(true);
        }
        if self.stored.values.len() >= MOST && !self.stored.values.contains_key(&key) {
            return wrong_type(format!("more than {MOST} system variables are written"));
        }
        self.stored.values.insert(key, value);
        Ok(true)
    }

    /// The axis of a setting of the working area.
    fn area_axis(&mut self, host: &mut dyn InterpreterHost, name: &IndexedName) -> Outcome<String> {
        let asked = self.written(host, name)?;
        let axis = asked.split_once('[').and_then(|(_, rest)| rest.strip_suffix(']')).unwrap_or_default();
        match host.axis_letter(axis) {
            Some(letter) => Ok(letter.to_owned()),
            None => wrong_type(format!("{} needs an axis of the channel", name.name)),
        }
    }

    /// The name with its indices, which are within their limits.
    fn key(&mut self, host: &mut dyn InterpreterHost, name: &IndexedName, row: &VariableFamily) -> Outcome<String> {
        let mut key = name.name.clone();
        if row.scope == FamilyScope::Setting {
            // Their indices are numbers or axes.
            return self.written(host, name);
        }
        if name.index.len() != row.sizes.len() {
            return syntax(format!("{} has {} indices, not {}", name.name, row.sizes.len(), name.index.len()));
        }
        for (index, (low, high)) in name.index.iter().zip(row.sizes) {
            let number = self.whole_number(host, index)?;
            if !(*low..=*high).contains(&number) {
                return wrong_type(format!("17020 index {number} of {} is not from {low} to {high}", name.name));
            }
            key = format!("{key}[{number}]");
        }
        Ok(key)
    }
}
