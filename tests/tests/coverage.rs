//! What the spec pages show: identifiers, system variables.
//!
//! Every example of `tests/spec/emulator` and `tests/spec/tables` is run with the trace of codes and data; what comes
//! up there has been shown. Every built-in identifier must.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use counterpoint_kernel::files::Memory;
use counterpoint_kernel::job::Program;
use counterpoint_kernel::log::event::Kind;
use counterpoint_kernel::machine::ident::{codes, data};
use counterpoint_kernel::machine::load;
use counterpoint_kernel::machine::macros::system;
use counterpoint_kernel::machine::package::{Overlay, shipped};
use counterpoint_kernel::options::Options;
use counterpoint_tests::Work;

/// Identifiers that never come up in a trace: a page that gives them a row and runs shows them.
const STRUCTURE: &[&str] =
    &["CODE_NONE", "REG_NONE", "REG_DEFSUB_ID", "REG_LABEL", "REG_LABEL_END", "REG_OPSKIP", "REG_IGNORE"];

fn spec() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("spec")
}

fn pages(folder: &str) -> Vec<String> {
    let mut paths: Vec<_> =
        std::fs::read_dir(spec().join(folder)).unwrap().map(|entry| entry.unwrap().path()).collect();
    paths.sort();
    paths.iter().map(|path| std::fs::read_to_string(path).unwrap()).collect()
}

/// One example of a page: its machine and programs, whichever kind of page it is.
#[derive(Default)]
struct Example {
    machine: Memory,
    toml: String,
    programs: Vec<(String, String)>,
    files: Vec<(String, String)>,
    options: String,
}

impl Example {
    /// Fences of a page; a new example begins at each machine, or at each heading of a page of tables.
    fn of(page: &str, tables: bool) -> Vec<Self> {
        let mut examples = vec![Self::default()];
        let mut lines = page.lines();
        while let Some(line) = lines.next() {
            if tables && line.starts_with("## ") {
                examples.push(Self::default());
            }
            let Some(fence) = line.strip_prefix("```").filter(|fence| !fence.is_empty()) else { continue };
            let body: String =
                lines.by_ref().take_while(|line| *line != "```").map(|line| format!("{line}\n")).collect();
            let (kind, name) = fence.split_once(' ').unwrap_or((fence, ""));
            if kind == "toml" && !tables {
                examples.push(Self::default());
            }
            let Some(example) = examples.last_mut() else { continue };
            match (kind, tables) {
                ("toml", _) => example.toml = body,
                ("macro", _) | ("file", true) => example.machine.insert(format!("spec/{name}"), body),
                ("file", false) => example.files.push((name.to_owned(), body)),
                ("nc", _) => {
                    let number = example.programs.len() + 1;
                    let name = if name.is_empty() { format!("p{number}.nc") } else { name.to_owned() };
                    example.programs.push((name, body));
                }
                ("options", _) => example.options = body,
                _ => {}
            }
        }
        examples.retain(|example| !example.programs.is_empty());
        for example in &mut examples {
            if tables {
                // Only the first program runs, the others are files.
                example.files.extend(example.programs.drain(1..));
                let head = if example.toml.contains("extends") { "" } else { "extends = \"fanuc-mill\"\n" };
                let named = if example.toml.contains("[ce]") { "" } else { "\n[ce]\nname = \"spec\"\n" };
                example.toml = format!("{head}{}{named}", example.toml);
            }
            example.machine.insert("spec/machine.toml", example.toml.clone());
        }
        examples
    }

