//! A word that a machine does not have: the most similar word of the machine, and the machines that have the word.
//!
//! *Invariant:* machines are the shipped ones, in the order of their names.

use counterpoint_kernel::machine::Machine;
use counterpoint_kernel::machine::ident::meaning;
use counterpoint_kernel::machine::show;
use counterpoint_lang::ident;
use serde_json::{Value, json};

use super::{programs, words};
use crate::fields::Fields as _;
use crate::local_machine;

/// Shipped machines that have the word, by the kind of word, without the machine `not`.
pub(super) fn machines(word: &str, not: Option<&str>) -> Vec<Value> {
    let mut found: Vec<(String, Vec<String>)> = Vec::new();
    for (name, machine) in local_machine::all_shipped().filter(|(name, _)| Some(name.as_str()) != not) {
        for is in identifiers(&machine, word) {
            match found.iter_mut().find(|(known, _)| *known == is) {
                Some((_, machines)) => machines.push(name.clone()),
                None => found.push((is, vec![name.clone()])),
            }
        }
    }
    let row = |(is, machines): (String, Vec<String>)| {
        let meaning = meaning::of(&is);
        json!({ "id": is, "meaning": meaning, "machines": machines })
    };
    found.into_iter().map(row).collect()
}

/// The codes of a word; the data of a letter; the stored program.
fn identifiers(machine: &Machine, word: &str) -> Vec<String> {
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
    let mut seen: Vec<String> = Vec::new();
    names.retain(|name| {
        let first = !seen.contains(name);
        seen.push(name.clone());
        first
    });
    names
}

/// The most similar word of the machine.
pub(super) fn nearest(machine: &Machine, word: &str) -> Option<String> {
    let written =
        machine.codes.iter().filter(|row| row.enable).map(|row| show::code_json(machine, row).at("word").clone());
    let written = written.filter_map(|word| word.as_str().map(|word| word.trim_matches('"').to_owned()));
    let mut names: Vec<String> = written.filter(|word| word != "-").collect();
    names.extend(machine.storage.iter().filter_map(|file| programs::stem(&file.path).map(str::to_uppercase)));
    let word = word.to_uppercase();
    // A nearby number is not a typing error.
    let plain = word.chars().skip(1).all(|c| c.is_ascii_digit() || c == '.');
    if plain {
        return None;
    }
    ident::nearest(&word, names.iter().map(String::as_str)).map(str::to_owned)
}
