//! Tools that come into use, and their data.

use super::declare::{record, words};
use super::work::WorkClass;

words! {
    /// Action of a tool code.
    pub enum ToolAction {
        /// Preselected, not yet in the spindle.
        Select = 1 "select",
        /// Loaded or indexed.
        Load = 2 "load",
        /// Only the offset of the loaded tool changed.
        Offset = 3 "offset",
    }
}

record! {
    /// A tool was selected or loaded; the duration of the event is the change time.
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    pub struct ToolChange {
        /// Preselect or load.
        pub action: ToolAction = 1,
        /// Tool number as programmed (station on a turret).
        pub tool: u32 = 2,
        /// Offset number, 0 = none or cancelled.
        pub offset: u32 = 3,
    }

    fn work(&self) -> Option<WorkClass> {
        Some(WorkClass::Tool)
    }

    fn action(&self, _: fn(f64) -> String) -> Option<String> {
        let Self { tool, offset, .. } = self;
        Some(match self.action {
            ToolAction::Select => format!("select tool n={tool}"),
            ToolAction::Load => format!("load tool n={tool}"),
            ToolAction::Offset => format!("tool offset n={offset}"),
        })
    }
}

record! {
    /// Data of a tool: the whole of it, whenever something changes.
    #[derive(Debug, Clone, PartialEq, Default)]
    pub struct ToolData {
        /// Tool number as programmed.
        pub tool: u32 = 1,
        /// Name, empty without one.
        pub name: Box<str> = 2 [optional],
        /// Diameter in machine units.
        pub diameter: Option<f64> = 3 [optional],
        /// Corner radius in machine units.
        pub radius: Option<f64> = 4 [optional],
        /// Length in machine units.
        pub length: Option<f64> = 5 [optional],
        /// Its place among the tools of the channel, from 1; 0 = by its first load.
        pub place: u16 = 6 [optional],
    }
}
