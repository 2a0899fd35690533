//! The coverage of the spec pages: identifiers, system variables.
//!
//! Every example of `tests/spec/emulator` and `tests/spec/tables` is run with the trace of codes and data; identifiers
//! in that trace have been shown. Every built-in identifier must be shown.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use counterpoint_kernel::log::event::{Kind, Trace};
use counterpoint_kernel::machine::ident::{codes, data};
use counterpoint_kernel::machine::macros::system;
use counterpoint_mdspec::{Example, Page};
use counterpoint_tests::spec::{Case, FENCES, folder};

/// Identifiers that never occur in a trace: a page that gives them a row and runs shows them.
const STRUCTURE: &[&str] =
    &["CODE_NONE", "REG_NONE", "REG_DEFSUB_ID", "REG_LABEL", "REG_LABEL_END", "REG_OPSKIP", "REG_IGNORE"];

fn paths(kind: &str) -> Vec<PathBuf> {
    let mut paths: Vec<_> = std::fs::read_dir(folder(kind)).unwrap().map(|entry| entry.unwrap().path()).collect();
    paths.sort();
    paths
}

fn pages(kind: &str) -> Vec<String> {
    paths(kind).iter().map(|path| std::fs::read_to_string(path).unwrap()).collect()
}

/// Identifiers that come up when an example runs.
fn shows(example: &Example, shown: &mut BTreeSet<String>) {
    let case = Case::of(example).unwrap_or_else(|(line, text)| panic!("{}, line {line}: {text}", example.name));
    let Some(work) = case.work(|options| "C".clone_into(&mut options.trace)) else { return };
    let Ok(done) = work.run(None) else { return };
    for event in &done.events {
        let Kind::Trace(Trace { text, .. }) = &event.kind else { continue };
        let mut words = text.split_whitespace();
        let name = words.next().unwrap_or_default().to_uppercase();
        let ignored = words.next() == Some("(ignored)");
        if !ignored || name == "CODE_COMMENT" || name == "CODE_IGNORE" {
            shown.insert(name);
        }
    }
    shown.extend(STRUCTURE.iter().filter(|name| case.definition.contains(**name)).map(|name| (*name).to_owned()));
}

#[test]
fn built_in_identifiers_are_shown() {
    let mut shown: BTreeSet<String> = BTreeSet::new();
    for kind in ["emulator", "tables"] {
        for path in paths(kind) {
            let page = Page::read(&path, FENCES).unwrap_or_else(|fault| panic!("{}: {fault}", path.display()));
            page.examples.iter().for_each(|example| shows(example, &mut shown));
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

/// A name is in a text, not only as the beginning of a longer one.
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
    let heading = "* Variables without a function here";
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