    /// Identifiers that come up when it runs.
    fn shows(&self, shown: &mut BTreeSet<String>) {
        let loaded = load(&Overlay::new(self.machine.clone(), shipped()), "spec");
        let Some(machine) = loaded.machine.map(Arc::new) else { return };
        let mut options: Options = toml::from_str(&self.options).unwrap();
        options.trace = "C".to_owned();
        let mut files = Memory::default();
        let programs = self.programs.iter().map(|(file, text)| {
            files.insert(file.clone(), text.clone());
            Program { file: file.clone(), number: None, channel: None }
        });
        let programs = programs.collect();
        self.files.iter().for_each(|(name, text)| files.insert(name.clone(), text.clone()));
        let Ok(done) = (Work { machine, files, programs, options }).run(None) else { return };
        for event in &done.events {
            let Kind::Trace { text, .. } = &event.kind else { continue };
            let mut words = text.split_whitespace();
            let name = words.next().unwrap_or_default().to_uppercase();
            let ignored = words.next() == Some("(ignored)");
            if !ignored || name == "CODE_COMMENT" || name == "CODE_IGNORE" {
                shown.insert(name);
            }
        }
        shown.extend(STRUCTURE.iter().filter(|name| self.toml.contains(**name)).map(|name| (*name).to_owned()));
    }
}

#[test]
fn built_in_identifiers_are_shown() {
    let mut shown: BTreeSet<String> = BTreeSet::new();
    for (folder, tables) in [("emulator", false), ("tables", true)] {
        for page in pages(folder) {
            Example::of(&page, tables).iter().for_each(|example| example.shows(&mut shown));
        }
    }
    let codes = codes::TABLE.iter().filter(|facts| facts.built_in).map(|facts| facts.name);
    let data = data::TABLE.iter().filter(|facts| facts.built_in).map(|facts| facts.name);
    let all: BTreeSet<String> = codes.chain(data).map(str::to_owned).collect();
    let missing: Vec<_> = all.difference(&shown).collect();
    assert!(missing.is_empty(), "no page shows: {missing:#?}");
}

/// The names of a pattern of the table: `[x]` is left out or one of x, `{xy}` is one of x and y.
fn names(pattern: &str) -> Vec<String> {
    let brackets = [('[', ']'), ('{', '}')];
    let first = brackets.into_iter().filter_map(|(open, close)| Some((pattern.find(open)?, open, close))).min();
    let Some((at, open, close)) = first else { return vec![pattern.to_owned()] };
    let end = at + pattern[at..].find(close).unwrap();
    let mut choices: Vec<String> = pattern[at + 1..end].chars().map(String::from).collect();
    if open == '[' {
        choices.push(String::new());
    }
    let tails = names(&pattern[end + 1..]);
    let joined = choices.iter().flat_map(|one| tails.iter().map(move |tail| format!("{one}{tail}")));
    joined.map(|rest| format!("{}{rest}", &pattern[..at])).collect()
}

/// A name stands in a text, not only as the beginning of a longer one.
fn mentions(text: &str, name: &str) -> bool {
    text.match_indices(name).any(|(at, _)| {
        let next = text[at + name.len()..].chars().next();
        next.is_none_or(|next| !next.is_ascii_uppercase() && !next.is_ascii_digit() && next != '_')
    })
}

#[test]
fn system_variables_are_shown_or_have_a_reason() {
    let all: String = ["emulator", "lang", "tables"].into_iter().flat_map(pages).collect();
    let docs = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/emulation.md");
    let docs = std::fs::read_to_string(docs).unwrap();
    let heading = "* Variables of things that do not exist here";
    let reasons = &docs[docs.find(heading).expect("the reasons")..];
    let reasons = &reasons[..reasons[1..].find("\n* ").expect("their end")];
    let excused = |name: &str| {
        mentions(reasons, name) || (3..name.len()).any(|at| reasons.contains(&format!("{}…", &name[..at])))
    };
    let table =
        std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("../kernel/machine/src/macros/system.tsv"));
    let table = table.unwrap();
    let patterns = table.lines().filter(|line| !line.starts_with('#')).filter_map(|line| line.split('\t').next());
    let hidden: Vec<&str> =
        patterns.filter(|pattern| !names(pattern).iter().any(|name| mentions(&all, name) || excused(name))).collect();
    assert!(hidden.is_empty(), "no page shows these and docs/emulation.md gives no reason: {hidden:#?}");
}

#[test]
fn patterns_of_names() {
    assert_eq!(names("$[L]{XY}M"), ["$LXM", "$LYM", "$XM", "$YM"]);
    assert!(mentions("`$XM`", "$XM") && !mentions("$XMCD", "$XM"));
    assert!(system::find("$XM").is_some());
}
