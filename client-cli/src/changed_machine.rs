//! A machine with other data for one run.
//!
//! The files of the machine and of the families it extends are combined, the value is replaced in them, and the run
//! gets the changed machine. Invariants: lines keep their numbers, so that findings name the place in the user's file;
//! a key that changes nothing on the machine is refused.

use std::ops::RangeInclusive;
use std::path::Path;

use counterpoint_client::Blob;
use counterpoint_kernel::files::JobFiles as _;
use counterpoint_kernel::log::info::MachineUnit;
use counterpoint_kernel::machine::package;

use crate::error::Error;
use crate::machine_folder;
use crate::pack::PackedFiles;
use crate::settings::MachineSetting;
use crate::tools::{ToolDefinitions, ToolImportContext};

/// End of the name of a shipped machine after a setting; the server reserves the names of shipped machines.
const CHANGED: &str = "-set";

/// Suffix of the name of a machine whose channels share the variables of a setting.
const SHARES: &str = "-shared";

/// Suffix of the name of a machine with the stops of a setting.
const STOPS: &str = "-stops";

/// End of the name of a machine that has the tools of a run.
const TOOLS: &str = "-tools";

/// A shipped machine or a folder, with all families, and the settings in it; returns the name of the machine, too.
pub(crate) fn machine(machine: &str, settings: &[MachineSetting]) -> Result<(String, PackedFiles), Error> {
    let own = machine_folder::is_folder(machine);
    let (name, mut files) =
        if own { machine_folder::machine(Path::new(machine))? } else { (machine.to_owned(), PackedFiles::default()) };
    let chain = chain(&mut files, &name, &[]);
    let components = components(&mut files, &chain);
    for setting in settings {
        let MachineSetting::Waits(range) = setting else { continue };
        let mut changed = false;
        for folder in &chain {
            let path = definition(folder);
            let Some(text) = files.0.get(&path).map(|blob| String::from_utf8_lossy(blob.content()).into_owned()) else {
                continue;
            };
            if let Some(text) = with_waits(&text, range) {
                files.0.insert(path, Blob::new(text.into_bytes()));
                changed = true;
            }
        }
        if !changed {
            return Err(Error::Usage(format!(
                "--set waits: machine '{machine}' has no range of M codes that wait (a row of [[waits]] with a word, or of \
                 CODE_SYNC_REG)"
            )));
        }
    }
    let lathes: Vec<String> =
        components.iter().filter(|(_, chain)| has_systems(&files, chain)).map(|(name, _)| name.clone()).collect();
    let has_systems = !lathes.is_empty() || components.is_empty() && has_systems(&files, &chain);
    if settings.iter().any(|setting| matches!(setting, MachineSetting::System(_))) && !has_systems {
        return Err(Error::Usage(format!(
            "--set system: machine '{machine}' has only one G-code system (it is not a lathe, or no row of [[codes]] has `systems`)"
        )));
    }
    if settings.iter().any(|setting| matches!(setting, MachineSetting::Shared(..))) {
        let tables = tables(&files, &chain);
        let has =
            |key: &str| tables.iter().any(|table| table.get("variables").is_some_and(|own| own.get(key).is_some()));
        if !has("shared") && !has("channel") {
            return Err(Error::Usage(format!(
                "--set shared: machine '{machine}' has no common variables with numbers"
            )));
        }
        let channels = tables.iter().find_map(|table| table.get("channels")?.as_array());
        if channels.is_none_or(|channels| channels.len() < 2) {
            return Err(Error::Usage(format!("--set shared: machine '{machine}' has no second channel to share with")));
        }
    }
    let unit = settings.iter().rev().find_map(|setting| match setting {
        MachineSetting::Units(unit) => Some(*unit),
        _ => None,
    });
    // A composite takes its unit from its components.
    let mut initial = Vec::new();
    if let Some(unit) = unit {
        for (_, chain) in &components {
            initial.push(units::initial(machine, &tables(&files, chain), unit)?);
        }
        if components.is_empty() {
            initial.push(units::initial(machine, &tables(&files, &chain), unit)?);
        }
    }
    let components: Vec<String> = components.into_iter().map(|(name, _)| name).collect();
    let begins = Begins { unit, initial };
    if own {
        return Ok(extended(name, files, settings, (&components, &lathes), &begins));
    }
    let (changed, inside) = (with_end(&name, CHANGED), format!("{name}/"));
    let renamed = |path: String| match path.strip_prefix(&inside) {
        Some(rest) => format!("{changed}/{rest}"),
        None => path,
    };
    let files = PackedFiles(files.0.into_iter().map(|(path, blob)| (renamed(path), blob)).collect());
    Ok(extended(changed, files, settings, (&components, &lathes), &begins))
}

