//! Data of tools beyond those of the machine's macros: the position of the edge, and wear.
//!
//! Facts: list of system variables: `$TC_DP12` and `$TC_DP13` are the wear of lengths 1 and 2, `$TC_DP15` that of the
//! radius; the active length and radius include it, as do `$P_TOOLL`, `$P_TOOLR` and `$P_AD`. Along which axes the
//! lengths are says the machine: its identification macro answers `$P_SCLENGTHS`. *Invariant:* a wear that the machine
//! has no axis for is unknown, so that it is reported.

use super::compiled::IndexedName;
use super::conversions::number;
use super::value::Data;
use super::{Outcome, Siemens, syntax, wrong_type};
use counterpoint_control_api::host::InterpreterHost;

/// Largest number of a tool.
const MOST_TOOLS: i64 = 32_000;
/// The radius, beside the axes X, Y and Z.
const RADIUS: usize = 3;

/// Wear of one value: where the table has it, and how often.
#[derive(Debug, Clone, Copy)]
struct WearEntry {
    of: usize,
    factor: f64,
}

impl Siemens {
    /// The value of such a variable; none if it is another one.
    pub(super) fn tool_value(&mut self, host: &mut dyn InterpreterHost, name: &IndexedName) -> Outcome<Option<Data>> {
        if name.name == "$TC_DP2" {
            let edge = self.edge(host, name)?;
            return Ok(Some(Data::Int(i64::from(host.tip(edge)))));
        }
        let Some(place) = self.wear_place(host, &name.name)? else { return Ok(None) };
        let edge = self.edge(host, name)?;
        Ok(Some(Data::Real(host.wear(edge, place.of) / place.factor)))
    }

    /// Sets such a variable; whether it is one.
    pub(super) fn set_tool_value(
        &mut self,
        host: &mut dyn InterpreterHost,
        name: &IndexedName,
        value: &Data,
    ) -> Outcome<bool> {
        if name.name == "$TC_DP2" {
            let (edge, tip) = (self.edge(host, name)?, number(value)?);
            if !host.set_tip(edge, tip) {
                return wrong_type(format!("the position of an edge is 0 to 9, not {tip}"));
            }
            host.effect();
            return Ok(true);
        }
        let Some(place) = self.wear_place(host, &name.name)? else { return Ok(false) };
        let (edge, wear) = (self.edge(host, name)?, number(value)?);
        if !host.set_wear(edge, place.of, wear * place.factor) {
            return wrong_type(format!("the wear {wear} of {} cannot be kept", name.name));
        }
        host.effect();
        Ok(true)
    }

    /// A value that the machine has given, with the wear of the active edge if it is a length or a radius.
    pub(super) fn worn(&mut self, host: &mut dyn InterpreterHost, name: &IndexedName, value: Data) -> Outcome<Data> {
        let part = match (name.name.as_str(), name.index.as_slice()) {
            ("$P_TOOLR", []) => "$TC_DP15",
            ("$P_TOOLL" | "$P_AD", [_]) => match (name.name.as_str(), self.only_index(host, name)?) {
                ("$P_TOOLL", 1) | ("$P_AD", 3) => "$TC_DP12",
                ("$P_TOOLL", 2) | ("$P_AD", 4) => "$TC_DP13",
                ("$P_AD", 6) => "$TC_DP15",
                _ => return Ok(value),
            },
            _ => return Ok(value),
        };
        let edge = IndexedName { name: "$P_TOOL".to_owned(), index: Vec::new() };
        let edge = number(&self.read(host, &edge)?)?;
        let (Some(place), true) = (self.wear_place(host, part)?, edge > 0.0) else { return Ok(value) };
        let wear = host.wear(host.tool().saturating_mul(10).saturating_add(edge as u32), place.of) / place.factor;
        Ok(if wear == 0.0 { value } else { Data::Real(number(&value)? + wear) })
    }

    /// Where the wear that a variable means is kept.
    fn wear_place(&mut self, host: &mut dyn InterpreterHost, name: &str) -> Outcome<Option<WearEntry>> {
        let second = match name {
            "$TC_DP15" => return Ok(Some(WearEntry { of: RADIUS, factor: 1.0 })),
            "$TC_DP12" => false,
            "$TC_DP13" => true,
            _ => return Ok(None),
        };
        let lengths = IndexedName { name: "$P_SCLENGTHS".to_owned(), index: Vec::new() };
        let counterpoint_control_api::host::IdentificationAnswer::Instead(text) = host.identify(&lengths.name, None)?
        else {
            return Ok(None);
        };
        // Hundreds: axis of length 1; tens: axis of length 2; units: how often the table has length 1.
        let digits = text.trim().trim_end_matches('.').parse::<usize>().unwrap_or(0);
        let (axis, factor) = if second { (digits / 10 % 10, 1.0) } else { (digits / 100 % 10, (digits % 10) as f64) };
        Ok(axis.checked_sub(1).filter(|_| factor > 0.0).map(|of| WearEntry { of, factor }))
    }

    /// The tool offset of an edge, `[T,D]`.
    fn edge(&mut self, host: &mut dyn InterpreterHost, name: &IndexedName) -> Outcome<u32> {
        let [tool, edge] = name.index.as_slice() else {
            return syntax(format!("{} needs a tool and an edge", name.name));
        };
        let (tool, edge) = (self.whole_number(host, tool)?, self.whole_number(host, edge)?);
        if !(1..=MOST_TOOLS).contains(&tool) || !(1..=9).contains(&edge) {
            return syntax(format!("edge {edge} of tool {tool} does not exist"));
        }
        Ok(u32::try_from(tool * 10 + edge).unwrap_or(0))
    }
}
