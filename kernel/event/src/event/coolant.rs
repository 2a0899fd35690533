//! Coolant.

use super::fields::{EventField, EventRecord, EventValue, FieldReader, FieldType, FieldWriter};
use super::work::WorkClass;

/// A coolant that was switched.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Coolant {
    /// `true` = on.
    pub on: bool,
    /// Fluid by the numbers of `$COOLTYP`: 1 flood, 2 mist, 3 tapping oil, 4 through the tool, 5 to 9 of the machine's
    /// own; 0 = off, or unspecified.
    pub fluid: u8,
    /// Where.
    pub outlet: Outlet,
}

/// Where coolant flows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Outlet {
    /// At the main head.
    Main,
    /// At the side head.
    Side,
    /// From an auxiliary device, 1 to 9.
    Device(u8),
}

impl Coolant {
    /// Names of the fluids, by number.
    pub const FLUIDS: [&'static str; 10] =
        ["on", "flood", "mist", "tapkul", "thru", "type5", "type6", "type7", "type8", "type9"];

    /// The fluid, in one word; `off` for none.
    #[must_use]
    pub fn word(&self) -> &'static str {
        if self.on { Self::FLUIDS.get(usize::from(self.fluid)).copied().unwrap_or("on") } else { "off" }
    }
}

/// The words of the listing.
impl std::fmt::Display for Coolant {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self.outlet {
            Outlet::Main => write!(f, "coolant {}", self.word()),
            Outlet::Side => write!(f, "coolant side {}", self.word()),
            Outlet::Device(number) => write!(f, "coolant dev{number} {}", self.word()),
        }
    }
}

impl EventRecord for Coolant {
    fn fields(&self, out: &mut impl FieldWriter) {
        self.on.put(EventField::new(1, "on"), out);
        out.put(EventField::new(2, "fluid"), EventValue::Named(self.fluid, self.word()));
        let (word, side, device, number) = match self.outlet {
            Outlet::Main => ("main", false, 0, 0),
            Outlet::Side => ("side", true, 0, 255),
            Outlet::Device(number) => ("device", false, number, number),
        };
        out.put(EventField::shown("outlet"), EventValue::Text(word));
        side.put(EventField::wire(3), out);
        device.put(EventField::wire(4), out);
        device.put(EventField::shown("device").shown_if(matches!(self.outlet, Outlet::Device(_))), out);
        number.put(EventField::counted(), out);
    }

    fn read(from: &impl FieldReader) -> Option<Self> {
        let outlet = match (bool::get(3, from)?, u8::get(4, from)?) {
            (false, 0) => Outlet::Main,
            (false, number) => Outlet::Device(number),
            (true, _) => Outlet::Side,
        };
        Some(Self { on: FieldType::get(1, from)?, fluid: FieldType::get(2, from)?, outlet })
    }

    fn work(&self) -> Option<WorkClass> {
        Some(WorkClass::Misc)
    }

    fn action(&self, _: fn(f64) -> String) -> Option<String> {
        Some(self.to_string())
    }
}