/// The unit in which programs begin.
#[derive(Default)]
struct Begins {
    /// The unit, if it is set.
    unit: Option<MachineUnit>,
    /// The lines `initial` of the components, or of the machine if it has no components.
    initial: Vec<String>,
}

/// The definitions of a machine and of the families that it extends.
fn tables(files: &PackedFiles, chain: &[String]) -> Vec<toml::Table> {
    let blobs = chain.iter().filter_map(|folder| files.0.get(&definition(folder)));
    let read =
        |blob: &Blob| toml::from_str::<toml::Table>(&String::from_utf8_lossy(blob.content())).unwrap_or_default();
    blobs.map(read).collect()
}

/// Whether a lathe has codes that only some systems of G codes have.
fn has_systems(files: &PackedFiles, chain: &[String]) -> bool {
    let tables = tables(files, chain);
    let kind = tables.iter().find_map(|table| table.get("machine")?.get("type")?.as_str());
    let codes = tables.iter().filter_map(|table| table.get("codes")?.as_array()).flatten();
    kind.is_some_and(|kind| kind.ends_with("lathe")) && codes.into_iter().any(|row| row.get("systems").is_some())
}

/// Characters that the name of a machine may have.
const LONGEST_NAME: usize = 32;

/// The name of a machine with a further end; a name that becomes too long loses characters before the end.
fn with_end(name: &str, end: &str) -> String {
    let kept = LONGEST_NAME.saturating_sub(end.len());
    name.chars().take(kept).chain(end.chars()).collect()
}

/// The machine, or one that extends it by the settings: those of its control, where the last one of a key counts, and
/// the variables that its channels share. The control of a composite is that of its components, which get definitions
/// inside the folder of the machine. The lathes among them have systems of G codes.
fn extended(
    name: String,
    mut files: PackedFiles,
    settings: &[MachineSetting],
    (components, lathes): (&[String], &[String]),
    begins: &Begins,
) -> (String, PackedFiles) {
    let said = |of: fn(&MachineSetting) -> bool| settings.iter().rev().find(|setting| of(setting));
    let numbers = said(|setting| matches!(setting, MachineSetting::Increments));
    let system = said(|setting| matches!(setting, MachineSetting::System(_)));
    let control: Vec<_> = [numbers, system].into_iter().flatten().filter_map(MachineSetting::of_control).collect();
    let shares = settings.iter().filter_map(|setting| match setting {
        MachineSetting::Shared(first, last) => Some((*first, *last)),
        _ => None,
    });
    let shares: Vec<(u32, u32)> = shares.collect();
    let stops = settings.iter().filter_map(|setting| match setting {
        MachineSetting::Stop(axis, at) => Some((axis.as_str(), *at)),
        _ => None,
    });
    // The last setting of an axis counts.
    let stops: std::collections::BTreeMap<&str, f64> = stops.collect();
    if control.is_empty() && shares.is_empty() && stops.is_empty() && begins.unit.is_none() {
        return (name, files);
    }
    let mut changed = control.iter().fold(name.clone(), |name, (_, end)| with_end(&name, end));
    if let Some(unit) = begins.unit {
        changed = with_end(&changed, &format!("-{}", unit.name()));
    }
    let mut text = String::new();
    let lines =
        |setting: &Option<&MachineSetting>| setting.and_then(MachineSetting::of_control).map(|(line, _)| line + "\n");
    let of_control =
        |system: &Option<&MachineSetting>| [lines(&numbers), lines(system)].into_iter().flatten().collect::<String>();
    if !control.is_empty() && components.is_empty() {
        text.push_str("[control]\n");
        text.push_str(&of_control(&system));
    }
    if !shares.is_empty() {
        changed = with_end(&changed, SHARES);
        text.push_str(&sharing(&files, &name, &shares));
    }
    if !stops.is_empty() {
        changed = with_end(&changed, STOPS);
        text.push_str("[stops.at]\n");
        text.extend(stops.iter().map(|(axis, at)| format!("{axis} = {at:?}\n")));
    }
    for (index, component) in components.iter().enumerate() {
        let own = of_control(&system.filter(|_| lathes.contains(component)));
        let initial = begins.initial.get(index).map_or("", String::as_str);
        if !own.is_empty() || !initial.is_empty() {
            let head = if own.is_empty() { "" } else { "[control]\n" };
            let text = format!("extends = \"{component}\"\n{initial}{head}{own}");
            files.0.insert(definition(&format!("{changed}/{component}")), Blob::new(text.into_bytes()));
        }
    }
    let initial = if components.is_empty() { begins.initial.concat() } else { String::new() };
    let text = format!("extends = \"{name}\"\n{initial}[ce]\nname = \"{changed}\"\n{text}");
    files.0.insert(definition(&changed), Blob::new(text.into_bytes()));
    (changed, files)
}

