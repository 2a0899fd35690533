//! A word that a machine does not have: the most similar word of the machine, and the machines that have the word.
//!
//! *Invariant:* machines are the shipped ones, in the order of their names.

use counterpoint_kernel::machine::Machine;
use counterpoint_kernel::machine::ident::meaning;
use counterpoint_kernel::machine::show;
use counterpoint_lang::ident;
use serde_json::{Value, json};

use super::{ExplainedMachine, components, programs, words};
use crate::fields::JsonFields as _;
use crate::local_machine::{self, LocalMachine};

/// Shipped machines that have the word, by the kind of word, without the machine `not`.
pub(super) fn machines(word: &str, not: Option<&str>) -> Vec<Value> {
    let machines: Vec<(String, Machine)> =
        local_machine::all_shipped().filter(|(name, _)| Some(name.as_str()) != not).collect();
    let direct = grouped(machines.iter().map(|(name, machine)| (name.as_str(), identifiers(machine, word))));
    if !direct.is_empty() {
        return direct;
    }
    // Variables, several words and statements need the whole definition.
    let all = machines.into_iter().filter_map(|(name, machine)| {
        let local = LocalMachine::shipped(&name);
        let definition = local.definition().ok()?;
        let own = name.clone();
        Some((name, ExplainedMachine { machine, local, definition, own }))
    });
    let all: Vec<(String, ExplainedMachine)> = all.collect();
    grouped(all.iter().map(|(name, subject)| {
        let mut kinds: Vec<String> = match subject.machine.components.is_empty() {
            true => described(subject, word),
            false => components::subjects(subject).iter().flat_map(|(_, one)| described(one, word)).collect(),
        };
        keep_first(&mut kinds);
        (name.as_str(), kinds)
    }))
}

/// Removes repeated texts.
fn keep_first(texts: &mut Vec<String>) {
    let mut seen = std::collections::BTreeSet::new();
    texts.retain(|text| seen.insert(text.clone()));
}

/// Machines by the kind of word.
fn grouped<'m>(all: impl Iterator<Item = (&'m str, Vec<String>)>) -> Vec<Value> {
    let mut found: Vec<(String, Vec<&str>)> = Vec::new();
    for (name, kinds) in all {
        for is in kinds {
            match found.iter_mut().find(|(known, _)| *known == is) {
                Some((_, machines)) => machines.push(name),
                None => found.push((is, vec![name])),
            }
        }
    }
    let row = |(is, machines): (String, Vec<&str>)| {
        let meaning = meaning::of(&is);
        json!({ "id": is, "meaning": meaning, "machines": machines })
    };
    found.into_iter().map(row).collect()
}

/// Mentions of a text in the whole definition of a machine and in the pages of its control.
fn described(subject: &ExplainedMachine, asked: &str) -> Vec<String> {
    let words = subject.looked_up(asked);
    if words.iter().any(|word| word.at("known") == false) {
        return Vec::new();
    }
    let mut kinds = Vec::new();
    for word in &words {
        let texts = |key: &str, of: &str| -> Vec<String> {
            let rows = word.at(key).as_array().into_iter().flatten();
            rows.filter_map(|row| row.at(of).as_str().map(str::to_owned)).collect()
        };
        let variable = word.at("variable").at("means").as_str().map(str::to_owned);
        let data = word.at("register").at("data").as_array().into_iter().flatten();
        kinds.extend(variable);
        kinds.extend(texts("codes", "id"));
        kinds.extend(data.filter_map(|row| row.at("id").as_str().map(str::to_owned)));
        kinds.extend(texts("rows", "text"));
        kinds.extend(texts("called", "text"));
        // A bare number is on every page.
        if kinds.is_empty() && asked.contains(|c: char| c.is_ascii_alphabetic()) {
            kinds.extend(texts("pages", "text").into_iter().take(1));
        }
    }
    kinds
}

/// Codes of a word, data of a letter, or the stored program; on a composite, those of all components.
fn identifiers(machine: &Machine, word: &str) -> Vec<String> {
    let mut names: Vec<String> =
        machine.definitions().flat_map(|(_, machine)| own_identifiers(machine, word)).collect();
    keep_first(&mut names);
    names
}

fn own_identifiers(machine: &Machine, word: &str) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    if let Some(found) = words::find(machine, word) {
        let enabled = found.codes.iter().map(|row| &machine.codes[*row]).filter(|row| row.enable);
        names.extend(enabled.map(|row| machine.code_name(row.id).to_owned()));
        if names.is_empty() {
            let data = found.data.iter().map(|row| machine.data_name(machine.data[*row].id).to_owned());
            names.extend(data);
        }
    }
    if names.is_empty() {
        let programs = programs::stored(machine, word);
        names.extend(programs.iter().filter_map(|program| program.at("path").as_str().map(str::to_owned)));
    }
    names
}

/// The most similar word of the machine.
pub(super) fn nearest(machine: &Machine, word: &str) -> Option<String> {
    let written = machine.definitions().flat_map(|(_, machine)| {
        let rows = machine.codes.iter().filter(|row| row.enable);
        rows.map(|row| show::code_json(machine, row).at("word").clone()).collect::<Vec<_>>()
    });
    let written = written.filter_map(|word| word.as_str().map(|word| word.trim_matches('"').to_owned()));
    let mut names: Vec<String> = written.filter(|word| word != "-").collect();
    names.extend(machine.storage.iter().filter_map(|file| programs::stem(&file.path).map(str::to_uppercase)));
    let word = word.to_uppercase();
    // A nearby number does not count as a typing error.
    let plain = word.chars().skip(1).all(|c| c.is_ascii_digit() || c == '.');
    if plain {
        return None;
    }
    ident::nearest(&word, names.iter().map(String::as_str)).map(str::to_owned)
}
