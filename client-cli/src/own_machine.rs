//! `machine new`: the user's own folder for a machine, thin over a shipped one.
//!
//! Invariants: the written files load without a finding and are the shipped machine until they are edited; nothing
//! that exists is overwritten.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use counterpoint_kernel::files::JobFiles as _;
use counterpoint_kernel::machine::package;
use counterpoint_lang::ident;

use crate::error::Error;
use crate::say;

/// Sections that a shop has to review, each with a remark.
const OWN: [(&str, &str); 3] = [
    ("[time]", "Times of the machine: tool change, functions, how axes share a rapid move."),
    (
        "[[axes]]",
        "Rapid rates (per minute), home, limits, acceleration (per second squared). A row replaces the whole row of the family.",
    ),
    ("[[spindles]]", "Speeds (revolutions per minute) and run-up (seconds)."),
];

/// Most characters of a name.
const LONGEST: usize = 32;

/// Writes the folder.
pub(crate) fn create(folder: &Path, from: &str) -> Result<u8, Error> {
    create_with(folder, from, Ok)?;
    Ok(0)
}

/// Writes the folder with a changed definition.
pub(crate) fn create_with(
    folder: &Path,
    from: &str,
    change: impl FnOnce(String) -> Result<String, Error>,
) -> Result<(), Error> {
    let names = package::shipped_names();
    if !names.iter().any(|name| name == from) {
        let near = ident::nearest(from, names.iter().map(String::as_str));
        let near = near.map(|near| format!("did you mean {near}? ")).unwrap_or_default();
        return Err(Error::Usage(format!(
            "machine '{from}' not found: {near}shipped machines are {}",
            names.join(", ")
        )));
    }
    let name = name_of(folder, &names)?;
    if folder.exists() {
        return Err(Error::Usage(format!(
            "'{}' exists already: give a folder that is not there yet",
            folder.display()
        )));
    }
    let definition = change(definition(name, from))?;
    fs::create_dir_all(folder).map_err(Error::file(folder))?;
    let components = components(from);
    for (file, text) in [("machine.toml", definition), ("README.md", readme(name, from, &components))] {
        let path = folder.join(file);
        fs::write(&path, text).map_err(Error::file(&path))?;
    }
    for (machine, of) in &components {
        let inside = folder.join(machine);
        fs::create_dir_all(&inside).map_err(Error::file(&inside))?;
        let path = inside.join("machine.toml");
        fs::write(&path, component(machine, of)).map_err(Error::file(&path))?;
    }
    let shown = folder.display();
    say::data(
        format!("{shown}/machine.toml written, based on {from}: edit it, then `counterpoint machine check {shown}`\n")
            .as_bytes(),
    )?;
    Ok(())
}

/// The machine has the name of its folder.
fn name_of<'f>(folder: &'f Path, shipped: &[String]) -> Result<&'f str, Error> {
    let name = folder.file_name().and_then(|name| name.to_str()).unwrap_or("");
    let good = |c: char| c.is_ascii_alphanumeric() || c == '-' || c == '_';
    if name.is_empty() || name.len() > LONGEST || !name.chars().all(good) {
        return Err(Error::Usage(format!(
            "'{name}' cannot be the name of a machine: the folder's name must have 1 to {LONGEST} letters, digits, - or _"
        )));
    }
    if shipped.iter().any(|own| own == name) {
        return Err(Error::Usage(format!("{name} is a shipped machine: give the folder another name")));
    }
    Ok(name)
}

/// The machine file: the sections of the shipped machine that differ from shop to shop, as they are there.
fn definition(name: &str, from: &str) -> String {
    let mut text = format!(
        "# {name}: what is not written here is as on {from}. docs/machine-definition.md explains every key; \n\
         # `counterpoint machine show FOLDER` prints the whole machine.\n\
         extends = \"{from}\"\n\n[ce]\nname = \"{name}\"\nnumber = 1\nrevision = 1\n\
         description = \"{name}, based on {from}\"\n"
    );
    text = text.replace("; \n", ";\n");
    for (header, about) in OWN {
        let found = sections(from, header);
        if !found.is_empty() {
            let _ = write!(text, "\n# {about}\n{}", found.join("\n"));
        }
    }
    text
}