/// `[variables]` of a machine that shares these variables besides its own shared ones; those that remain are separate.
fn sharing(files: &PackedFiles, name: &str, shares: &[(u32, u32)]) -> String {
    let mut known = PackedFiles(files.0.clone());
    let chain = chain(&mut known, name, &[]);
    let tables = tables(&known, &chain);
    let ranges = |key: &str| {
        let lists = tables.iter().find_map(|table| table.get("variables")?.get(key)?.as_array());
        let end = |value: &toml::Value| value.as_integer().and_then(|number| u32::try_from(number).ok());
        let range = |item: &toml::Value| Some((end(item.as_array()?.first()?)?, end(item.as_array()?.get(1)?)?));
        lists.into_iter().flatten().filter_map(range).collect::<Vec<_>>()
    };
    let mut shared: Vec<(u32, u32)> = Vec::new();
    for &range in shares {
        let before: Vec<_> = shared.clone();
        shared.extend(without(vec![range], &before));
    }
    let before = without(ranges("shared"), &shared);
    shared.extend(before);
    let separate = without(ranges("channel"), &shared);
    let list = |ranges: Vec<(u32, u32)>| {
        ranges.iter().map(|(first, last)| format!("[{first}, {last}]")).collect::<Vec<_>>().join(", ")
    };
    format!("[variables]\nshared = [{}]\nchannel = [{}]\n", list(shared), list(separate))
}

/// The parts of ranges outside other ranges.
fn without(ranges: Vec<(u32, u32)>, others: &[(u32, u32)]) -> Vec<(u32, u32)> {
    others.iter().fold(ranges, |ranges, &(first, last)| {
        let cut = |(low, high): (u32, u32)| {
            let below = (low < first).then(|| (low, high.min(first - 1)));
            let above = (high > last).then(|| (low.max(last + 1), high));
            [below, above].into_iter().flatten().filter(|(low, high)| low <= high)
        };
        ranges.into_iter().flat_map(cut).collect()
    })
}

/// A machine that extends this one by the tools of a file; its files and the tools are given, too.
pub(crate) fn with_tools(
    machine: &str,
    mut files: PackedFiles,
    path: &Path,
) -> Result<(String, PackedFiles, ToolDefinitions), Error> {
    let mut known = PackedFiles(files.0.clone());
    let chain = chain(&mut known, machine, &[]);
    let blobs = chain.iter().filter_map(|folder| known.0.get(&definition(folder)));
    let texts: Vec<String> = blobs.map(|blob| String::from_utf8_lossy(blob.content()).into_owned()).collect();
    let mut tools = ToolDefinitions::read(path, &ToolImportContext::of(texts.iter().map(String::as_str)))?;
    let name = with_end(machine, TOOLS);
    files.0.insert(definition(&name), Blob::new(tools.definition(&name, machine).into_bytes()));
    Ok((name, files, tools))
}

fn definition(folder: &str) -> String {
    format!("{folder}/machine.toml")
}

