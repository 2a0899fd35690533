//! Coolant.

use super::fields::{Datum, Field, Fields, Record, Source, Value};
use super::work::Work;

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

impl Record for Coolant {
    fn fields(&self, out: &mut impl Fields) {
        self.on.put(Field::new(1, "on"), out);
        out.put(Field::new(2, "fluid"), Value::Named(self.fluid, self.word()));
        let (word, side, device, number) = match self.outlet {
            Outlet::Main => ("main", false, 0, 0),
            Outlet::Side => ("side", true, 0, 255),
            Outlet::Device(number) => ("device", false, number, number),
        };
        out.put(Field::shown("outlet"), Value::Text(word));
        side.put(Field::wire(3), out);
        device.put(Field::wire(4), out);
        device.put(Field::shown("device").shown_if(matches!(self.outlet, Outlet::Device(_))), out);
        number.put(Field::counted(), out);
    }

    fn read(from: &impl Source) -> Option<Self> {
        let outlet = match (bool::get(3, from)?, u8::get(4, from)?) {
            (false, 0) => Outlet::Main,
            (false, number) => Outlet::Device(number),
            (true, _) => Outlet::Side,
        };
        Some(Self { on: Datum::get(1, from)?, fluid: Datum::get(2, from)?, outlet })
    }

    fn work(&self) -> Option<Work> {
        Some(Work::Misc)
    }

    fn action(&self, _: fn(f64) -> String) -> Option<String> {
        Some(self.to_string())
    }
}
