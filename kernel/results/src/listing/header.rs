//! The identification header.
//!
//! Layout: reference listing-and-trace.md 2; data that a job does not have leave their line out. *Invariant:* nothing
//! in it depends on the time or the place of the run.

use std::io::{Result, Write};

use counterpoint_event::info::Info;

/// Version of the emulated system's definitions, the middle part of a definition's full name.
const DEFINITION_VERSION: u32 = 260;

/// Line of the project below its name.
const LICENCE: &str = "(c) the Counterpoint project, MIT or Apache-2.0";

pub(super) fn write(info: &Info, out: &mut dyn Write) -> Result<()> {
    write!(out, "Counterpoint\n{LICENCE}\n\nControl Emulator Counterpoint Version {}\n\n", env!("CARGO_PKG_VERSION"))?;
    for channel in info.channels.iter().filter(|c| !c.program.is_empty()) {
        label(out, "Input:", &channel.program)?;
    }
    let (number, revision) = (info.machine_number, info.machine_revision);
    let mut name = format!("{},{number}.{DEFINITION_VERSION};{revision}", info.machine);
    if !info.machine_created.is_empty() {
        name.push_str(", Created ");
        name.push_str(&info.machine_created);
    }
    label(out, "CE:", &name)?;
    label(out, "Database:", &info.machine_file)?;
    writeln!(out)?;
    if !info.parameters.is_empty() {
        label(out, "UPARAM:", &info.parameters)?;
        writeln!(out)?;
    }
    Ok(())
}

/// A label of 14 characters and its value.
fn label(out: &mut dyn Write, label: &str, value: &str) -> Result<()> {
    writeln!(out, "{label:<14}{value}")
}
