//! Tools of a machine: their word, their names and data, their offsets.

use crate::index::{AxisId, IdTable};

/// Tool word, tools and offsets.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ToolSetup {
    /// Digits at the end of the tool word that are the offset number (Fanuc lathe T0101: 2); 0 = tool number only.
    pub offset_digits: u8,
    /// Offsets by number: per machine axis, axis units, and nose radius.
    pub offsets: Vec<ToolOffset>,
    /// Data of tools, ascending by number.
    pub data: Vec<ToolFacts>,
    /// Tool-change position in the machine frame, per machine axis, as programmed.
    pub change_point: IdTable<AxisId, Option<f64>>,
    /// The axes go there before a tool is loaded.
    pub change_motion: bool,
    /// Tools by name, in capital letters.
    pub names: Vec<(String, u32)>,
    /// Offsets of a tool: its edge D has the offset `edges` × T + D; 0 = the offset has the number of the tool.
    pub edges: u32,
    /// Programs call tools by their names; names that are in no table get numbers from this one on.
    pub named_from: Option<u32>,
}

/// The machine's data of a tool.
#[derive(Debug, Clone, PartialEq)]
pub struct ToolFacts {
    /// Number.
    pub number: u32,
    /// Name, empty without one.
    pub name: String,
    /// Diameter.
    pub diameter: Option<f64>,
    /// Corner radius.
    pub radius: Option<f64>,
    /// Length.
    pub length: Option<f64>,
    /// Number of its offset.
    pub offset: Option<u32>,
}

impl ToolSetup {
    /// Data of a tool.
    #[must_use]
    pub fn facts(&self, number: u32) -> Option<&ToolFacts> {
        let at = self.data.binary_search_by_key(&number, |facts| facts.number).ok()?;
        self.data.get(at)
    }

    /// Number of the tool with a name in any letter case; a row of names takes precedence over the data of a tool.
    #[must_use]
    pub fn number_of(&self, name: &str) -> Option<u32> {
        let of_names = self.names.iter().find(|(known, _)| known.eq_ignore_ascii_case(name));
        let of_data = || self.data.iter().find(|facts| facts.name.eq_ignore_ascii_case(name));
        of_names.map(|(_, number)| *number).or_else(|| Some(of_data().filter(|facts| !facts.name.is_empty())?.number))
    }
}

/// One tool offset.
#[derive(Debug, Clone, PartialEq)]
pub struct ToolOffset {
    /// Number.
    pub number: u32,
    /// Value per machine axis, as programmed (diameter on a diameter axis).
    pub values: IdTable<AxisId, f64>,
    /// Wear per machine axis, added to the value of the axis.
    pub wear: IdTable<AxisId, f64>,
    /// Nose or cutter radius.
    pub radius: f64,
    /// Wear of the radius, added to it.
    pub radius_wear: f64,
    /// Imaginary tip direction 0–9.
    pub tip: u8,
}