/// The sections of this header in the machine's file, or in the nearest family that has one.
fn sections(machine: &str, header: &str) -> Vec<String> {
    let (files, mut folder) = (package::shipped(), machine.to_owned());
    loop {
        let text = files.read(&format!("{folder}/machine.toml")).unwrap_or_default();
        let text = String::from_utf8_lossy(&text).into_owned();
        let (mut found, mut inside) = (Vec::<String>::new(), false);
        for line in text.lines() {
            if line.starts_with('[') {
                inside = line.trim_end() == header;
                if inside {
                    found.push(String::new());
                }
            }
            if inside
                && !line.trim().is_empty()
                && !line.starts_with('#')
                && let Some(section) = found.last_mut()
            {
                section.push_str(line);
                section.push('\n');
            }
        }
        let parent =
            text.lines().find_map(|line| line.strip_prefix("extends = \"")?.strip_suffix('"').map(str::to_owned));
        match parent {
            Some(parent) if found.is_empty() => folder = parent,
            _ => return found,
        }
    }
}

/// The component definitions of a shipped composite machine, each with its components.
fn components(from: &str) -> Vec<(String, Vec<String>)> {
    let text = package::shipped().read(&format!("{from}/machine.toml")).unwrap_or_default();
    let table = toml::from_str::<toml::Table>(&String::from_utf8_lossy(&text)).unwrap_or_default();
    let mut found: Vec<(String, Vec<String>)> = Vec::new();
    for row in table.get("components").and_then(toml::Value::as_array).into_iter().flatten() {
        let text = |key: &str| row.get(key).and_then(toml::Value::as_str).unwrap_or_default().to_owned();
        let (machine, designator) = (text("machine"), text("designator"));
        match found.iter_mut().find(|(known, _)| *known == machine) {
            Some((_, designators)) => designators.push(designator),
            None => found.push((machine, vec![designator])),
        }
    }
    found
}

/// The definition of a component in a folder inside that of the machine; it replaces the shipped definition.
fn component(machine: &str, designators: &[String]) -> String {
    let of = designators.join(", ");
    format!(
        "# Component {of}: codes, data and [control] of its own. What is not written here is as in {machine}; axes, spindles,\n\
         # channels and waits are those of the machine.\n\
         extends = \"{machine}\"\n"
    )
}

fn readme(name: &str, from: &str, components: &[(String, Vec<String>)]) -> String {
    let component = |(machine, designators): &(String, Vec<String>)| {
        format!("* `{machine}/machine.toml` is the control of component {}.\n", designators.join(", "))
    };
    let inside: String = components.iter().map(component).collect();
    format!(
        "# {name}\n\nBased on `{from}` of Counterpoint. Write down here what control the machine has, which options, and what \
         differs from the real one.\n\n\
         * `counterpoint machine check {name}` finds mistakes in `machine.toml`.\n{inside}\
         * `counterpoint run --machine {name} part.nc` runs a program.\n\
         * `counterpoint machine show {name} codes` lists the words and what they mean.\n"
    )
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;
    use counterpoint_kernel::files::MemoryFiles;
    use counterpoint_kernel::machine::{load, package::Overlay};

    #[test]
    fn each_shipped_machine_can_be_the_start_of_an_own_one() {
        for from in package::shipped_names() {
            let mut files = MemoryFiles::default();
            files.insert("own/machine.toml".to_owned(), definition("own", &from).into_bytes());
            let (own, shipped) = (load(&Overlay::over_shipped(files), "own"), load(&package::shipped(), &from));
            assert_eq!(own.findings, [], "{from}");
            let (own, shipped) = (own.machine.unwrap(), shipped.machine.unwrap());
            assert_eq!(own.name, "own");
            assert_eq!(format!("{:?}", own.axes), format!("{:?}", shipped.axes), "{from}");
            assert_eq!(format!("{:?}", own.spindles), format!("{:?}", shipped.spindles), "{from}");
            assert_eq!(format!("{:?}", own.time), format!("{:?}", shipped.time), "{from}");
        }
    }
}
