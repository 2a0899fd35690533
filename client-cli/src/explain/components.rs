//! A word on a composite machine: explained on each of its components.
//!
//! *Invariant:* a component is shown as one with the word only if its tables have the word, unless no component has it
//! there; the pages of a control name the words of all its machines.

use counterpoint_kernel::machine::{DefinedComponent, DefinitionRow, WrittenDefinition};
use serde_json::{Value, json};

use super::{ExplainedMachine, trial};
use crate::fields::JsonFields as _;
use crate::local_machine::LocalMachine;

/// Sections of the composite that explain words of all its components.
const SHARED: [&str; 2] = ["waits", "tool.names"];

/// The words on the components that have them, each with its `component`; then the components that lack them.
pub(super) fn words(composite: &ExplainedMachine, asked: &str) -> Vec<Value> {
    let subjects = subjects(composite);
    let mut found: Vec<(&str, Vec<Value>)> =
        subjects.iter().map(|(designator, subject)| (*designator, subject.looked_up(asked))).collect();
    for ((_, subject), (_, words)) in subjects.iter().zip(&mut found) {
        for word in words.iter_mut().filter(|word| word.at("known") == false) {
            let text = word.at("word").as_str().unwrap_or_default().to_owned();
            if let Some(accepted) = trial::accepted(&subject.machine, &text) {
                word.set("accepted", json!(accepted));
                word.set("known", json!(true));
            }
        }
    }
    let has = |words: &[Value], by_table: bool| {
        words.iter().all(|word| word.at("known") == true && (!by_table || is_in_tables(word)))
    };
    let by_table = found.iter().any(|(_, words)| has(words, true));
    let (with, without): (Vec<_>, Vec<_>) = found.into_iter().partition(|(_, words)| has(words, by_table));
    let extends = |designator: &str| {
        subjects.iter().find(|(name, _)| *name == designator).map(|(_, subject)| &subject.definition.chain)
    };
    let mut all = Vec::new();
    for (designator, words) in &with {
        all.extend(words.iter().cloned().map(|mut word| {
            word.set("component", json!(designator));
            word.set("extends", json!(extends(designator)));
            word
        }));
    }
    if with.is_empty() {
        // The response is that of the composite, because its first component reads the block.
        let mut words = without.into_iter().next().map(|(_, words)| words).unwrap_or_default();
        for word in words.iter_mut().filter(|word| word.at("known") == false) {
            let text = word.at("word").as_str().unwrap_or_default().to_owned();
            composite.not_found(word, &text);
        }
        return words;
    }
    all.extend(
        without.into_iter().map(
            |(designator, _)| json!({ "word": asked, "known": false, "elsewhere": true, "component": designator }),
        ),
    );
    all
}

/// Whether the answer has rows other than those of pages.
fn is_in_tables(word: &Value) -> bool {
    word.as_object()
        .is_some_and(|fields| fields.keys().any(|key| !matches!(key.as_str(), "word" | "known" | "pages" | "edited")))
}

/// The components as machines with pages and tables of their own.
pub(super) fn subjects(composite: &ExplainedMachine) -> Vec<(&str, ExplainedMachine)> {
    let all = composite.machine.components.iter().zip(&composite.definition.components);
    all.map(|(component, defined)| {
        let subject = ExplainedMachine {
            machine: (*component.machine).clone(),
            local: LocalMachine { name: composite.local.name.clone(), files: composite.local.files.clone() },
            definition: definition(defined, &composite.definition),
            own: composite.own.clone(),
        };
        (component.designator.as_str(), subject)
    })
    .collect()
}

/// Definition of a component with the rows that the composite shares.
fn definition(component: &DefinedComponent, composite: &WrittenDefinition) -> WrittenDefinition {
    let mut definition = component.definition.clone();
    let shared = composite.rows.iter().filter(|row: &&DefinitionRow| SHARED.contains(&row.section.as_str()));
    definition.rows.extend(shared.cloned());
    definition
}