/// The component definitions of a composite machine, by name with their chains; shipped definitions are added to the
/// files.
fn components(files: &mut PackedFiles, chain_of_machine: &[String]) -> Vec<(String, Vec<String>)> {
    let mut designators: Vec<String> = Vec::new();
    let mut names: Vec<String> = Vec::new();
    for folder in chain_of_machine {
        let Some(blob) = files.0.get(&definition(folder)) else { continue };
        let table = toml::from_str::<toml::Table>(&String::from_utf8_lossy(blob.content())).unwrap_or_default();
        for row in table.get("components").and_then(toml::Value::as_array).into_iter().flatten() {
            let text = |key: &str| row.get(key).and_then(toml::Value::as_str).unwrap_or_default().to_owned();
            let (designator, name) = (text("designator"), text("machine"));
            // A row of the machine takes the place of that of a family.
            if designators.contains(&designator) {
                continue;
            }
            designators.push(designator);
            if !names.contains(&name) {
                names.push(name);
            }
        }
    }
    names.into_iter().map(|name| (name.clone(), chain(files, &name, chain_of_machine))).collect()
}

/// The folders of a machine and its families; shipped folders are added to the files. Folders inside those of `within`
/// come before others.
fn chain(files: &mut PackedFiles, name: &str, within: &[String]) -> Vec<String> {
    let shipped = package::shipped();
    let mut chain: Vec<String> = Vec::new();
    let found = |files: &PackedFiles, chain: &[String], name: String| {
        let mut inside = within.iter().map(|outer| format!("{outer}/{name}"));
        let inside = inside.find(|folder| !chain.contains(folder) && files.0.contains_key(&definition(folder)));
        inside.unwrap_or(name)
    };
    let mut next = Some(found(files, &chain, name.to_owned()));
    while let Some(folder) = next.take().filter(|folder| !chain.contains(folder)) {
        if !files.0.contains_key(&definition(&folder)) {
            let inside = format!("{folder}/");
            for path in shipped.list().into_iter().filter(|path| path.starts_with(&inside)) {
                if let Ok(content) = shipped.read(&path) {
                    files.0.entry(path).or_insert_with(|| Blob::new(content.to_vec()));
                }
            }
        }
        let Some(blob) = files.0.get(&definition(&folder)) else { break };
        let table = toml::from_str::<toml::Table>(&String::from_utf8_lossy(blob.content())).ok();
        let parent = table.and_then(|table| table.get("extends")?.as_str().map(str::to_owned));
        chain.push(folder);
        next = parent.map(|parent| found(files, &chain, parent));
    }
    chain
}

/// The text of a definition with another range of waiting codes; `None` if it has none.
fn with_waits(text: &str, range: &RangeInclusive<u32>) -> Option<String> {
    let lines: Vec<&str> = text.split_inclusive('\n').collect();
    let mut out = String::with_capacity(text.len() + 16);
    let mut changed = false;
    for section in sections(&lines) {
        let of = |key: &str| section.iter().find_map(|line| value(line, key));
        let head = section.first().map_or("", |line| line.trim());
        let waits = head.starts_with("[[waits]]") || head.starts_with("[[codes]]") && of("id") == Some("CODE_SYNC_REG");
        for line in section {
            match value(line, "word").filter(|word| waits && is_range(word)) {
                Some(word) => {
                    out.push_str(&line.replacen(word, &format!("M{}-M{}", range.start(), range.end()), 1));
                    changed = true;
                }
                None => out.push_str(line),
            }
        }
    }
    changed.then_some(out)
}

/// The lines of each section, its head first.
fn sections<'a, 'l>(lines: &'a [&'l str]) -> impl Iterator<Item = &'a [&'l str]> {
    lines.chunk_by(|_, next| !next.starts_with('['))
}

/// The text that a line gives to a key.
fn value<'l>(line: &'l str, key: &str) -> Option<&'l str> {
    let rest = line.trim_start().strip_prefix(key)?.trim_start().strip_prefix('=')?;
    rest.trim_start().strip_prefix('"')?.split('"').next()
}

/// `M100-M199`.
fn is_range(word: &str) -> bool {
    let number = |text: &str| text.strip_prefix('M').is_some_and(|digits| digits.parse::<u32>().is_ok());
    word.split_once('-').is_some_and(|(first, last)| number(first) && number(last))
}

#[cfg(test)]
mod tests;
mod units;
